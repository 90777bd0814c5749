mod character;
mod character_check;
pub mod clip;
mod error;

pub use character::{
    BladeEntry, Character, GainsEntry, GripEntry, JointEntry, LeanLawEntry, LimitsEntry, LinkEntry, PointEntry,
    ShapeEntry,
};
pub use error::{AssetError, CharacterError};
