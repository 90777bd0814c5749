//! Trials in lanes: a batch of characters, each at its own place in the motion.

use crate::asset::CourseInstance;
use crate::contact::Terrain;
use crate::control::tracking::{Heading, Tracker, TrackingTerms};
use crate::control::tracking_error;
use crate::math::{RandomStream, Real, Vec3};
use crate::model::ModelPose;
use crate::sim::{ExternalForce, Simulator, step};
use crate::skill::disturb::{Disturbance, ball};
use crate::skill::{PerformanceRecorder, PerformanceSample, Range, SETTLE, Shortfall};
use crate::train::ppo::handover::HandOver;
use crate::train::ppo::lane_courses::LaneCourses;
use crate::train::ppo::sampling::StartSampler;
use crate::train::ppo::task::{Predecessor, SkillTask, TARGET_SUBSTEPS};
use glam::DVec3;
use std::sync::Arc;

/// Whether a lane's episode goes on after a tick, and why not.
///
/// The difference is in what the last state is worth (Pardo, Tavakoli, Levdik, Kormushev 2018, "Time Limits in Reinforcement
/// Learning", equation 6). After *terminated* nothing follows: the episode's value ends with its last reward. *Truncated* is
/// what was cut from outside; the last state is worth what the critic says of it.
///
/// The end of a motion truncates. It is the reference that is over, not the athlete: a game goes on from there with another
/// skill. A value of nothing would make a good ending worth as little as a fall, and the last second free to fall in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EpisodeStatus {
    /// The episode goes on.
    Running,
    /// The character fell, strayed too far, or missed what the whole motion has to show.
    Terminated,
    /// The time is up, or the motion is over.
    Truncated,
}

/// What a tick brought one lane.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// In [0, 1] less the effort.
    pub reward: f64,
    /// Whether the episode goes on.
    pub status: EpisodeStatus,
}

/// What an ended episode was.
#[derive(Clone, Copy, Debug)]
pub struct Episode {
    /// Length, ticks.
    pub ticks: usize,
    /// Sum of rewards.
    pub reward: f64,
    /// It was terminated.
    pub failed: bool,
}

/// How a trial began: enough to begin it again.
#[derive(Clone, Debug)]
struct TrialStart {
    tick: usize,
    /// Part (0 to 1) of the range of speeds.
    part: f64,
    /// Gives everything else that was drawn for it.
    random: RandomStream,
}

/// Trials of a motion that repeats, and that failed so soon, failed by how they began, s.
const SOON: f64 = 2.0;
/// Part of the commands, and of the steered trials, that ask for the slowest speed: to stand is not to walk slowly.
const STOPS: f64 = 0.25;
/// Hard starts kept for each lane.
const HARD_STARTS: usize = 8;

/// One lane's trial.
#[derive(Clone, Debug)]
struct Lane {
    start: Option<TrialStart>,
    failed: bool,
    /// It is judged, or shows the whole motion: its end is judged by the skill's criteria.
    whole: bool,
    age: usize,
    limit: usize,
    /// Part of the range of starting speeds.
    speed: f64,
    reward: f64,
    push_from: usize,
    push_to: usize,
    push: DVec3,
    pushed: usize,
    /// When the next command comes, and how far the reference turns in a tick until then, rad.
    command_at: usize,
    turn: f64,
    /// Ticks in a row that a standing foot has been up.
    lifted: usize,
    /// Heading of the reference's world when the trial began.
    heading: Heading<f64>,
    /// What was seen of a whole trial.
    samples: Vec<PerformanceSample>,
    /// What a whole trial lacked.
    shortfall: Option<Shortfall>,
}

impl Lane {
    fn new(limit: usize, speed: f64, heading: Heading<f64>) -> Self {
        Self {
            start: None,
            failed: false,
            whole: false,
            age: 0,
            limit,
            speed,
            reward: 0.0,
            push_from: 0,
            push_to: 0,
            push: DVec3::ZERO,
            pushed: 0,
            command_at: 0,
            turn: 0.0,
            lifted: 0,
            heading,
            samples: Vec::new(),
            shortfall: None,
        }
    }
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
    /// Starts after which a trial failed (soon, where the motion repeats), and that have not been lasted through since.
    hard_starts: Vec<TrialStart>,
    recorder: Option<PerformanceRecorder<R>>,
    course: Option<LaneCourses<R>>,
    features: Vec<R>,
}

