//! The world of a performance: one that has a name, with a course in it if one is given.

use super::input_error::VALID_WORLDS;
use super::world_spec::{WorldSpec, drawn};
use crate::asset::{Course, CourseError, CourseInstance};
use crate::contact::{CourseTerrain, HeightFieldError, World};
use crate::model::{CharacterModel, Shape};
use glam::{DQuat, DVec3};
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

/// What worlds on courses are called by in control files.
const PREFIX: &str = "course:";

/// A parameter of a course as it is given on the command line: `height=0.45`.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Name of the parameter.
    pub name: String,
    /// Its value.
    pub value: f64,
}

/// Why there is no such world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldChoiceError {
    /// The course cannot be had.
    #[error(transparent)]
    Course(#[from] CourseError),
    /// The course's bumps are no ground.
    #[error(transparent)]
    Bumps(#[from] HeightFieldError),
    /// A text that should be a setting.
    #[error("setting `{found}`; valid: NAME=NUMBER, such as height=0.5")]
    Setting {
        /// What was given.
        found: String,
    },
    /// A control that was made on a course is played without it, or on another.
    #[error("the control was made on course `{made_on}`, not {found}; valid: --course FILE with that course's file")]
    OtherCourse {
        /// The course's name.
        made_on: String,
        /// What is given.
        found: String,
    },
    /// A control names a world that there is not.
    #[error(
        "the control was made in world `{found}`; valid: {VALID_WORLDS}, or course:NAME,seed=N,PARAMETER=NUMBER,..."
    )]
    Recorded {
        /// What the file says.
        found: String,
    },
}

impl FromStr for Setting {
    type Err = WorldChoiceError;

    fn from_str(text: &str) -> Result<Self, WorldChoiceError> {
        let bad = || WorldChoiceError::Setting { found: text.chars().take(80).collect() };
        let (name, value) = text.split_once('=').ok_or_else(bad)?;
        let value: f64 = value.trim().parse().map_err(|_| bad())?;
        if name.trim().is_empty() || !value.is_finite() {
            return Err(bad());
        }
        Ok(Self { name: name.trim().to_owned(), value })
    }
}

/// A course with its numbers.
#[derive(Clone, Debug)]
struct ChosenCourse {
    course: Course,
    values: Vec<f64>,
    seed: u64,
    instance: CourseInstance,
}

/// A world with a name, and a course on it.
#[derive(Clone, Debug)]
pub struct ChosenWorld {
    spec: WorldSpec,
    course: Option<ChosenCourse>,
}

impl ChosenWorld {
    /// A world without a course.
    pub fn named(spec: WorldSpec) -> Self {
        Self { spec, course: None }
    }

    /// The world of a character: `world`, else ice for one with blades and ground for others; with the course of a file, its
    /// parameters as `settings` say, and its bumps drawn from `seed`. A course with ground of its own takes the world's place.
    pub fn new(
        model: &CharacterModel,
        world: Option<WorldSpec>,
        course: Option<&Path>,
        settings: &[Setting],
        seed: u64,
    ) -> Result<Self, WorldChoiceError> {
        let spec = world.unwrap_or_else(|| WorldSpec::default_for(model));
        let Some(path) = course else { return Ok(Self::named(spec)) };
        let course = Course::read(path)?;
        let mut values = course.defaults();
        for setting in settings {
            course.set(&mut values, &setting.name, setting.value)?;
        }
        let instance = course.instance(&values, seed)?;
        let spec = if instance.ground.is_some() { WorldSpec::Empty } else { spec };
        Ok(Self { spec, course: Some(ChosenCourse { course, values, seed, instance }) })
    }

