//! A skill made ready for trials: its motion laid out for the character, its world, its numbers.

use crate::asset::clip::{ClipError, MotionClip};
use crate::asset::{Course, CourseError};
use crate::contact::{Surface, World};
use crate::control::tracking::{ObservationLayout, SoleParts, TrackedMotion, TrackerOptions};
use crate::model::{CharacterModel, ContactPoint, Foot, FootKind, LinkTransform, ModelPose, SharedModel, Side};
use crate::sim::SimulationSettings;
use crate::skill::{
    Criterion, ENTRY, EpisodeOptions, PushOptions, Range, SkillDefinition, SkillError, Transition, TrialRow,
    best_transition, fitting_rate,
};
use crate::train::ppo::handover::HandOver;
use std::sync::Arc;

pub(crate) use crate::control::tracking::TARGET_SUBSTEPS;

/// Why a skill cannot be tried.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TaskError {
    /// The motion does not fit.
    #[error(transparent)]
    Clip(#[from] ClipError),
    /// The skill's own numbers.
    #[error(transparent)]
    Skill(#[from] SkillError),
    /// The rates do not fit together.
    #[error(
        "skill {skill}: {rate} simulation steps per second and {control_rate} decisions per second; valid: the first a multiple of {TARGET_SUBSTEPS} times the second"
    )]
    Rate {
        /// The skill.
        skill: String,
        /// Steps per second.
        rate: f64,
        /// Decisions per second.
        control_rate: f64,
    },
    /// Something is asked of feet that the character lacks.
    #[error(
        "skill {skill}: {field}: {character} has no feet; valid: a character with feet, or nothing that asks for them"
    )]
    Feet {
        /// The skill.
        skill: String,
        /// What asks for feet.
        field: &'static str,
        /// The character.
        character: String,
    },
    /// The course cannot be built for the skill.
    #[error("skill {skill}: {source}")]
    Course {
        /// The skill.
        skill: String,
        /// What is wrong with it.
        source: Box<CourseError>,
    },
    /// Trials are to begin where a skill before is left, and no skill before is known.
    #[error("skill {skill}: trial.rows: `{row}` begins after another skill; valid: where `after` names one")]
    Before {
        /// The skill.
        skill: String,
        /// The row.
        row: String,
    },
    /// A push names no link.
    #[error("skill {skill}: push.link `{link}`: valid is one of {valid}")]
    PushLink {
        /// The skill.
        skill: String,
        /// The name.
        link: String,
        /// Names of the links.
        valid: String,
    },
}

/// A motion that another may follow, and how it is left.
#[derive(Clone, Debug)]
pub struct Predecessor {
    /// The motion.
    pub motion: Arc<TrackedMotion>,
    /// Where it is left, and where the other one is entered.
    pub transition: Transition,
    /// Bodies as its policy leaves it; none for its own pose.
    pub bodies: Arc<[HandOver]>,
}

/// A skill made ready for trials.
#[derive(Clone, Debug)]
pub struct SkillTask {
    /// The skill.
    pub skill: SkillDefinition,
    /// The character.
    pub model: SharedModel,
    /// The motion as it was read.
    pub clip: MotionClip,
    /// The motion, tick by tick.
    pub motion: Arc<TrackedMotion>,
    /// How it is followed.
    pub tracker: TrackerOptions,
    /// What a policy sees.
    pub layout: Arc<ObservationLayout>,
    /// The world.
    pub world: World,
    /// Obstacles, drawn for every episode.
    pub course: Option<Arc<Course>>,
    /// Friction coefficient of its surface.
    pub friction: f64,
    /// Settings of the simulation; the rate is that of training.
    pub settings: SimulationSettings,
    /// How much each joint counts in a pose: by the mass it carries.
    pub weights: Vec<f64>,
    /// Joints of the feet, where the reward asks for them.
    pub feet: Vec<usize>,
    /// Parts of the soles, where the reward asks for their contacts.
    pub soles: SoleParts,
    /// Contact points that must not touch anything.
    pub forbidden: Vec<usize>,
    /// Link that is pushed.
    pub push_link: Option<usize>,
    /// Height of the root above its support below which the character has fallen, m.
    pub pelvis: f64,
    /// For each tick of the motion, whether the left and the right foot are in the air.
    pub free_feet: Arc<[[bool; 2]]>,
    /// For each tick, whether they are on the ground, and have been for a while and will be.
    pub standing_feet: Arc<[[bool; 2]]>,
    /// Motions that this one may follow, and where.
    pub before: Vec<Predecessor>,
    /// Trials end and count as the skill's `trial` says, not as in training.
    pub judged: bool,
    /// What each of the skill's parameters is drawn from, in its unit.
    pub drawn_from: Vec<Range>,
}

