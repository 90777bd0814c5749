//! What soles do on the ground.

use crate::asset::{Material, Side};
use bevy::ecs::entity::Entity;
use bevy::math::DVec3;
use bevy::prelude::*;

/// The phases of a step, as gait analysis names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
pub enum FootPhase {
    /// What lies behind the ankle comes down first, or alone again.
    HeelStrike,
    /// What lies before the ankle comes down first.
    ToeStrike,
    /// Both touch.
    FootFlat,
    /// What lies behind the ankle has left the ground.
    HeelOff,
    /// Nothing touches any more.
    ToeOff,
}

/// A sole touches the ground in another way than before, and has done so for 10 ms, or has been off it for 60: for the sound of steps, for dust and for tracks.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct Footstep {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time of the change, s.
    pub time: f64,
    /// Index of the foot in the character.
    pub foot: usize,
    /// The side of the body that it is on; `None` for a foot in the middle.
    #[reflect(ignore)]
    pub side: Option<Side>,
    /// What it has come to.
    pub phase: FootPhase,
    /// Force of the ground when that was certain, world axes, N; zero after [`FootPhase::ToeOff`].
    pub force: DVec3,
    /// Impulse of the ground on the foot from the change until that was certain, world axes, N s: how hard it comes down.
    pub impulse: DVec3,
    /// Where it acts, world frame, m; zero without force.
    pub place: DVec3,
    /// What the ground is made of there; [`Material::GROUND`] without force.
    #[reflect(ignore)]
    pub material: Material,
    /// Speed of what touches along the ground, m/s: a foot that slips.
    pub slip: f64,
}
