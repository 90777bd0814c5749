//! The description of a skill: which motion is followed, how, and what a trial looks like. `*.skill.ron`.

mod reward;
mod text;
mod trial;

use crate::asset::Character;
use crate::asset::policy_contract::GainAction;
use crate::asset::read_file::read_text;
use crate::control::terms::ObservationTerm;
use crate::model::PointRole;
use crate::skill::planner::Clearance;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

pub use reward::{RewardScales, TerminationLimits};
pub use trial::{PELVIS, TrialOptions, TrialRow};

/// An interval from which numbers are drawn evenly.
pub type Range = (f64, f64);

/// A skill, as saved in a `*.skill.ron` file. Every field but the first three has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkillDefinition {
    /// Name of the skill.
    pub name: String,
    /// Character whose skill it is: a preset, or a `.character.ron` file, relative to this file or to the working folder.
    pub character: String,
    /// The motion: a `.clip.ron`, `.keyposes.ron` or `.bvh` file, relative to this file.
    pub motion: PathBuf,
    /// World: `ice` or `ground`.
    #[serde(default = "ice")]
    pub world: String,
    /// Part of the motion that is used, s; the whole by default.
    #[serde(default)]
    pub window: Option<Range>,
    /// The motion repeats.
    #[serde(default)]
    pub cyclic: bool,
    /// A motion that repeats keeps its heading from cycle to cycle.
    #[serde(default)]
    pub straight: bool,
    /// One cycle for each speed of a gait: from when to when in the motion, s, slow to fast; empty for a motion of one speed. See
    /// [`TrackedMotion::gait`](crate::control::tracking::TrackedMotion::gait).
    #[serde(default)]
    pub gait: Vec<Range>,
    /// How fast a gait goes over to another speed, m/s^2.
    #[serde(default = "acceleration")]
    pub acceleration: f64,
    /// Parameters, drawn for each trial.
    #[serde(default)]
    pub parameters: Vec<SkillParameter>,
    /// Obstacles: a `.course.ron` file, relative to this file. Its parameters are those of the skill with the same names.
    #[serde(default)]
    pub course: Option<PathBuf>,
    /// How parameters move the reference.
    #[serde(default)]
    pub warps: Vec<SkillWarp>,
    /// From when on a motion that ends may be left for another skill, s; by default at its end.
    #[serde(default)]
    pub exit: Option<f64>,
    /// What it brings a runner over, for whoever chooses skills on a course.
    #[serde(default)]
    pub clears: Option<Clearance>,
    /// What the policy sees; [`ObservationTerm::STANDARD`] by default.
    #[serde(default)]
    pub observation: Option<Vec<ObservationTerm>>,
    /// What it sees besides.
    #[serde(default)]
    pub observe: Vec<ObservationTerm>,
    /// What may touch the world besides feet.
    #[serde(default)]
    pub touch: TouchOptions,
    /// How long the last pose of a motion that ends is held, s.
    #[serde(default)]
    pub hold: f64,
    /// Skills that this one may follow in a program: `.skill.ron` files, relative to this file.
    #[serde(default)]
    pub after: Vec<PathBuf>,
    /// Decisions per second.
    #[serde(default = "thirty")]
    pub control_rate: f64,
    /// Simulation steps per second in training; by default the character's. A whole multiple of the control rate.
    #[serde(default)]
    pub training_rate: Option<f64>,
    /// Offset of a joint's target for an action of one, rad.
    #[serde(default = "action_scale")]
    pub action_scale: f64,
    /// Joints whose servo gains the policy sets, besides their targets.
    #[serde(default)]
    pub gain_action: Option<GainAction>,
    /// Servo gains (kp N m/rad, kd N m s/rad) instead of the character's.
    #[serde(default)]
    pub gains: Option<(f64, f64)>,
    /// How far the reference may be from the character before it is dragged along, m; `None` leaves it in its place.
    #[serde(default, alias = "leash")]
    pub max_reference_drift: Option<f64>,
    /// Trials.
    #[serde(default)]
    pub episode: EpisodeOptions,
    /// Rewards.
    #[serde(default)]
    pub reward: RewardScales,
    /// When a trial in training ends early.
    #[serde(default)]
    pub limits: TerminationLimits,
    /// How its policy is judged.
    #[serde(default)]
    pub trial: TrialOptions,
}

fn ice() -> String {
    "ice".into()
}
fn thirty() -> f64 {
    30.0
}
fn acceleration() -> f64 {
    1.5
}
fn action_scale() -> f64 {
    0.3
}

