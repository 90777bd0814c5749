//! What a way of choosing is told, and what it answers.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::sim::Simulator;
use crate::skill::planner::{Obstacle, Refusal};
use crate::skill::{BadParameter, NoEntry, SkillParameters};
use glam::DVec3;

/// What is wished for from outside. Each way of choosing takes from it what it can use.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DirectorInput {
    /// Direction of travel over the ground, world frame; its length does not matter, zero is as it comes.
    pub direction: DVec3,
    /// Mean speed, m/s; `None` is that of the skill's motion.
    pub speed: Option<f64>,
    /// Turns the way of a skill that plays by itself, rad/s, positive to the left.
    pub turn: f64,
    /// Values for the parameters of the skills.
    pub parameters: SkillParameters,
}

impl DirectorInput {
    /// All of it.
    pub(super) fn write_state(&self, out: &mut StateWriter) {
        out.vector(self.direction);
        out.option(self.speed, StateWriter::number);
        out.number(self.turn);
        self.parameters.write_state(out);
    }
    /// As it was written.
    pub(super) fn read_state(from: &mut StateReader) -> Result<Self, StateError> {
        let direction = from.vector("wished direction")?;
        let speed = from.option("wished speed", |from| from.number("wished speed"))?;
        let turn = from.number("wished turn")?;
        Ok(Self { direction, speed, turn, parameters: SkillParameters::read_state(from)? })
    }
}

/// The body at a decision, and where it is in its skill.
#[derive(Debug)]
pub struct BodyView<'a> {
    /// The body.
    pub simulator: &'a mut Simulator<f64>,
    /// The way that its reference goes over the ground, world axes; unlike the body's own it does not sway with every step.
    pub way: DVec3,
    /// Index of its skill in the graph.
    pub skill: usize,
    /// Tick of the skill's motion at which the next decision is made.
    pub tick: usize,
    /// Whether a motion that ends has ended.
    pub finished: bool,
    /// Decisions since the skill was entered.
    pub decisions: usize,
}

impl BodyView<'_> {
    /// Velocity of the centre of mass, world axes, m/s.
    pub fn velocity(&mut self) -> DVec3 {
        self.simulator.total_momentum().linear.lane(0) / self.simulator.model().mass()
    }
}

/// What plays from a decision on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Choice {
    /// A skill to go over to, by its index in the graph, and the tick at which it is entered; `None` goes on with the present one.
    pub enter: Option<(usize, usize)>,
    /// Mean speed, m/s; `None` leaves the one that the skill has, which at its entry is that of the body.
    pub speed: Option<f64>,
    /// Turns the way, rad/s, positive to the left.
    pub turn: f64,
}

/// What is thought of the obstacle ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseView {
    /// The obstacle.
    pub obstacle: Obstacle,
    /// The skill that will clear it, by its index in the graph, or why none does.
    pub plan: Result<usize, Refusal>,
}

/// What a director did.
#[derive(Clone, Debug, PartialEq)]
pub enum DirectorEvent {
    /// The skill with this index in the graph began; the one before, if any, ended.
    Began(usize),
    /// A skill that was asked for will not begin.
    Refused {
        /// Its name.
        skill: String,
        /// Why.
        reason: NoEntry,
    },
    /// A parameter has not the value that was wished for.
    Parameter {
        /// Its name.
        name: String,
        /// Why.
        reason: BadParameter,
    },
    /// Another plan for what is ahead.
    Plan(CourseView),
    /// The last skill ended; its last pose is held.
    Ended,
}
