//! What the skater on the rink does.

use crate::skill::SKATING_SKILLS;
use bevy::prelude::*;

/// What the skater on the rink does.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// The reconstructed control, beside the motion it follows.
    Clip,
    /// The short program.
    Program,
    /// Where the player points.
    Steer,
    /// One skill, by its index among those that ship.
    Skill(usize),
}

impl Act {
    /// The act of this name: `clip`, `program`, `steer`, or a skill.
    pub fn of_name(name: &str) -> Option<Self> {
        match name {
            "clip" => Some(Self::Clip),
            "program" => Some(Self::Program),
            "steer" => Some(Self::Steer),
            skill => SKATING_SKILLS.iter().position(|s| *s == skill).map(Self::Skill),
        }
    }

    /// All names that [`Act::of_name`] knows.
    pub fn names() -> impl Iterator<Item = &'static str> {
        ["clip", "program", "steer"].into_iter().chain(SKATING_SKILLS)
    }

    /// Its title in the menu.
    pub fn title(self) -> String {
        match self {
            Self::Clip => "Reconstructed clip".into(),
            Self::Program => "Short program".into(),
            Self::Steer => "Steer it yourself".into(),
            Self::Skill(k) => skill_title(SKATING_SKILLS.get(k).copied().unwrap_or_default()),
        }
    }
}

/// A skill's name as a title.
pub(crate) fn skill_title(name: &str) -> String {
    let mut title = name.replace('_', " ");
    if let Some(first) = title.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    title
}