/// A named number of a skill, such as the height of its obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkillParameter {
    /// Its name.
    pub name: String,
    /// From where to where it is drawn, in its unit.
    pub range: Range,
}

/// How a parameter moves the reference: see [`Warp`](crate::control::tracking::Warp).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkillWarp {
    /// Name of the parameter.
    pub parameter: String,
    /// Its value in the motion as it is.
    pub neutral: f64,
    /// Which way the reference is moved by what the parameter is more.
    pub direction: WarpDirection,
    /// Times (s) and factors.
    pub profile: Vec<(f64, f64)>,
}

/// A direction in the motion's own world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WarpDirection {
    /// Up.
    Up,
    /// Ahead, -Z.
    Ahead,
}

/// What may touch the world besides feet without counting as a fall.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TouchOptions {
    /// Roles of contact points, such as `[Hand]`.
    pub roles: Vec<PointRole>,
    /// Points that the motion itself brings to the ground.
    pub as_motion: bool,
    /// Contact points that may not, whatever the two fields before say: `["head"]` for a roll.
    pub never: Vec<String>,
}

/// What is drawn at random for a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EpisodeOptions {
    /// Longest trial, s.
    pub seconds: f64,
    /// Commanded mean speed, m/s; `None` takes that of the motion.
    pub speed: Option<Range>,
    /// Speed at the start, m/s; `None` takes the commanded one.
    pub start_speed: Option<Range>,
    /// Friction coefficient of the surface; `None` leaves the surface's own.
    pub friction: Option<Range>,
    /// Largest angle by which each joint is off at the start, rad.
    pub joint_noise: f64,
    /// Largest error of the velocity at the start, m/s.
    pub velocity_noise: f64,
    /// Largest error of each joint's angular velocity at the start, rad/s.
    pub joint_velocity_noise: f64,
    /// Pushes in training.
    pub push: Option<PushOptions>,
    /// Commands that change during a trial.
    pub steer: Option<SteerOptions>,
    /// Where in the motion trials begin, s; `None` is anywhere.
    pub start: Option<Range>,
    /// Part of the trials in training that begin in the pose in which another skill (see [`SkillDefinition::after`]) is
    /// left for this one, 0 to 1.
    pub after_share: f64,
    /// They begin as that skill's policy (`policy.onnx` beside its file) leaves it, instead of in the pose of its motion.
    pub after_policy: bool,
    /// Part of the other trials in training that begin at the start of a motion that ends, 0 to 1.
    pub begin_share: f64,
}

impl Default for EpisodeOptions {
    fn default() -> Self {
        Self {
            seconds: 10.0,
            speed: None,
            start_speed: None,
            friction: Some((0.01, 0.04)),
            joint_noise: 0.05,
            velocity_noise: 0.1,
            joint_velocity_noise: 0.5,
            push: None,
            steer: None,
            start: None,
            after_share: 0.25,
            after_policy: false,
            begin_share: 0.4,
        }
    }
}

/// Commands at random times: a speed from the range of the episode (a quarter of them the slowest), and a turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteerOptions {
    /// Time from one command to the next, s.
    pub every: Range,
    /// Fastest turn to either side, rad/s. A third of the commands go straight on.
    pub turn: f64,
}

/// Pushes at random times from random sides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PushOptions {
    /// Link that is pushed, at its centre of mass.
    pub link: String,
    /// Force, N.
    pub force: Range,
    /// Length of a push, s.
    pub seconds: f64,
    /// Mean time between pushes, s.
    pub every: f64,
    /// Pushes in a trial; `None` is no limit.
    #[serde(default)]
    pub count: Option<usize>,
    /// Pushes only in the air, one in each flight.
    #[serde(default)]
    pub airborne: bool,
}

/// Why a skill file was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SkillError {
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The text is not a skill file.
    #[error("{}: not a skill file: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Where and why.
        message: String,
    },
    /// A field cannot be used.
    #[error("skill {name}: {field} is {found}; {valid}")]
    Value {
        /// The skill.
        name: String,
        /// The field.
        field: &'static str,
        /// What it holds.
        found: String,
        /// What would be valid.
        valid: String,
    },
}

/// Largest file of a skill, bytes.
const MAX_SKILL_BYTES: u64 = 1 << 20;
/// Two numbers as they stand in a file.
fn shown(pair: Option<(f64, f64)>) -> String {
    pair.map_or_else(|| "none".into(), |(a, b)| format!("({a}, {b})"))
}

