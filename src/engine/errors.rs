//! Why a file was not loaded or an athlete not simulated.

use crate::asset::AssetError;
use crate::asset::bone_map::BoneMapError;
use crate::control::ControlError;
use bevy::prelude::*;

/// Why a character or control file could not become an asset.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The bytes could not be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The asset's path.
        file: String,
        /// What the asset source said.
        source: std::io::Error,
    },
    /// The file is no possible character; the message names the file.
    #[error(transparent)]
    Character(#[from] AssetError),
    /// The file is no bone map; the message names the file.
    #[error(transparent)]
    BoneMap(#[from] BoneMapError),
    /// The file is no control that can be played.
    #[error("{file}: {source}")]
    Control {
        /// The asset's path.
        file: String,
        /// What is wrong with it.
        source: Box<ControlError>,
    },
    /// A skill, its motion or its policy, or a program, cannot be used.
    #[error("{file}: {message}")]
    Skill {
        /// The asset's path.
        file: String,
        /// What is wrong with it.
        message: String,
    },
}

/// Why an athlete, its controller or its placement was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AthleteRefusal {
    /// Athletes have the size of their character file.
    #[error("the Transform has scale {scale}; valid: 1 in all directions (sizes come from the character file)")]
    Scale {
        /// The scale found.
        scale: Vec3,
    },
    /// A position or rotation that is no number.
    #[error(
        "the Transform is at {translation} with rotation {rotation}; valid: finite numbers, a rotation of length 1"
    )]
    Transform {
        /// The translation found.
        translation: Vec3,
        /// The rotation found.
        rotation: Quat,
    },
    /// The character or control file could not be loaded.
    #[error("a file could not be loaded: {message}")]
    Load {
        /// The loader's message, with the file's name.
        message: String,
    },
    /// The control, the skill or the program does not fit the character.
    #[error("{message}")]
    Control {
        /// What does not fit.
        message: String,
    },
}

/// Marks an athlete that was refused: it is not simulated. Mend what the reason names and remove this component to try
/// again.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Refused(pub AthleteRefusal);
