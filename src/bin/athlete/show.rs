//! `athlete show`: what is in a file of key poses or a clip, as a picture.

use crate::motion::load_motion;
use crate::output::{Outcome, say, say_json};
use crate::simulate::in_file;
use crate::world_args::WorldArgs;
use bevy_athlete::asset::Character;
use bevy_athlete::cli::{WorldSpec, check_output, clip_frames, key_pose_frames, load_character, within};
use bevy_athlete::model::KeyPoses;
use bevy_athlete::storyboard::{Ground, Storyboard, StoryboardFrame, StoryboardOptions};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Most figures of a picture.
const MOST: usize = 64;
/// Figures in a row.
const COLUMNS: usize = 8;
/// Size of a figure's cell, pixels.
const CELL: (u32, u32) = (240, 440);
/// Heights of the title and of the band below, and a narrowest width, pixels.
const REST: (u32, u32, u32) = (40, 110, 960);
/// Way from which the band with the path from above says something, m.
const WAY: f64 = 0.3;

#[derive(Debug, Args)]
pub struct Show {
    /// Key poses (.keyposes.ron; one figure for each) or a motion (.clip.ron, .bvh; figures at even times)
    file: PathBuf,
    /// Where to write the picture (PNG)
    #[arg(long)]
    storyboard: PathBuf,
    #[arg(long, help = character_help!("; by default that of the key poses, else skater"))]
    character: Option<String>,
    /// Joint map for a .bvh file, instead of the built-in one that knows its skeleton, or the one that is found
    #[arg(long)]
    map: Option<PathBuf>,
    /// Most figures, 1 to 64; by default 8 for a motion, 64 for key poses
    #[arg(long)]
    figures: Option<usize>,
    /// Where the camera stands, degrees: 0 at the side, the figure facing right; 90 in front; -90 behind
    #[arg(long, default_value_t = 20.0, allow_negative_numbers = true)]
    azimuth: f64,
    #[command(flatten)]
    world: WorldArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Show {
    pub fn run(&self) -> Outcome {
        self.figures.map(|n| within("--figures", n, 1..=MOST, "")).transpose()?;
        within("--azimuth", self.azimuth, -360.0..=360.0, "degrees")?;
        check_output("--storyboard", &self.storyboard)?;
        let keys = self.file.to_string_lossy().ends_with(".keyposes.ron").then(|| KeyPoses::load(&self.file));
        let keys = keys.transpose().map_err(|error| in_file(&self.file, &error))?;
        let own = keys.as_ref().map(|keys| Character::beside(&self.file, &keys.character));
        let model = load_character(self.character.as_deref().or(own.as_deref()).unwrap_or("skater"))?;
        // The whole motion is checked, also where only its key poses are drawn.
        let clip = load_motion(&self.file, self.map.as_deref(), &model)?;
        let frames = match &keys {
            Some(keys) => key_pose_frames(keys, &model).map_err(|error| in_file(&self.file, &error))?,
            None => clip_frames(&clip, &model).map_err(|error| in_file(&self.file, &error))?,
        };
        let asked = self.figures.unwrap_or(if keys.is_some() { MOST } else { 8 });
        let figures = asked.min(frames.len());

        let world = self.world.choose(&model, None)?;
        let columns = figures.min(COLUMNS);
        let rows = figures.div_ceil(columns) as u32;
        let path_band = way(&frames) > WAY;
        let options = StoryboardOptions {
            width: (CELL.0 * columns as u32).max(REST.2),
            height: CELL.1 * rows + REST.0 + if path_band { REST.1 } else { 0 },
            frames: figures,
            columns,
            azimuth: self.azimuth.to_radians(),
            ground: if world.spec() == WorldSpec::Ice { Ground::Ice } else { Ground::Floor },
            scenery: world.scenery(),
            path_band,
            title: format!("{}, {}", model.name, clip.name),
            ..Default::default()
        };
        Storyboard::new(options).write(&model, &frames, &self.storyboard)?;
        let what = if keys.is_some() { "key poses" } else { "poses" };
        let count = if keys.is_some() { frames.len() } else { clip.poses.len() };
        if self.json {
            say_json(&json!({
                "file": self.file, "character": model.name, "name": clip.name, "seconds": clip.duration(),
                "kind": what, "count": count, "figures": figures, "storyboard": self.storyboard,
            }))?;
        } else {
            say(&format!("{}: {count} {what}, {:.2} s, character {}", clip.name, clip.duration(), model.name))?;
            say(&format!("storyboard       {} ({figures} figures)", self.storyboard.display()))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Length of the way from the first root to the furthest, horizontally, m.
fn way(frames: &[StoryboardFrame]) -> f64 {
    let root = |f: &StoryboardFrame| f.links.first().map_or((0.0, 0.0), |l| (l.position.x, l.position.z));
    let Some(start) = frames.first().map(root) else { return 0.0 };
    frames.iter().map(root).map(|(x, z)| (x - start.0).hypot(z - start.1)).fold(0.0, f64::max)
}
