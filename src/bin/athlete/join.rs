//! `athlete join`: motions one after the other in one clip, such as the cycles of a gait.

use crate::motion::load_motion;
use crate::output::{Outcome, say, say_json};
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::cli::{ArgumentError, check_output, load_character};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Prints from when to when each motion is in the clip, as the field `gait` of a skill file has it.
#[derive(Debug, Args)]
pub struct Join {
    /// Motions (.clip.ron, .keyposes.ron, .bvh) in their order; one alone becomes a clip
    #[arg(required = true, num_args = 1..)]
    files: Vec<PathBuf>,
    #[arg(long, help = character_help!())]
    character: String,
    /// Joint map for .bvh files, instead of the built-in ones that know their skeletons, or those that are found
    #[arg(long)]
    map: Option<PathBuf>,
    /// Poses per second of the clip
    #[arg(long, default_value_t = 60.0)]
    frame_rate: f64,
    /// The clip to write (.clip.ron)
    #[arg(long)]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Join {
    pub fn run(&self) -> Outcome {
        if !(1.0..=1000.0).contains(&self.frame_rate) {
            return Err(ArgumentError::new("--frame-rate", self.frame_rate, "1 to 1000 poses per second").into());
        }
        if !self.out.to_string_lossy().ends_with(".clip.ron") {
            return Err(ArgumentError::new("--out", self.out.display(), "a name that ends in .clip.ron").into());
        }
        check_output("--out", &self.out)?;
        let model = load_character(&self.character)?;
        let (mut clips, mut lift) = (Vec::new(), 0.0_f64);
        for file in &self.files {
            let (clip, by) = load_motion(file, self.map.as_deref(), &model)?.lifted_clear(&model)?;
            lift = lift.max(by);
            clips.push(clip);
        }
        let name = self.out.file_name().and_then(|n| n.to_str()).and_then(|n| n.split('.').next()).unwrap_or("joined");
        let (joined, parts) = MotionClip::joined(name, &clips, self.frame_rate)?;
        joined.save(&self.out)?;
        if self.json {
            say_json(&json!({ "clip": self.out, "gait": parts, "lifted_m": lift }))?;
        } else {
            let parts: Vec<String> = parts.iter().map(|(from, to)| format!("({from:.6}, {to:.6})")).collect();
            say(&format!("{}: {} poses", self.out.display(), joined.poses.len()))?;
            say(&format!("gait: [{}]", parts.join(", ")))?;
            if lift > 0.0 {
                say(&format!("root lifted by up to {lift:.3} m where a motion is below the ground"))?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
