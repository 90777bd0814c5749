//! Trials in lanes: a batch of characters, each at its own place in the motion.

mod disturb;
mod judge;
mod start;

use crate::asset::CourseInstance;
use crate::control::tracking::{Heading, Tracker};
use crate::control::tracking_error;
use crate::math::{RandomStream, Real, Vec3};
use crate::sim::{ExternalForce, Simulator, step};
use crate::skill::{PerformanceRecorder, PerformanceSample, Range, Shortfall};
use crate::train::ppo::lane_courses::LaneCourses;
use crate::train::ppo::sampling::StartSampler;
use crate::train::ppo::task::{SkillTask, TARGET_SUBSTEPS};
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
