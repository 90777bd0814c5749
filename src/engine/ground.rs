//! What a body is stepped on.

use crate::contact::{Terrain, World as Surroundings};
use crate::sim::Simulator;
use bevy::prelude::Component;

/// Something to stand on that may move and be pushed while a tick is stepped.
pub(crate) trait Ground: Terrain<f64> {
    /// Called after every step of the athlete: moving parts go on by the length of a step.
    fn stepped(&mut self, simulator: &Simulator<f64>) {
        let _ = simulator;
    }
}

impl Ground for &Surroundings {}

/// Marks an athlete that is stepped on a ground of its own, not on [`AthleteWorld`](super::AthleteWorld) alone: another
/// system does it.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct OwnGround;
