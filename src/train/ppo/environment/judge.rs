//! What a decision was worth, and whether a trial goes on.

use super::{Environment, EpisodeStatus, Outcome};
use crate::contact::Terrain;
use crate::control::tracking::TrackingTerms;
use crate::math::Real;
use crate::skill::{SETTLE, Shortfall};

impl<R: Real> Environment<R> {
    pub(super) fn judge(
        &mut self,
        lane: usize,
        terms: &TrackingTerms<R>,
        contacts: f64,
        touched: bool,
        action: &[f32],
    ) -> Outcome {
        let (scales, limits) = (&self.task.skill.reward, &self.task.skill.limits);
        let height = terms.height.lane(lane);
        let value = |(weight, sharpness): (f64, f64), error: f64| weight * (-sharpness * error).exp();
        let effort = action.iter().map(|a| f64::from(a * a)).sum::<f64>() / action.len().max(1) as f64;
        let (pose, root, place) = (terms.pose.lane(lane), terms.root.lane(lane), terms.place.lane(lane));
        let reward = value(scales.pose, pose)
            + value(scales.velocity, terms.velocity.lane(lane))
            + value(scales.ends, terms.ends.lane(lane))
            + value(scales.root, root)
            + value(scales.height, height * height)
            + value(scales.com_velocity, terms.com_velocity.lane(lane))
            + value(scales.place, place)
            + value(scales.feet, terms.feet.lane(lane))
            + value(scales.contacts, contacts)
            - scales.effort * effort.min(10.0);
        let strayed = height.abs() > limits.height
            || root > limits.root * limits.root
            || pose > limits.pose * limits.pose
            || place > limits.place * limits.place
            || (limits.touch && touched)
            || (limits.free_foot && self.free_foot_down(lane))
            || limits.turn.is_some_and(|most| self.dragged_round(lane).c < most.cos())
            || (limits.standing_foot && self.standing_foot_up(lane));
        let trial = &self.task.skill.trial;
        let root_height = self.sim.state.root_position.y.lane(lane);
        let is_low = |ground: f64| root_height - ground < self.task.pelvis;
        let fallen = touched || (is_low(self.tracker.support().height.lane(lane)) && is_low(self.ground_of(lane)));
        let failed = !self.sim.is_sane(lane)
            || !reward.is_finite()
            || if self.task.judged { fallen || (trial.success.is_empty() && strayed) } else { strayed };
        let reward = if failed { 0.0 } else { reward };
        let l = &mut self.lanes[lane];
        l.age += 1;
        l.reward += reward;
        if l.whole {
            let fall = || Err(Shortfall { condition: "no fall", found: format!("fell at tick {}", l.age) });
            let missing = || trial.success.iter().try_for_each(|criterion| criterion.check(&l.samples));
            let verdict = if failed {
                fall()
            } else if l.age >= l.limit {
                missing()
            } else {
                Ok(())
            };
            l.shortfall = verdict.err();
        }
        l.failed = failed || l.shortfall.is_some();
        let status = if l.failed {
            EpisodeStatus::Terminated
        } else if l.age >= l.limit {
            EpisodeStatus::Truncated
        } else {
            EpisodeStatus::Running
        };
        Outcome { reward, status }
    }

    /// Height of what a fall counts from, m: the support, or the ground below where that is lower, as in a hop down.
    fn ground_of(&self, lane: usize) -> f64 {
        let support = self.tracker.support().height.lane(lane);
        let Some(course) = &self.course else { return support };
        let below = course.terrain.height(self.sim.state.root_position);
        if R::mask_lane(below.found, lane) { support.min(below.height.lane(lane)) } else { support }
    }

    /// Whether a blade is on the ice that the motion has in the air.
    fn free_foot_down(&self, lane: usize) -> bool {
        let settled = self.lanes[lane].age as f64 >= SETTLE * self.task.skill.control_rate;
        let Some(recorder) = self.recorder.as_ref().filter(|_| settled) else { return false };
        let free = self.task.free_feet[self.tracker.tick(lane)];
        recorder.pressed(lane).iter().zip(free).any(|(down, free)| *down && free)
    }

    /// Whether a blade that the motion has on the ice has been without contact at two ticks in a row.
    fn standing_foot_up(&mut self, lane: usize) -> bool {
        let l = &mut self.lanes[lane];
        let settled = l.age as f64 >= SETTLE * self.task.skill.control_rate;
        let Some(recorder) = self.recorder.as_ref().filter(|_| settled) else { return false };
        let stands = self.task.standing_feet[self.tracker.tick(lane)];
        let up = recorder.pressed(lane).iter().zip(stands).any(|(down, stands)| !*down && stands);
        l.lifted = if up { l.lifted + 1 } else { 0 };
        l.lifted >= 2
    }
}
