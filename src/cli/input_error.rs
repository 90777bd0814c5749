//! Why an input was refused: what was given, what is wrong with it, what would be valid.

use crate::asset::AssetError;
use crate::model::ImportMotionError;
use std::path::{Path, PathBuf};

/// How a push is written.
pub(super) const VALID_PUSHES: &str =
    "LINK:FX,FY,FZ:START:DURATION, forces in N below 1e5, times in s from 0 to 3600, such as pelvis:0,0,-80:0.5:0.1";
/// The worlds that have a name.
pub(super) const VALID_WORLDS: &str = "ice, ground, empty, stairs, sphere, slope:DEGREES (-60 to 60)";

/// Why an input was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// Neither the name of a preset nor a file.
    #[error(
        "character `{name}`: no such preset and no such file; valid: {valid}, or the path of a .character.ron file"
    )]
    NoCharacter {
        /// What was given.
        name: String,
        /// Names of the presets.
        valid: String,
    },
    /// Neither the name of a skill nor a file of key poses.
    #[error("skill `{name}`: no such skill; valid: {valid}, or the path of a .keyposes.ron file")]
    NoSkill {
        /// What was given.
        name: String,
        /// Names of the skills.
        valid: String,
    },
    /// The character file is wrong.
    #[error(transparent)]
    Character(#[from] AssetError),
    /// The file cannot be used.
    #[error("{}: {reason}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The file has a name that says nothing about what it holds.
    #[error("{}: not a motion by its name; valid: a file that ends in .bvh, .clip.ron or .keyposes.ron", file.display())]
    Kind {
        /// The file.
        file: PathBuf,
    },
    /// The motion could not be put onto the character.
    #[error("{}: {source}{}", file.display(), by_map(source))]
    Motion {
        /// The file.
        file: PathBuf,
        /// Why.
        source: Box<ImportMotionError>,
    },
    /// A text that should be a world.
    #[error("world `{found}`: {reason}; valid: {}", VALID_WORLDS)]
    World {
        /// What was given.
        found: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// A text that should be a push.
    #[error("push `{found}`: {reason}; valid: {}", VALID_PUSHES)]
    Push {
        /// What was given.
        found: String,
        /// What is wrong.
        reason: String,
    },
}

/// What helps where no map was found.
fn by_map(error: &ImportMotionError) -> &'static str {
    if matches!(error, ImportMotionError::NoMap(_)) {
        "; give a map by --map FILE, where a command has no --map to a clip that `athlete join` makes of the file"
    } else {
        ""
    }
}

impl InputError {
    pub(super) fn file(file: &Path, reason: impl std::fmt::Display) -> Self {
        Self::File { file: file.to_path_buf(), reason: reason.to_string() }
    }
}
