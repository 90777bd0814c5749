//! The character file (`*.character.ron`): who the links are, how they hang together, what may touch the world.
//!
//! Metres, kilograms, seconds; angles in degrees here and in radians everywhere else. The character frame is Y up, facing
//! -Z, +X to the character's right. A link frame has its origin at the link's joint and is parallel to the character frame
//! in the zero pose.

mod check;
mod parts;

use crate::asset::read_file::{ReadFault, read_bytes};
use crate::asset::{AssetError, CharacterError};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::path::Path;

pub use parts::{FootEntry, FootKindEntry, PointRole, Side, SoleEntry};

/// A character as written in its file. [`Character::parse`] returns only validated ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Character {
    /// Where it was read from, for error messages; not part of the file.
    #[serde(skip)]
    pub file: String,
    /// Name, such as `skater`.
    pub name: String,
    /// Simulation steps per second the character is made for, 1/s.
    pub step_rate: f64,
    /// Servo gains of every joint that names none of its own.
    pub gains: GainsEntry,
    /// Links in any order; the order of the children of one link is kept.
    pub links: Vec<LinkEntry>,
    /// Spheres that may touch the world.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contact_points: Vec<PointEntry>,
    /// Skate blades.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub blades: Vec<BladeEntry>,
    /// Places that can hold on to the world.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grips: Vec<GripEntry>,
    /// Pairs of links that never collide with each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub no_collision: Vec<(String, String)>,
    /// Feet; without them, the blades named `left` and `right`, or what touches the ground at rest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub feet: Vec<FootEntry>,
    /// Name of the link that carries head and arms; without it, where the way up from the hips divides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trunk: Option<String>,
}

/// Gains of a joint's stable PD servo.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainsEntry {
    /// Stiffness, N m/rad.
    pub kp: f64,
    /// Damping, N m s/rad.
    pub kd: f64,
}

/// One body and the joint that carries it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkEntry {
    /// Unique name.
    pub name: String,
    /// Name of the parent; none for the root.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// The joint to the parent.
    pub joint: JointEntry,
    /// Joint position in the zero pose, character frame, m.
    pub position: DVec3,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, link frame, m; without it, that of the shapes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub com: Option<DVec3>,
    /// Inertia about the centre of mass, link axes, as xx, yy, zz, xy, xz, yz (the last three are entries of the matrix, so
    /// minus the products of inertia), kg m^2; without it, that of the shapes at uniform density, holding the link's mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<[f64; 6]>,
    /// Solids for drawing, self-collision and mass distribution, link frame, m. An overlap counts twice.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shapes: Vec<ShapeEntry>,
    /// Servo gains, N m/rad and N m s/rad; without them, the character's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gains: Option<GainsEntry>,
    /// Largest servo torque, N m; without it, unbounded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_torque: Option<f64>,
    /// Range of the joint, degrees; without it, free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitsEntry>,
    /// Inertia that turns with the joint and with no link, kg m^2: a rotor's, times the square of its gear ratio. Without it, zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub armature: Option<f64>,
    /// A passive spring at the joint, such as ligaments are; without it, none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spring: Option<SpringEntry>,
}

/// A spring and a damper that act at a joint whatever it is told to do. No torque limit holds for them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpringEntry {
    /// N m/rad.
    pub stiffness: f64,
    /// N m s/rad.
    #[serde(default)]
    pub damping: f64,
    /// Rotation vector of the joint at which the spring is slack, degrees; of a hinge the part about its axis counts.
    #[serde(default)]
    pub rest: DVec3,
}

/// How a link moves against its parent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum JointEntry {
    /// Free in the world: the root, and only the root.
    Free,
    /// Ball and socket.
    Ball,
    /// Turns about one axis.
    Hinge {
        /// Unit axis, link frame.
        axis: DVec3,
    },
    /// Does not move: the link becomes part of its parent.
    Weld,
}

/// Ranges of the components of a joint's rotation vector (axis times angle, parent axes at rest), each (low, high), degrees.
/// An axis that is not given is free.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitsEntry {
    /// About the axis to the character's right, degrees.
    #[serde(default = "any_angle")]
    pub x: (f64, f64),
    /// About the axis up, degrees.
    #[serde(default = "any_angle")]
    pub y: (f64, f64),
    /// About the axis backwards, degrees.
    #[serde(default = "any_angle")]
    pub z: (f64, f64),
}

/// The range of an axis without limits, degrees.
fn any_angle() -> (f64, f64) {
    (-180.0, 180.0)
}

/// A solid. Link frame, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ShapeEntry {
    /// A box.
    Box {
        /// Centre, link frame, m.
        center: DVec3,
        /// Full edge lengths, m.
        size: DVec3,
        /// Rotation vector (axis times angle) of the box in the link frame, degrees.
        #[serde(default)]
        rotation: DVec3,
    },
    /// A segment with a radius.
    Capsule {
        /// One end of the segment, link frame, m.
        a: DVec3,
        /// The other end, link frame, m.
        b: DVec3,
        /// Radius, m.
        radius: f64,
    },
    /// A ball.
    Sphere {
        /// Centre, link frame, m.
        center: DVec3,
        /// Radius, m.
        radius: f64,
    },
}

