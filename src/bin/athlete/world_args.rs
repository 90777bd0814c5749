//! Options that choose the world of a performance.

use bevy_athlete::cli::{ChosenWorld, Setting, WorldChoiceError, WorldSpec};
use bevy_athlete::model::CharacterModel;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct WorldArgs {
    /// ice, ground, empty, stairs, sphere or slope:DEGREES; by default that of a control, else ice for a character with blades and
    /// ground for others
    #[arg(long)]
    pub world: Option<WorldSpec>,
    /// Course of obstacles (.course.ron); one with ground of its own takes the world's place
    #[arg(long)]
    pub course: Option<PathBuf>,
    /// A parameter of the course, NAME=NUMBER; may be repeated
    #[arg(long, requires = "course")]
    pub set: Vec<Setting>,
    /// Seed of the course's bumps
    #[arg(long, requires = "course", default_value_t = 0)]
    pub course_seed: u64,
}

impl WorldArgs {
    /// The world for a character; `made_in` is what a control says of its own.
    pub fn choose(&self, model: &CharacterModel, made_in: Option<&str>) -> Result<ChosenWorld, WorldChoiceError> {
        match made_in {
            Some(text) if self.world.is_none() && self.set.is_empty() && self.course_seed == 0 => {
                let recorded = ChosenWorld::recorded(text, model, self.course.as_deref())?;
                match (&self.course, recorded.course()) {
                    // Made without a course, and played on one.
                    (Some(course), None) => ChosenWorld::new(model, Some(recorded.spec()), Some(course), &[], 0),
                    _ => Ok(recorded),
                }
            }
            _ => ChosenWorld::new(model, self.world, self.course.as_deref(), &self.set, self.course_seed),
        }
    }
}
