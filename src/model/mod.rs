//! The frozen description of a character, built once from a validated file.

mod build;
mod character_model;
mod key_poses;
mod mass;
mod mass_path;
mod mjcf;
mod model_clip;
mod overlap;
mod presets;
mod retarget;
mod sole_height;
mod windows;

pub use character_model::{
    Blade, CharacterModel, ContactKind, ContactPoint, Gains, Grip, JointKind, JointLimits, LeanLaw, Link, Shape,
    SharedModel,
};
pub use key_poses::{KeyPose, KeyPoseError, KeyPoses};
pub use mjcf::export_mjcf;
pub use model_clip::{LinkTransform, ModelClip, ModelPose, ModelVelocity};
pub use presets::{PRESET_NAMES, foot_human, preset, preset_source, runner, skater, two_segment_human};
pub use retarget::{ImportError, import_bvh};
pub use sole_height::SoleHeights;
pub use windows::{BodyPart, Objective, OptimizeRecord, Side, Window};
