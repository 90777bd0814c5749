//! `athlete export-mjcf`: a character for MuJoCo.

use crate::output::{Outcome, say};
use bevy_athlete::cli::load_character;
use bevy_athlete::model::{PRESET_NAMES, export_mjcf};
use bevy_athlete::scenes::{SCENE_NAMES, scene};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, Args)]
pub struct ExportMjcf {
    /// Name of a preset, path of a .character.ron file, or name of a scene of `athlete bench` (its character with the
    /// scene's contact points and friction)
    #[arg(long)]
    character: String,
    /// File to write
    out: PathBuf,
}

impl ExportMjcf {
    pub fn run(&self) -> Outcome {
        let model = match scene(&self.character) {
            Some(scene) => scene.exported_model(),
            None => (*load_character(&self.character).map_err(|error| match error {
                bevy_athlete::cli::InputError::NoCharacter { name, .. } => format!(
                    "--character `{name}`: no preset ({}), no scene ({}) and no file of that name",
                    PRESET_NAMES.join(", "),
                    SCENE_NAMES.join(", ")
                ),
                other => other.to_string(),
            })?)
            .clone(),
        };
        std::fs::write(&self.out, export_mjcf(&model))
            .map_err(|error| format!("cannot write {}: {error}", self.out.display()))?;
        say(&format!(
            "{}: {}, {} links, {} degrees of freedom, {} contact points",
            self.out.display(),
            model.name,
            model.links.len(),
            model.dof(),
            model.contact_points.len()
        ))?;
        Ok(ExitCode::SUCCESS)
    }
}
