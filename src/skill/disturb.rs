//! Starts that are off: what trials, trainings and programs begin with.

use crate::dynamics::State;
use crate::math::{RandomStream, Real};
use glam::{DQuat, DVec3};

/// How far a start is off at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// Angle of each joint, rad.
    pub joint: f64,
    /// Angular velocity of each joint, rad/s.
    pub joint_velocity: f64,
    /// Velocity of the root, m/s; a third of it upwards.
    pub velocity: f64,
}

/// A vector of components in [-1, 1), cut to length 1.
pub(crate) fn ball(random: &mut RandomStream) -> DVec3 {
    DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), random.range(-1.0, 1.0)).clamp_length_max(1.0)
}

impl Disturbance {
    /// Disturbs a lane of a state; tell the simulator that its state has changed.
    pub fn apply<R: Real>(&self, state: &mut State<R>, lane: usize, random: &mut RandomStream) {
        for joint in state.joints.iter_mut().skip(1) {
            let q = joint.rotation.lane(lane) * DQuat::from_scaled_axis(ball(random) * self.joint);
            joint.rotation.set_lane(lane, q.normalize());
            joint.velocity.set_lane(lane, joint.velocity.lane(lane) + ball(random) * self.joint_velocity);
        }
        let moving = &mut state.root_velocity.linear;
        let level = DVec3::new(1.0, 0.3, 1.0);
        moving.set_lane(lane, moving.lane(lane) + ball(random) * level * self.velocity);
    }
}
