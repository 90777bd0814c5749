//! Obstacles of the lanes of an environment: each has a course of its own, built anew for every episode.

use crate::asset::{Course, CourseInstance};
use crate::contact::CourseTerrain;
use crate::math::{RandomStream, Real};
use crate::skill::SkillDefinition;
use crate::train::ppo::task::SkillTask;
use std::sync::Arc;

/// The course of every lane.
pub(super) struct LaneCourses<R: Real> {
    course: Arc<Course>,
    pub terrain: CourseTerrain<R>,
    /// Work space: values of the course's parameters, and the course that they give.
    values: Vec<f64>,
    instance: CourseInstance,
}

impl<R: Real> LaneCourses<R> {
    pub fn new(course: Arc<Course>, task: &SkillTask) -> Self {
        let values = course.defaults();
        // The course has been built with its defaults before.
        let instance = course.instance(&values, 0).unwrap_or_default();
        let terrain = CourseTerrain::new(Arc::new(task.world.clone()), &instance);
        Self { course, terrain, values, instance }
    }

    /// Puts another course into a lane: the skill's parameters as drawn, all others at their defaults, and other bumps.
    pub fn draw(&mut self, lane: usize, skill: &SkillDefinition, drawn: &[f64], random: &mut RandomStream) {
        for (parameter, value) in skill.parameters.iter().zip(drawn) {
            if let Some(index) = self.course.parameter(&parameter.name) {
                self.values[index] = *value;
            }
        }
        let seed = random.below(1 << 30) as u64;
        // Values in the parameters' ranges give a course of the same kinds of solids; it was tried when the task was made.
        if self.course.evaluate(&self.values, seed, &mut self.instance).is_ok() {
            let fits = self.terrain.set_lane(lane, &self.instance);
            debug_assert!(fits.is_ok(), "{fits:?}");
        }
    }

    /// The course that was drawn last.
    pub fn last(&self) -> &CourseInstance {
        &self.instance
    }

    /// Time goes on by `h`, s.
    pub fn advance(&mut self, h: f64) {
        if self.terrain.moves() {
            self.terrain.advance(h);
        }
    }
}
