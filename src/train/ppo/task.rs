//! A skill made ready for trials: its motion laid out for the character, its world, its numbers.

use crate::asset::clip::{ClipError, MotionClip};
use crate::contact::{Surface, World};
use crate::control::tracking::{ObservationLayout, TrackedMotion, TrackerOptions};
use crate::model::{ContactKind, SharedModel};
use crate::sim::SimulationSettings;
use crate::skill::{SkillDefinition, SkillError};
use std::sync::Arc;

/// Targets move on this often within a tick.
pub(crate) const SUBTICKS: usize = 4;

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
        "skill {skill}: {rate} simulation steps per second and {control_rate} decisions per second; valid: the first a multiple of {SUBTICKS} times the second"
    )]
    Rate {
        /// The skill.
        skill: String,
        /// Steps per second.
        rate: f64,
        /// Decisions per second.
        control_rate: f64,
    },
    /// A push names no link.
    #[error("skill {skill}: episode.push.link `{link}`: valid is one of {valid}")]
    PushLink {
        /// The skill.
        skill: String,
        /// The name.
        link: String,
        /// Names of the links.
        valid: String,
    },
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
    pub layout: ObservationLayout,
    /// The world.
    pub world: World,
    /// Friction coefficient of its surface.
    pub friction: f64,
    /// Settings of the simulation; the rate is that of training.
    pub settings: SimulationSettings,
    /// How much each joint counts in a pose: by the mass it carries.
    pub weights: Vec<f64>,
    /// Contact points that must not touch anything.
    pub forbidden: Vec<usize>,
    /// Link that is pushed.
    pub push_link: Option<usize>,
}

impl SkillTask {
    /// Prepares a skill whose motion has been read.
    pub fn new(skill: &SkillDefinition, model: SharedModel, clip: &MotionClip) -> Result<Self, TaskError> {
        skill.validate()?;
        let part = match skill.window {
            Some((from, to)) => clip.cut(from, to)?,
            None => clip.clone(),
        };
        let rate = skill.control_rate;
        let motion = if skill.cyclic {
            TrackedMotion::cyclic(&part, &model, rate, skill.straight)?
        } else {
            TrackedMotion::once(&part, &model, rate, skill.hold)?
        };
        let surface = if skill.world == "ground" { Surface::GROUND } else { Surface::ICE };
        let mut settings = SimulationSettings::of(&model);
        settings.rate = skill.training_rate.unwrap_or(settings.rate);
        let push_link = match &skill.episode.push {
            None => None,
            Some(push) => Some(model.link_index(&push.link).ok_or_else(|| TaskError::PushLink {
                skill: skill.name.clone(),
                link: push.link.clone(),
                valid: model.links.iter().map(|l| l.name.as_str()).collect::<Vec<_>>().join(", "),
            })?),
        };
        let task = Self {
            tracker: TrackerOptions {
                action_scale: skill.action_scale,
                leash: skill.leash,
                gains: skill.gains,
                ..TrackerOptions::default()
            },
            layout: ObservationLayout::of(&model),
            world: World::plane(surface),
            friction: surface.friction,
            weights: crate::control::joint_weights(&model),
            forbidden: forbidden_points(&model),
            push_link,
            clip: clip.clone(),
            motion: Arc::new(motion),
            skill: skill.clone(),
            settings,
            model,
        };
        task.check_rate(settings.rate)?;
        Ok(task)
    }

    /// Whether a simulation rate fits the control rate.
    pub fn check_rate(&self, rate: f64) -> Result<(), TaskError> {
        let parts = rate / (self.skill.control_rate * SUBTICKS as f64);
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

    /// Numbers of an action: three for each link but the root.
    pub fn action_size(&self) -> usize {
        3 * (self.model.links.len() - 1)
    }
}

/// Contact points that do not belong to a foot or a blade.
fn forbidden_points(model: &crate::model::CharacterModel) -> Vec<usize> {
    let stands = |link: usize| {
        let name = &model.links[link].name;
        ["foot", "heel", "metatarsal", "phalan", "toe"].iter().any(|part| name.contains(part))
    };
    let is_forbidden = |(p, c): (usize, &crate::model::ContactPoint)| {
        (matches!(c.kind, ContactKind::Point) && !stands(c.link)).then_some(p)
    };
    model.contact_points.iter().enumerate().filter_map(is_forbidden).collect()
}
