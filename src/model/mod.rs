//! The frozen description of a character, built once from a validated file.

mod build;
mod character_model;
mod mass;
mod overlap;
mod presets;

pub use character_model::{
    Blade, CharacterModel, ContactKind, ContactPoint, Gains, Grip, JointKind, JointLimits, LeanLaw, Link, Shape,
    SharedModel,
};
pub use presets::{PRESET_NAMES, foot_human, preset, preset_source, runner, skater, two_segment_human};
