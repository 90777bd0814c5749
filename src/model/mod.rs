//! The frozen description of a character, built once from a validated file.

mod character_model;

pub use character_model::{
    Blade, CharacterModel, ContactKind, ContactPoint, Gains, Grip, JointKind, JointLimits, LeanLaw, Link, Shape,
    SharedModel,
};
