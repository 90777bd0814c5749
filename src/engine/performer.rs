//! Performers: what makes a body perform trained skills.

use crate::control::PolicyError;
use crate::control::tracking::Heading;
use crate::engine::Placement;
use crate::math::Quat;
use crate::sim::Simulator;
use crate::skill::{ProgramNews, ProgramPlayer, SkillPlayer, SteeringPlayer, Wish};
use bevy::math::DVec3;

/// One skill, a program, or skills by wish.
#[derive(Clone, Debug)]
pub(super) enum Performer {
    Skill { player: Box<SkillPlayer>, speed: Option<f64>, steering: f64, begun: bool },
    Program(Box<ProgramPlayer>),
    Steered { player: Box<SteeringPlayer>, wish: Wish },
}

impl Performer {
    /// Puts the body at the start.
    pub fn begin(&mut self, sim: &mut Simulator<f64>, placement: &Placement) {
        let heading = Heading::of(Quat::<f64>::splat(placement.heading));
        let place = placement.point(DVec3::ZERO);
        sim.state.time = 0.0;
        match self {
            Self::Skill { player, speed, begun, .. } => {
                player.begin(sim, heading, place, *speed);
                *begun = false;
            }
            Self::Program(player) => player.begin(sim, heading, place),
            Self::Steered { player, .. } => player.begin(sim, heading, place),
        }
    }

    /// The targets of the coming step.
    pub fn drive(&mut self, sim: &mut Simulator<f64>) -> Result<(), PolicyError> {
        match self {
            Self::Skill { player, speed, steering, .. } => {
                if let Some(speed) = speed {
                    player.set_speed(*speed);
                }
                player.set_steering(*steering);
                player.drive(sim)
            }
            Self::Program(player) => player.drive(sim),
            Self::Steered { player, wish } => player.drive(sim, wish),
        }
    }

    /// After a step.
    pub fn after_step(&mut self, sim: &Simulator<f64>) {
        match self {
            Self::Skill { player, .. } => player.after_step(sim),
            Self::Program(player) => player.after_step(sim),
            Self::Steered { player, .. } => player.after_step(sim),
        }
    }

    /// Name of the skill that has begun since this was last asked.
    pub fn take_begun(&mut self) -> Option<String> {
        match self {
            Self::Skill { player, begun, .. } => {
                (!std::mem::replace(begun, true)).then(|| player.skill().name().to_owned())
            }
            Self::Program(player) => match player.take_news() {
                Some(ProgramNews::Began(_)) => Some(player.player().skill().name().to_owned()),
                Some(ProgramNews::Ended) | None => None,
            },
            Self::Steered { player, .. } => player.take_begun().map(str::to_owned),
        }
    }

    /// Whether it has come to its end; what steers or repeats has none.
    pub fn is_finished(&self) -> bool {
        match self {
            Self::Skill { player, .. } => player.is_finished(),
            Self::Program(player) => player.is_finished(),
            Self::Steered { .. } => false,
        }
    }

    /// The player of the present skill.
    pub fn player(&self) -> &SkillPlayer {
        match self {
            Self::Skill { player, .. } => player,
            Self::Program(player) => player.player(),
            Self::Steered { player, .. } => player.player(),
        }
    }
}
