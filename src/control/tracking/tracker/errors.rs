//! How far a body is from its reference.

use super::Tracker;
use crate::math::{Quat, Real};
use crate::sim::Simulator;

/// Squared errors of the lanes against their references.
#[derive(Clone, Copy, Debug)]
pub struct TrackingTerms<R> {
    /// Mean squared joint angle, rad^2.
    pub pose: R,
    /// Mean squared joint velocity error, (rad/s)^2.
    pub velocity: R,
    /// Mean squared distance of the end links, relative to the root, m^2.
    pub ends: R,
    /// Squared angle between the roots' rotations, rad^2.
    pub root: R,
    /// Squared error of the root's angular velocity, (rad/s)^2.
    pub spin: R,
    /// Height of the centre of mass against the reference's, m.
    pub height: R,
    /// Squared error of the centre of mass's velocity, (m/s)^2.
    pub com_velocity: R,
    /// Squared horizontal distance of the root, m^2.
    pub place: R,
    /// Mean squared angle of the feet's joints, rad^2.
    pub feet: R,
}

impl<R: Real> Tracker<R> {
    /// How far the lanes are from their references. `weights` are those of the joints, `feet` the joints that are feet.
    pub fn terms(&self, sim: &mut Simulator<R>, weights: &[f64], feet: &[usize]) -> TrackingTerms<R> {
        let com_velocity = sim.total_momentum().linear * R::splat(1.0 / sim.model().mass());
        let com = sim.center_of_mass();
        let (mut pose, mut velocity, mut sum) = (R::zero(), R::zero(), 0.0);
        let off = |joint: Quat<R>, wanted: Quat<R>| (joint.conjugate() * wanted).to_rotation_vector();
        let wanted = self.now.joints.iter().zip(&self.now.joint_velocities);
        for (((wanted, speed), joint), weight) in wanted.zip(&sim.state.joints).zip(weights).skip(1) {
            let part = R::splat(*weight);
            let error = off(joint.rotation, *wanted);
            pose = error.length_squared().mul_add(part, pose);
            velocity = (joint.velocity - *speed).length_squared().mul_add(part, velocity);
            sum += weight;
        }
        let mean = R::splat(1.0 / sum.max(1e-9));
        let links = sim.kinematics();
        let mut ends = R::zero();
        for (&link, place) in self.motion.ends().iter().zip(&self.now.ends) {
            let place = self.anchor_heading.to_world(self.leaned(*place, &self.now));
            ends += (links[link].origin - place).length_squared();
        }
        let part = R::splat(1.0 / feet.len().max(1) as f64);
        let foot = |k: &usize| off(sim.state.joints[*k].rotation, self.now.joints[*k]).length_squared() * part;
        let feet = feet.iter().fold(R::zero(), |sum, k| sum + foot(k));
        // Cosine of the lean.
        let lean = self.lean * self.lean;
        let upright = (R::one() - lean) * (R::one() + lean).recip();
        let root = (sim.state.root_rotation.conjugate() * self.reference_rotation()).to_rotation_vector();
        let spin = sim.state.root_velocity.angular - self.anchor_heading.to_world(self.now.root_angular);
        let mut away = sim.state.root_position - self.reference_root();
        away.y = R::zero();
        TrackingTerms {
            pose: pose * mean,
            velocity: velocity * mean,
            ends: ends * R::splat(1.0 / self.motion.ends().len().max(1) as f64),
            root: root.length_squared(),
            spin: spin.length_squared(),
            height: com.y - (self.now.com_height * upright + self.anchor_place.y),
            com_velocity: (com_velocity - self.wanted_velocity()).length_squared(),
            place: away.length_squared(),
            feet,
        }
    }
}