impl SkillDefinition {
    /// A skill that follows a motion once, in place, with all defaults.
    pub fn imitate(name: &str, character: &str, motion: impl Into<PathBuf>) -> Self {
        Self {
            name: name.into(),
            character: character.into(),
            motion: motion.into(),
            world: ice(),
            window: None,
            cyclic: false,
            straight: false,
            gait: Vec::new(),
            acceleration: acceleration(),
            parameters: Vec::new(),
            course: None,
            warps: Vec::new(),
            exit: None,
            clears: None,
            observation: None,
            observe: Vec::new(),
            touch: TouchOptions::default(),
            hold: 0.0,
            after: Vec::new(),
            control_rate: thirty(),
            training_rate: None,
            action_scale: action_scale(),
            gain_action: None,
            gains: None,
            max_reference_drift: None,
            episode: EpisodeOptions::default(),
            reward: RewardScales::default(),
            limits: TerminationLimits::default(),
            trial: TrialOptions::default(),
        }
    }

    /// A skill that follows a motion of which nothing else is known: a clip alone says nothing of what may go wrong, so trials
    /// last as long as the motion and begin with small errors only, on the surface as it is.
    pub fn imitate_alone(name: &str, character: &str, motion: impl Into<PathBuf>, world: &str) -> Self {
        let mut skill = Self::imitate(name, character, motion);
        skill.world = world.into();
        let (episode, trial) = (&mut skill.episode, &mut skill.trial);
        (episode.seconds, trial.seconds) = (600.0, 600.0);
        (episode.friction, trial.friction) = (None, None);
        (episode.joint_noise, trial.joint_noise) = (0.02, 0.02);
        (episode.velocity_noise, trial.velocity_noise) = (0.02, 0.02);
        (episode.joint_velocity_noise, trial.joint_velocity_noise) = (0.1, 0.1);
        // A roll lands on its back, a get-up begins on it.
        skill.touch.as_motion = true;
        trial.pelvis = None;
        skill
    }

    /// Makes the motion of [`SkillDefinition::imitate_alone`] one that repeats, and whose reference is dragged along; `straight` keeps its heading from
    /// cycle to cycle.
    pub fn repeat(&mut self, straight: bool) {
        (self.cyclic, self.straight, self.max_reference_drift) = (true, straight, Some(0.3));
        (self.episode.seconds, self.trial.seconds) = (20.0, 20.0);
    }

