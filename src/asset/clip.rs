//! Motion clips: poses over time, by joint name.
//!
//! Reading and writing files: `clip_file.rs`; making other clips from a clip: `clip_edit.rs`; a clip laid out for one
//! character: [`crate::model::ModelClip`].

use super::turn::{rotation_vector, slerp};
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// One pose of a clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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
#[serde(deny_unknown_fields)]
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

/// How fast a pose changes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseVelocity {
    /// Velocity of the root joint, world frame, m/s.
    pub root_linear: DVec3,
    /// Angular velocity of the root, world frame, rad/s.
    pub root_angular: DVec3,
    /// Angular velocity of each joint of the clip against its parent, child frame, rad/s.
    pub joints: Vec<DVec3>,
}

/// Why a clip was refused or could not be changed as asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClipError {
    /// A file could not be read or written.
    #[error("clip file {path}: {reason}")]
    File {
        /// The file.
        path: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// The text is no clip.
    #[error("clip text, line {line}, column {column}: {reason}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        reason: String,
    },
    /// A size limit was passed.
    #[error("clip: {found} {what}, but at most {limit} are allowed")]
    TooLarge {
        /// Bytes, joints or poses.
        what: &'static str,
        /// Found.
        found: usize,
        /// The limit.
        limit: usize,
    },
    /// The frame rate is out of range.
    #[error("clip `{clip}`: frame rate {found} /s; valid is 0.001 to 100000 /s")]
    FrameRate {
        /// The clip.
        clip: String,
        /// Found, 1/s.
        found: f64,
    },
    /// The clip has no poses.
    #[error("clip `{clip}` has no poses; at least one is needed")]
    NoPoses {
        /// The clip.
        clip: String,
    },
    /// A joint name is empty or comes twice.
    #[error("clip `{clip}`: joint name `{joint}` is empty or comes twice")]
    JointName {
        /// The clip.
        clip: String,
        /// The name.
        joint: String,
    },
    /// A pose has too few or too many joints.
    #[error("clip `{clip}`, pose {pose}: {found} joint rotations, but the clip names {expected} joints")]
    JointCount {
        /// The clip.
        clip: String,
        /// Index of the pose.
        pose: usize,
        /// Rotations in the pose.
        found: usize,
        /// Joints of the clip.
        expected: usize,
    },
    /// A position or rotation is no number, or a rotation has no unit length.
    #[error("clip `{clip}`, pose {pose}, {place}: {found}; valid is {expected}")]
    Value {
        /// The clip.
        clip: String,
        /// Index of the pose.
        pose: usize,
        /// Root position, root rotation or the joint's name.
        place: String,
        /// The value.
        found: String,
        /// What would be valid.
        expected: &'static str,
    },
    /// An option of an edit is out of range.
    #[error("clip `{clip}`: {option} is {found}; valid is {expected}")]
    Option {
        /// The clip.
        clip: String,
        /// The option.
        option: &'static str,
        /// Its value.
        found: f64,
        /// What would be valid.
        expected: &'static str,
    },
    /// A joint has a side but no partner on the other.
    #[error("clip `{clip}`: joint `{joint}` has no partner `{partner}`, so the clip cannot be mirrored")]
    NoPartner {
        /// The clip.
        clip: String,
        /// The joint.
        joint: String,
        /// The name looked for.
        partner: String,
    },
    /// A clip lacks a joint that another one has.
    #[error("clip `{clip}`: no joint `{joint}`, which the first clip has; both need the same joints to be joined")]
    OtherJoints {
        /// The clip.
        clip: String,
        /// The joint.
        joint: String,
    },
    /// A joint is no link of the character.
    #[error("clip `{clip}`: joint `{joint}` is no link of character `{character}`, which has: {links}")]
    UnknownJoint {
        /// The clip.
        clip: String,
        /// The joint.
        joint: String,
        /// The character.
        character: String,
        /// Its links.
        links: String,
    },
}

/// Most joints of a clip.
pub const MAX_JOINTS: usize = 1024;
/// Most poses of a clip.
pub const MAX_POSES: usize = 1_000_000;
/// Largest coordinate of a root position, m.
const MAX_COORDINATE: f64 = 1e6;

/// The frame before time `t` and the fraction of the way to the next; clamped to the clip, NaN counts as 0.
pub(crate) fn frame_at(t: f64, frame_rate: f64, count: usize) -> (usize, f64) {
    let last = count.saturating_sub(1);
    let x = (t * frame_rate).max(0.0).min(last as f64);
    let frame = (x.floor() as usize).min(last.saturating_sub(1));
    (frame, x - frame as f64)
}

impl MotionClip {
    /// Time from the first pose to the last, s.
    pub fn duration(&self) -> f64 {
        self.poses.len().saturating_sub(1) as f64 / self.frame_rate
    }

