//! `athlete import-joints`: from positions of joints to key poses.

use crate::output::{Outcome, complain, say, say_json};
use crate::simulate::in_file;
use bevy_athlete::asset::joint_positions::{JointPositions, PositionOptions};
use bevy_athlete::asset::landmark_layout::{Axes, LandmarkLayout};
use bevy_athlete::cli::{ArgumentError, check_output, load_character};
use bevy_athlete::model::{ImportedPoses, PositionImportOptions, SidedPart, import_positions};
use clap::Args;
use clap::builder::PossibleValuesParser;
use serde_json::json;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const ENDING: &str = ".keyposes.ron";

#[derive(Debug, Args)]
pub struct ImportJoints {
    /// Positions (.json): one frame or many, as docs/book/motions.md describes them
    file: PathBuf,
    /// Where to write the key poses (.keyposes.ron); by default beside the input, if nothing is there
    #[arg(long)]
    out: Option<PathBuf>,
    #[arg(long, help = character_help!(), default_value = "skater")]
    character: String,
    /// smpl24, smpl22, mediapipe33 or path of a .landmarks.ron file; by default what the file says, else by the number of landmarks
    #[arg(long)]
    layout: Option<String>,
    /// Axes of the positions; by default what the file says, else those of the layout
    #[arg(long, value_parser = PossibleValuesParser::new(Axes::NAMES.map(|(name, _)| name)))]
    axes: Option<String>,
    /// Frames per second; by default what the file says, else 30
    #[arg(long)]
    fps: Option<f64>,
    /// Make key poses of these frames only, counted from 0: 0,12,25
    #[arg(long, value_delimiter = ',', conflicts_with = "every")]
    frames: Option<Vec<usize>>,
    /// Make a key pose of every so manieth frame
    #[arg(long)]
    every: Option<usize>,
    /// Count a landmark as not seen below this visibility
    #[arg(long, default_value_t = PositionImportOptions::default().min_visibility)]
    min_visibility: f64,
    /// Exchange left and right first, of all or of a part
    #[arg(long, value_parser = PossibleValuesParser::new(SidedPart::ALL.map(SidedPart::name)))]
    exchange: Option<String>,
    /// Take speed, path and heights from the positions; else each pose stands on the ground at one place
    #[arg(long)]
    travel: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl ImportJoints {
    pub fn run(&self) -> Outcome {
        let (out, name) = self.place()?;
        let model = load_character(&self.character)?;
        let options = PositionOptions {
            layout: self.layout.as_deref().map(layout).transpose()?,
            axes: Axes::NAMES.iter().find(|(name, _)| self.axes.as_deref() == Some(name)).map(|(_, axes)| *axes),
            fps: self.fps,
        };
        let positions = JointPositions::load(&self.file, &options).map_err(|error| in_file(&self.file, &error))?;
        let frames = match self.every {
            Some(0) => return Err(ArgumentError::new("--every", 0, "1 or more").into()),
            Some(every) => Some((0..positions.frames.len()).step_by(every).collect()),
            None => self.frames.clone(),
        };
        let options = PositionImportOptions {
            name,
            min_visibility: self.min_visibility,
            frames,
            exchange: SidedPart::ALL.into_iter().find(|part| self.exchange.as_deref() == Some(part.name())),
            travel: self.travel,
        };
        let imported = import_positions(&model, &positions, &options).map_err(|error| in_file(&self.file, &error))?;
        std::fs::write(&out, &imported.text).map_err(|error| format!("cannot write {}: {error}", out.display()))?;
        self.print(&positions, &imported, &out)?;
        Ok(ExitCode::SUCCESS)
    }

    /// Where the key poses go, and what they are called.
    fn place(&self) -> Result<(PathBuf, String), Box<dyn Error>> {
        let out = match &self.out {
            Some(out) if !out.to_string_lossy().ends_with(ENDING) => {
                return Err(ArgumentError::new("--out", out.display(), format!("a name that ends in {ENDING}")).into());
            }
            Some(out) => out.clone(),
            None => {
                let stem = self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                let out = self.file.with_file_name(stem + ENDING);
                if out.exists() {
                    let out = out.display();
                    return Err(format!("{out} exists; --out {out} replaces it").into());
                }
                out
            }
        };
        check_output("--out", &out)?;
        let name = out.file_name().unwrap_or_default().to_string_lossy().trim_end_matches(ENDING).to_owned();
        Ok((out, name))
    }

    fn print(&self, positions: &JointPositions, imported: &ImportedPoses, out: &Path) -> Result<(), Box<dyn Error>> {
        let poses = &imported.fits;
        let worst = poses.iter().map(|fit| fit.rms()).fold(0.0, f64::max);
        let mean = poses.iter().map(|fit| fit.rms()).sum::<f64>() / poses.len() as f64;
        let scale = poses[0].scale;
        let notes = positions.notes().iter().map(ToString::to_string);
        let warnings: Vec<String> = notes.chain(imported.warnings.iter().map(ToString::to_string)).collect();
        for warning in &warnings {
            complain(&format!("warning: {warning}"));
        }
        if self.json {
            return say_json(&json!({
                "file": self.file, "layout": positions.layout.name, "frames": positions.frames.len(),
                "poses": poses.len(), "units_per_metre": scale, "mean_rms_m": mean, "worst_rms_m": worst,
                "unshown": imported.unshown, "warnings": warnings, "out": out,
            }));
        }
        let frames = positions.frames.len();
        say(&format!(
            "read             {frames} frames of {} landmarks ({})",
            positions.layout.landmarks.len(),
            positions.layout.name
        ))?;
        say(&format!(
            "scale            {scale:.4} units of the file in a metre of the {}",
            imported.key_poses.character
        ))?;
        say(&format!(
            "landmarks        {:.1} cm off the body (RMS), {:.1} cm in the worst pose",
            100.0 * mean,
            100.0 * worst
        ))?;
        if !imported.unshown.is_empty() {
            say(&format!("not shown        {} by this layout: near straight", imported.unshown.join(", ")))?;
        }
        say(&format!("key poses        {} ({})", out.display(), poses.len()))
    }
}

/// A built-in layout or one from a file.
fn layout(name: &str) -> Result<LandmarkLayout, Box<dyn Error>> {
    if let Some(layout) = LandmarkLayout::built_in(name) {
        return Ok(layout);
    }
    if !Path::new(name).is_file() {
        let valid = LandmarkLayout::NAMES.join(", ");
        return Err(format!(
            "--layout {name}: no such layout and no such file; valid: {valid}, or the path of a .landmarks.ron file"
        )
        .into());
    }
    Ok(LandmarkLayout::load(name)?)
}
