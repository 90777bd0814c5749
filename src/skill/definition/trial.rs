//! How the trials of a skill are drawn and judged.

use crate::skill::{Criterion, PushOptions, Range};
use serde::{Deserialize, Serialize};

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
    /// Height of the root below which the character has fallen, m.
    pub pelvis: f64,
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
            pelvis: 0.45,
            rows: Vec::new(),
            success: Vec::new(),
        }
    }
}

/// One row of a skill's table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
}
