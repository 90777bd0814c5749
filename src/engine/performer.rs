//! Performers: what makes a body perform trained skills.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::control::tracking::Heading;
use crate::engine::Placement;
use crate::math::Quat;
use crate::sim::Simulator;
use crate::skill::{ProgramNews, ProgramPlayer, SkillPlayer, SteeringPlayer, TrainedSkill, Wish};
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

    /// What comes before a decision: another skill, where it is time.
    pub fn prepare(&mut self, sim: &mut Simulator<f64>) {
        match self {
            Self::Skill { player, speed: Some(speed), .. } => player.set_speed(*speed),
            Self::Skill { .. } => {}
            Self::Program(player) => player.prepare(sim),
            Self::Steered { player, wish } => player.prepare(sim, wish),
        }
    }

    /// Moves the targets to where they are in the coming step; false if they stay.
    pub fn move_targets(&mut self, sim: &mut Simulator<f64>) -> bool {
        if let Self::Skill { player, steering, .. } = self {
            player.set_steering(*steering);
        }
        self.player_mut().move_targets(sim)
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

    /// Goes on at another rate, see [`SkillPlayer::set_rate`].
    pub fn set_rate(&mut self, rate: f64) -> bool {
        match self {
            Self::Skill { player, .. } => player.set_rate(rate),
            Self::Program(player) => player.set_rate(rate),
            Self::Steered { player, .. } => player.set_rate(rate),
        }
    }

    /// A name for people; what it is made of is written to `out`.
    pub fn identity(&self, out: &mut StateWriter) -> String {
        let mut skill = |skill: &TrainedSkill| {
            out.text(skill.name());
            out.text(skill.policy.fingerprint());
            out.count(skill.motion.last());
        };
        match self {
            Self::Skill { player, .. } => {
                skill(player.skill());
                format!("the skill {}", player.skill().name())
            }
            Self::Program(player) => {
                player.skills().for_each(|s| skill(s));
                for element in player.elements() {
                    out.number(element.seconds);
                    out.option(element.speed, StateWriter::number);
                    out.number(element.steering);
                }
                format!("a program of {} elements", player.elements().len())
            }
            Self::Steered { player, .. } => {
                player.skills().for_each(|s| skill(s));
                format!("steering among {} skills", player.skills().count())
            }
        }
    }

    /// What it remembers.
    pub fn write_state(&self, out: &mut StateWriter) {
        match self {
            Self::Skill { player, speed, steering, begun } => {
                player.write_state(out);
                out.option(*speed, StateWriter::number);
                out.number(*steering);
                out.switch(*begun);
            }
            Self::Program(player) => player.write_state(out),
            Self::Steered { player, wish } => {
                player.write_state(out);
                out.vector(wish.direction);
                out.number(wish.speed);
                out.option(wish.perform.as_deref(), StateWriter::text);
            }
        }
    }

    /// Goes to where one like it was.
    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        match self {
            Self::Skill { player, speed, steering, begun } => {
                player.read_state(from)?;
                *speed = from.option("wished speed", |from| from.number("wished speed"))?;
                *steering = from.number("wished turn")?;
                *begun = from.switch("whether the skill has begun")?;
            }
            Self::Program(player) => player.read_state(from)?,
            Self::Steered { player, wish } => {
                player.read_state(from)?;
                wish.direction = from.vector("wished direction")?;
                wish.speed = from.number("wished speed")?;
                wish.perform = from.option("wished skill", |from| from.text("wished skill"))?;
            }
        }
        Ok(())
    }

    /// The player of the present skill.
    pub fn player(&self) -> &SkillPlayer {
        match self {
            Self::Skill { player, .. } => player,
            Self::Program(player) => player.player(),
            Self::Steered { player, .. } => player.player(),
        }
    }

    /// The player of the present skill.
    pub fn player_mut(&mut self) -> &mut SkillPlayer {
        match self {
            Self::Skill { player, .. } => player,
            Self::Program(player) => player.player_mut(),
            Self::Steered { player, .. } => player.player_mut(),
        }
    }
}
