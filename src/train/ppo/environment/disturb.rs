//! What comes to a trial from outside: commands and pushes.

use super::{Environment, STOPS, draw};
use crate::control::tracking::Heading;
use crate::math::Real;
use crate::skill::disturb::ball;
use glam::DVec3;

impl<R: Real> Environment<R> {
    /// Draws the next push of a lane.
    pub(super) fn plan_push(&mut self, lane: usize) {
        let Some(push) = &self.task.skill.episode.push else { return };
        if push.count.is_some_and(|n| self.lanes[lane].pushed >= n) {
            (self.lanes[lane].push_from, self.lanes[lane].push_to) = (usize::MAX, usize::MAX);
            return;
        }
        let rate = self.task.skill.control_rate;
        let wait = push.every * (0.25 + 1.5 * self.random.uniform());
        let side = ball(&mut self.random) * DVec3::new(1.0, 0.0, 1.0);
        let force = side.normalize_or(DVec3::X) * draw(&mut self.random, push.force);
        let l = &mut self.lanes[lane];
        l.push_from = if push.airborne { usize::MAX } else { l.age + (wait * rate) as usize };
        l.push_to = l.push_from.saturating_add(((push.seconds * rate).round() as usize).max(1));
        l.push = force;
    }

    /// Commands that change.
    pub(super) fn steer_lanes(&mut self) {
        let task = self.task.clone();
        let Some(steer) = &task.skill.episode.steer else { return };
        let rate = task.skill.control_rate;
        for (lane, l) in self.lanes.iter_mut().enumerate().filter(|(_, l)| l.age >= l.command_at) {
            l.command_at = l.age + ((draw(&mut self.random, steer.every) * rate) as usize).max(1);
            let turn = 1.5 * draw(&mut self.random, (-1.0, 1.0));
            // A third of them goes straight on.
            l.turn = (turn - turn.clamp(-0.5, 0.5)) * steer.turn / rate;
            if let Some(speed) = task.skill.episode.speed {
                let stops = self.random.uniform() < STOPS;
                let drawn = draw(&mut self.random, speed);
                self.tracker.set_speed(lane, if stops { speed.0 } else { drawn });
                // Half of those that stop do not turn on the spot.
                if stops && self.random.uniform() < 0.5 {
                    l.turn = 0.0;
                }
            }
        }
        self.tracker.steer(R::from_lanes(|lane| self.lanes[lane].turn));
        for l in &mut self.lanes {
            l.heading = l.heading.turned(Heading { c: 1.0 - 0.5 * l.turn * l.turn, s: l.turn }).normalized();
        }
    }

    pub(super) fn push_lanes(&mut self) {
        let task = self.task.clone();
        let Some(push) = task.skill.episode.push.as_ref().filter(|_| task.push_link.is_some()) else { return };
        for lane in 0..R::LANES {
            let in_air = self.recorder.as_ref().is_some_and(|w| w.pressed(lane) == [false; 2]);
            let l = &mut self.lanes[lane];
            if push.airborne
                && l.push_from == usize::MAX
                && in_air
                && l.age > 0
                && push.count.is_none_or(|n| l.pushed < n)
            {
                let ticks = ((push.seconds * task.skill.control_rate).round() as usize).max(1);
                (l.push_from, l.push_to) = (l.age, l.age + ticks);
            }
            let on = (l.push_from..l.push_to).contains(&l.age);
            let (force, over) = (if on { l.push } else { DVec3::ZERO }, l.age >= l.push_to);
            if let Some(external) = self.sim.external.first_mut() {
                external.force.set_lane(lane, force);
            }
            // The next push in the air needs another flight.
            if over && !(push.airborne && in_air) {
                self.lanes[lane].pushed += 1;
                self.plan_push(lane);
            }
        }
    }
}
