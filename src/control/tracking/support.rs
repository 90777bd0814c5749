//! What carries a body: the ground under its last foothold. Heights and velocities count from it, so that a motion that was learnt
//! on the level goes on on a box, a slope or a platform.

use crate::contact::Terrain;
use crate::math::{Real, Vec3};
use crate::model::PointRole;
use crate::sim::Simulator;

/// A foot that is less above the ground at a start stands on it, m.
const NEAR: f64 = 0.05;

/// The ground under the last foothold of every lane.
#[derive(Clone, Copy, Debug)]
pub struct Support<R> {
    /// Height, world frame, m.
    pub height: R,
    /// Velocity of the ground there, level part, world axes, m/s.
    pub velocity: Vec3<R>,
}

impl<R: Real> Support<R> {
    /// Level ground at rest, at the height 0.
    pub fn level() -> Self {
        Self { height: R::zero(), velocity: Vec3::zero() }
    }

    /// The ground at `height` (m), at rest.
    pub fn at(height: f64) -> Self {
        Self { height: R::splat(height), velocity: Vec3::zero() }
    }

    /// Looks at the ground under feet before the first step, when nothing has pressed yet: its velocity is that of the ground less than
    /// a little below a foot. The height stays that of the start.
    pub fn look_below(&mut self, sim: &mut Simulator<R>, terrain: &impl Terrain<R>) {
        let model = sim.model().clone();
        let root = sim.state.root_position;
        let (mut count, mut velocity) = (R::zero(), Vec3::zero());
        for point in model.points(PointRole::Foot) {
            let p = &model.contact_points[point];
            let link = &sim.kinematics()[p.link];
            let place = root + link.origin + link.rotation.mul_vec(Vec3::splat(p.position));
            let ground = terrain.height(place);
            let near = ground.found & (place.y - ground.height).lt(R::splat(NEAR + p.radius));
            count += R::one().masked(near);
            velocity += ground.velocity.masked(near);
        }
        let stands = R::zero().lt(count);
        velocity.y = R::zero();
        self.velocity = Vec3::select(stands, velocity * count.max(R::one()).recip(), self.velocity);
    }

    /// Looks where feet stand: in lanes where a foot was pressed in the last step, the mean over the pressed points of the ground below
    /// them; in others it stays. Returns the lanes with a foothold.
    pub fn update(&mut self, sim: &mut Simulator<R>, terrain: &impl Terrain<R>) -> R::Mask {
        let model = sim.model().clone();
        let root = sim.state.root_position;
        let (mut count, mut height, mut velocity) = (R::zero(), R::zero(), Vec3::zero());
        for point in model.points(PointRole::Foot) {
            let pressed = R::zero().lt(sim.state.contact_impulses[point].length_squared());
            if !R::any(pressed) {
                continue;
            }
            let p = &model.contact_points[point];
            let link = &sim.kinematics()[p.link];
            let place = root + link.origin + link.rotation.mul_vec(Vec3::splat(p.position));
            let ground = terrain.height(place);
            let pressed = pressed & ground.found;
            count += R::one().masked(pressed);
            height += ground.height.masked(pressed);
            velocity += ground.velocity.masked(pressed);
        }
        let stands = R::zero().lt(count);
        if R::any(stands) {
            let share = count.max(R::one()).recip();
            velocity.y = R::zero();
            self.height = R::select(stands, height * share, self.height);
            self.velocity = Vec3::select(stands, velocity * share, self.velocity);
        }
        stands
    }
}
