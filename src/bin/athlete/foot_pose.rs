//! `athlete foot-pose`: the four basic poses of a foot as the foot pose controller finds them.

use crate::output::{Outcome, say, say_json};
use bevy_athlete::cli::{ArgumentError, basic_poses, check_output, foot_alone, foot_frames, load_character};
use bevy_athlete::control::foot::FootAnatomy;
use bevy_athlete::storyboard::{Ground, Heading, Storyboard, StoryboardOptions};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, Args)]
pub struct FootPose {
    /// Name of a preset (foot_human, toes_human) or path of a .character.ron file
    #[arg(long, default_value = "foot_human")]
    character: String,
    /// Number of the foot in the character file's order
    #[arg(long, default_value_t = 1)]
    foot: usize,
    /// Where to write a close-up of the four poses (PNG); bones that touch the ground are red
    #[arg(long)]
    storyboard: Option<PathBuf>,
    /// Where the camera stands, degrees: 0 at the side, 90 in front
    #[arg(long, default_value_t = 55.0, allow_negative_numbers = true)]
    azimuth: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl FootPose {
    pub fn run(&self) -> Outcome {
        bevy_athlete::cli::within("--azimuth", self.azimuth, -360.0..=360.0, "degrees")?;
        if let Some(path) = &self.storyboard {
            check_output("--storyboard", path)?;
        }
        let model = load_character(&self.character)?;
        let wrong = |error: bevy_athlete::control::foot::FootError| {
            ArgumentError::new(
                "--character",
                format!("{}: {error}", self.character),
                "one with feet of segments, as foot_human has",
            )
        };
        let foot = FootAnatomy::of(&model, self.foot).map_err(wrong)?;
        let poses = basic_poses(&foot).map_err(wrong)?;
        if let Some(path) = &self.storyboard {
            let alone = foot_alone(&model, &foot);
            let frames = foot_frames(&alone, &foot, &poses);
            let options = StoryboardOptions {
                width: 1920,
                height: 520,
                azimuth: self.azimuth.to_radians(),
                elevation: 0.30,
                heading: Heading::World,
                ground: Ground::Floor,
                path_band: false,
                times: false,
                title: format!("{}, foot {}: basic poses", model.name, self.foot),
                ..Default::default()
            };
            Storyboard::new(options).write(&alone, &frames, path)?;
        }
        let names = |set: bevy_athlete::control::foot::SegmentSet| -> Vec<&str> {
            set.iter().filter_map(|k| foot.segments().get(k)).map(|s| s.name.as_str()).collect()
        };
        if self.json {
            let rows: Vec<_> = poses
                .iter()
                .map(|p| {
                    let r = &p.pose.report;
                    json!({
                        "pose": p.basic.name(), "ankle_height_m": p.pose.ankle.y, "ankle_moved_m": r.displacement,
                        "rotation_degrees": r.rotation.to_degrees(), "roll_degrees": r.roll.to_degrees(),
                        "touching": names(r.touching), "met": r.is_met(),
                    })
                })
                .collect();
            say_json(&json!({ "character": model.name, "foot": self.foot, "poses": rows }))?;
        } else {
            say(&format!("{:<14}{:>10}{:>12}{:>12}  touching", "pose", "ankle mm", "moved mm", "turned deg"))?;
            for p in &poses {
                let r = &p.pose.report;
                let (height, moved) = (p.pose.ankle.y * 1e3, r.displacement * 1e3);
                let touching = names(r.touching).join(" ");
                say(&format!(
                    "{:<14}{height:>10.1}{moved:>12.2}{:>12.2}  {touching}",
                    p.basic.name(),
                    r.rotation.to_degrees()
                ))?;
            }
            if let Some(path) = &self.storyboard {
                say(&format!("storyboard    {}", path.display()))?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
