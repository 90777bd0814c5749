//! Trials in lanes: a batch of characters, each at its own place in the motion.

use crate::control::tracking::{Tracker, TrackingTerms};
use crate::math::{RandomStream, Real, Vec3};
use crate::sim::{ExternalForce, Simulator, step};
use crate::skill::Range;
use crate::train::ppo::sampling::StartSampler;
use crate::train::ppo::task::{SUBTICKS, SkillTask};
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// How a tick ended for one lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The trial goes on.
    GoesOn,
    /// The character fell or strayed too far.
    Failed,
    /// The time is up.
    TimeUp,
}

/// What a tick brought one lane.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// In [0, 1] less the effort.
    pub reward: f64,
    /// How it ended.
    pub ending: Ending,
}

/// What an ended trial was.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Length, ticks.
    pub ticks: usize,
    /// Sum of rewards.
    pub reward: f64,
    /// It ended by a failure.
    pub failed: bool,
}

/// One lane's trial.
#[derive(Clone, Copy, Debug, Default)]
struct Lane {
    age: usize,
    limit: usize,
    reward: f64,
    push_from: usize,
    push_to: usize,
    push: DVec3,
}

/// A batch of trials.
pub struct Environment<R: Real> {
    task: Arc<SkillTask>,
    /// The simulation.
    pub sim: Simulator<R>,
    /// Reference, phase and targets.
    pub tracker: Tracker<R>,
    random: RandomStream,
    lanes: Vec<Lane>,
    features: Vec<R>,
    /// Whether the pushes of the skill happen.
    pub pushes: bool,
}

fn draw(random: &mut RandomStream, range: Range) -> f64 {
    random.range(range.0, range.1)
}

/// A vector of components in [-1, 1).
fn cube(random: &mut RandomStream) -> DVec3 {
    DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), random.range(-1.0, 1.0))
}

impl<R: Real> Environment<R> {
    /// A batch whose lanes have all begun a trial. `stream` names its random numbers.
    pub fn new(task: Arc<SkillTask>, seed: u64, stream: u64, starts: &StartSampler) -> Self {
        let mut sim = Simulator::<R>::new(task.model.clone(), task.settings);
        let tracker = Tracker::new(task.motion.clone(), task.tracker);
        tracker.set_gains(&mut sim);
        if let Some(link) = task.push_link {
            let position = Vec3::splat(task.model.links[link].com);
            sim.external.push(ExternalForce { link, position, force: Vec3::zero() });
        }
        let mut env = Self {
            sim,
            tracker,
            random: RandomStream::new(seed, stream),
            lanes: vec![Lane::default(); R::LANES],
            features: Vec::with_capacity(task.layout.size()),
            pushes: true,
            task,
        };
        for lane in 0..R::LANES {
            env.reset(lane, starts);
        }
        env
    }

    /// Begins a new trial in a lane.
    pub fn reset(&mut self, lane: usize, starts: &StartSampler) {
        let task = self.task.clone();
        let (motion, episode) = (&task.motion, &task.skill.episode);
        let random = &mut self.random;
        let tick = if episode.from_start { 0 } else { starts.draw(random) };
        let speed = episode.speed.map_or(motion.mean_speed(), |range| draw(random, range));
        let start = episode.start_speed.map_or(speed, |range| draw(random, range));
        self.tracker.begin(&mut self.sim, lane, tick, start);
        self.tracker.set_speed(lane, speed);
        if let Some(friction) = episode.friction {
            self.sim.friction_scale.set_lane(lane, draw(random, friction) / task.friction);
        }
        let state = &mut self.sim.state;
        for joint in state.joints.iter_mut().skip(1) {
            let turn = cube(random) * episode.joint_noise;
            let q = joint.rotation.lane(lane) * DQuat::from_scaled_axis(turn);
            joint.rotation.set_lane(lane, q.normalize());
            let velocity = joint.velocity.lane(lane) + cube(random) * (5.0 * episode.velocity_noise);
            joint.velocity.set_lane(lane, velocity);
        }
        let moving = &mut state.root_velocity.linear;
        let level = DVec3::new(1.0, 0.3, 1.0);
        moving.set_lane(lane, moving.lane(lane) + cube(random) * level * episode.velocity_noise);
        self.sim.state_changed();

        let ticks = (episode.seconds * task.skill.control_rate).round() as usize;
        // A motion that ends gives trials that end with it.
        let left = if motion.cycle().is_some() { ticks } else { ticks.min(motion.last().saturating_sub(tick).max(1)) };
        self.lanes[lane] = Lane { limit: left, ..Lane::default() };
        self.plan_push(lane);
    }

