//! How the trials of a skill are drawn and judged.

use super::{PushOptions, Range, SkillParameter, SteerOptions};
use crate::control::tracking::TrackedMotion;
use crate::skill::Criterion;
use serde::{Deserialize, Serialize};

/// Height of the root above its support below which an athlete has fallen, m, where nothing else is said.
pub const PELVIS: f64 = 0.45;
/// How far below the lowest point of its reference the root may be in a motion that goes low, m.
const BELOW_MOTION: f64 = 0.15;

/// What `athlete evaluate` and the measurements of a training try. A trial fails by a fall (anything but the blades on
/// the ice, or the root below [`TrialOptions::pelvis`]) and by an unmet criterion. A skill without criteria fails as in
/// training, too: by its limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrialOptions {
    /// Longest trial, s. One of a motion that ends, ends with it.
    pub seconds: f64,
    /// Where in the motion trials begin, s; by default anywhere in a cycle, or at the start of a motion that ends.
    pub start: Option<Range>,
    /// Friction coefficient of the surface; `None` leaves the surface's own.
    pub friction: Option<Range>,
    /// Largest angle by which each joint is off at the start, rad.
    pub joint_noise: f64,
    /// Largest error of the velocity at the start, m/s.
    pub velocity_noise: f64,
    /// Largest error of each joint's angular velocity at the start, rad/s.
    pub joint_velocity_noise: f64,
    /// Height of the root above its support below which the character has fallen, m; `None` takes [`PELVIS`], or less where the motion
    /// itself goes lower.
    pub pelvis: Option<f64>,
    /// What is tried; by default one row.
    pub rows: Vec<TrialRow>,
    /// What a trial has to show.
    pub success: Vec<Criterion>,
}

impl Default for TrialOptions {
    fn default() -> Self {
        Self {
            seconds: 10.0,
            start: None,
            friction: Some((0.01, 0.04)),
            joint_noise: 0.1,
            velocity_noise: 0.2,
            joint_velocity_noise: 0.0,
            pelvis: None,
            rows: Vec::new(),
            success: Vec::new(),
        }
    }
}

/// One row of a skill's table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialRow {
    /// Its name.
    pub name: String,
    /// Commanded mean speed, m/s; by default that of the training.
    #[serde(default)]
    pub speed: Option<Range>,
    /// Speed at the start, m/s; by default that of the training.
    #[serde(default)]
    pub start_speed: Option<Range>,
    /// Pushes.
    #[serde(default)]
    pub push: Option<PushOptions>,
    /// Commands that change; by default those of the training where the row names no speed.
    #[serde(default)]
    pub steer: Option<SteerOptions>,
    /// Narrower ranges of some of the skill's parameters; the others are drawn as in training.
    #[serde(default)]
    pub parameters: Vec<SkillParameter>,
    /// Longest trial, s; by default [`TrialOptions::seconds`].
    #[serde(default)]
    pub seconds: Option<f64>,
    /// What a trial of this row has to show; by default [`TrialOptions::success`].
    #[serde(default)]
    pub success: Option<Vec<Criterion>>,
    /// Trials begin where the skills of [`SkillDefinition::after`](crate::skill::SkillDefinition::after) are left for this one, as their policies
    /// leave it where [`EpisodeOptions::after_policy`](crate::skill::EpisodeOptions::after_policy) says so, instead of at the motion's own start.
    #[serde(default)]
    pub after: bool,
}

impl TrialRow {
    /// A row that tries the skill as it is trained, but for pushes and commands.
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }
}

impl TrialOptions {
    /// Height of the root above its support below which an athlete that follows this motion has fallen, m.
    pub fn pelvis_limit(&self, motion: &TrackedMotion) -> f64 {
        let height = |k: usize| motion.tick(k).pose.root_position.y - motion.tick(k).support;
        let lowest = (0..=motion.last()).map(height).fold(f64::INFINITY, f64::min);
        self.pelvis.unwrap_or(PELVIS.min(lowest - BELOW_MOTION))
    }
}
