//! A gait: its phase and pace in each lane, the way that it goes, and its lean in turns.

use super::Tracker;
use crate::control::tracking::gathered::Gathered;
use crate::math::{Quat, Real, Vec3};

/// Time in which a gait takes up the lean of a turn, s.
const LEAN_TIME: f64 = 0.2;
/// Tangent of half of the most that it leans.
const MOST_LEAN: f64 = 0.25;
/// Least gravity by which a lean is reckoned, m/s^2.
const LEAST_GRAVITY: f64 = 0.1;
/// Turns slower than this are turned standing, rad/s.
const STANDS: f64 = 0.05;

impl<R: Real> Tracker<R> {
    /// The rotation by which a gait leans, in the reference's own world.
    pub(super) fn lean_rotation(&self, reference: &Gathered<R>) -> Quat<R> {
        let w = self.lean.mul_add(self.lean, R::one()).sqrt().recip();
        Quat { v: reference.travel * (self.lean * w), w }
    }

    /// A place in the reference's own world, about the line on the ground on which a gait goes.
    pub(super) fn leaned(&self, place: Vec3<R>, reference: &Gathered<R>) -> Vec3<R> {
        if self.motion.levels().is_empty() { place } else { self.lean_rotation(reference).rotate(place) }
    }

    /// Puts a lane of a gait at a phase, ticks.
    pub(super) fn stride(&mut self, lane: usize, phase: f64) {
        let motion = &self.motion;
        let around = |phase: f64| if phase >= motion.last() as f64 { phase - motion.last() as f64 } else { phase };
        let (phase, pace) = (around(phase), self.paces[lane]);
        self.ticks[lane] = phase as usize;
        self.fractions[lane] = phase - self.ticks[lane] as f64;
        motion.sample(phase, pace, &mut self.sampled);
        self.now.put(lane, &self.sampled);
        motion.sample(around(phase + motion.phase_step(pace)), pace, &mut self.sampled);
        self.next.put(lane, &self.sampled);
    }

    /// The next tick of a lane of a gait: the place goes on by what was gone, the pace towards what is commanded, and the lean to what the turn asks
    /// for under `gravity` (m/s^2).
    pub(super) fn stride_on(&mut self, lane: usize, gravity: f64) {
        let motion = self.motion.clone();
        let gone = self.anchor_place.lane(lane) + self.gone(lane);
        self.anchor_place.set_lane(lane, gone);
        let turning = self.turning.lane(lane) * motion.tick_rate();
        let mut wanted = motion.pace(self.speed.lane(lane));
        if let Some(step) = motion.step_on_the_spot().filter(|_| turning.abs() > STANDS) {
            wanted = wanted.max(step);
        }
        let phase = self.ticks[lane] as f64 + self.fractions[lane];
        let most = self.options.acceleration / motion.tick_rate();
        let (phase, pace) = motion.after(phase, self.paces[lane], wanted, most);
        self.paces[lane] = pace;
        // What is turned at v with omega is drawn outwards by v omega: tan(angle) = v omega / g.
        let lean = (-0.5 * pace * turning / gravity.max(LEAST_GRAVITY)).clamp(-MOST_LEAN, MOST_LEAN);
        let (old, part) = (self.lean.lane(lane), 1.0 / (LEAN_TIME * motion.tick_rate()).max(1.0));
        self.lean.set_lane(lane, old + (lean - old) * part);
        self.stride(lane, phase);
    }

    /// How far the reference of a gait goes in a decision, world axes, m.
    pub(super) fn gone(&self, lane: usize) -> glam::DVec3 {
        let along = self.now.travel.lane(lane) * (self.paces[lane] / self.motion.tick_rate());
        self.heading(lane).to_world(Vec3::splat(along)).lane(0)
    }
}
