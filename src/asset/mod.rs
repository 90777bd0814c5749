//! Files to validated data and back: characters, motion clips, BVH, joint maps, bone maps, contracts of policies, robustness
//! cards, state as bytes.

pub mod bone_map;
pub mod bvh;
pub mod card;
mod character;
pub mod clip;
pub(crate) mod clip_edit;
mod clip_file;
pub mod course;
pub mod dense_layers;
mod error;
pub mod joint_map;
mod joint_map_text;
pub mod joint_positions;
pub mod landmark_layout;
mod material;
pub mod policy_contract;
pub mod policy_fit;
pub mod read_file;
mod state_bytes;
pub(crate) mod turn;

pub use character::{
    BladeEntry, Character, FootEntry, FootKindEntry, GainsEntry, GripEntry, JointEntry, LeanLawEntry, LimitsEntry,
    LinkEntry, PointEntry, PointRole, ShapeEntry, Side, SoleEntry, SpringEntry,
};
pub use course::{Course, CourseError, CourseInstance};
pub use error::{AssetError, CharacterError};
pub use material::Material;
pub use state_bytes::{StateError, StateReader, StateWriter};
