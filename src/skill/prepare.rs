//! From a skill's description and its clip to a motion that can be followed.

use crate::asset::clip::{ClipError, MotionClip};
use crate::asset::{Course, CourseError};
use crate::contact::{CourseTerrain, Terrain, World};
use crate::control::terms::{GainTerm, ObservationLayout};
use crate::control::tracking::{TARGET_SUBSTEPS, TrackedMotion, TrackerOptions, Warp};
use crate::math::Vec3;
use crate::model::{CharacterModel, PointRole};
use crate::skill::{SkillDefinition, SkillError, TouchOptions, WarpDirection};
use glam::DVec3;
use std::sync::Arc;

impl SkillDefinition {
    /// The motion, tick by tick: the skill's part of a clip, lifted clear of the ground, repeated or held at its end.
    pub fn prepare_motion(&self, clip: &MotionClip, model: &CharacterModel) -> Result<TrackedMotion, ClipError> {
        // Over a course, the ground of the clip is not where its lowest point is.
        let lifted = if self.course.is_some() { clip.clone() } else { clip.lifted_clear(model)?.0 };
        let part = match self.window {
            Some((from, to)) => lifted.cut(from, to)?,
            None => lifted,
        };
        let motion = if !self.gait.is_empty() {
            let cycles = self.gait.iter().map(|(from, to)| part.cut(*from, *to)).collect::<Result<Vec<_>, _>>()?;
            TrackedMotion::gait(&cycles, model, self.control_rate)?
        } else if self.cyclic {
            TrackedMotion::cyclic(&part, model, self.control_rate, self.straight)?
        } else {
            TrackedMotion::once(&part, model, self.control_rate, self.hold)?
        };
        let warps = self.warps.iter().filter_map(|warp| {
            let parameter = self.parameters.iter().position(|p| p.name == warp.parameter)?;
            let direction = match warp.direction {
                WarpDirection::Up => DVec3::Y,
                WarpDirection::Ahead => DVec3::NEG_Z,
            };
            let ticks = motion.last() + 1;
            Some(Warp::new(parameter, warp.neutral, direction, &warp.profile, ticks, self.control_rate))
        });
        let warps = warps.collect();
        Ok(motion.with_warps(warps))
    }

    /// Tells a prepared motion what it stands on: the course where every warp is neutral, in `world` where it has no ground of its own.
    pub fn stand_on_course(
        &self,
        motion: &mut TrackedMotion,
        course: &Course,
        world: &World,
        model: &CharacterModel,
    ) -> Result<(), CourseError> {
        let mut values = course.defaults();
        for warp in self.warps.iter().filter(|w| course.parameter(&w.parameter).is_some()) {
            course.set(&mut values, &warp.parameter, warp.neutral)?;
        }
        let world = if course.ground.is_some() { World::empty() } else { world.clone() };
        let terrain = CourseTerrain::<f64>::new(Arc::new(world), &course.instance(&values, 0)?);
        motion.stand_on(model, |p| terrain.height(Vec3::splat(p)).height);
        Ok(())
    }

    /// The world that it names.
    pub fn named_world(&self) -> World {
        if self.world == "ground" { World::ground() } else { World::ice() }
    }

    /// How it is followed.
    pub fn tracker_options(&self) -> TrackerOptions {
        TrackerOptions {
            action_scale: self.action_scale,
            max_reference_drift: self.max_reference_drift,
            gains: self.gains,
            acceleration: self.acceleration,
            ..TrackerOptions::default()
        }
    }

    /// What its policy sees of a character.
    pub fn layout(&self, model: &CharacterModel) -> ObservationLayout {
        let layout = ObservationLayout::from_terms(model, &self.terms(), self.parameters.len());
        match &self.gain_action {
            Some(action) => layout.with_gains(GainTerm::new(action, model, self.gains)),
            None => layout,
        }
    }

    /// Whether a character has the links and the contact points that the skill names.
    pub fn check_links(&self, model: &CharacterModel) -> Result<(), SkillError> {
        let points = || model.contact_points.iter().map(|p| p.name.as_str());
        if let Some(name) = self.touch.never.iter().find(|name| points().all(|point| point != name.as_str())) {
            return Err(SkillError::Value {
                name: self.name.clone(),
                field: "touch.never",
                found: format!("the contact point `{name}`"),
                valid: points().collect::<Vec<_>>().join(", "),
            });
        }
        let named = self.gain_action.iter().flat_map(|action| &action.links);
        match named.into_iter().find(|name| model.link_index(name).is_none_or(|link| link == 0)) {
            None => Ok(()),
            Some(name) => Err(SkillError::Value {
                name: self.name.clone(),
                field: "gain_action",
                found: format!("the link `{name}`"),
                valid: model.links.iter().skip(1).map(|l| l.name.as_str()).collect::<Vec<_>>().join(", "),
            }),
        }
    }

    /// Steps per second at which a character performs it: the rate nearest to its own that is a multiple of the decisions and of the
    /// [`TARGET_SUBSTEPS`] in which targets move.
    pub fn simulation_rate(&self, model: &CharacterModel) -> f64 {
        fitting_rate(model.step_rate, self.control_rate)
    }
}

/// The rate nearest to `rate` (steps per second) that has a whole number of steps in each part of a decision.
pub fn fitting_rate(rate: f64, control_rate: f64) -> f64 {
    let unit = control_rate * TARGET_SUBSTEPS as f64;
    (rate / unit).round().max(1.0) * unit
}

/// Contact points that must not touch anything: those of no foot, and of no role that is allowed. An athlete that stands on one of them
/// has fallen.
pub fn forbidden_points(model: &CharacterModel) -> Vec<usize> {
    let on_a_foot = |p: &usize| model.contact_points[*p].role == PointRole::Foot;
    (0..model.contact_points.len()).filter(|p| !on_a_foot(p)).collect()
}

/// What a motion brings as near to the ground as this may touch it, where a skill may touch what its motion does, m: of two bodies that roll the same way, one is
/// a little rounder.
const NEAR: f64 = 0.1;

impl TouchOptions {
    /// [`forbidden_points`] without those that are allowed to touch, where the motion is the reference.
    pub fn forbidden_points(&self, model: &CharacterModel, motion: &TrackedMotion) -> Vec<usize> {
        let mut forbidden = forbidden_points(model);
        let never = |p: usize| self.never.contains(&model.contact_points[p].name);
        forbidden.retain(|&p| never(p) || !self.roles.contains(&model.contact_points[p].role));
        if self.as_motion {
            let mut places = Vec::with_capacity(model.links.len());
            for tick in (0..=motion.last()).map(|k| motion.tick(k)) {
                tick.pose.link_transforms(model, &mut places);
                forbidden.retain(|&p| {
                    if never(p) {
                        return true;
                    }
                    let point = &model.contact_points[p];
                    let place = places[point.link].position + places[point.link].rotation * point.position;
                    place.y - point.radius - tick.support > NEAR
                });
            }
        }
        forbidden
    }
}
