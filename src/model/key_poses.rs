//! Key poses written by hand: a pose every few tenths of a second, by joint name, in degrees.
//!
//! Angles are the components of each joint's rotation vector in the character frame (X to the right, Y up, Z backwards; the
//! character faces -Z). For a skater or runner standing upright: `+x` bends the hip, shoulder and elbow forwards and
//! lifts the toes, `-x` bends the knee and the trunk forwards, `+y` turns to the left, `+z` tilts to the left (a hanging
//! arm or leg goes to the right).
//!
//! Poses become a clip by monotone cubic curves through the angles. The body travels along -Z at the file's speed; its
//! height is such that the lowest contact point is on the ground, or given.
//!
//! With a curvature the root travels on a circle, and the heading turns with it: the pose's own root rotation and lateral
//! place count from the heading. A negative speed travels backwards, facing the way it came from.
//!
//! Contacts name points that lie still between poses ([`KeyContact`]): the joints that lead to them give way, so that a standing foot does
//! not slide and a hand is where the obstacle is.
//!
//! With `mass_on_path` it is the centre of mass that travels, however the body turns above it; between take-off and
//! landing, where poses are airborne, it also follows the parabola of free fall.

mod check;
mod curves;

use crate::asset::clip::ClipError;
use crate::asset::clip_edit::other_side;
use crate::asset::read_file::read_text;
use crate::model::key_contacts::KeyContact;
use crate::model::{OptimizeRecord, Window};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Key poses, as saved in a `*.keyposes.ron` file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyPoses {
    /// Name of the motion.
    pub name: String,
    /// Character whose links are named.
    pub character: String,
    /// Speed along -Z, m/s; negative travels backwards along +Z, facing -Z.
    pub speed: f64,
    /// Turn of the heading for each metre travelled, 1/m: positive turns to the left, counter-clockwise seen from above,
    /// forwards and backwards. So the centre of the circle is to the left of the direction of travel: forwards on the
    /// athlete's left, backwards on its right. The heading starts along -Z. In the air the path is straight.
    #[serde(default)]
    pub curvature: f64,
    /// Change of the speed, m/s^2: a coasting skater slows down.
    #[serde(default)]
    pub acceleration: f64,
    /// If true, the centre of mass travels on the path instead of the root.
    #[serde(default)]
    pub mass_on_path: bool,
    /// Seconds from each pose to the next; the last one leads to the first of the next repetition.
    pub seconds: Vec<f64>,
    /// The poses.
    pub poses: Vec<KeyPose>,
    /// Points that lie still between poses: joints give way.
    #[serde(default)]
    pub contacts: Vec<KeyContact>,
    /// If true, each repetition is followed by its mirror image.
    #[serde(default)]
    pub mirrored: bool,
    /// How often the poses are repeated (a mirror image counts with its original).
    #[serde(default = "one")]
    pub repeat: usize,
    /// Poses per second of the clip.
    #[serde(default = "thirty")]
    pub frame_rate: f64,
    /// Parts of one repetition (without its mirror image) and what is asked of the simulated motion there; none where
    /// the poses are all there is.
    #[serde(default)]
    pub windows: Vec<Window>,
    /// How the windows are optimised.
    #[serde(default)]
    pub optimize: OptimizeRecord,
}

fn one() -> usize {
    1
}
fn thirty() -> f64 {
    30.0
}

/// One pose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyPose {
    /// Place of the root, or with `mass_on_path` of the centre of mass, beside the path, m: to the right of the heading.
    #[serde(default)]
    pub lateral: f64,
    /// Height of the root, m; by default the lowest contact point is on the support. Given in every pose or in none.
    #[serde(default)]
    pub height: Option<f64>,
    /// Height of what the pose stands on, m: the top of a box, of a stair. Heights are those of the poses between.
    #[serde(default)]
    pub support: f64,
    /// Turn about the vertical from the heading, degrees, to the left; beyond 360 it counts whole turns. Comes before
    /// `root`.
    #[serde(default)]
    pub turn: f64,
    /// In the air: from the pose before it to the next one that is not, the centre of mass falls freely. Needs
    /// `mass_on_path`, no `height`, and poses on the ground before and after.
    #[serde(default)]
    pub airborne: bool,
    /// Rotation vector of the root from the heading and the turn, degrees.
    #[serde(default)]
    pub root: (f64, f64, f64),
    /// Rotation vectors of the joints, degrees; joints that are not named are straight.
    #[serde(default)]
    pub joints: BTreeMap<String, (f64, f64, f64)>,
}

/// Why key poses were refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum KeyPoseError {
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The text is not a key pose file.
    #[error("{}: not a key pose file: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Where and why.
        message: String,
    },
    /// A value cannot be used.
    #[error("key poses {name}: {place}: {found}; {valid}")]
    Value {
        /// Name of the motion.
        name: String,
        /// Pose and field.
        place: String,
        /// What was found.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// The clip does not fit the character.
    #[error(transparent)]
    Clip(#[from] ClipError),
}

impl KeyPose {
    /// The pose seen in a mirror that swaps left and right.
    pub fn mirrored(&self) -> Self {
        let flip = |(x, y, z): (f64, f64, f64)| (x, -y, -z);
        Self {
            lateral: -self.lateral,
            turn: -self.turn,
            root: flip(self.root),
            joints: self.joints.iter().map(|(name, v)| (other_side(name), flip(*v))).collect(),
            ..self.clone()
        }
    }
}

/// Largest file, bytes.
const MAX_KEY_POSE_BYTES: u64 = 4 << 20;

impl KeyPoses {
    /// Reads a file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, KeyPoseError> {
        let path = path.as_ref();
        let text = read_text(path, MAX_KEY_POSE_BYTES)
            .map_err(|e| KeyPoseError::Io { path: path.to_path_buf(), source: e.into() })?;
        Self::from_ron(&text, path)
    }

    /// Reads text; `path` is for messages.
    pub fn from_ron(text: &str, path: impl AsRef<Path>) -> Result<Self, KeyPoseError> {
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        options
            .from_str(text)
            .map_err(|e| KeyPoseError::Syntax { path: path.as_ref().to_path_buf(), message: e.to_string() })
    }
}