impl SkillTask {
    /// Prepares a skill whose motion has been read.
    pub fn new(skill: &SkillDefinition, model: SharedModel, clip: &MotionClip) -> Result<Self, TaskError> {
        skill.validate()?;
        skill.check_links(&model)?;
        let motion = skill.prepare_motion(clip, &model)?;
        let surface = if skill.world == "ground" { Surface::GROUND } else { Surface::ICE };
        let mut settings = SimulationSettings::of(&model);
        settings.rate = skill.training_rate.unwrap_or(skill.simulation_rate(&model));
        let push_link = link_of(&model, skill, skill.episode.push.as_ref())?;
        let free = free_feet(&motion, &model);
        let task = Self {
            tracker: skill.tracker_options(),
            layout: Arc::new(skill.layout(&model)),
            world: World::plane(surface),
            course: None,
            friction: surface.friction,
            weights: crate::control::joint_weights(&model),
            soles: if skill.reward.contacts.0 > 0.0 { SoleParts::of(&model) } else { SoleParts::default() },
            feet: if skill.reward.feet.0 > 0.0 { foot_joints(&model) } else { Vec::new() },
            forbidden: skill.touch.forbidden_points(&model, &motion),
            pelvis: skill.trial.pelvis_limit(&motion),
            push_link,
            before: Vec::new(),
            judged: false,
            drawn_from: skill.parameters.iter().map(|p| p.range).collect(),
            clip: clip.clone(),
            standing_feet: standing_feet(&free),
            free_feet: free,
            motion: Arc::new(motion),
            skill: skill.clone(),
            settings,
            model,
        };
        task.check_rate(settings.rate)?;
        task.check_feet()?;
        Ok(task)
    }

    /// The same task over a course. The motion stands on it as it is where every warp is neutral.
    pub fn on_course(mut self, course: Course) -> Result<Self, TaskError> {
        let fault = |source| TaskError::Course { skill: self.skill.name.clone(), source: Box::new(source) };
        let mut motion = TrackedMotion::clone(&self.motion);
        self.skill.stand_on_course(&mut motion, &course, &self.world, &self.model).map_err(fault)?;
        if course.ground.is_some() {
            self.world = World::empty();
        }
        // Every parameter that the skill draws is one that the course can have.
        for p in &self.skill.parameters {
            if course.parameter(&p.name).is_some() {
                for value in [p.range.0, p.range.1] {
                    course.set(&mut course.defaults(), &p.name, value).map_err(fault)?;
                }
            }
        }
        self.forbidden = self.skill.touch.forbidden_points(&self.model, &motion);
        self.pelvis = self.skill.trial.pelvis_limit(&motion);
        self.free_feet = free_feet(&motion, &self.model);
        self.standing_feet = standing_feet(&self.free_feet);
        self.motion = Arc::new(motion);
        self.course = Some(Arc::new(course));
        Ok(self)
    }

    /// Whether the character has the feet that the skill asks for.
    fn check_feet(&self) -> Result<(), TaskError> {
        let skill = &self.skill;
        let pushes = skill.episode.push.iter().chain(skill.trial.rows.iter().filter_map(|r| r.push.as_ref()));
        let asking = [
            ("trial.success", skill.trial.success.iter().any(Criterion::needs_feet)),
            (
                "trial.rows success",
                skill.trial.rows.iter().filter_map(|r| r.success.as_ref()).flatten().any(Criterion::needs_feet),
            ),
            ("limits.free_foot", skill.limits.free_foot),
            ("limits.standing_foot", skill.limits.standing_foot),
            ("push.airborne", pushes.into_iter().any(|p| p.airborne)),
        ];
        match asking.into_iter().find(|(_, asks)| *asks && self.model.feet().is_empty()) {
            Some((field, _)) => {
                Err(TaskError::Feet { skill: skill.name.clone(), field, character: self.model.name.clone() })
            }
            None => Ok(()),
        }
    }

