//! How trials begin.

use super::{Environment, HARD_STARTS, Lane, STOPS, TrialStart, draw};
use crate::control::tracking::Heading;
use crate::math::Real;
use crate::model::ModelPose;
use crate::skill::Range;
use crate::skill::disturb::Disturbance;
use crate::train::ppo::handover::HandOver;
use crate::train::ppo::sampling::StartSampler;
use crate::train::ppo::task::Predecessor;
use glam::DVec3;

/// Trials of a motion that repeats, and that failed so soon, failed by how they began, s.
const SOON: f64 = 2.0;

impl<R: Real> Environment<R> {
    /// How the next trial of a lane begins, and whether one has begun so before.
    fn next_start(&mut self, lane: usize, starts: &StartSampler) -> (TrialStart, bool) {
        let share = starts.replay_share();
        if share > 0.0 {
            let ended = &mut self.lanes[lane];
            let soon = self.task.motion.cycle().is_none() || ended.age as f64 <= SOON * self.task.skill.control_rate;
            if let Some(start) = ended.start.take().filter(|_| ended.failed && soon) {
                if self.hard_starts.len() < HARD_STARTS * R::LANES {
                    self.hard_starts.push(start);
                } else {
                    let other = self.random.below(self.hard_starts.len());
                    self.hard_starts[other] = start;
                }
            }
            if !self.hard_starts.is_empty() && self.random.uniform() < share {
                let which = self.random.below(self.hard_starts.len());
                return (self.hard_starts.swap_remove(which), true);
            }
        }
        let (tick, part) = starts.draw(&mut self.random);
        (TrialStart { tick, part, random: self.random.clone() }, false)
    }

    /// Begins a new trial in a lane.
    pub fn reset(&mut self, lane: usize, starts: &StartSampler) {
        let task = self.task.clone();
        let (motion, episode) = (&task.motion, &task.skill.episode);
        let rate = task.skill.control_rate;
        let (began, again) = self.next_start(lane, starts);
        let (drawn, part) = (began.tick, began.part);
        let mut own = began.random.clone();
        let random = &mut own;
        // A motion that nothing lasts through yet is not learnt from its start.
        let share = episode.begin_share * starts.ripeness();
        let begins = motion.cycle().is_none() && random.uniform() < share;
        let tick = match episode.start {
            Some(range) => ((draw(random, range) * rate).round() as usize).min(motion.last().saturating_sub(1)),
            None if begins => 0,
            None => drawn,
        };
        let slowest = episode.steer.is_some() && random.uniform() < STOPS;
        let at_part = |(low, high): Range| if slowest { low } else { low + part * (high - low) };
        // How fast a trial begins is what it fails by, where that is not the commanded speed.
        let (speed, start) = match (episode.speed, episode.start_speed) {
            (speed, Some(start)) => (speed.map_or(motion.mean_speed(), |range| draw(random, range)), at_part(start)),
            (speed, None) => {
                let speed = speed.map_or(motion.mean_speed(), at_part);
                (speed, speed)
            }
        };
        if !task.skill.parameters.is_empty() {
            let values: Vec<f64> = task.drawn_from.iter().map(|range| draw(random, *range)).collect();
            self.tracker.set_parameters(lane, &values, &task.skill.normalise(&values));
            if let Some(course) = &mut self.course {
                course.draw(lane, &task.skill, &values, random);
            }
        } else if let Some(course) = &mut self.course {
            course.draw(lane, &task.skill, &[], random);
        }
        let follows = !task.before.is_empty() && random.uniform() < episode.after_share;
        let tick = if follows {
            let other = &task.before[random.below(task.before.len())];
            let body = (!other.bodies.is_empty()).then(|| &other.bodies[random.below(other.bodies.len())]);
            self.take_over(lane, other, body, start)
        } else {
            // A motion over obstacles begins where it is in its own world.
            let over = task.course.is_some() && motion.cycle().is_none();
            let place = if over { self.tracker.place_of(lane, tick) } else { DVec3::ZERO };
            self.tracker.begin_at(&mut self.sim, lane, tick, start, Heading::ahead(), place);
            tick
        };
        self.tracker.set_speed(lane, speed);
        if let Some(friction) = episode.friction {
            self.sim.friction_scale.set_lane(lane, draw(random, friction) / task.friction);
        }
        let disturbance = Disturbance {
            joint: episode.joint_noise,
            joint_velocity: episode.joint_velocity_noise,
            velocity: episode.velocity_noise,
        };
        disturbance.apply(&mut self.sim.state, lane, random);
        self.sim.state_changed();
        if episode.joint_noise > 0.0 && !follows {
            self.stand(lane);
        }

        let ticks = (episode.seconds * rate).round() as usize;
        // A motion that ends gives trials that end with it.
        let left = if motion.cycle().is_some() { ticks } else { ticks.min(motion.last().saturating_sub(tick).max(1)) };
        self.lanes[lane] = Lane::new(left, part, self.tracker.heading(lane));
        self.lanes[lane].start = Some(began);
        self.lanes[lane].whole = task.judged || (task.counts_whole() && tick == 0 && !follows);
        if let Some(steer) = &episode.steer {
            self.lanes[lane].command_at = (draw(random, steer.every) * rate) as usize;
        }
        if !again {
            self.random = own;
        }
        self.plan_push(lane);
    }

    /// Puts a lane into a body as another skill's policy left it, or else into the pose in which its motion is left, and joins this one there;
    /// the tick that is joined.
    fn take_over(&mut self, lane: usize, other: &Predecessor, body: Option<&HandOver>, speed: f64) -> usize {
        let enter = other.transition.enter;
        // A motion over obstacles is joined where it is in its own world.
        let over = self.task.course.is_some() && self.task.motion.cycle().is_none();
        let ground = if over { self.tracker.support_of(lane, enter) } else { 0.0 };
        let place = if over { self.tracker.place_of(lane, enter) + DVec3::Y * ground } else { DVec3::ZERO };
        match body {
            Some(body) => body.put(&mut self.sim, lane, place),
            None => HandOver::of_motion(&other.motion, other.transition.leave, speed).put(&mut self.sim, lane, place),
        }
        for impulse in &mut self.sim.state.contact_impulses {
            impulse.set_lane(lane, DVec3::ZERO);
        }
        self.sim.state_changed();
        self.tracker.set_support(lane, ground, DVec3::ZERO);
        self.tracker.join(&mut self.sim, lane, enter);
        enter
    }

    /// Raises or lowers a disturbed start so that its lowest contact point is as high as the reference's.
    fn stand(&mut self, lane: usize) {
        let task = self.task.clone();
        let state = &mut self.sim.state;
        let now = ModelPose {
            root_position: state.root_position.lane(lane),
            root_rotation: state.root_rotation.lane(lane),
            joints: state.joints.iter().map(|j| j.rotation.lane(lane)).collect(),
        };
        // The reference as it is warped: on a step as high as this lane's.
        let lift = task.lowest_point(&self.tracker.reference_pose(lane)) - task.lowest_point(&now);
        let place = now.root_position + DVec3::Y * lift;
        state.root_position.set_lane(lane, place);
        self.sim.state_changed();
    }
}
