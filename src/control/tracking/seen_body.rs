//! What an observation reads of a body: of every lane of a simulator at once, or of one lane of it.

use crate::math::{Mat3, Motion, Quat, Real, Vec3};
use crate::model::SharedModel;
use crate::sim::Simulator;

/// A body as a policy sees it, in numbers of type `R`; world axes, m, m/s and rad/s.
pub(crate) trait SeenBody<R: Real> {
    /// The character.
    fn model(&self) -> &SharedModel;
    /// Velocity of the centre of mass.
    fn com_velocity(&self) -> Vec3<R>;
    /// The centre of mass relative to the root.
    fn com_from_root(&self) -> Vec3<R>;
    /// Impulse of the last step at a contact point, N s.
    fn contact_impulse(&self, point: usize) -> Vec3<R>;
    /// Steps per second.
    fn steps_per_second(&self) -> f64;
    /// Place and rotation of the root.
    fn root(&self) -> (Vec3<R>, Quat<R>);
    /// Twist of the root at its origin.
    fn root_velocity(&self) -> Motion<R>;
    /// Origin of a link relative to the root's, and its velocity.
    fn link(&self, link: usize) -> (Vec3<R>, Vec3<R>);
    /// Axes of a link.
    fn link_rotation(&self, link: usize) -> Mat3<R>;
    /// Rotation and angular velocity of a link against its parent, child axes.
    fn joint(&self, link: usize) -> (Quat<R>, Vec3<R>);
}

/// Velocity of the centre of mass in every lane, world axes, m/s.
pub(crate) fn com_velocity<R: Real>(sim: &mut Simulator<R>) -> Vec3<R> {
    sim.total_momentum().linear * R::splat(1.0 / sim.model().mass())
}

/// Every lane of a simulator.
pub(crate) struct AllLanes<'a, R: Real> {
    sim: &'a Simulator<R>,
    com_velocity: Vec3<R>,
}

impl<'a, R: Real> AllLanes<'a, R> {
    pub fn of(sim: &'a mut Simulator<R>) -> Self {
        let com_velocity = com_velocity(sim);
        Self { sim, com_velocity }
    }
}

impl<R: Real> SeenBody<R> for AllLanes<'_, R> {
    fn model(&self) -> &SharedModel {
        self.sim.model()
    }
    #[inline(always)]
    fn com_velocity(&self) -> Vec3<R> {
        self.com_velocity
    }
    fn com_from_root(&self) -> Vec3<R> {
        self.sim.com_from_root()
    }
    fn contact_impulse(&self, point: usize) -> Vec3<R> {
        self.sim.state.contact_impulses[point]
    }
    fn steps_per_second(&self) -> f64 {
        self.sim.settings().rate
    }
    #[inline(always)]
    fn root(&self) -> (Vec3<R>, Quat<R>) {
        (self.sim.state.root_position, self.sim.state.root_rotation)
    }
    #[inline(always)]
    fn root_velocity(&self) -> Motion<R> {
        self.sim.state.root_velocity
    }
    #[inline(always)]
    fn link(&self, link: usize) -> (Vec3<R>, Vec3<R>) {
        let link = &self.sim.kinematics[link];
        (link.origin, link.velocity.linear)
    }
    #[inline(always)]
    fn link_rotation(&self, link: usize) -> Mat3<R> {
        self.sim.kinematics[link].rotation
    }
    #[inline(always)]
    fn joint(&self, link: usize) -> (Quat<R>, Vec3<R>) {
        let joint = &self.sim.state.joints[link];
        (joint.rotation, joint.velocity)
    }
}

/// One lane of a simulator whose kinematics are those of its present state.
#[cfg(feature = "engine")]
pub(crate) struct OneLane<'a, R: Real> {
    sim: &'a Simulator<R>,
    lane: usize,
    com_velocity: Vec3<R>,
}

#[cfg(feature = "engine")]
impl<'a, R: Real> OneLane<'a, R> {
    /// `com_velocity` is that of all lanes, [`com_velocity`].
    pub fn of(sim: &'a Simulator<R>, lane: usize, com_velocity: Vec3<R>) -> Self {
        Self { sim, lane, com_velocity }
    }
    #[inline(always)]
    fn vector(&self, v: Vec3<R>) -> Vec3<f64> {
        Vec3::splat(v.lane(self.lane))
    }
}

#[cfg(feature = "engine")]
impl<R: Real> SeenBody<f64> for OneLane<'_, R> {
    fn model(&self) -> &SharedModel {
        self.sim.model()
    }
    fn com_velocity(&self) -> Vec3<f64> {
        self.vector(self.com_velocity)
    }
    fn com_from_root(&self) -> Vec3<f64> {
        self.vector(self.sim.com_from_root())
    }
    fn contact_impulse(&self, point: usize) -> Vec3<f64> {
        self.vector(self.sim.state.contact_impulses[point])
    }
    fn steps_per_second(&self) -> f64 {
        self.sim.settings().rate
    }
    fn root(&self) -> (Vec3<f64>, Quat<f64>) {
        let state = &self.sim.state;
        (self.vector(state.root_position), Quat::splat(state.root_rotation.lane(self.lane)))
    }
    fn root_velocity(&self) -> Motion<f64> {
        let velocity = &self.sim.state.root_velocity;
        Motion { angular: self.vector(velocity.angular), linear: self.vector(velocity.linear) }
    }
    fn link(&self, link: usize) -> (Vec3<f64>, Vec3<f64>) {
        let link = &self.sim.kinematics[link];
        (self.vector(link.origin), self.vector(link.velocity.linear))
    }
    fn link_rotation(&self, link: usize) -> Mat3<f64> {
        Mat3::splat(self.sim.kinematics[link].rotation.lane(self.lane))
    }
    fn joint(&self, link: usize) -> (Quat<f64>, Vec3<f64>) {
        let joint = &self.sim.state.joints[link];
        (Quat::splat(joint.rotation.lane(self.lane)), self.vector(joint.velocity))
    }
}