    /// The same task at the rate at which a game performs it.
    pub fn at_play_rate(&self) -> Result<Self, TaskError> {
        self.at_rate(fitting_rate(self.model.step_rate, self.skill.control_rate))
    }

    /// Lets trials of the training begin where another motion is left for this one: at its end, or from tick `exit` on.
    pub fn follow(&mut self, other: TrackedMotion, exit: Option<usize>) {
        let entry = (ENTRY * self.skill.control_rate).round() as usize;
        let transition = best_transition(&other, exit, &self.motion, entry);
        self.before.push(Predecessor { motion: Arc::new(other), transition, bodies: Arc::new([]) });
    }

    /// Whether a simulation rate fits the control rate.
    pub fn check_rate(&self, rate: f64) -> Result<(), TaskError> {
        let parts = rate / (self.skill.control_rate * TARGET_SUBSTEPS as f64);
        if parts >= 1.0 && (parts - parts.round()).abs() < 1e-9 {
            return Ok(());
        }
        Err(TaskError::Rate { skill: self.skill.name.clone(), rate, control_rate: self.skill.control_rate })
    }

    /// The same task at another simulation rate.
    pub fn at_rate(&self, rate: f64) -> Result<Self, TaskError> {
        self.check_rate(rate)?;
        let mut other = self.clone();
        other.settings.rate = rate;
        Ok(other)
    }

    /// The skill's table: for each row its name and the task that its trials are made of.
    pub fn trials(&self) -> Result<Vec<(String, Arc<Self>)>, TaskError> {
        let trial = &self.skill.trial;
        let plain = TrialRow::named("unpushed");
        let rows = if trial.rows.is_empty() { core::slice::from_ref(&plain) } else { &trial.rows };
        rows.iter().map(|row| Ok((row.name.clone(), Arc::new(self.trial(row)?)))).collect()
    }

    /// The task that the trials of a row are made of.
    pub fn trial(&self, row: &TrialRow) -> Result<Self, TaskError> {
        let trial = &self.skill.trial;
        if row.after && self.before.is_empty() {
            return Err(TaskError::Before { skill: self.skill.name.clone(), row: row.name.clone() });
        }
        let mut task = self.clone();
        task.judged = true;
        let start = trial.start.or(self.motion.cycle().is_none().then_some((0.0, 0.0)));
        let episode = &mut task.skill.episode;
        *episode = EpisodeOptions {
            seconds: row.seconds.unwrap_or(trial.seconds),
            speed: row.speed.or(episode.speed),
            start_speed: row.start_speed.or(if row.speed.is_some() { None } else { episode.start_speed }),
            friction: trial.friction,
            joint_noise: trial.joint_noise,
            velocity_noise: trial.velocity_noise,
            joint_velocity_noise: trial.joint_velocity_noise,
            push: row.push.clone(),
            steer: row.steer.clone().or_else(|| episode.steer.clone().filter(|_| row.speed.is_none())),
            start,
            after_share: if row.after { 1.0 } else { 0.0 },
            after_policy: false,
            begin_share: 0.0,
        };
        for (range, p) in task.drawn_from.iter_mut().zip(&self.skill.parameters) {
            if let Some(narrower) = row.parameters.iter().find(|q| q.name == p.name) {
                *range = narrower.range;
            }
        }
        if let Some(success) = &row.success {
            task.skill.trial.success.clone_from(success);
        }
        task.push_link = link_of(&task.model, &self.skill, row.push.as_ref())?;
        Ok(task)
    }

    /// Whether a trial of the training that shows the whole motion is judged at its end by the skill's criteria, too: a motion
    /// that ends is over by then, and what it lacks counts as a fall does.
    pub(crate) fn counts_whole(&self) -> bool {
        let whole = self.motion.last() as f64 <= self.skill.episode.seconds * self.skill.control_rate;
        let begins = self.skill.trial.start.is_none_or(|(first, _)| first == 0.0);
        !self.judged && !self.skill.trial.success.is_empty() && self.motion.cycle().is_none() && whole && begins
    }

