//! The scenes of the demo. Each is a state of the app: what it spawns goes when it is left.
//!
//! | file | scene |
//! | --- | --- |
//! | `skating` | the rink: a skater with a control, a program, skills, or steered |
//! | `foot_lab` | the human with feet of sixteen bones on a floor that tilts |
//! | `course` | the runner and its obstacles |
//! | `field` | a walk over rough ground |
//! | `crowd` | as many skaters as the machine holds |

pub(super) mod course;
pub(super) mod crowd;
pub(super) mod field;
pub(super) mod foot_lab;
pub(super) mod skating;

use bevy::prelude::*;

/// A scene of the demo.
#[derive(States, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DemoScene {
    /// A skater on a rink.
    #[default]
    Rink,
    /// The foot human on a floor that tilts.
    FootLab,
    /// The runner and its obstacles.
    Course,
    /// As many skaters as the machine holds.
    Crowd,
    /// A walk over rough ground.
    Field,
}

impl DemoScene {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Rink, Self::FootLab, Self::Course, Self::Crowd, Self::Field];

    /// Its name on a command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rink => "rink",
            Self::FootLab => "foot-lab",
            Self::Course => "course",
            Self::Crowd => "crowd",
            Self::Field => "field",
        }
    }

    /// Its title in the menu.
    pub fn title(self) -> &'static str {
        match self {
            Self::Rink => "Rink",
            Self::FootLab => "Foot lab",
            Self::Course => "Course",
            Self::Crowd => "Crowd",
            Self::Field => "Field",
        }
    }

    /// The scene of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scene| scene.name() == name)
    }
}

/// An entity that everything a scene spawns hangs on.
pub(super) fn scene_root(commands: &mut Commands, scene: DemoScene) -> Entity {
    commands.spawn((DespawnOnExit(scene), Transform::default(), Visibility::default())).id()
}
