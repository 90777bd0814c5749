//! Files to validated data and back: characters, motion clips, BVH, joint maps.

pub mod bvh;
mod bvh_parse;
mod character;
mod character_check;
pub mod clip;
mod clip_edit;
mod clip_file;
mod error;
pub mod joint_map;
pub(crate) mod turn;

pub use character::{
    BladeEntry, Character, GainsEntry, GripEntry, JointEntry, LeanLawEntry, LimitsEntry, LinkEntry, PointEntry,
    ShapeEntry,
};
pub use error::{AssetError, CharacterError};
