//! A program: one skill after the other, each for as long as its element says.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::skill::director::{BodyView, Choice};
use crate::skill::{Entry, ProgramElement, SkillGraph};
use std::sync::Arc;

/// Goes through the elements of a program. Clones share them.
#[derive(Clone, Debug)]
pub struct Program {
    elements: Arc<[ProgramElement]>,
    /// The skill of each element in the graph.
    skills: Arc<[usize]>,
    now: usize,
    ended: bool,
}

impl Program {
    /// The elements of a program, which has been checked, and their skills in the graph.
    pub(super) fn new(elements: &[ProgramElement], skills: Vec<usize>) -> Self {
        Self { elements: elements.into(), skills: skills.into(), now: 0, ended: false }
    }

    /// The elements.
    pub fn elements(&self) -> &[ProgramElement] {
        &self.elements
    }
    /// The skill of each element, by its index in the graph.
    pub fn skills(&self) -> &[usize] {
        &self.skills
    }
    /// Index of the present element.
    pub fn element(&self) -> usize {
        self.now
    }
    /// Whether the last element has ended.
    pub fn is_finished(&self) -> bool {
        self.ended
    }

    pub(super) fn restart(&mut self) {
        (self.now, self.ended) = (0, false);
    }

    /// The first skill and the speed it begins with, m/s.
    pub(super) fn start(&self) -> (usize, Option<f64>) {
        (self.skills[0], self.elements[0].speed)
    }

    /// Goes on to the next element where the present one has lasted and can be left.
    pub(super) fn next(&mut self, body: &BodyView, graph: &SkillGraph) -> Choice {
        let (element, skill) = (&self.elements[self.now], &graph.skills()[body.skill]);
        let enough = if skill.repeats() {
            body.decisions as f64 >= element.seconds * skill.skill.definition.control_rate
        } else {
            body.finished
        };
        let mut enter = None;
        if enough && !self.ended {
            match self.skills.get(self.now + 1) {
                None => self.ended = true,
                Some(&next) => {
                    if let Entry::Now { tick } = graph.entry(body.skill, body.tick, next) {
                        enter = Some((next, tick));
                        self.now += 1;
                    }
                }
            }
        }
        let element = &self.elements[self.now];
        Choice { enter, speed: element.speed, turn: element.steering.to_radians() }
    }

    pub(super) fn write_state(&self, out: &mut StateWriter) {
        out.count(self.now);
        out.switch(self.ended);
    }

    pub(super) fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        self.now = from.below("element of the program", self.elements.len())?;
        self.ended = from.switch("whether the program has ended")?;
        Ok(())
    }
}
