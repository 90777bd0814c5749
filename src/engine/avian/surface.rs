//! What colliders are made of, as athletes feel it.

use crate::contact::{Material, Surface};
use avian3d::prelude::Friction;
use bevy::prelude::*;

/// What a collider is made of for athletes: put it on the collider's entity, or on its rigid body for all of that body's colliders.
///
/// Without it, a collider is ordinary ground with the dynamic coefficient of Avian's [`Friction`] (that of the collider, else
/// of its body, else Avian's `DefaultFriction`). Avian's combine rules do not apply: each contact point of a character has a factor of its own.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct AthleteSurface {
    /// Blades act as knife edges on it, as on ice.
    pub carves: bool,
    /// Hands can hold on to it, as to a rail.
    pub grippable: bool,
    /// Coulomb coefficient (finite, not negative; anything else counts as zero).
    pub friction: f32,
}

impl AthleteSurface {
    /// Ice with the friction of the skating paper, 0.02.
    pub const ICE: Self = Self { carves: true, grippable: false, friction: 0.02 };
    /// Ground with friction 0.8.
    pub const GROUND: Self = Self { carves: false, grippable: false, friction: 0.8 };
    /// A rail with friction 0.8, which hands can hold on to.
    pub const RAIL: Self = Self { carves: false, grippable: true, friction: 0.8 };

    /// As the core has it.
    pub fn surface(self) -> Surface {
        let friction = if self.friction.is_finite() { f64::from(self.friction).max(0.0) } else { 0.0 };
        // The two constants are those of the core, not their single-precision neighbours.
        match self {
            Self::ICE => Surface::ICE,
            Self::GROUND => Surface::GROUND,
            Self::RAIL => Surface::RAIL,
            Self { carves, grippable, .. } => {
                let of_its_kind = match (carves, grippable) {
                    (true, _) => Material::ICE,
                    (false, true) => Material::RAIL,
                    (false, false) => Material::GROUND,
                };
                Surface { material: Material { carves, grippable, ..of_its_kind }, friction }
            }
        }
    }

    /// Ground with the friction of a collider.
    pub(super) fn of_friction(friction: &Friction) -> Self {
        Self { friction: friction.dynamic_coefficient, ..Self::GROUND }
    }
}

impl Default for AthleteSurface {
    fn default() -> Self {
        Self::GROUND
    }
}