    /// Draws the next push of a lane.
    fn plan_push(&mut self, lane: usize) {
        let Some(push) = &self.task.skill.episode.push else { return };
        let rate = self.task.skill.control_rate;
        let wait = push.every * (0.25 + 1.5 * self.random.uniform());
        let side = cube(&mut self.random) * DVec3::new(1.0, 0.0, 1.0);
        let force = side.normalize_or(DVec3::X) * push.force * self.random.uniform();
        let l = &mut self.lanes[lane];
        l.push_from = l.age + (wait * rate) as usize;
        l.push_to = l.push_from + ((push.seconds * rate).round() as usize).max(1);
        l.push = force;
    }

    /// Writes what every lane's policy sees into `rows` (lanes x size, row by row).
    pub fn observe(&mut self, rows: &mut [f32]) {
        self.features.clear();
        self.tracker.observe(&mut self.sim, &mut self.features);
        let size = self.features.len();
        for (k, value) in self.features.iter().enumerate() {
            for lane in 0..R::LANES {
                rows[lane * size + k] = value.lane(lane) as f32;
            }
        }
    }

    /// One tick of every lane under these actions (lanes x size, row by row).
    pub fn tick(&mut self, actions: &[f32]) -> Vec<Outcome> {
        let task = self.task.clone();
        let size = task.action_size();
        self.tracker.act(|link| {
            let at = 3 * (link - 1);
            let part = |k: usize| R::from_lanes(|lane| f64::from(actions[lane * size + at + k]).clamp(-4.0, 4.0));
            Vec3::new(part(0), part(1), part(2))
        });
        self.push_lanes();
        let steps = (task.settings.rate / (task.skill.control_rate * SUBTICKS as f64)).round() as usize;
        let none = R::zero().lt(R::zero());
        let mut touched = none;
        for part in 0..SUBTICKS {
            self.tracker.command(&mut self.sim, (part + 1) as f64 / SUBTICKS as f64);
            for _ in 0..steps {
                step(&mut self.sim, &task.world);
            }
            for &p in &task.forbidden {
                touched = touched | R::zero().lt(self.sim.state.contact_impulses[p].length_squared());
            }
        }
        self.tracker.advance(&self.sim);
        let terms = self.tracker.terms(&mut self.sim, &task.weights);
        (0..R::LANES)
            .map(|lane| self.judge(lane, &terms, R::mask_lane(touched, lane), &actions[lane * size..(lane + 1) * size]))
            .collect()
    }

    fn push_lanes(&mut self) {
        if self.task.push_link.is_none() {
            return;
        }
        for lane in 0..R::LANES {
            let l = self.lanes[lane];
            let on = self.pushes && (l.push_from..l.push_to).contains(&l.age);
            let force = if on { l.push } else { DVec3::ZERO };
            if let Some(external) = self.sim.external.first_mut() {
                external.force.set_lane(lane, force);
            }
            if l.age >= l.push_to {
                self.plan_push(lane);
            }
        }
    }

    fn judge(&mut self, lane: usize, terms: &TrackingTerms<R>, touched: bool, action: &[f32]) -> Outcome {
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
            - scales.effort * effort.min(10.0);
        let failed = !self.sim.is_sane(lane)
            || height.abs() > limits.height
            || root > limits.root * limits.root
            || pose > limits.pose * limits.pose
            || place > limits.place * limits.place
            || (limits.touch && touched)
            || !reward.is_finite();
        let reward = if failed { 0.0 } else { reward };
        let l = &mut self.lanes[lane];
        l.age += 1;
        l.reward += reward;
        let ending = if failed {
            Ending::Failed
        } else if l.age >= l.limit {
            Ending::TimeUp
        } else {
            Ending::GoesOn
        };
        Outcome { reward, ending }
    }

    /// The trial of a lane so far.
    pub fn trial(&self, lane: usize, ending: Ending) -> Trial {
        let l = &self.lanes[lane];
        Trial { ticks: l.age, reward: l.reward, failed: ending == Ending::Failed }
    }

    /// Ticks that a lane's trial may last in all.
    pub fn limit(&self, lane: usize) -> usize {
        self.lanes[lane].limit
    }
}
