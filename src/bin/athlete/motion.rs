//! Motions from files, with what they were taken for on stderr.

use crate::output::complain;
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::cli::{InputError, load_motion_with};
use bevy_athlete::model::{CharacterModel, FoundMap, ImportWarning, ImportedMotion};
use std::path::Path;

/// The motion in a file. What was taken for what, and what a person should know, goes to stderr.
pub fn load_motion(file: &Path, map: Option<&Path>, model: &CharacterModel) -> Result<MotionClip, InputError> {
    let motion = load_motion_with(file, map, model)?;
    tell(file, &motion);
    Ok(motion.clip)
}

/// What a motion was taken for, and what a person should know, on stderr: every command that reads a motion says it so.
pub fn tell(file: &Path, motion: &ImportedMotion) {
    if let Some(found) = &motion.found {
        complain(&format!("{}: no built-in map has this skeleton; what it was taken for:", file.display()));
        complain(&found.table());
        complain(&correct(file, found));
    }
    warn(&motion.warnings);
}

/// How to correct a map that was found.
fn correct(file: &Path, found: &FoundMap) -> String {
    format!(
        "to correct it: athlete map {} --character {} --out my.map.ron, edit, then --map my.map.ron",
        file.display(),
        found.character
    )
}

/// Warnings, a line each.
pub fn warn(warnings: &[ImportWarning]) {
    for warning in warnings {
        complain(&format!("warning: {warning}"));
    }
}
