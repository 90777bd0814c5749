//! Skills as components: what an athlete performs, instead of an [`AthleteController`](super::AthleteController).

use crate::engine::{ProgramAsset, SkillAsset};
use bevy::prelude::*;

/// Performs one skill by its policy, over and over if it repeats. Takes the place of the athlete's controller.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component)]
pub struct SkillController {
    /// The skill.
    pub skill: Handle<SkillAsset>,
    /// Commanded mean speed, m/s; `None` is that of the motion. Change it at any time.
    pub speed: Option<f32>,
    /// Turns the way, rad/s, positive to the left. Change it at any time.
    pub steering: f32,
}

impl SkillController {
    /// A skill as its motion has it.
    pub fn new(skill: Handle<SkillAsset>) -> Self {
        Self { skill, speed: None, steering: 0.0 }
    }
}

/// Performs a program: one skill after the other. Takes the place of the athlete's controller.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component)]
pub struct SkatingProgram(pub Handle<ProgramAsset>);

/// Skates where it is told to: strokes on straight ways, crosses over on curves, turns and jumps on request. Takes the
/// place of the athlete's controller.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component)]
pub struct Steering {
    /// The skills it may use; it begins with the first.
    pub skills: Vec<Handle<SkillAsset>>,
    /// Direction of travel over the ground, world frame; zero is as it comes.
    pub direction: Vec3,
    /// Mean speed, m/s.
    pub speed: f32,
    /// Name of a skill to perform once, as soon as it can begin; taken out when it does.
    pub perform: Option<String>,
}

impl Steering {
    /// Straight on at 2.5 m/s.
    pub fn new(skills: Vec<Handle<SkillAsset>>) -> Self {
        Self { skills, direction: Vec3::ZERO, speed: 2.5, perform: None }
    }
}
