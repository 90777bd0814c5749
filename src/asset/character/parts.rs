//! What the parts of a character are for: its feet, its hands, its trunk.
//!
//! All of it is optional in a character file; `model/body_parts.rs` says what is taken instead.

use serde::{Deserialize, Serialize};

/// Left or right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    /// The athlete's left.
    Left,
    /// The athlete's right.
    Right,
}

impl Side {
    /// The other one.
    pub fn other(self) -> Self {
        match self {
            Side::Left => Side::Right,
            Side::Right => Side::Left,
        }
    }
    /// As in the names of links and blades.
    pub fn name(self) -> &'static str {
        match self {
            Side::Left => "left",
            Side::Right => "right",
        }
    }
}

/// What a contact point is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PointRole {
    /// A foot or a blade: made to be stood on.
    Foot,
    /// A hand: may be put on an obstacle.
    Hand,
    /// Anything else: whoever lies on it has fallen.
    Body,
}

/// What a foot stands with.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FootKindEntry {
    /// Contact points of its links.
    Sole,
    /// The blade of this name.
    Blade(String),
}

/// A shoe's sole under a foot, as thick everywhere; `model/soles.rs` says how it follows the foot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoleEntry {
    /// From the bare foot's lowest points to the underside, m.
    pub thickness: f64,
    /// How far it reaches beyond the bare foot's foremost point, m.
    #[serde(default)]
    pub front: f64,
    /// The same behind, m.
    #[serde(default)]
    pub rear: f64,
    /// The same on either side, m.
    #[serde(default)]
    pub side: f64,
    /// Factor on the friction coefficient of the surface it touches; it takes the place of the bare points' own.
    #[serde(default = "one")]
    pub friction: f64,
    /// Mass of the shoe, kg.
    pub mass: f64,
}

/// The neutral factor.
fn one() -> f64 {
    1.0
}

/// A foot: the links that it is made of and what it stands with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FootEntry {
    /// The side of the body; none for a foot in the middle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<Side>,
    /// What it stands with.
    pub kind: FootKindEntry,
    /// Names of its links, at least one.
    pub links: Vec<String>,
    /// Name of the contact point at its front; without it, the blade's toe, or the foremost of the lowest points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toe: Option<String>,
    /// Name of the contact point at its rear; without it, the blade's heel, or the rearmost of the lowest points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heel: Option<String>,
    /// A shoe's sole under it; without it, the foot is bare.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sole: Option<SoleEntry>,
}
