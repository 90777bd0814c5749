//! The frozen description of a character, built once from a validated file.

mod character_model;

pub use character_model::{
    Blade, CharacterModel, ContactKind, ContactPoint, Gains, Grip, JointKind, JointLimits, LeanLaw, Link, Shape,
    SharedModel,
};

mod mjcf;
mod model_clip;
mod retarget;
mod sole_height;

pub use mjcf::export_mjcf;
pub use model_clip::{LinkTransform, ModelClip, ModelPose, ModelVelocity};
pub use retarget::{ImportError, import_bvh};
pub use sole_height::SoleHeights;
