//! A course that is run once: what was seen, planned and cleared, and what became of the runner.

use crate::asset::{Course, CourseError, CourseInstance};
use crate::contact::{CourseTerrain, Surface, Terrain, World};
use crate::control::PolicyError;
use crate::control::tracking::Heading;
use crate::math::{RandomStream, Vec3};
use crate::model::{CharacterModel, SharedModel};
use crate::sim::{SimulationSettings, Simulator, step};
use crate::skill::{CourseView, Director, DirectorEvent, DirectorInput, Disturbance, TrainedSkill};
use glam::DVec3;
use std::sync::Arc;

/// A course, and how it is run.
#[derive(Clone, Debug)]
pub struct CourseTask {
    /// The obstacles.
    pub course: Course,
    /// Values that stay; all other parameters are drawn from their ranges for every run.
    pub values: Vec<(String, f64)>,
    /// Way ahead at which it is over, m.
    pub finish: f64,
    /// Longest time, s.
    pub seconds: f64,
    /// Errors of the start.
    pub disturbance: Disturbance,
    /// Friction coefficient of everything, drawn.
    pub friction: (f64, f64),
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CourseEnd {
    /// It came to the finish.
    Finished,
    /// Something touched that may not, or it lay down.
    Fell,
    /// It left the way.
    Aside,
    /// It stopped, or was too slow.
    Stopped,
}

/// What became of a run.
#[derive(Clone, Debug)]
pub struct CourseRun {
    /// How it ended.
    pub end: CourseEnd,
    /// Way ahead, m.
    pub ahead: f64,
    /// Time, s.
    pub seconds: f64,
    /// Skills that were begun after the first, in order, by name.
    pub skills: Vec<String>,
    /// How long ago the last of them had been left when the run ended, s; `None` where it ended in that skill, or none was begun.
    pub left_before: Option<f64>,
    /// What a fall was: the contact point that touched, or how low the root was.
    pub fell_by: Option<String>,
    /// Plans that were new: when (s), what was seen, and the skill by name.
    pub plans: Vec<(f64, CourseView, Option<String>)>,
}

impl CourseTask {
    /// The course of a run: the parameters that stay, and the others as drawn from `random`.
    fn draw(&self, number: u64, random: &mut RandomStream) -> Result<CourseInstance, CourseError> {
        let mut values = self.course.defaults();
        for (value, parameter) in values.iter_mut().zip(&self.course.parameters) {
            *value = random.range(parameter.range.0, parameter.range.1);
        }
        for (name, value) in &self.values {
            self.course.set(&mut values, name, *value)?;
        }
        self.course.instance(&values, number)
    }

    /// The obstacles of run `number`.
    pub fn instance(&self, (seed, number): (u64, u64)) -> Result<CourseInstance, CourseError> {
        self.draw(number, &mut random_of(seed, number))
    }
}

/// The ground at the start is looked for from here, m.
const HIGHEST: f64 = 50.0;
/// The runner is told to go to the middle of the way, so far ahead, m.
const LOOK: f64 = 6.0;

fn random_of(seed: u64, number: u64) -> RandomStream {
    RandomStream::new(seed, 0x636f_7572_7365 + number)
}

/// Runs a course once; obstacles, friction and start are drawn from `seed` and the run's number. `look` is called after every step.
pub fn run_course(
    director: &mut Director,
    model: &SharedModel,
    task: &CourseTask,
    (seed, number): (u64, u64),
    mut look: impl FnMut(&mut Simulator<f64>, &Director),
) -> Result<Result<CourseRun, PolicyError>, CourseError> {
    let mut random = random_of(seed, number);
    let instance = task.draw(number, &mut random)?;
    let world = if task.course.ground.is_some() { World::empty() } else { World::ground() };
    let mut terrain = CourseTerrain::<f64>::new(Arc::new(world), &instance);
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(model));
    // On whatever is there.
    let ground = terrain.height(Vec3::splat(DVec3::Y * HIGHEST));
    director.begin(&mut sim, Heading::ahead(), DVec3::Y * if ground.found { ground.height } else { 0.0 });
    task.disturbance.apply(&mut sim.state, 0, &mut random);
    sim.friction_scale = random.range(task.friction.0, task.friction.1) / Surface::GROUND.friction;
    sim.state_changed();
    // Who is farther from the middle has gone round.
    let aside = instance.side_walls.map_or(f64::INFINITY, |width| 0.5 * width);
    Ok(perform(director, task, aside, &mut sim, &mut terrain, &mut look))
}

