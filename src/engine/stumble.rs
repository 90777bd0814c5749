//! Steps, and what comes before a fall.

use crate::asset::Side;
use bevy::ecs::entity::Entity;
use bevy::math::DVec3;
use bevy::prelude::*;

/// A foot that had left the ground stands again, and another foot carried the body meanwhile: a step of a walk or a run, or one that catches a fall. A
/// jump on both feet is none.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct StepTaken {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time at which the foot came down, s.
    pub time: f64,
    /// Index of the foot in the character.
    pub foot: usize,
    /// The side of the body that it is on; `None` for a foot in the middle.
    #[reflect(ignore)]
    pub side: Option<Side>,
    /// Where its ankle was when it had come down the last time, world frame, m.
    pub from: DVec3,
    /// Where its ankle is now, world frame, m.
    pub to: DVec3,
    /// How long it was off the ground, s.
    pub airtime: f64,
}

/// An athlete is about to lose its balance: a foot caught on something in its swing, or what stands no longer holds a body that balances. Told once until it
/// has been steady for half a second, and of a foot once a swing.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct Stumbled {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time, s.
    pub time: f64,
    /// What happened.
    pub cause: StumbleCause,
}

/// Why an athlete stumbles.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub enum StumbleCause {
    /// A foot met something in its swing at more than [`StumbleCause::CAUGHT`].
    FootCaught {
        /// Index of the foot in the character.
        foot: usize,
        /// Its speed along the surface that it met, m/s.
        speed: f64,
    },
    /// The capture point, where a body that falls like a pendulum would come to rest, lies further than [`StumbleCause::OUTSIDE`] outside of what stands
    /// ([`AthleteController::Balance`](super::AthleteController::Balance) alone looks for that).
    BalanceLost {
        /// How far outside, m.
        outside: f64,
    },
}

impl StumbleCause {
    /// Speed along what it meets at which a foot in its swing is caught, m/s. A foot that comes down at the end of a step is slower.
    pub const CAUGHT: f64 = 1.0;
    /// How far outside of what stands the capture point may lie, m.
    pub const OUTSIDE: f64 = 0.015;
}