    /// The world that a control file says it was made in (as [`ChosenWorld`] is displayed). One on a course needs the course's
    /// file, and then has the numbers it was made with.
    pub fn recorded(text: &str, model: &CharacterModel, course: Option<&Path>) -> Result<Self, WorldChoiceError> {
        let wrong = || WorldChoiceError::Recorded { found: text.chars().take(200).collect() };
        let Some(rest) = text.strip_prefix(PREFIX) else {
            return text.parse().map(Self::named).map_err(|_| wrong());
        };
        let mut parts = rest.split(',');
        let made_on = parts.next().unwrap_or_default();
        let other = |found: String| WorldChoiceError::OtherCourse { made_on: made_on.to_owned(), found };
        let path = course.ok_or_else(|| other("without one".to_owned()))?;
        let (mut settings, mut seed, mut world) = (Vec::new(), 0, None);
        for part in parts {
            match part.split_once('=').ok_or_else(wrong)? {
                ("seed", number) => seed = number.parse().map_err(|_| wrong())?,
                ("world", name) => world = Some(name.parse().map_err(|_| wrong())?),
                _ => settings.push(part.parse::<Setting>()?),
            }
        }
        let found = Course::read(path)?.name;
        if found != made_on {
            return Err(other(format!("`{found}`")));
        }
        Self::new(model, world, Some(path), &settings, seed)
    }

    /// The world without its course.
    pub fn spec(&self) -> WorldSpec {
        self.spec
    }

    /// The course, with its numbers.
    pub fn course(&self) -> Option<(&Course, &CourseInstance)> {
        self.course.as_ref().map(|c| (&c.course, &c.instance))
    }

    /// True if a solid of the course moves.
    pub fn moves(&self) -> bool {
        self.course.as_ref().is_some_and(|c| c.instance.solids.iter().any(|s| s.motion.is_some()))
    }

    /// All its solids, those of the course as they are at the start.
    pub fn world(&self) -> Result<World, WorldChoiceError> {
        let base = self.spec.world();
        Ok(match &self.course {
            Some(c) => World::with_course(&base, &c.instance)?,
            None => base,
        })
    }

    /// It as a terrain, in which the course's solids move.
    pub fn terrain(&self) -> CourseTerrain<f64> {
        let base = Arc::new(self.spec.world());
        match &self.course {
            Some(c) => CourseTerrain::new(base, &c.instance),
            None => CourseTerrain::empty(base),
        }
    }

    /// Solids to draw besides the floor. Gaps are marked on it; bumps are too low to be seen.
    pub fn scenery(&self) -> Vec<Shape> {
        let mut shapes = self.spec.scenery();
        if let Some(c) = &self.course {
            shapes.extend(course_scenery(&c.instance));
        }
        shapes
    }
}

/// A course's gaps, marked, and its solids as they are at the start, as shapes to draw.
pub fn course_scenery(course: &CourseInstance) -> Vec<Shape> {
    /// Half of a mark's width and thickness, m.
    const MARK: (f64, f64) = (1.0, 0.002);
    let mark = |(near, far): &(f64, f64)| Shape::Box {
        center: DVec3::new(0.0, 0.0, 0.5 * (near + far)),
        half_extents: DVec3::new(MARK.0, MARK.1, 0.5 * (near - far)),
        rotation: DQuat::IDENTITY,
    };
    let mut shapes: Vec<Shape> = course.gaps.iter().map(mark).collect();
    shapes.extend(World::course_solids(course, 0.0).iter().flatten().filter_map(drawn));
    // The steps of stairs share their sides: each box is drawn a hair narrower than the one before.
    for (k, shape) in shapes.iter_mut().enumerate() {
        if let Shape::Box { half_extents, .. } = shape {
            half_extents.x -= (0.001 * (k % 16) as f64).min(0.1 * half_extents.x);
        }
    }
    shapes
}

/// The world's name; on a course `course:NAME,seed=N,world=NAME,PARAMETER=NUMBER,...`, which [`ChosenWorld::recorded`] reads.
impl std::fmt::Display for ChosenWorld {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(c) = &self.course else { return self.spec.fmt(f) };
        write!(f, "{PREFIX}{},seed={}", c.course.name, c.seed)?;
        if c.instance.ground.is_none() {
            write!(f, ",world={}", self.spec)?;
        }
        c.course.parameters.iter().zip(&c.values).try_for_each(|(p, value)| write!(f, ",{}={value}", p.name))
    }
}
