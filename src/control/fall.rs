//! When a character that follows a reference counts as fallen.

use crate::control::TrackingError;
use crate::math::Real;
use crate::model::ModelPose;
use crate::sim::Simulator;

/// How far below its reference the root may be, m.
pub const FALL_DEPTH: f64 = 0.35;
/// How far the root may be turned against its reference, rad: 80 degrees.
pub const FALL_ANGLE: f64 = 1.4;

/// In what way a character fell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fall {
    /// The root is more than [`FALL_DEPTH`] below its reference.
    TooLow,
    /// The root is turned by more than [`FALL_ANGLE`] against its reference.
    Turned,
    /// The state left the range the step is made for (see [`Simulator::is_sane`]).
    OutOfRange,
}

impl Fall {
    /// A few words for reports.
    pub fn words(self) -> &'static str {
        match self {
            Fall::TooLow => "root more than 0.35 m below its reference",
            Fall::Turned => "root turned by more than 80 degrees against its reference",
            Fall::OutOfRange => "state out of range",
        }
    }
}

/// Whether lane `lane` has fallen, judged by the pose it should be in; `error` is its tracking error there.
pub fn fallen<R: Real>(sim: &Simulator<R>, lane: usize, pose: &ModelPose, error: &TrackingError) -> Option<Fall> {
    if !sim.is_sane(lane) {
        Some(Fall::OutOfRange)
    } else if pose.root_position.y - sim.state.root_position.y.lane(lane) > FALL_DEPTH {
        Some(Fall::TooLow)
    } else if error.root_angle > FALL_ANGLE {
        Some(Fall::Turned)
    } else {
        None
    }
}