    /// Reads a file; the paths of motion and course, and of a character file beside it, are made relative to the working folder.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SkillError> {
        let path = path.as_ref();
        let text = read_text(path, MAX_SKILL_BYTES)
            .map_err(|e| SkillError::Io { path: path.to_path_buf(), source: e.into() })?;
        let mut skill = Self::from_ron(&text, path)?;
        if let Some(folder) = path.parent() {
            skill.character = Character::beside(path, &skill.character);
            skill.motion = folder.join(&skill.motion);
            skill.course = skill.course.map(|course| folder.join(course));
            for other in &mut skill.after {
                *other = folder.join(&*other);
            }
        }
        Ok(skill)
    }

    /// Reads text; `path` is for messages.
    pub fn from_ron(text: &str, path: impl AsRef<Path>) -> Result<Self, SkillError> {
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let skill: Self = options
            .from_str(text)
            .map_err(|e| SkillError::Syntax { path: path.as_ref().to_path_buf(), message: e.to_string() })?;
        skill.validate()?;
        Ok(skill)
    }

    /// Whether every number can be used.
    pub fn validate(&self) -> Result<(), SkillError> {
        let bad = |field, found: String, valid: &str| {
            Err(SkillError::Value { name: self.name.clone(), field, found, valid: valid.into() })
        };
        if self.name.is_empty() {
            return bad("name", "empty".into(), "at least one letter");
        }
        if !["ice", "ground"].contains(&self.world.as_str()) {
            return bad("world", self.world.clone(), "`ice` or `ground`");
        }
        if !(5.0..=240.0).contains(&self.control_rate) {
            return bad("control_rate", self.control_rate.to_string(), "5 to 240 decisions per second");
        }
        if let Some(rate) = self.training_rate {
            let multiple = rate / self.control_rate;
            if !((1.0..=1000.0).contains(&multiple) && (multiple - multiple.round()).abs() < 1e-9) {
                return bad("training_rate", rate.to_string(), "a whole multiple of the control rate");
            }
        }
        if !(0.0..=3.0).contains(&self.action_scale) {
            return bad("action_scale", self.action_scale.to_string(), "0 to 3 rad");
        }
        if let Some((_, found, valid)) = self.gain_action.as_ref().and_then(GainAction::fault) {
            return bad("gain_action", found, valid);
        }
        if self.exit.is_some_and(|exit| !(0.0..=3600.0).contains(&exit)) {
            return bad("exit", self.exit.unwrap_or_default().to_string(), "0 to 3600 s");
        }
        if !(0.0..=60.0).contains(&self.hold) {
            return bad("hold", self.hold.to_string(), "0 to 60 s");
        }
        if !(0.05..=100.0).contains(&self.acceleration) {
            return bad("acceleration", self.acceleration.to_string(), "0.05 to 100 m/s^2");
        }
        if let Some((a, b)) = self.gait.iter().find(|(a, b)| !(a.is_finite() && b.is_finite() && 0.0 <= *a && a < b)) {
            return bad("gait", format!("({a}, {b})"), "two times in order, s");
        }
        if !self.gait.is_empty() && (!self.cyclic || self.window.is_some()) {
            return bad("gait", format!("{} cycles", self.gait.len()), "a motion that is `cyclic`, without a `window`");
        }
        if self.window.is_some_and(|(a, b)| !(a.is_finite() && b.is_finite() && 0.0 <= a && a < b)) {
            return bad("window", shown(self.window), "two times in order, s");
        }
        if self.gains.is_some_and(|(kp, kd)| !((0.0..=1e6).contains(&kp) && (0.0..=1e6).contains(&kd))) {
            return bad("gains", shown(self.gains), "two numbers from 0 to 1e6");
        }
        let (e, t) = (&self.episode, &self.trial);
        let lengths = t.rows.iter().filter_map(|r| r.seconds.map(|s| ("trial.rows seconds", s)));
        for (field, seconds) in
            [("episode.seconds", e.seconds), ("trial.seconds", t.seconds)].into_iter().chain(lengths)
        {
            if !(0.1..=600.0).contains(&seconds) {
                return bad(field, seconds.to_string(), "0.1 to 600 s");
            }
        }
        let ranges = [
            ("episode.speed", e.speed, 30.0),
            ("episode.start_speed", e.start_speed, 30.0),
            ("episode.friction", e.friction, 10.0),
            ("episode.start", e.start, 3600.0),
            ("trial.friction", t.friction, 10.0),
            ("trial.start", t.start, 3600.0),
        ];
        let rows = t
            .rows
            .iter()
            .flat_map(|r| [("trial.rows speed", r.speed, 30.0), ("trial.rows start_speed", r.start_speed, 30.0)]);
        for (field, range, most) in ranges.into_iter().chain(rows) {
            if range.is_some_and(|(a, b)| !(0.0 <= a && a <= b && b <= most)) {
                return bad(field, shown(range), &format!("two numbers in order, from 0 to {most}"));
            }
        }
        for (field, joint, velocity, turning) in [
            ("episode noise", e.joint_noise, e.velocity_noise, e.joint_velocity_noise),
            ("trial noise", t.joint_noise, t.velocity_noise, t.joint_velocity_noise),
        ] {
            let possible = (0.0..=1.0).contains(&joint) && (0.0..=5.0).contains(&velocity);
            if !(possible && (0.0..=20.0).contains(&turning)) {
                return bad(field, format!("{joint}, {velocity}, {turning}"), "0 to 1 rad, 0 to 5 m/s, 0 to 20 rad/s");
            }
        }
        for steer in e.steer.iter().chain(t.rows.iter().filter_map(|r| r.steer.as_ref())) {
            let (least, most) = steer.every;
            if !(0.1 <= least && least <= most && most <= 600.0 && (0.0..=20.0).contains(&steer.turn)) {
                let found = format!("every {least} to {most} s up to {} rad/s", steer.turn);
                return bad("steer", found, "0.1 to 600 s in order, 0 to 20 rad/s");
            }
        }
        for push in e.push.iter().chain(t.rows.iter().filter_map(|r| r.push.as_ref())) {
            let (least, most) = push.force;
            let force = 0.0 <= least && least <= most && most <= 1e5;
            if !(force && (0.0..=10.0).contains(&push.seconds) && push.every >= 0.1) {
                let found = format!("{least} to {most} N for {} s every {} s", push.seconds, push.every);
                return bad("push", found, "0 to 1e5 N in order, 0 to 10 s, every 0.1 s or more");
            }
        }
        for (field, share) in [("episode.after_share", e.after_share), ("episode.begin_share", e.begin_share)] {
            if !(0.0..=1.0).contains(&share) {
                return bad(field, share.to_string(), "0 to 1");
            }
        }
        if self.limits.turn.is_some_and(|turn| !(0.0..=core::f64::consts::PI).contains(&turn)) {
            return bad("limits.turn", self.limits.turn.unwrap_or_default().to_string(), "0 to pi rad");
        }
        if let Some((field, found, valid)) = self.clears.as_ref().and_then(Clearance::fault) {
            return bad(field, found, valid);
        }
        let mut names = std::collections::BTreeSet::new();
        if let Some(row) = t.rows.iter().find(|r| r.name.trim().is_empty() || !names.insert(r.name.as_str())) {
            return bad("trial.rows", format!("the name `{}`", row.name), "a name used once");
        }
        if let Some(pelvis) = t.pelvis.filter(|p| !(p.is_finite() && *p >= 0.0)) {
            return bad("trial.pelvis", pelvis.to_string(), "0 m or more");
        }
        self.validate_parameters()
    }

    /// Whether parameters, warps and terms fit together.
    fn validate_parameters(&self) -> Result<(), SkillError> {
        let bad = |field, found: String, valid: &str| {
            Err(SkillError::Value { name: self.name.clone(), field, found, valid: valid.into() })
        };
        let mut names = std::collections::BTreeSet::new();
        for p in &self.parameters {
            let (low, high) = p.range;
            if p.name.trim().is_empty() || !names.insert(p.name.as_str()) {
                return bad("parameters", format!("the name `{}`", p.name), "a name used once");
            }
            if !(low.is_finite() && high.is_finite() && low <= high) {
                return bad("parameters", format!("{} from {low} to {high}", p.name), "two numbers in order");
            }
        }
        for (row, p) in self.trial.rows.iter().flat_map(|r| r.parameters.iter().map(move |p| (&r.name, p))) {
            let (low, high) = p.range;
            let found = format!("{} from {low} to {high} in the row `{row}`", p.name);
            let Some(whole) = self.parameters.iter().find(|q| q.name == p.name) else {
                return bad("trial.rows parameters", found, "the name of a parameter of the skill");
            };
            if !(whole.range.0 <= low && low <= high && high <= whole.range.1) {
                let valid = format!("two numbers in order, from {} to {}", whole.range.0, whole.range.1);
                return bad("trial.rows parameters", found, &valid);
            }
        }
        for warp in &self.warps {
            if !names.contains(warp.parameter.as_str()) {
                return bad("warps", format!("the parameter `{}`", warp.parameter), "the name of a parameter");
            }
            let ascending = warp.profile.windows(2).all(|w| w[0].0 < w[1].0);
            let finite = warp.profile.iter().all(|(t, f)| t.is_finite() && f.is_finite()) && warp.neutral.is_finite();
            if warp.profile.is_empty() || !ascending || !finite {
                return bad(
                    "warps",
                    format!("the profile {:?}", warp.profile),
                    "finite points with ascending times, s",
                );
            }
        }
        let terms = self.terms();
        if let Some(d) = terms.iter().flat_map(ObservationTerm::heights_ahead).find(|d| !(-10.0..=50.0).contains(*d)) {
            return bad("observe", format!("a distance of {d} m"), "-10 to 50 m");
        }
        let mut names = std::collections::BTreeSet::new();
        if let Some(term) = terms.iter().find(|t| !names.insert(t.name())) {
            return bad("observe", format!("the term {} twice", term.name()), "every term once");
        }
        if terms.is_empty() {
            return bad("observation", "empty".into(), "at least one term");
        }
        Ok(())
    }

    /// First tick at which it may be left, where that is not its end.
    pub fn exit_tick(&self) -> Option<usize> {
        self.exit.map(|exit| (exit * self.control_rate).round() as usize)
    }

    /// All terms of the observation, in order.
    pub fn terms(&self) -> Vec<ObservationTerm> {
        let first = self.observation.as_deref().unwrap_or(&ObservationTerm::STANDARD);
        first.iter().chain(&self.observe).cloned().collect()
    }

    /// The values of the parameters from -1 to 1 over their ranges, as a policy sees them.
    pub fn normalise(&self, values: &[f64]) -> Vec<f64> {
        let one = |(value, p): (&f64, &SkillParameter)| {
            let (low, high) = p.range;
            if high > low { (2.0 * value - low - high) / (high - low) } else { 0.0 }
        };
        values.iter().zip(&self.parameters).map(one).collect()
    }
}
