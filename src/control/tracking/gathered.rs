//! The references of all lanes side by side: each lane is at a tick of its own.

use crate::control::tracking::{TrackedMotion, TrackedTick};
use crate::math::{Quat, Real, Vec3};

/// One [`TrackedTick`](crate::control::tracking::TrackedTick) per lane, in the clip's own world.
#[derive(Clone, Debug)]
pub(crate) struct Gathered<R: Real> {
    pub root_position: Vec3<R>,
    pub root_rotation: Quat<R>,
    pub root_angular: Vec3<R>,
    pub joints: Vec<Quat<R>>,
    pub joint_velocities: Vec<Vec3<R>>,
    pub com_height: R,
    pub com_velocity: Vec3<R>,
    pub ends: Vec<Vec3<R>>,
    pub travel: Vec3<R>,
    pub phase: [R; TrackedMotion::PHASES],
    /// Height of what carries the reference, m, and a mask (1 or 0) of whether a foot of it stands there.
    pub support: R,
    pub stands: R,
}

impl<R: Real> Gathered<R> {
    pub fn new(motion: &TrackedMotion) -> Self {
        let first = motion.tick(0);
        let mut gathered = Self {
            root_position: Vec3::zero(),
            root_rotation: Quat::identity(),
            root_angular: Vec3::zero(),
            joints: vec![Quat::identity(); first.pose.joints.len()],
            joint_velocities: vec![Vec3::zero(); first.pose.joints.len()],
            com_height: R::zero(),
            com_velocity: Vec3::zero(),
            ends: vec![Vec3::zero(); first.ends.len()],
            travel: Vec3::zero(),
            phase: [R::zero(); TrackedMotion::PHASES],
            support: R::zero(),
            stands: R::zero(),
        };
        for lane in 0..R::LANES {
            gathered.set_lane(lane, motion, 0, &[]);
        }
        gathered
    }

    /// Puts lane `lane` at tick `index`, warped to the values of the skill's parameters.
    pub fn set_lane(&mut self, lane: usize, motion: &TrackedMotion, index: usize, values: &[f64]) {
        self.put(lane, motion.tick(index));
        if !motion.warps().is_empty() {
            self.warp(lane, motion, index, values);
        }
    }

    /// Puts lane `lane` where a reference is.
    pub fn put(&mut self, lane: usize, tick: &TrackedTick) {
        self.root_position.set_lane(lane, tick.pose.root_position);
        self.root_rotation.set_lane(lane, tick.pose.root_rotation);
        self.root_angular.set_lane(lane, tick.velocity.root_angular);
        for (mine, theirs) in self.joints.iter_mut().zip(&tick.pose.joints).skip(1) {
            mine.set_lane(lane, *theirs);
        }
        for (mine, theirs) in self.joint_velocities.iter_mut().zip(&tick.velocity.joints).skip(1) {
            mine.set_lane(lane, *theirs);
        }
        self.com_height.set_lane(lane, tick.com.y);
        self.com_velocity.set_lane(lane, tick.com_velocity);
        for (mine, theirs) in self.ends.iter_mut().zip(&tick.ends) {
            mine.set_lane(lane, *theirs);
        }
        self.travel.set_lane(lane, tick.travel);
        for (mine, theirs) in self.phase.iter_mut().zip(&tick.phase) {
            mine.set_lane(lane, *theirs);
        }
        self.support.set_lane(lane, tick.support);
        self.stands.set_lane(lane, f64::from(u8::from(tick.stands)));
    }

    /// Moves a lane by what its parameters ask for.
    fn warp(&mut self, lane: usize, motion: &TrackedMotion, index: usize, values: &[f64]) {
        for warp in motion.warps() {
            let (moved, moving) = warp.offset(index, values);
            self.root_position.set_lane(lane, self.root_position.lane(lane) + moved);
            self.com_height.set_lane(lane, self.com_height.lane(lane) + moved.y);
            self.com_velocity.set_lane(lane, self.com_velocity.lane(lane) + moving);
            // Ground that the neutral motion has raised is raised with the motion.
            if motion.tick(index).support != 0.0 {
                self.support.set_lane(lane, self.support.lane(lane) + moved.y);
            }
        }
    }
}
