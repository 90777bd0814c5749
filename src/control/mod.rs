//! What tells the joints where to go: targets sampled from a clip, and open-loop controls.

mod drive;
mod fall;
mod joint_weights;
mod open_loop;
mod reference;
pub mod tracking;

pub use drive::{apply_initial_state, command_pose};
pub use fall::{FALL_ANGLE, FALL_DEPTH, Fall, fallen};
pub use joint_weights::joint_weights;
pub use open_loop::{ControlError, ControlPlayer, Offset, ReconstructedControl};
#[cfg(feature = "train")]
pub(crate) use open_loop::{offset_rotation, window_blend};
pub use reference::{Reference, ReferenceTick, TrackingError, tracking_error};
