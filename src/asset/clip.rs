//! Motion clips: poses over time, by joint name.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// One pose of a clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Root joint position, world frame, m.
    pub root_position: DVec3,
    /// Root rotation, root axes to world axes.
    pub root_rotation: DQuat,
    /// Rotation of each joint of the clip, child axes to parent axes.
    pub joints: Vec<DQuat>,
}

/// A motion: poses at even times. Y up, the character faces -Z, metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionClip {
    /// Name for reports.
    pub name: String,
    /// Poses per second.
    pub frame_rate: f64,
    /// Names of the joints whose rotations the poses hold (link names of the character; the root is not among them).
    pub joints: Vec<String>,
    /// The poses; at least one.
    pub poses: Vec<Pose>,
}
