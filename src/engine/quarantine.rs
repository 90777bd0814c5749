//! Why a body is stopped, and the checks that find it.

use crate::math::Vec3;
use crate::sim::Simulator;
use bevy::prelude::*;

/// Why an athlete was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect, thiserror::Error)]
#[non_exhaustive]
pub enum QuarantineReason {
    /// A position or rotation of its state was no number before a tick.
    #[error("a position or rotation is no number")]
    Position,
    /// A velocity of its state was no number, or beyond 100 m/s or 200 rad/s of the root or 1000 rad/s of a joint, before
    /// a tick.
    #[error("a velocity is no number or beyond what the step is made for")]
    Velocity,
    /// A joint's target, gain or extra torque was no number.
    #[error("a joint's target, gain or torque is no number")]
    Target,
    /// The policy failed, or its action held a number that is none.
    #[error("the policy failed or its action is no number")]
    Policy,
    /// The terrain answered with something that is no number.
    #[error("the terrain's answer is no number")]
    Terrain,
    /// Its `Transform` was no number.
    #[error("the Transform is no number")]
    Transform,
    /// A force from outside was infinite or no number, or acted on a link that is not there.
    #[error("a force from outside is no number, or its link is not there")]
    Force,
    /// It went out of bounds by itself in the course of a tick.
    #[error("the simulation left the range it is made for")]
    Unstable,
}

/// What keeps a body from being stepped, if anything.
pub(super) fn bad_input(sim: &Simulator<f64>) -> Option<QuarantineReason> {
    let finite = |v: &Vec3<f64>| v.lane(0).is_finite();
    let state = &sim.state;
    let places = finite(&state.root_position)
        && state.root_rotation.lane(0).is_finite()
        && state.joints.iter().all(|j| j.rotation.lane(0).is_finite());
    if !places {
        return Some(QuarantineReason::Position);
    }
    if !sim.is_sane(0) {
        return Some(QuarantineReason::Velocity);
    }
    let commanded = sim.commands.iter().skip(1).all(|c| {
        let numbers = c.kp.is_finite() && c.kd.is_finite();
        numbers && c.rotation.lane(0).is_finite() && finite(&c.velocity) && finite(&c.torque)
    });
    if !commanded {
        return Some(QuarantineReason::Target);
    }
    let links = state.joints.len();
    let pushed = sim.external.iter().all(|f| f.link < links && finite(&f.position) && finite(&f.force));
    (!pushed).then_some(QuarantineReason::Force)
}
