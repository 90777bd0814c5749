//! From a skill's description and its clip to a motion that can be followed.

use crate::asset::clip::{ClipError, MotionClip};
use crate::control::tracking::{TrackedMotion, TrackerOptions};
use crate::model::{CharacterModel, ContactPoint, PointRole};
use crate::skill::SkillDefinition;

impl SkillDefinition {
    /// The motion, tick by tick: the skill's part of a clip, lifted clear of the ground, repeated or held at its end.
    pub fn prepare_motion(&self, clip: &MotionClip, model: &CharacterModel) -> Result<TrackedMotion, ClipError> {
        let part = match self.window {
            Some((from, to)) => clip.lifted_clear(model)?.0.cut(from, to)?,
            None => clip.lifted_clear(model)?.0,
        };
        if self.cyclic {
            TrackedMotion::cyclic(&part, model, self.control_rate, self.straight)
        } else {
            TrackedMotion::once(&part, model, self.control_rate, self.hold)
        }
    }

    /// How it is followed.
    pub fn tracker_options(&self) -> TrackerOptions {
        TrackerOptions {
            action_scale: self.action_scale,
            leash: self.leash,
            gains: self.gains,
            ..TrackerOptions::default()
        }
    }
}

/// Contact points that do not belong to a foot or a blade: an athlete that stands on one of them has fallen.
pub fn forbidden_points(model: &CharacterModel) -> Vec<usize> {
    let on_a_foot = |p: &ContactPoint| p.role == PointRole::Foot;
    (0..model.contact_points.len()).filter(|&p| !on_a_foot(&model.contact_points[p])).collect()
}
