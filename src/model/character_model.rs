//! The frozen description of a character that the dynamics reads.

use crate::asset::{PointRole, Side};
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;

/// How a link moves against its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Six degrees of freedom against the world: the root, and only the root.
    Free,
    /// Three degrees of freedom: a ball-and-socket joint.
    Ball,
    /// One degree of freedom about a unit axis (link frame, equal to the parent frame at rest).
    Hinge {
        /// Unit axis, link frame.
        axis: DVec3,
    },
}

impl JointKind {
    /// Number of degrees of freedom.
    pub fn dof(&self) -> usize {
        match self {
            JointKind::Free => 6,
            JointKind::Ball => 3,
            JointKind::Hinge { .. } => 1,
        }
    }
}

/// Gains of the stable PD servo of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Stiffness, N m/rad.
    pub kp: f64,
    /// Damping, N m s/rad.
    pub kd: f64,
}

/// A passive spring and damper at a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSpring {
    /// N m/rad.
    pub stiffness: f64,
    /// N m s/rad.
    pub damping: f64,
    /// Rotation vector of the joint at which it is slack, rad; along the axis of a hinge.
    pub rest: DVec3,
}

/// The range of a joint: bounds on each component of its rotation vector (exponential map of the joint rotation, parent
/// axes at rest), rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Lower bounds, rad.
    pub low: DVec3,
    /// Upper bounds, rad.
    pub high: DVec3,
}

/// A solid for drawing, self-collision and mass distribution. Link frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A box.
    Box {
        /// Centre.
        center: DVec3,
        /// Half of the edge lengths.
        half_extents: DVec3,
        /// Box axes to link axes.
        rotation: DQuat,
    },
    /// A segment with a radius.
    Capsule {
        /// One end of the segment.
        a: DVec3,
        /// The other end.
        b: DVec3,
        /// Radius.
        radius: f64,
    },
    /// A ball.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius.
        radius: f64,
    },
}

/// One rigid body and the joint that carries it.
///
/// The link frame has its origin at the joint. In the zero pose all link frames are parallel to the character frame
/// (Y up, facing -Z, +X to the character's right).
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Unique name.
    pub name: String,
    /// Index of the parent, always smaller than the link's own; `None` for the root.
    pub parent: Option<usize>,
    /// The joint to the parent.
    pub joint: JointKind,
    /// Joint position in the parent's link frame, m (zero for the root).
    pub offset: DVec3,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, link frame, m.
    pub com: DVec3,
    /// Rotational inertia about the centre of mass, link axes, kg m^2.
    pub inertia: DMat3,
    /// Servo gains.
    pub gains: Gains,
    /// Largest servo torque, N m; infinite where the file names none.
    pub max_torque: f64,
    /// Joint range; `None` is free.
    pub limits: Option<JointLimits>,
    /// Inertia on the joint's own velocity, about every axis it turns about, kg m^2: it adds to the diagonal of the joint-space mass
    /// matrix and to no link's inertia, as a geared rotor's does (Featherstone 2008, "Rigid Body Dynamics Algorithms", Section 9.6).
    pub armature: f64,
    /// A passive spring; `None` for most joints.
    pub spring: Option<JointSpring>,
    /// Solids.
    pub shapes: Vec<Shape>,
}

/// Whether a contact point is an ordinary one or an end of a blade.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactKind {
    /// A sphere with Coulomb friction.
    Point,
    /// The front (toe) end of the blade with this index.
    BladeToe(usize),
    /// The rear (heel) end of the blade with this index.
    BladeHeel(usize),
}

/// A sphere on a link that may touch the world.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoint {
    /// Name, unique in the character.
    pub name: String,
    /// Link index.
    pub link: usize,
    /// Centre of the sphere, link frame, m.
    pub position: DVec3,
    /// Radius, m; zero for a blade end.
    pub radius: f64,
    /// Factor on the friction coefficient of the surface it touches.
    pub friction: f64,
    /// Ordinary or blade.
    pub kind: ContactKind,
    /// What it is part of.
    pub role: PointRole,
}

/// How leaning turns the line that a blade must follow: curvature in 1/m as a function of the lean angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LeanLaw {
    /// Zero within the dead zone, then proportional: `gain * (lean - dead_zone)`. After Yu, Park, Lee 2019, Section 4.2.
    DeadZone {
        /// Lean below which the blade goes straight, rad.
        dead_zone: f64,
        /// Yaw per metre and radian of lean beyond the dead zone, 1/(m rad).
        gain: f64,
    },
    /// A blade ground to a circle: `sin(lean) / radius`.
    Rocker {
        /// Rocker radius, m.
        radius: f64,
    },
}

