//! What tells the joints where to go: targets sampled from a clip, open-loop controls, trained policies (feature `policy`);
//! and what joints did: recorded clips.

pub mod balance;
mod drive;
mod fall;
pub mod foot;
mod joint_weights;
mod motion_recorder;
mod open_loop;
#[cfg(feature = "policy")]
mod policy;
#[cfg(feature = "policy")]
mod policy_affine;
#[cfg(feature = "policy")]
mod policy_error;
#[cfg(feature = "policy")]
mod policy_file;
#[cfg(feature = "policy")]
mod policy_graph;
#[cfg(feature = "policy")]
mod policy_normaliser;
mod reference;
pub mod terms;
pub mod tracking;

pub use drive::{apply_initial_state, command_pose};
pub use fall::{FALL_ANGLE, FALL_DEPTH, Fall, fallen};
pub use joint_weights::joint_weights;
pub use motion_recorder::MotionRecorder;
pub use open_loop::{ControlError, ControlPlayer, Offset, ReconstructedControl};
#[cfg(feature = "train")]
pub(crate) use open_loop::{offset_rotation, window_blend};
#[cfg(feature = "policy")]
pub use policy::{GOLDEN_TOLERANCE, Policy};
#[cfg(feature = "policy")]
pub use policy_error::PolicyError;
#[cfg(feature = "policy")]
pub use policy_file::MAX_POLICY_BYTES;
#[cfg(all(feature = "policy", feature = "train"))]
pub(crate) use policy_file::{decode, read_bytes};
#[cfg(feature = "policy")]
pub use policy_graph::OPERATORS;
#[cfg(all(feature = "policy", feature = "train"))]
pub(crate) use policy_graph::{check_and_clean, tensor_values};
pub use reference::{Reference, ReferenceTick, TrackingError, tracking_error};
