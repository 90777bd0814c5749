//! What a course file is made of.

use super::Quantity;
use serde::{Deserialize, Serialize};

/// A material of the file's own.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialEntry {
    /// Unique name.
    pub name: String,
    /// Blades act as knife edges on it.
    #[serde(default)]
    pub carves: bool,
    /// Hands can hold on to it.
    #[serde(default)]
    pub grippable: bool,
}

/// A part of a course.
///
/// `ahead`, `right`, `up` (m) are the middle of its front at the bottom, `yaw` (degrees) turns it to the left about the vertical
/// there. `material` and `friction` say what it is made of, `motion` how it moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub enum SolidEntry {
    /// A box: `depth` along the way, `width` across, `height`, m. With `edge` the edges of its top can be held on to.
    Box {
        ahead: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        right: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        up: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        yaw: Quantity,
        depth: Quantity,
        width: Quantity,
        height: Quantity,
        #[serde(default, skip_serializing_if = "is_false")]
        edge: bool,
        #[serde(default = "wall")]
        material: String,
        #[serde(default = "friction")]
        friction: Quantity,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        motion: Option<MotionEntry>,
    },
    /// A level rod across the way with round ends: `length` between their centres, `radius`; `up` is the height of its axis, m.
    Rail {
        ahead: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        right: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        up: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        yaw: Quantity,
        length: Quantity,
        radius: Quantity,
        #[serde(default = "rail")]
        material: String,
        #[serde(default = "friction")]
        friction: Quantity,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        motion: Option<MotionEntry>,
    },
    /// `count` steps up, each `tread` deep and `rise` higher than the one before, `width` across, m.
    Stairs {
        ahead: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        right: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        up: Quantity,
        count: usize,
        tread: Quantity,
        rise: Quantity,
        width: Quantity,
        #[serde(default = "ground")]
        material: String,
        #[serde(default = "friction")]
        friction: Quantity,
    },
    /// A slab whose upper face rises from its front by `height` over `length` (level), `width` across, `thickness` square to the
    /// face, m. A negative height falls.
    Ramp {
        ahead: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        right: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        up: Quantity,
        #[serde(default = "zero", skip_serializing_if = "is_zero")]
        yaw: Quantity,
        length: Quantity,
        width: Quantity,
        height: Quantity,
        #[serde(default = "thickness")]
        thickness: Quantity,
        #[serde(default = "ground")]
        material: String,
        #[serde(default = "friction")]
        friction: Quantity,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        motion: Option<MotionEntry>,
    },
    /// A gap in the course's ground, right across, `length` m long and without a bottom.
    Gap { ahead: Quantity, length: Quantity },
    /// Rough ground from `ahead` on: nodes every `spacing` m over `length` and `width`, their heights drawn evenly from -`amplitude`
    /// to `amplitude` (m) by the seed of the course, straight between them; level at the border.
    Bumps { ahead: Quantity, length: f64, width: f64, spacing: f64, amplitude: Quantity },
}

/// How a solid moves: its place is a function of the time alone. Directions are (right, up, ahead).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum MotionEntry {
    /// To and fro about its place, as a sine.
    Sway {
        /// Direction.
        along: (Quantity, Quantity, Quantity),
        /// Furthest from its place, m.
        amplitude: Quantity,
        /// Periods in a second, Hz.
        frequency: Quantity,
    },
    /// Once, from its place by a way, at minimum jerk.
    Jerk {
        /// The way, m.
        by: (Quantity, Quantity, Quantity),
        /// When it begins, s.
        start: Quantity,
        /// How long it takes, s.
        seconds: Quantity,
    },
    /// From its place by a way and back again, over and over, at constant speed.
    Cross {
        /// The way, m.
        by: (Quantity, Quantity, Quantity),
        /// Speed, m/s.
        speed: Quantity,
    },
}

pub(super) fn zero() -> Quantity {
    Quantity::ZERO
}

pub(super) fn is_zero(quantity: &Quantity) -> bool {
    *quantity == Quantity::ZERO
}

fn is_false(value: &bool) -> bool {
    !value
}

fn friction() -> Quantity {
    Quantity::Number(0.8)
}

fn thickness() -> Quantity {
    Quantity::Number(0.3)
}

fn wall() -> String {
    "wall".to_owned()
}

fn rail() -> String {
    "rail".to_owned()
}

fn ground() -> String {
    "ground".to_owned()
}

impl SolidEntry {
    /// What kind of part it is, as in the file.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Box { .. } => "Box",
            Self::Rail { .. } => "Rail",
            Self::Stairs { .. } => "Stairs",
            Self::Ramp { .. } => "Ramp",
            Self::Gap { .. } => "Gap",
            Self::Bumps { .. } => "Bumps",
        }
    }

    /// Name of its material, unless it is part of the ground.
    pub fn material(&self) -> Option<&str> {
        match self {
            Self::Box { material, .. }
            | Self::Rail { material, .. }
            | Self::Stairs { material, .. }
            | Self::Ramp { material, .. } => Some(material),
            Self::Gap { .. } | Self::Bumps { .. } => None,
        }
    }

    /// All its numbers with the names of their fields.
    pub(super) fn quantities(&self) -> Vec<(&'static str, &Quantity)> {
        match self {
            Self::Box { ahead, right, up, yaw, depth, width, height, friction, motion, .. } => {
                let own = [
                    ("ahead", ahead),
                    ("right", right),
                    ("up", up),
                    ("yaw", yaw),
                    ("depth", depth),
                    ("width", width),
                    ("height", height),
                    ("friction", friction),
                ];
                own.into_iter().chain(motion.iter().flat_map(MotionEntry::quantities)).collect()
            }
            Self::Rail { ahead, right, up, yaw, length, radius, friction, motion, .. } => {
                let own = [
                    ("ahead", ahead),
                    ("right", right),
                    ("up", up),
                    ("yaw", yaw),
                    ("length", length),
                    ("radius", radius),
                    ("friction", friction),
                ];
                own.into_iter().chain(motion.iter().flat_map(MotionEntry::quantities)).collect()
            }
            Self::Stairs { ahead, right, up, tread, rise, width, friction, .. } => vec![
                ("ahead", ahead),
                ("right", right),
                ("up", up),
                ("tread", tread),
                ("rise", rise),
                ("width", width),
                ("friction", friction),
            ],
            Self::Ramp { ahead, right, up, yaw, length, width, height, thickness, friction, motion, .. } => {
                let own = [
                    ("ahead", ahead),
                    ("right", right),
                    ("up", up),
                    ("yaw", yaw),
                    ("length", length),
                    ("width", width),
                    ("height", height),
                    ("thickness", thickness),
                    ("friction", friction),
                ];
                own.into_iter().chain(motion.iter().flat_map(MotionEntry::quantities)).collect()
            }
            Self::Gap { ahead, length } => vec![("ahead", ahead), ("length", length)],
            Self::Bumps { ahead, amplitude, .. } => vec![("ahead", ahead), ("amplitude", amplitude)],
        }
    }
}

impl MotionEntry {
    fn quantities(&self) -> Vec<(&'static str, &Quantity)> {
        match self {
            Self::Sway { along: (x, y, z), amplitude, frequency } => {
                vec![("along", x), ("along", y), ("along", z), ("amplitude", amplitude), ("frequency", frequency)]
            }
            Self::Jerk { by: (x, y, z), start, seconds } => {
                vec![("by", x), ("by", y), ("by", z), ("start", start), ("seconds", seconds)]
            }
            Self::Cross { by: (x, y, z), speed } => vec![("by", x), ("by", y), ("by", z), ("speed", speed)],
        }
    }
}
