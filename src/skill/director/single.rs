//! One skill, over and over if it repeats.

use crate::skill::SkillGraph;
use crate::skill::director::{BodyView, Choice, DirectorInput};

/// Plays the first skill of its graph, as fast as is wished and turning as is wished.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Single;

impl Single {
    pub(super) fn next(&self, body: &BodyView, graph: &SkillGraph, input: &DirectorInput) -> Choice {
        let mean = graph.skills()[body.skill].skill.motion.mean_speed();
        Choice { enter: None, speed: Some(input.speed.unwrap_or(mean)), turn: input.turn }
    }
}
