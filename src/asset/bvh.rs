//! BVH motion capture files: reading, checking, and forward kinematics of the file's own skeleton.
//!
//! A [`Bvh`] keeps the file's units, axes and names; nothing is converted here. Conventions that the format leaves
//! open, and how they are read:
//!
//! - Rotation channels multiply in the order of the joint's `CHANNELS` line: `Zrotation Yrotation Xrotation` means
//!   `R = Rz * Ry * Rx` (child axes to parent axes), angles in degrees.
//! - A position channel replaces that component of the joint's `OFFSET`, at the root and at any other joint.
//! - Values of a frame follow the order of the `CHANNELS` lines in the file.

mod parse;

use super::read_file::{ReadFault, read_bytes};
use glam::{DQuat, DVec3};
use std::fmt;
use std::path::{Path, PathBuf};

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// First axis.
    X,
    /// Second axis.
    Y,
    /// Third axis.
    Z,
}

impl Axis {
    /// The unit vector along the axis.
    pub fn unit(self) -> DVec3 {
        match self {
            Axis::X => DVec3::X,
            Axis::Y => DVec3::Y,
            Axis::Z => DVec3::Z,
        }
    }
}

/// What one number of a frame means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Position of the joint in its parent's axes, file units.
    Position(Axis),
    /// Rotation about a parent-side axis, degrees.
    Rotation(Axis),
}

/// A joint of the file's skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct BvhJoint {
    /// Name, unique in the file.
    pub name: String,
    /// Index of the parent, smaller than the joint's own; `None` for the root.
    pub parent: Option<usize>,
    /// Joint position in the parent's axes where no position channel says otherwise, file units.
    pub offset: DVec3,
    /// Channels in the order of the `CHANNELS` line.
    pub channels: Vec<Channel>,
    /// Index of the joint's first value in a frame.
    pub first_channel: usize,
    /// End sites below the joint, joint axes, file units.
    pub end_sites: Vec<DVec3>,
}

/// Place of a joint in the world of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BvhTransform {
    /// Joint position, file's world, file units.
    pub position: DVec3,
    /// Joint axes to world axes of the file.
    pub rotation: DQuat,
}

/// A parsed and checked BVH file: at least one joint and one frame, every value finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    pub(super) joints: Vec<BvhJoint>,
    pub(super) frame_time: f64,
    pub(super) channel_count: usize,
    pub(super) frame_count: usize,
    pub(super) values: Vec<f64>,
    pub(super) warnings: Vec<BvhWarning>,
}

/// A header that does not say what the file holds, and what was read all the same.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BvhWarning {
    /// The header counts other frames than there are.
    FrameCount {
        /// Frames that the header counts.
        declared: usize,
        /// Frames in the file, all of which were read.
        found: usize,
    },
    /// The frame time is no time in seconds.
    FrameTime {
        /// The number in the header.
        declared: f64,
        /// What it was taken for.
        taken: FrameTimeUnit,
        /// Time between frames, s.
        seconds: f64,
    },
}

/// What a frame time that is too long for seconds is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameTimeUnit {
    /// Milliseconds between frames.
    Milliseconds,
    /// Frames per second.
    Rate,
}

impl fmt::Display for BvhWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BvhWarning::FrameCount { declared, found } => {
                write!(f, "the header counts {declared} frames, the file holds {found}; all {found} were read")
            }
            BvhWarning::FrameTime { declared, taken, seconds } => {
                let taken = match taken {
                    FrameTimeUnit::Milliseconds => "milliseconds",
                    FrameTimeUnit::Rate => "a rate in frames per second",
                };
                write!(
                    f,
                    "frame time {declared} is no time between frames in seconds; taken as {taken}: {seconds:.6} s"
                )
            }
        }
    }
}

/// Sizes beyond which a file is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BvhLimits {
    /// Largest text, bytes.
    pub bytes: usize,
    /// Most joints.
    pub joints: usize,
    /// Most frames.
    pub frames: usize,
}

impl Default for BvhLimits {
    fn default() -> Self {
        Self { bytes: 256 << 20, joints: 1024, frames: 1_000_000 }
    }
}

/// Why a BVH file was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BvhError {
    /// The file could not be read.
    #[error("cannot read {path}: {reason}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// A size limit was passed.
    #[error("{what}: {found}, but at most {limit} are read")]
    TooLarge {
        /// Bytes, joints or frames.
        what: &'static str,
        /// Found in the file.
        found: usize,
        /// The limit.
        limit: usize,
    },
    /// The text ended early.
    #[error("the file ends where {expected} should come")]
    UnexpectedEnd {
        /// What would be valid.
        expected: &'static str,
    },
    /// A word where another was due.
    #[error("line {line}: found `{found}` where {expected} should come")]
    UnexpectedToken {
        /// Line, from 1.
        line: usize,
        /// The word.
        found: String,
        /// What would be valid.
        expected: &'static str,
    },
    /// Something is wrong with a joint.
    #[error("line {line}, joint `{joint}`: {problem}")]
    Joint {
        /// Line, from 1.
        line: usize,
        /// The joint.
        joint: String,
        /// What is wrong and what would be valid.
        problem: String,
    },
    /// Not a finite number.
    #[error("line {line}, {place}: `{found}` is not a finite number of size below 1e9")]
    BadNumber {
        /// Line, from 1.
        line: usize,
        /// Joint, frame or header field.
        place: String,
        /// The word.
        found: String,
    },
    /// The frame time is out of range.
    #[error(
        "line {line}: frame time {found} s; valid is 0.00001 to 2 s, or milliseconds, or a rate in frames per second"
    )]
    FrameTime {
        /// Line, from 1.
        line: usize,
        /// Found, s.
        found: f64,
    },
    /// The values are no whole number of frames.
    #[error(
        "line {line}: a row of another length; the header counts {frames} frames, and {found} values are {} frames of {channels} channels and {} values more",
        found / (*channels).max(1),
        found % (*channels).max(1)
    )]
    ValueCount {
        /// The first row whose number of values differs from the channel count, or the last line.
        line: usize,
        /// Frames that the header counts.
        frames: usize,
        /// Channels of all joints.
        channels: usize,
        /// Values that makes.
        needed: usize,
        /// Values found.
        found: usize,
    },
    /// No frames.
    #[error("line {line}: no frames; at least one is needed")]
    NoFrames {
        /// Line, from 1.
        line: usize,
    },
}