    /// Whether it matters when a foot touches the ground.
    pub(crate) fn watches_feet(&self) -> bool {
        let limits = &self.skill.limits;
        let in_air = self.skill.episode.push.as_ref().is_some_and(|p| p.airborne);
        self.judged || self.counts_whole() || limits.free_foot || limits.standing_foot || in_air
    }

    /// Height of the lowest contact point of a pose, m.
    pub(crate) fn lowest_point(&self, pose: &ModelPose) -> f64 {
        let places = place_links(pose, &self.model);
        let bottom = |p: &ContactPoint| point_height(p, &places) - p.radius;
        self.model.contact_points.iter().map(bottom).fold(f64::INFINITY, f64::min)
    }

    /// Simulated steps between two decisions.
    pub(crate) fn steps_per_tick(&self) -> f64 {
        self.settings.rate / self.skill.control_rate
    }

    /// The speeds that are drawn for the beginnings of trials, m/s.
    pub(crate) fn drawn_speeds(&self) -> Range {
        let (episode, mean) = (&self.skill.episode, self.motion.mean_speed());
        episode.start_speed.or(episode.speed).unwrap_or((mean, mean))
    }

    /// Numbers of an action.
    pub fn action_size(&self) -> usize {
        self.layout.action_size(&self.model)
    }
}

/// Height of a foot above which the motion has it in the air, m.
const FREE: f64 = 0.03;

/// The joints of all feet.
fn foot_joints(model: &CharacterModel) -> Vec<usize> {
    model.feet().iter().flat_map(|foot| foot.links.iter().copied()).collect()
}

/// Ticks after a landing and before a take-off in which a foot need not stand.
const LANDED: usize = 6;
const LEAVING: usize = 3;

fn place_links(pose: &ModelPose, model: &CharacterModel) -> Vec<LinkTransform> {
    let mut places = Vec::with_capacity(model.links.len());
    pose.link_transforms(model, &mut places);
    places
}

/// Height of the middle of a contact point, m.
fn point_height(point: &ContactPoint, places: &[LinkTransform]) -> f64 {
    let link = &places[point.link];
    (link.position + link.rotation * point.position).y
}

/// For each tick, which of the two feet is in the air.
fn free_feet(motion: &TrackedMotion, model: &SharedModel) -> Arc<[[bool; 2]]> {
    let points = [Side::Left, Side::Right].map(|side| match model.foot(side) {
        Some(Foot { kind: FootKind::Blade(_), toe, heel, .. }) => vec![*toe, *heel],
        Some(foot) => model.foot_points(foot).collect(),
        None => Vec::new(),
    });
    let free = |tick: usize| {
        let (places, support) = (place_links(&motion.tick(tick).pose, model), motion.tick(tick).support);
        let height = |p: &usize| {
            let point = &model.contact_points[*p];
            point_height(point, &places) - point.radius - support
        };
        points.each_ref().map(|foot| foot.iter().map(height).fold(f64::INFINITY, f64::min) > FREE)
    };
    (0..=motion.last()).map(free).collect()
}

/// For each tick, which feet have been on the ground for [`LANDED`] ticks and will be for [`LEAVING`].
fn standing_feet(free: &[[bool; 2]]) -> Arc<[[bool; 2]]> {
    let span = |k: usize| &free[k.saturating_sub(LANDED)..(k + LEAVING + 1).min(free.len())];
    (0..free.len()).map(|k| [0, 1].map(|side| span(k).iter().all(|feet| !feet[side]))).collect()
}

/// The link that a push names.
fn link_of(
    model: &SharedModel,
    skill: &SkillDefinition,
    push: Option<&PushOptions>,
) -> Result<Option<usize>, TaskError> {
    let Some(push) = push else { return Ok(None) };
    model.link_index(&push.link).map(Some).ok_or_else(|| TaskError::PushLink {
        skill: skill.name.clone(),
        link: push.link.clone(),
        valid: model.links.iter().map(|l| l.name.as_str()).collect::<Vec<_>>().join(", "),
    })
}