fn draw(random: &mut RandomStream, range: Range) -> f64 {
    random.range(range.0, range.1)
}

impl<R: Real> Environment<R> {
    /// A batch whose lanes have all begun a trial. `stream` names its random numbers.
    pub fn new(task: Arc<SkillTask>, seed: u64, stream: u64, starts: &StartSampler) -> Self {
        let mut sim = Simulator::<R>::new(task.model.clone(), task.settings);
        let tracker = Tracker::new(task.motion.clone(), task.tracker, task.layout.clone());
        tracker.set_gains(&mut sim);
        if let Some(link) = task.push_link {
            let position = Vec3::splat(task.model.links[link].com);
            sim.external.push(ExternalForce { link, position, force: Vec3::zero() });
        }
        let mut env = Self {
            sim,
            tracker,
            random: RandomStream::new(seed, stream),
            lanes: vec![Lane::new(0, 0.0, Heading::ahead()); R::LANES],
            hard_starts: Vec::new(),
            features: Vec::with_capacity(task.layout.size()),
            course: task.course.as_ref().map(|course| LaneCourses::new(course.clone(), &task)),
            recorder: task.watches_feet().then(|| PerformanceRecorder::new(&task.model)),
            task,
        };
        for lane in 0..R::LANES {
            env.reset(lane, starts);
        }
        env
    }

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
        if let Some(body) = body {
            body.put(&mut self.sim, lane, place);
        } else {
            let left = other.motion.tick(other.transition.leave);
            let (pose, velocity) = (&left.pose, &left.velocity);
            let state = &mut self.sim.state;
            let height = DVec3::Y * (pose.root_position.y - left.support);
            state.set_pose(lane, place + height, pose.root_rotation, &pose.joints);
            let linear = velocity.root_linear + left.travel * (speed - other.motion.mean_speed());
            state.set_velocity(lane, linear, velocity.root_angular, &velocity.joints);
            for (command, joint) in self.sim.commands.iter_mut().zip(&pose.joints) {
                command.rotation.set_lane(lane, *joint);
            }
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

    /// Draws the next push of a lane.
    fn plan_push(&mut self, lane: usize) {
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

    /// Writes what every lane's policy sees into `rows` (lanes x size, row by row).
    pub fn observe(&mut self, rows: &mut [f32]) {
        self.features.clear();
        match &self.course {
            None => self.tracker.look_ahead(&self.sim, &self.task.world),
            Some(course) => self.tracker.look_ahead(&self.sim, &course.terrain),
        }
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
        self.tick_with(actions, |_, _| {})
    }

    /// [`Environment::tick`] that calls `look` after each step, and tells it whether a part of the tick ends there.
    pub fn tick_with(&mut self, actions: &[f32], mut look: impl FnMut(&mut Simulator<R>, bool)) -> Vec<Outcome> {
        let task = self.task.clone();
        let size = task.action_size();
        self.tracker.act(|link| {
            let at = 3 * (link - 1);
            let part = |k: usize| R::from_lanes(|lane| f64::from(actions[lane * size + at + k]).clamp(-4.0, 4.0));
            Vec3::new(part(0), part(1), part(2))
        });
        let first = 3 * (task.model.links.len() - 1);
        self.tracker.act_gains(|k| R::from_lanes(|lane| f64::from(actions[lane * size + first + k])));
        self.push_lanes();
        self.steer_lanes();
        let steps = (task.settings.rate / (task.skill.control_rate * TARGET_SUBSTEPS as f64)).round() as usize;
        let none = R::zero().lt(R::zero());
        let mut touched = none;
        for part in 0..TARGET_SUBSTEPS {
            self.tracker.command(&mut self.sim, (part + 1) as f64 / TARGET_SUBSTEPS as f64);
            if let Some(recorder) = &mut self.recorder {
                recorder.forget();
            }
            for k in 0..steps {
                match &mut self.course {
                    None => step(&mut self.sim, &task.world),
                    Some(course) => {
                        step(&mut self.sim, &course.terrain);
                        course.advance(1.0 / task.settings.rate);
                    }
                }
                if let Some(recorder) = &mut self.recorder {
                    recorder.look(&self.sim);
                }
                look(&mut self.sim, k + 1 == steps);
            }
            for &p in &task.forbidden {
                touched = touched | R::zero().lt(self.sim.state.contact_impulses[p].length_squared());
            }
            if let (true, Some(recorder)) = (self.lanes.iter().any(|l| l.whole), &self.recorder) {
                let support = self.tracker.support();
                for (l, mut sample) in self.lanes.iter_mut().zip(recorder.sample(&mut self.sim, 0.0, support)) {
                    if !l.whole {
                        continue;
                    }
                    sample.time = (l.age as f64 + (part + 1) as f64 / TARGET_SUBSTEPS as f64) / task.skill.control_rate;
                    l.samples.push(sample);
                }
            }
        }
        self.turn_with_cycles();
        match &self.course {
            None => self.tracker.sense(&mut self.sim, &task.world),
            Some(course) => self.tracker.sense(&mut self.sim, &course.terrain),
        }
        self.tracker.advance(&self.sim);
        for (lane, l) in self.lanes.iter_mut().enumerate() {
            if let Some(sample) = l.samples.last_mut() {
                sample.error = Some(tracking_error(&self.sim, lane, &self.tracker.reference_pose(lane)));
            }
        }
        let contacts =
            if task.soles.is_empty() { R::zero() } else { self.tracker.contact_error(&self.sim, &task.soles) };
        let terms = self.tracker.terms(&mut self.sim, &task.weights, &task.feet);
        (0..R::LANES)
            .map(|lane| {
                let (touched, contacts) = (R::mask_lane(touched, lane), contacts.lane(lane));
                self.judge(lane, &terms, contacts, touched, &actions[lane * size..(lane + 1) * size])
            })
            .collect()
    }

    /// Commands that change.
    fn steer_lanes(&mut self) {
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

    fn push_lanes(&mut self) {
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

    fn judge(
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

    /// A cycle that begins anew turns its reference: that is no dragging.
    fn turn_with_cycles(&mut self) {
        let Some(cycle) = self.task.motion.cycle() else { return };
        for (lane, l) in self.lanes.iter_mut().enumerate() {
            if self.tracker.tick(lane) >= self.task.motion.last() {
                l.heading = l.heading.turned(Heading { c: cycle.turn.0, s: cycle.turn.1 }).normalized();
            }
        }
    }

    /// How far a lane has dragged its reference round since the trial began.
    fn dragged_round(&self, lane: usize) -> Heading<f64> {
        self.tracker.heading(lane).relative_to(self.lanes[lane].heading)
    }

    /// The episode of a lane so far.
    pub fn episode(&self, lane: usize, status: EpisodeStatus) -> Episode {
        let l = &self.lanes[lane];
        Episode { ticks: l.age, reward: l.reward, failed: status == EpisodeStatus::Terminated }
    }

    /// What a lane's trial lacked when it ended, where it is judged or shows the whole motion.
    pub fn shortfall(&self, lane: usize) -> Option<&Shortfall> {
        self.lanes[lane].shortfall.as_ref()
    }

    /// What was seen of a lane's trial, where it is judged or shows the whole motion.
    pub fn samples(&self, lane: usize) -> &[PerformanceSample] {
        &self.lanes[lane].samples
    }

    /// The course that was drawn last, of any lane; `None` for a task without obstacles.
    pub fn course(&self) -> Option<&CourseInstance> {
        self.course.as_ref().map(LaneCourses::last)
    }

    /// At which part (0 to 1) of the range of speeds a lane's trial is.
    pub(crate) fn speed_part(&self, lane: usize) -> f64 {
        self.lanes[lane].speed
    }

    /// Ticks that a lane's trial may last in all.
    pub fn limit(&self, lane: usize) -> usize {
        self.lanes[lane].limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::asset::clip::MotionClip;
    use crate::model::{KeyPoses, preset};
    use crate::skill::{Criterion, SkillDefinition};
    use std::collections::HashSet;

    type Lanes = crate::math::F32x8;

    fn task() -> Arc<SkillTask> {
        let poses = include_str!("../../../assets/skills/skating/stroking/stroking.keyposes.ron");
        let model = preset("skater").unwrap();
        let clip: MotionClip = KeyPoses::from_ron(poses, "stroking").unwrap().to_clip(&model).unwrap();
        let mut skill = SkillDefinition::imitate("stroking", "skater", "stroking.clip.ron");
        skill.training_rate = Some(120.0);
        skill.episode.seconds = 1.5;
        Arc::new(SkillTask::new(&skill, model, &clip).unwrap())
    }

    /// How every trial within four seconds without a policy begins: the rotation of a joint, which is off at random.
    fn beginnings(again: f64) -> Vec<[u64; 2]> {
        let task = task();
        let mut starts = StartSampler::uniform(task.motion.last(), false);
        starts.set_replay_share(again);
        let mut env = Environment::<Lanes>::new(task.clone(), 3, 1, &starts);
        let bits = |env: &Environment<Lanes>, lane: usize| {
            let joint = env.sim.state.joints[3].rotation.lane(lane);
            [joint.x.to_bits(), joint.y.to_bits()]
        };
        let mut all: Vec<_> = (0..Lanes::LANES).map(|lane| bits(&env, lane)).collect();
        let nothing = vec![0.0; Lanes::LANES * task.action_size()];
        for _ in 0..120 {
            for (lane, outcome) in env.tick(&nothing).into_iter().enumerate() {
                if outcome.status != EpisodeStatus::Running {
                    env.reset(lane, &starts);
                    all.push(bits(&env, lane));
                }
            }
        }
        all
    }

    #[test]
    fn a_start_that_failed_comes_again_as_it_was() {
        let different = |all: &[[u64; 2]]| all.iter().collect::<HashSet<_>>().len();
        let fresh = beginnings(0.0);
        assert_eq!(different(&fresh), fresh.len(), "every trial begins in its own way");
        let again = beginnings(1.0);
        assert!(again.len() > 3 * Lanes::LANES, "{} trials", again.len());
        assert!(different(&again) < 2 * Lanes::LANES, "{} of {}", different(&again), again.len());
    }

    /// How the first episodes that begin at `start` (s) of a second of the motion end, with no limit in their way.
    fn end_of_trials(start: f64, success: Vec<Criterion>) -> EpisodeStatus {
        let mut task = SkillTask::clone(&task());
        let skill = &mut task.skill;
        skill.window = Some((0.0, 1.0));
        skill.episode.start = Some((start, start));
        skill.limits.touch = false;
        (skill.limits.height, skill.limits.root, skill.limits.pose, skill.limits.place) = (10.0, 10.0, 10.0, 1e3);
        skill.trial.success = success;
        let task = Arc::new(SkillTask::new(&task.skill, task.model, &task.clip).unwrap());
        let mut env = Environment::<f64>::new(task.clone(), 3, 1, &StartSampler::uniform(task.motion.last(), false));
        let nothing = vec![0.0; task.action_size()];
        (0..=30).map(|_| env.tick(&nothing)[0].status).find(|e| *e != EpisodeStatus::Running).unwrap()
    }

    #[test]
    fn what_a_whole_motion_lacks_counts_as_a_fall_in_training_too() {
        let fast = |at_least| vec![Criterion::KeptSpeed { at_least, seconds: 0.1 }];
        assert_eq!(end_of_trials(0.0, Vec::new()), EpisodeStatus::Truncated);
        assert_eq!(end_of_trials(0.0, fast(50.0)), EpisodeStatus::Terminated);
        assert_eq!(end_of_trials(0.0, fast(0.0)), EpisodeStatus::Truncated);
        // A part of the motion cannot show all of it.
        assert_eq!(end_of_trials(0.5, fast(50.0)), EpisodeStatus::Truncated);
    }
}