/// A sphere on a link that may touch the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointEntry {
    /// Unique name.
    pub name: String,
    /// Name of the link.
    pub link: String,
    /// Centre, link frame, m.
    pub position: DVec3,
    /// Radius, m.
    pub radius: f64,
    /// Factor on the friction coefficient of the surface it touches.
    #[serde(default = "one")]
    pub friction: f64,
    /// What it is part of; without it, `Foot` on the links of a foot and `Body` elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<PointRole>,
}

/// The neutral factor.
fn one() -> f64 {
    1.0
}

/// A skate blade. Its ends become two contact points, `blade_NAME_toe` and `blade_NAME_heel`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BladeEntry {
    /// Unique name, such as `left`.
    pub name: String,
    /// Name of the link.
    pub link: String,
    /// Front end of the running edge, link frame, m.
    pub toe: DVec3,
    /// Rear end of the running edge, link frame, m.
    pub heel: DVec3,
    /// Unit vector across the blade towards the midline (the inside edge), link frame.
    pub inside: DVec3,
    /// How lean turns the blade.
    pub lean_law: LeanLawEntry,
    /// Largest lateral impulse as a multiple of the normal impulse; without it, the blade never skids.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bite: Option<f64>,
}

/// Curvature of a blade's trace over its lean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum LeanLawEntry {
    /// Straight within the dead zone, then proportional to the lean beyond it.
    DeadZone {
        /// Lean below which the blade goes straight, degrees.
        dead_zone: f64,
        /// Yaw per metre and radian of lean beyond the dead zone, 1/(m rad).
        gain: f64,
    },
    /// A blade ground to a circle.
    Rocker {
        /// Rocker radius, m.
        radius: f64,
    },
}

/// A place on a link that can hold on to the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripEntry {
    /// Unique name, such as `left_hand`.
    pub name: String,
    /// Name of the link.
    pub link: String,
    /// Position, link frame, m.
    pub position: DVec3,
    /// Largest force that it can hold by, N; 450 where it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_force: Option<f64>,
}

impl BladeEntry {
    /// Names of the contact points at the toe and at the heel.
    pub fn end_names(&self) -> [String; 2] {
        [format!("blade_{}_toe", self.name), format!("blade_{}_heel", self.name)]
    }
}

impl Character {
    /// Largest file, bytes.
    pub const MAX_BYTES: usize = 1 << 20;
    /// Most links in a file, welded ones included.
    pub const MAX_LINKS: usize = 128;
    /// Most contact points, blade ends included.
    pub const MAX_POINTS: usize = 256;

    /// Parses and validates the bytes of a character file; `file` is the name used in messages.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, AssetError> {
        let name = || file.to_owned();
        if bytes.len() > Self::MAX_BYTES {
            let (bytes, limit) = (bytes.len() as u64, Self::MAX_BYTES as u64);
            return Err(AssetError::TooLarge { file: name(), bytes, limit });
        }
        let text = std::str::from_utf8(bytes)
            .map_err(|error| AssetError::NotText { file: name(), at: error.valid_up_to() })?;
        let mut character: Character = options().from_str(text).map_err(|error| AssetError::Syntax {
            file: name(),
            line: error.span.start.line,
            column: error.span.start.col,
            reason: error.code.to_string().chars().take(400).collect(),
        })?;
        character.file = name();
        character.validate()?;
        Ok(character)
    }

    /// Reads, parses and validates a character file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, AssetError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let bytes = read_bytes(path, Self::MAX_BYTES as u64).map_err(|error| match error.fault {
            ReadFault::TooLarge { bytes, limit } => AssetError::TooLarge { file: file.clone(), bytes, limit },
            fault => AssetError::Read { file: file.clone(), reason: fault.to_string() },
        })?;
        Self::parse(&file, &bytes)
    }

    /// The character `name` as the file at `file` names it: a character file (`NAME.character.ron`) that lies beside that file, and
    /// otherwise the name as it is, a preset's or a path from the working folder.
    pub fn beside(file: &Path, name: &str) -> String {
        let own = file.with_file_name(name);
        if name.ends_with(".character.ron") && own.is_file() { own.to_string_lossy().into_owned() } else { name.into() }
    }

    /// The text of a character file, which [`Character::parse`] reads back; refuses what it would refuse.
    pub fn to_ron(&self) -> Result<String, AssetError> {
        self.validate()?;
        let pretty = ron::ser::PrettyConfig::new().depth_limit(3);
        options().to_string_pretty(self, pretty).map_err(|error| AssetError::Syntax {
            file: self.file.clone(),
            line: 0,
            column: 0,
            reason: error.to_string(),
        })
    }

    /// Checks everything that the types alone do not promise.
    pub fn validate(&self) -> Result<(), CharacterError> {
        check::check(self)
    }
}

/// RON as our files are written: `parent: "pelvis"` without `Some(..)`.
fn options() -> ron::Options {
    ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
}
