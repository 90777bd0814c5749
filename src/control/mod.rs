//! What tells the joints where to go: targets sampled from a clip, and open-loop controls; and what joints did: recorded
//! clips.

mod drive;
mod fall;
mod motion_recorder;
mod open_loop;
mod reference;

pub use drive::{apply_initial_state, command_pose};
pub use fall::{FALL_ANGLE, FALL_DEPTH, Fall, fallen};
pub use motion_recorder::MotionRecorder;
pub use open_loop::{ControlError, ControlPlayer, Offset, ReconstructedControl};
#[cfg(feature = "train")]
pub(crate) use open_loop::{offset_rotation, window_blend};
pub use reference::{Reference, ReferenceTick, TrackingError, tracking_error};