/// A skate blade: a line between two contact points.
#[derive(Clone, Debug, PartialEq)]
pub struct Blade {
    /// Name, such as `left`.
    pub name: String,
    /// Link index.
    pub link: usize,
    /// Contact point at the front end.
    pub toe: usize,
    /// Contact point at the rear end.
    pub heel: usize,
    /// Unit vector across the blade towards the body's midline (the inside edge), link frame.
    pub inside: DVec3,
    /// How lean turns the blade.
    pub lean_law: LeanLaw,
    /// Largest lateral impulse as a multiple of the blade's normal impulse, beyond which it skids; `None` never skids.
    pub bite: Option<f64>,
}

/// A place on a link that can hold on to the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Grip {
    /// Name, such as `left_hand`.
    pub name: String,
    /// Link index.
    pub link: usize,
    /// Position, link frame, m.
    pub position: DVec3,
    /// Largest force that it can hold by, N; beyond it slips.
    pub max_force: f64,
}

impl Grip {
    /// What a grip holds by where the file does not say, N: a strong hand on a rung that it can close about.
    pub const DEFAULT_FORCE: f64 = 450.0;
}

/// What a foot stands with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FootKind {
    /// Contact points of its links.
    Sole,
    /// The blade with this index.
    Blade(usize),
}

/// A foot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Foot {
    /// The side of the body; `None` for a foot in the middle.
    pub side: Option<Side>,
    /// What it stands with.
    pub kind: FootKind,
    /// Indices of its links, ascending.
    pub links: Vec<usize>,
    /// Index of the contact point at its front.
    pub toe: usize,
    /// Index of the contact point at its rear.
    pub heel: usize,
}

/// A character: immutable, built once from a validated file, shared by [`Arc`].
///
/// Links are in depth-first order, so the subtree of a link is the range that starts at it.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacterModel {
    /// Name, such as `skater`.
    pub name: String,
    /// Simulation steps per second the character is made for.
    pub step_rate: f64,
    /// Links, root first, depth-first.
    pub links: Vec<Link>,
    /// Contact points.
    pub contact_points: Vec<ContactPoint>,
    /// Blades.
    pub blades: Vec<Blade>,
    /// Grips.
    pub grips: Vec<Grip>,
    /// Pairs of links that may collide with each other.
    pub collision_pairs: Vec<(usize, usize)>,
    /// Feet; empty for a body that stands on none.
    pub feet: Vec<Foot>,
    /// Index of the link that carries head and arms.
    pub trunk: usize,
}

/// A shared model.
pub type SharedModel = Arc<CharacterModel>;

impl CharacterModel {
    /// Number of degrees of freedom, the root's six included.
    pub fn dof(&self) -> usize {
        self.links.iter().map(|l| l.joint.dof()).sum()
    }
    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.links.iter().map(|l| l.mass).sum()
    }
    /// Index of the link with this name.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|l| l.name == name)
    }
    /// Index of the blade that the foot of a side stands with.
    pub fn blade_index(&self, side: Side) -> Option<usize> {
        match self.foot(side)?.kind {
            FootKind::Blade(blade) => Some(blade),
            FootKind::Sole => None,
        }
    }
    /// The blade that the foot of a side stands with.
    pub fn blade_of(&self, side: Side) -> Option<&Blade> {
        self.blade_index(side).map(|k| &self.blades[k])
    }
    /// The links without children: hands, feet, head.
    pub fn end_links(&self) -> Vec<usize> {
        (1..self.links.len()).filter(|&i| !self.links.iter().any(|l| l.parent == Some(i))).collect()
    }
    /// Joint positions in the zero pose, character frame with the root at the origin, m.
    pub fn rest_positions(&self) -> Vec<DVec3> {
        let mut positions: Vec<DVec3> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            positions.push(link.parent.map_or(DVec3::ZERO, |p| positions[p] + link.offset));
        }
        positions
    }
    /// Height of the root above the lowest contact sphere in the zero pose, m.
    pub fn rest_root_height(&self) -> f64 {
        let positions = self.rest_positions();
        self.contact_points.iter().map(|c| c.radius - positions[c.link].y - c.position.y).fold(0.0, f64::max)
    }
}
