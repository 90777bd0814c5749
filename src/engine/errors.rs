//! Why a file was not loaded or an athlete not simulated.

use crate::asset::bone_map::BoneMapError;
use crate::asset::clip::ClipError;
use crate::asset::{AssetError, CourseError};
use crate::control::balance::BalanceError;
use crate::control::{ControlError, PolicyError};
use crate::model::KeyPoseError;
use crate::skill::{GraphError, ProgramError, SkillError, TrainedSkillError};
use bevy::asset::{AssetLoadError, ReadAssetBytesError};
use bevy::prelude::*;
use std::sync::Arc;

/// Why a file could not become an asset.
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
    /// A file that belongs to a skill could not be read.
    #[error("{file}: {source}")]
    Part {
        /// The asset's path.
        file: String,
        /// What the asset server said.
        source: Box<ReadAssetBytesError>,
    },
    /// The description of a skill cannot be used; the message names the file.
    #[error(transparent)]
    Skill(Box<SkillError>),
    /// The motion of a skill is no clip.
    #[error("{file}: {source}")]
    Clip {
        /// The asset's path.
        file: String,
        /// What is wrong with it.
        source: Box<ClipError>,
    },
    /// The motion of a skill is no key poses; the message names the file.
    #[error(transparent)]
    KeyPoses(Box<KeyPoseError>),
    /// The policy of a skill cannot be used; the message names the file.
    #[error(transparent)]
    Policy(Box<PolicyError>),
    /// The motion of a skill is another one than its policy was learnt from.
    #[error("{file}: fingerprint {found}; valid: {wanted}, the motion that the policy beside it was learnt from")]
    OtherMotion {
        /// The motion's path.
        file: String,
        /// Its fingerprint.
        found: String,
        /// That of the policy's contract.
        wanted: String,
    },
    /// The course of a skill cannot be used; the message names the file.
    #[error(transparent)]
    Course(Box<CourseError>),
    /// The program cannot be used; the message names the file.
    #[error(transparent)]
    Program(Box<ProgramError>),
}

/// Why a skill does not fit a body.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SkillMisfit {
    /// Its motion cannot be laid out for the body.
    #[error("the skill {skill} does not fit {character}: {source}")]
    Motion {
        /// The skill.
        skill: String,
        /// The character of the body.
        character: String,
        /// Why.
        source: Box<KeyPoseError>,
    },
    /// Its parts do not fit the body or each other.
    #[error("the skill {skill} does not fit {character}: {source}")]
    Parts {
        /// The skill.
        skill: String,
        /// The character of the body.
        character: String,
        /// Why.
        source: Box<TrainedSkillError>,
    },
    /// It was made for another body, and its files are not at hand.
    #[error(
        "the skill {skill} was made for another body than this {character}; valid: one with the same links and masses"
    )]
    OtherBody {
        /// The skill.
        skill: String,
        /// The character of the body.
        character: String,
    },
}

/// Why an athlete, its controller or its placement was refused.
#[derive(Clone, Debug, thiserror::Error)]
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
    /// A file could not be loaded; the message names it.
    #[error("a file could not be loaded: {0}")]
    Load(Arc<AssetLoadError>),
    /// The control does not fit the character.
    #[error("{0}")]
    Control(Arc<ControlError>),
    /// A skill does not fit the character.
    #[error("{0}")]
    Skill(Arc<SkillMisfit>),
    /// The program cannot be performed.
    #[error("{0}")]
    Program(Arc<ProgramError>),
    /// The skills cannot follow each other, or not at the character's steps per second.
    #[error("{0}")]
    Graph(Arc<GraphError>),
    /// The character cannot balance so: its feet lack what the pose stands on.
    #[error("{0}")]
    Balance(Arc<BalanceError>),
}

impl From<SkillError> for LoadError {
    fn from(error: SkillError) -> Self {
        Self::Skill(Box::new(error))
    }
}

impl From<KeyPoseError> for LoadError {
    fn from(error: KeyPoseError) -> Self {
        Self::KeyPoses(Box::new(error))
    }
}

impl From<PolicyError> for LoadError {
    fn from(error: PolicyError) -> Self {
        Self::Policy(Box::new(error))
    }
}

impl From<ProgramError> for LoadError {
    fn from(error: ProgramError) -> Self {
        Self::Program(Box::new(error))
    }
}

impl From<BalanceError> for AthleteRefusal {
    fn from(error: BalanceError) -> Self {
        Self::Balance(Arc::new(error))
    }
}

impl From<ControlError> for AthleteRefusal {
    fn from(error: ControlError) -> Self {
        Self::Control(Arc::new(error))
    }
}

impl From<SkillMisfit> for AthleteRefusal {
    fn from(error: SkillMisfit) -> Self {
        Self::Skill(Arc::new(error))
    }
}

impl From<ProgramError> for AthleteRefusal {
    fn from(error: ProgramError) -> Self {
        Self::Program(Arc::new(error))
    }
}

impl From<GraphError> for AthleteRefusal {
    fn from(error: GraphError) -> Self {
        Self::Graph(Arc::new(error))
    }
}

/// Marks an athlete that was refused: it is not simulated. Mend what the reason names and remove this component to try
/// again.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(opaque)]
#[reflect(Component)]
pub struct Refused(pub AthleteRefusal);
