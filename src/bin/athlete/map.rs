//! `athlete map`: what the skeleton of a BVH file is taken for, as a table and as a joint map to edit.

use crate::motion::warn;
use crate::output::{Outcome, say, say_json};
use crate::simulate::in_file;
use bevy_athlete::asset::bvh::Bvh;
use bevy_athlete::cli::{ArgumentError, check_output, keep_earlier, load_character, map_picture};
use bevy_athlete::model::{CharacterModel, FoundMap, find_map, import_motion};
use bevy_athlete::storyboard::{Ground, Storyboard, StoryboardOptions};
use clap::Args;
use serde_json::json;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Instants of the motion in the picture.
const POSES: usize = 7;
/// Cells in a row, and the size of one, pixels.
const COLUMNS: usize = 4;
const CELL: (u32, u32) = (460, 360);
/// Height of the title, pixels.
const TITLE: u32 = 50;
/// Where the camera stands: between the figure's side and its front, rad.
const AZIMUTH: f64 = 0.9;
const ENDING: &str = ".map.ron";

#[derive(Debug, Args)]
pub struct Map {
    /// Motion (.bvh)
    file: PathBuf,
    #[arg(long, help = character_help!(), default_value = "skater")]
    character: String,
    /// Where to write the map (.map.ron); without it, it is only shown
    #[arg(long)]
    out: Option<PathBuf>,
    /// Replace the file at --out
    #[arg(long, requires = "out")]
    force: bool,
    /// Write a picture (PNG): the skeleton of the file beside the character that follows it, in the pose at zero and in the motion
    #[arg(long)]
    storyboard: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Map {
    pub fn run(&self) -> Outcome {
        if let Some(out) = &self.out {
            if !out.to_string_lossy().ends_with(ENDING) {
                return Err(ArgumentError::new("--out", out.display(), format!("a name that ends in {ENDING}")).into());
            }
            check_output("--out", out)?;
            keep_earlier("--out", core::slice::from_ref(out), self.force, "a new file")?;
        }
        if let Some(path) = &self.storyboard {
            check_output("--storyboard", path)?;
        }
        let model = load_character(&self.character)?;
        let bvh = Bvh::load(&self.file).map_err(|error| in_file(&self.file, &error))?;
        let mut found = find_map(&bvh, &model).map_err(|error| in_file(&self.file, &error))?;
        if let Some(stem) = self.file.file_stem() {
            found.map.name = stem.to_string_lossy().into_owned();
        }
        let table = found.table();
        if let Some(out) = &self.out {
            let remarks = [
                format!(
                    "Found for {} on {}; how to correct it: docs/book/motions.md, \"BVH and joint maps\".",
                    self.file.display(),
                    model.name
                ),
                table.clone(),
            ];
            found.map.save(out, &remarks)?;
        }
        // What the map makes of the motion is told as well: a map with a wrong rest pose looks right as a table.
        let imported = import_motion(&bvh, Some(&found.map), &model).map_err(|error| in_file(&self.file, &error))?;
        if let Some(path) = &self.storyboard {
            self.draw(path, &bvh, &found, &model)?;
        }
        let mut warnings: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
        warnings.extend(imported.warnings.iter().map(ToString::to_string));
        if self.json {
            let rows: Vec<_> = found
                .rows
                .iter()
                .map(|row| json!({"link": row.link, "joints": row.joints, "up": row.up, "facing": row.facing}))
                .collect();
            say_json(&json!({
                "file": self.file, "character": model.name, "frames": bvh.frame_count(), "frame_time_s": bvh.frame_time(),
                "unit": found.unit, "metres_per_unit": found.map.unit, "leg_m": found.leg,
                "pose_at_zero": found.rest.to_string(), "rows": rows,
                "unmapped": found.unmapped.iter().map(|(joint, reason)| json!([joint, reason])).collect::<Vec<_>>(),
                "warnings": warnings, "out": self.out, "storyboard": self.storyboard,
            }))?;
        } else {
            say(&format!(
                "read             {} frames, {:.6} s each, {} joints",
                bvh.frame_count(),
                bvh.frame_time(),
                bvh.joints().len()
            ))?;
            say(&table)?;
            if let Some(out) = &self.out {
                say(&format!("map              {}", out.display()))?;
            }
            if let Some(path) = &self.storyboard {
                say(&format!("storyboard       {}", path.display()))?;
            }
        }
        for warning in &found.warnings {
            crate::output::complain(&format!("warning: {warning}"));
        }
        warn(&imported.warnings);
        Ok(ExitCode::SUCCESS)
    }

    /// The skeleton of the file on the left, the character on the right.
    fn draw(&self, path: &Path, bvh: &Bvh, found: &FoundMap, model: &CharacterModel) -> Result<(), Box<dyn Error>> {
        let picture = map_picture(bvh, found, model, POSES, AZIMUTH).map_err(|error| in_file(&self.file, &error))?;
        let cells = picture.frames.len();
        let rows = cells.div_ceil(COLUMNS) as u32;
        let options = StoryboardOptions {
            width: CELL.0 * cells.clamp(2, COLUMNS) as u32,
            height: CELL.1 * rows + TITLE,
            frames: cells,
            columns: COLUMNS,
            azimuth: AZIMUTH,
            ground: Ground::Floor,
            path_band: false,
            title: format!("{} on {}, red: drives or follows nothing", found.map.name, model.name),
            ..Default::default()
        };
        Ok(Storyboard::new(options).write(&picture.model, &picture.frames, path)?)
    }
}
