//! Handing a reference to the servos, and starting a simulation from one.

use crate::control::ReferenceTick;
use crate::math::{Quat, Real, Vec3};
use crate::sim::Simulator;

/// Makes the reference the servos' target, in every lane: rotations and velocities.
pub fn command_pose<R: Real>(sim: &mut Simulator<R>, tick: &ReferenceTick) {
    for (i, command) in sim.commands.iter_mut().enumerate().skip(1) {
        command.rotation = Quat::splat(tick.pose.joints[i]);
        command.velocity = Vec3::splat(tick.velocity.joints[i]);
    }
}

/// Puts every lane into the reference's pose and velocity, and forgets warm starts.
pub fn apply_initial_state<R: Real>(sim: &mut Simulator<R>, tick: &ReferenceTick) {
    for lane in 0..R::LANES {
        let (p, v) = (&tick.pose, &tick.velocity);
        sim.state.set_pose(lane, p.root_position, p.root_rotation, &p.joints);
        sim.state.set_velocity(lane, v.root_linear, v.root_angular, &v.joints);
    }
    sim.state.contact_impulses.fill(Vec3::zero());
    sim.state.release_all();
    sim.state.time = 0.0;
    sim.state_changed();
}
