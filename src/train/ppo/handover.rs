//! A body as another skill leaves it: where trials of the skill that follows begin.

use crate::control::tracking::TrackedMotion;
use crate::math::Real;
use crate::sim::Simulator;
use glam::{DQuat, DVec3};

/// A body at the tick at which a skill is left, turned so that its reference goes along -Z.
#[derive(Clone, Debug)]
pub struct HandOver {
    /// Height of the root above what carries the body, m.
    pub height: f64,
    /// Rotation of the root.
    pub rotation: DQuat,
    /// Rotations of the joints.
    pub joints: Vec<DQuat>,
    /// Velocity of the root against what carries the body, m/s.
    pub linear: DVec3,
    /// Angular velocity of the root, rad/s, world axes.
    pub angular: DVec3,
    /// Angular velocities of the joints, child axes, rad/s.
    pub joint_velocities: Vec<DVec3>,
    /// Targets of the servos.
    pub targets: Vec<DQuat>,
}

impl HandOver {
    /// A body exactly on a motion at the tick at which it is left, at a mean `speed` (m/s).
    pub(crate) fn of_motion(motion: &TrackedMotion, leave: usize, speed: f64) -> Self {
        let left = motion.tick(leave);
        let (pose, velocity) = (&left.pose, &left.velocity);
        Self {
            height: pose.root_position.y - left.support,
            rotation: pose.root_rotation,
            joints: pose.joints.clone(),
            linear: velocity.root_linear + left.travel * (speed - motion.mean_speed()),
            angular: velocity.root_angular,
            joint_velocities: velocity.joints.clone(),
            targets: pose.joints.clone(),
        }
    }

    /// Puts a lane into it, its root above `place`, whose height is that of the ground.
    pub(crate) fn put<R: Real>(&self, sim: &mut Simulator<R>, lane: usize, place: DVec3) {
        sim.state.set_pose(lane, place + DVec3::Y * self.height, self.rotation, &self.joints);
        sim.state.set_velocity(lane, self.linear, self.angular, &self.joint_velocities);
        for (command, target) in sim.commands.iter_mut().zip(&self.targets) {
            command.rotation.set_lane(lane, *target);
        }
    }
}