    /// The pose at time `t` (s from the start, clamped to the clip): positions linear, rotations along the shorter arc
    /// (slerp). A clip without poses gives the identity at the origin.
    pub fn sample(&self, t: f64) -> Pose {
        let (frame, s) = frame_at(t, self.frame_rate, self.poses.len());
        let Some(a) = self.poses.get(frame) else {
            let joints = vec![DQuat::IDENTITY; self.joints.len()];
            return Pose { root_position: DVec3::ZERO, root_rotation: DQuat::IDENTITY, joints };
        };
        match self.poses.get(frame + 1) {
            Some(b) if s > 0.0 => a.mix(b, s),
            _ => a.clone(),
        }
    }

    /// How fast the pose changes at time `t` (s, clamped): central differences over one frame interval, one-sided at
    /// the ends of the clip. World frame for the root, child frame for joints.
    pub fn sample_velocity(&self, t: f64) -> PoseVelocity {
        let (t0, t1) = difference_interval(t, self.frame_rate, self.duration());
        let (a, b) = (self.sample(t0), self.sample(t1));
        let per_second = if t1 > t0 { 1.0 / (t1 - t0) } else { 0.0 };
        PoseVelocity {
            root_linear: (b.root_position - a.root_position) * per_second,
            root_angular: rotation_vector(b.root_rotation * a.root_rotation.conjugate()) * per_second,
            joints: a.joints.iter().zip(&b.joints).map(|(a, b)| joint_velocity(*a, *b, per_second)).collect(),
        }
    }

    /// Whether every count, name and number is valid: unique names, as many rotations as joints, everything finite,
    /// quaternions of unit length (to 0.001).
    pub fn validate(&self) -> Result<(), ClipError> {
        let clip = || self.name.clone();
        if self.joints.len() > MAX_JOINTS {
            return Err(ClipError::TooLarge { what: "joints", found: self.joints.len(), limit: MAX_JOINTS });
        }
        if self.poses.len() > MAX_POSES {
            return Err(ClipError::TooLarge { what: "poses", found: self.poses.len(), limit: MAX_POSES });
        }
        if !(1e-3..=1e5).contains(&self.frame_rate) {
            return Err(ClipError::FrameRate { clip: clip(), found: self.frame_rate });
        }
        if self.poses.is_empty() {
            return Err(ClipError::NoPoses { clip: clip() });
        }
        for (index, joint) in self.joints.iter().enumerate() {
            if joint.is_empty() || self.joints[..index].contains(joint) {
                return Err(ClipError::JointName { clip: clip(), joint: joint.clone() });
            }
        }
        for (pose, p) in self.poses.iter().enumerate() {
            let (found, expected) = (p.joints.len(), self.joints.len());
            if found != expected {
                return Err(ClipError::JointCount { clip: clip(), pose, found, expected });
            }
            if !(p.root_position.abs().max_element() <= MAX_COORDINATE && p.root_position.is_finite()) {
                let (place, found) = ("root position".into(), p.root_position.to_string());
                return Err(ClipError::Value { clip: clip(), pose, place, found, expected: "finite, within 1e6 m" });
            }
            let rotations = std::iter::once(("root rotation", &p.root_rotation));
            let rotations = rotations.chain(self.joints.iter().map(String::as_str).zip(&p.joints));
            for (place, q) in rotations {
                let off = (q.length_squared() - 1.0).abs();
                // A NaN is not within the bound either.
                if off.is_nan() || off > 2e-3 {
                    let (place, found) = (place.to_owned(), q.to_string());
                    return Err(ClipError::Value { clip: clip(), pose, place, found, expected: "a unit quaternion" });
                }
            }
        }
        Ok(())
    }
}

/// Times half a frame before and after `t`, within the clip.
pub(crate) fn difference_interval(t: f64, frame_rate: f64, duration: f64) -> (f64, f64) {
    let half = 0.5 / frame_rate;
    let t = t.max(0.0).min(duration);
    ((t - half).max(0.0), (t + half).min(duration))
}

/// Angular velocity that takes one child-to-parent rotation to the other, child frame, rad/s.
pub(crate) fn joint_velocity(a: DQuat, b: DQuat, per_second: f64) -> DVec3 {
    rotation_vector(a.conjugate() * b) * per_second
}

impl Pose {
    /// The pose a fraction `s` in [0, 1] of the way to another.
    pub fn mix(&self, other: &Pose, s: f64) -> Pose {
        Pose {
            root_position: self.root_position.lerp(other.root_position, s),
            root_rotation: slerp(self.root_rotation, other.root_rotation, s),
            joints: self.joints.iter().zip(&other.joints).map(|(a, b)| slerp(*a, *b, s)).collect(),
        }
    }
}