impl Bvh {
    /// Reads BVH text with the default limits. Never panics, whatever the text.
    pub fn parse(text: &str) -> Result<Self, BvhError> {
        Self::parse_with_limits(text, BvhLimits::default())
    }

    /// Reads BVH text with the limits given.
    pub fn parse_with_limits(text: &str, limits: BvhLimits) -> Result<Self, BvhError> {
        parse::parse(text, limits)
    }

    /// Reads a BVH file (text that is not UTF-8 is read as far as it is).
    pub fn load(path: impl AsRef<Path>) -> Result<Self, BvhError> {
        let path = path.as_ref();
        let limits = BvhLimits::default();
        let bytes = read_bytes(path, limits.bytes as u64).map_err(|error| match error.fault {
            ReadFault::TooLarge { bytes, .. } => {
                let found = usize::try_from(bytes).unwrap_or(usize::MAX);
                BvhError::TooLarge { what: "bytes", found, limit: limits.bytes }
            }
            fault => BvhError::Read { path: path.to_path_buf(), reason: fault.to_string() },
        })?;
        Self::parse_with_limits(&String::from_utf8_lossy(&bytes), limits)
    }

    /// The joints, parents first.
    pub fn joints(&self) -> &[BvhJoint] {
        &self.joints
    }
    /// Time between frames, s.
    pub fn frame_time(&self) -> f64 {
        self.frame_time
    }
    /// What the header says otherwise than the file.
    pub fn warnings(&self) -> &[BvhWarning] {
        &self.warnings
    }
    /// Number of frames, at least one.
    pub fn frame_count(&self) -> usize {
        self.frame_count
    }
    /// Number of values in a frame.
    pub fn channel_count(&self) -> usize {
        self.channel_count
    }
    /// Time from the first frame to the last, s.
    pub fn duration(&self) -> f64 {
        (self.frame_count - 1) as f64 * self.frame_time
    }
    /// The values of a frame (the last one where `index` is beyond it), file units and degrees.
    pub fn frame(&self, index: usize) -> &[f64] {
        let first = index.min(self.frame_count - 1) * self.channel_count;
        &self.values[first..first + self.channel_count]
    }
    /// One frame with every rotation zero, at the places that the position channels have in the first frame.
    pub fn at_zero(&self) -> Self {
        let mut values = self.frame(0).to_vec();
        for joint in &self.joints {
            for (channel, value) in joint.channels.iter().zip(&mut values[joint.first_channel..]) {
                if matches!(channel, Channel::Rotation(_)) {
                    *value = 0.0;
                }
            }
        }
        Self { frame_count: 1, values, warnings: Vec::new(), joints: self.joints.clone(), ..*self }
    }
    /// Index of the joint with this name.
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }

    /// Position and rotation of a joint against its parent (against the world for the root) in a frame; file units,
    /// parent axes.
    pub fn local_transform(&self, joint: usize, frame: usize) -> BvhTransform {
        let values = self.frame(frame);
        let joint = &self.joints[joint];
        let mut position = joint.offset;
        let mut rotation = DQuat::IDENTITY;
        for (channel, &value) in joint.channels.iter().zip(&values[joint.first_channel..]) {
            match channel {
                Channel::Position(Axis::X) => position.x = value,
                Channel::Position(Axis::Y) => position.y = value,
                Channel::Position(Axis::Z) => position.z = value,
                Channel::Rotation(axis) => {
                    // Reduced first, so that a wild angle costs no accuracy.
                    let angle = (value % 360.0).to_radians();
                    rotation *= DQuat::from_axis_angle(axis.unit(), angle);
                }
            }
        }
        BvhTransform { position, rotation: rotation.normalize() }
    }

    /// Forward kinematics of a frame: the place of every joint in the file's world, file units.
    pub fn world_transforms(&self, frame: usize) -> Vec<BvhTransform> {
        let mut world: Vec<BvhTransform> = Vec::with_capacity(self.joints.len());
        for (index, joint) in self.joints.iter().enumerate() {
            let local = self.local_transform(index, frame);
            world.push(match joint.parent {
                None => local,
                Some(parent) => {
                    let parent = world[parent];
                    BvhTransform {
                        position: parent.position + parent.rotation * local.position,
                        rotation: (parent.rotation * local.rotation).normalize(),
                    }
                }
            });
        }
        world
    }
}
