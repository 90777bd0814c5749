//! Worlds that have a name.

use super::input_error::{InputError, VALID_WORLDS};
use crate::contact::{Geometry, Solid, Surface, World};
use crate::model::{CharacterModel, Shape};
use glam::{DQuat, DVec3};
use std::str::FromStr;

/// Depth of a tread of the stairs, m.
const TREAD: f64 = 0.30;
/// Rise of a step of the stairs, m.
const RISE: f64 = 0.15;
/// Steps of the stairs.
const STEPS: usize = 10;
/// Where the stairs begin: so far ahead (-Z) of the origin, m.
const STAIRS_START: f64 = -1.0;
/// Width of the stairs, m.
const WIDTH: f64 = 3.0;
/// Radius of the globe, m.
const GLOBE: f64 = 20.0;

/// A world as named on the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WorldSpec {
    /// Level ice at y = 0.
    Ice,
    /// Level ground at y = 0.
    Ground,
    /// Nothing.
    Empty,
    /// Ten steps up (-Z), 0.15 m each, from 1 m ahead of the origin.
    Stairs,
    /// Ground through the origin that rises ahead (-Z) by this angle, degrees.
    Slope(f64),
    /// A globe of ground, 20 m in radius, with its top at the origin.
    Sphere,
}

impl WorldSpec {
    /// What can be parsed.
    pub const VALID: &'static str = VALID_WORLDS;

    /// Ice for a character with blades, ground for others.
    pub fn default_for(model: &CharacterModel) -> Self {
        if model.blades.is_empty() { WorldSpec::Ground } else { WorldSpec::Ice }
    }

    /// The world.
    pub fn world(&self) -> World {
        match *self {
            WorldSpec::Ice => World::ice(),
            WorldSpec::Ground => World::ground(),
            WorldSpec::Empty => World::empty(),
            WorldSpec::Stairs => World::stairs(STAIRS_START, STEPS, TREAD, RISE, WIDTH, Surface::GROUND),
            WorldSpec::Slope(degrees) => World {
                solids: vec![Solid::tilted_plane(DVec3::ZERO, DVec3::X, degrees.to_radians(), 0.0, Surface::GROUND)],
            },
            WorldSpec::Sphere => World {
                solids: vec![Solid::fixed(
                    Geometry::Sphere { center: DVec3::Y * -GLOBE, radius: GLOBE },
                    Surface::GROUND,
                )],
            },
        }
    }

    /// Solids to draw besides the floor.
    pub fn scenery(&self) -> Vec<Shape> {
        match *self {
            WorldSpec::Slope(degrees) => {
                let rotation = DQuat::from_rotation_x(degrees.to_radians());
                let half_extents = DVec3::new(1.5, 0.05, 4.0);
                vec![Shape::Box { center: rotation * DVec3::Y * -half_extents.y, half_extents, rotation }]
            }
            _ => self.world().solids.iter().filter_map(drawn).collect(),
        }
    }
}

/// A solid as a shape, if it has an end.
pub(super) fn drawn(solid: &Solid) -> Option<Shape> {
    match solid.geometry {
        Geometry::Box { center, half_extents, rotation } => Some(Shape::Box { center, half_extents, rotation }),
        Geometry::Rail { center, half, radius } => Some(Shape::Capsule { a: center - half, b: center + half, radius }),
        _ => None,
    }
}

impl std::fmt::Display for WorldSpec {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            WorldSpec::Ice => f.write_str("ice"),
            WorldSpec::Ground => f.write_str("ground"),
            WorldSpec::Empty => f.write_str("empty"),
            WorldSpec::Stairs => f.write_str("stairs"),
            WorldSpec::Slope(degrees) => write!(f, "slope:{degrees}"),
            WorldSpec::Sphere => f.write_str("sphere"),
        }
    }
}

impl FromStr for WorldSpec {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        let bad = |reason| InputError::World { found: text.to_owned(), reason };
        match text {
            "ice" => return Ok(WorldSpec::Ice),
            "ground" => return Ok(WorldSpec::Ground),
            "empty" => return Ok(WorldSpec::Empty),
            "stairs" => return Ok(WorldSpec::Stairs),
            "sphere" => return Ok(WorldSpec::Sphere),
            _ => {}
        }
        let degrees = text.strip_prefix("slope:").ok_or_else(|| bad("no such world"))?;
        let degrees: f64 = degrees.parse().map_err(|_| bad("the slope is no number"))?;
        if (-60.0..=60.0).contains(&degrees) { Ok(WorldSpec::Slope(degrees)) } else { Err(bad("too steep")) }
    }
}