/// What is a fall in a skill: what its motion does is none.
struct FallRule {
    /// Contact points that may not touch.
    forbidden: Vec<usize>,
    /// Lowest height of the root over the ground, m.
    pelvis: f64,
}

impl FallRule {
    fn of(skill: &TrainedSkill, model: &CharacterModel) -> Self {
        let definition = &skill.definition;
        Self {
            forbidden: definition.touch.forbidden_points(model, &skill.motion),
            pelvis: definition.trial.pelvis_limit(&skill.motion),
        }
    }
}

fn perform(
    director: &mut Director,
    task: &CourseTask,
    aside: f64,
    sim: &mut Simulator<f64>,
    terrain: &mut CourseTerrain<f64>,
    look: &mut impl FnMut(&mut Simulator<f64>, &Director),
) -> Result<CourseRun, PolicyError> {
    let model = sim.model().clone();
    let rules: Vec<FallRule> = director.graph().skills().iter().map(|s| FallRule::of(&s.skill, &model)).collect();
    let (mut skills, mut plans, mut left) = (Vec::new(), Vec::new(), None);
    let h = sim.step_seconds();
    loop {
        director.drive(sim, terrain)?;
        step(sim, terrain);
        director.after_step(sim, terrain);
        if terrain.moves() {
            terrain.advance(h);
        }
        look(sim, director);
        let seconds = sim.state.time;
        let place = sim.state.root_position.lane(0);
        director.set_input(DirectorInput { direction: DVec3::new(-place.x, 0.0, -LOOK), ..director.input().clone() });
        while let Some(event) = director.take_event() {
            let name = |k: usize| director.graph().skills()[k].name().to_owned();
            match event {
                DirectorEvent::Began(0) => left = (!skills.is_empty()).then_some(seconds),
                DirectorEvent::Began(k) => {
                    skills.push(name(k));
                    left = None;
                }
                DirectorEvent::Plan(view) => plans.push((seconds, view, view.plan.ok().map(name))),
                _ => {}
            }
        }
        let rule = &rules[director.skill()];
        let touches = rule.forbidden.iter().find(|p| sim.contact_force(**p, 0) != DVec3::ZERO);
        // In a hop down it is low over where it came from, but not over the ground.
        let low = |sim: &Simulator<f64>| {
            let ground = terrain.height(sim.state.root_position);
            !ground.found || place.y - ground.height < rule.pelvis
        };
        let lies = place.y - director.player().support().height < rule.pelvis && low(sim);
        let end = if touches.is_some() || !sim.is_sane(0) || lies {
            CourseEnd::Fell
        } else if -place.z >= task.finish {
            CourseEnd::Finished
        } else if place.x.abs() > aside {
            CourseEnd::Aside
        } else if seconds >= task.seconds {
            CourseEnd::Stopped
        } else {
            continue;
        };
        let left_before = left.map(|left| seconds - left);
        let fell_by = (end == CourseEnd::Fell).then(|| match touches {
            Some(point) => model.contact_points[*point].name.clone(),
            None if lies => format!("the root {:.2} m over its support", place.y - director.player().support().height),
            None => "numbers that make no sense".into(),
        });
        return Ok(CourseRun { end, ahead: -place.z, seconds, skills, left_before, fell_by, plans });
    }
}
