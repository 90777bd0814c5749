//! Programs: one skill after the other.

use crate::asset::read_file::read_text;
use crate::asset::{StateError, StateReader, StateWriter};
use crate::control::PolicyError;
use crate::control::tracking::Heading;
use crate::sim::Simulator;
use crate::skill::transition::{Transition, best_transition};
use crate::skill::{SkillPlayer, TrainedSkill};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A program, as saved in a `*.program.ron` file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgramDefinition {
    /// Its name.
    pub name: String,
    /// The character that performs it.
    pub character: String,
    /// What is performed, in order.
    pub elements: Vec<ProgramElement>,
}

/// One element of a program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgramElement {
    /// Name of the skill.
    pub skill: String,
    /// Shortest time, s, of a skill that repeats; it goes on to where the next element can begin. A skill that ends is
    /// performed once.
    #[serde(default)]
    pub seconds: f64,
    /// Commanded mean speed, m/s; by default the one at its beginning.
    #[serde(default)]
    pub speed: Option<f64>,
    /// Turns the way of a skill that repeats by so much, degrees per second, positive to the left.
    #[serde(default)]
    pub steering: f64,
}

/// Why a program cannot be performed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProgramError {
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The text is not a program.
    #[error("{}: not a program: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Where and why.
        message: String,
    },
    /// A value cannot be used.
    #[error("program {program}: {place}: {found}; valid: {valid}")]
    Value {
        /// The program.
        program: String,
        /// Element and field.
        place: String,
        /// What it holds.
        found: String,
        /// What would be valid.
        valid: String,
    },
}

/// Largest file of a program, bytes.
const MAX_PROGRAM_BYTES: u64 = 1 << 20;

impl ProgramDefinition {
    /// Reads a file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ProgramError> {
        let path = path.as_ref();
        let text =
            read_text(path, MAX_PROGRAM_BYTES).map_err(|e| ProgramError::Io { path: path.into(), source: e.into() })?;
        Self::from_ron(&text, path)
    }

    /// Reads text; `path` is for messages.
    pub fn from_ron(text: &str, path: impl AsRef<Path>) -> Result<Self, ProgramError> {
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let program: Self = options
            .from_str(text)
            .map_err(|e| ProgramError::Syntax { path: path.as_ref().into(), message: e.to_string() })?;
        program.validate()?;
        Ok(program)
    }

    /// Whether every number can be used.
    pub fn validate(&self) -> Result<(), ProgramError> {
        if self.elements.is_empty() {
            return self.refuse("elements", "none", "at least one");
        }
        for (k, e) in self.elements.iter().enumerate() {
            let place = |field: &str| format!("element {} ({}), {field}", k + 1, e.skill);
            if !(0.0..=3600.0).contains(&e.seconds) {
                return self.refuse(&place("seconds"), e.seconds, "0 to 3600 s");
            }
            if e.speed.is_some_and(|v| !(0.0..=30.0).contains(&v)) {
                return self.refuse(&place("speed"), format!("{:?}", e.speed), "0 to 30 m/s");
            }
            if !(-90.0..=90.0).contains(&e.steering) {
                return self.refuse(&place("steering"), e.steering, "-90 to 90 degrees per second");
            }
        }
        Ok(())
    }

    fn refuse(&self, place: &str, found: impl ToString, valid: &str) -> Result<(), ProgramError> {
        let (program, place) = (self.name.clone(), place.to_owned());
        Err(ProgramError::Value { program, place, found: found.to_string(), valid: valid.to_owned() })
    }
}

/// What a program player did at a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgramNews {
    /// The element with this index began; the one before, if any, ended.
    Began(usize),
    /// The last element ended; its last pose is held.
    Ended,
}

/// Performs a program with one body. Clones share the program.
#[derive(Clone, Debug)]
pub struct ProgramPlayer {
    elements: Arc<[ProgramElement]>,
    /// From each element to the next.
    transitions: Arc<[Transition]>,
    skills: Arc<[Arc<TrainedSkill>]>,
    /// Steps per second.
    rate: f64,
    /// That of the present element.
    player: SkillPlayer,
    now: usize,
    /// Decisions in the present element.
    age: usize,
    ended: bool,
    news: Option<ProgramNews>,
}

impl ProgramPlayer {
    /// A player of a program whose skills are given by name. `rate`: steps per second.
    pub fn new(
        program: &ProgramDefinition,
        skills: &BTreeMap<String, Arc<TrainedSkill>>,
        rate: f64,
    ) -> Result<Self, ProgramError> {
        program.validate()?;
        let value = |place: String, found: String, valid: String| ProgramError::Value {
            program: program.name.clone(),
            place,
            found,
            valid,
        };
        let mut performed: Vec<Arc<TrainedSkill>> = Vec::new();
        for (k, element) in program.elements.iter().enumerate() {
            let skill = skills.get(&element.skill).ok_or_else(|| {
                let known = skills.keys().cloned().collect::<Vec<_>>().join(", ");
                value(format!("element {}, skill", k + 1), element.skill.clone(), format!("one of {known}"))
            })?;
            performed.push(skill.clone());
        }
        let mut first = None;
        for (k, skill) in performed.iter().enumerate().rev() {
            first = Some(SkillPlayer::new(skill.clone(), rate).ok_or_else(|| {
                let valid = "a multiple of four times the decisions per second";
                value(format!("element {}, rate", k + 1), rate.to_string(), valid.into())
            })?);
        }
        let Some(player) = first else {
            return Err(value("elements".into(), "none".into(), "at least one".into()));
        };
        let passage =
            |pair: &[Arc<TrainedSkill>]| best_transition(&pair[0].motion, &pair[1].motion, pair[1].entry_ticks());
        Ok(Self {
            elements: program.elements.clone().into(),
            transitions: performed.windows(2).map(passage).collect(),
            skills: performed.into(),
            rate,
            player,
            now: 0,
            age: 0,
            ended: false,
            news: None,
        })
    }

    /// The passages from each element to the next.
    pub fn transitions(&self) -> &[Transition] {
        &self.transitions
    }
    /// Index of the present element.
    pub fn element(&self) -> usize {
        self.now
    }
    /// The skill of each element.
    pub fn skills(&self) -> impl Iterator<Item = &Arc<TrainedSkill>> {
        self.skills.iter()
    }
    /// The elements.
    pub fn elements(&self) -> &[ProgramElement] {
        &self.elements
    }
    /// Whether the last element has ended.
    pub fn is_finished(&self) -> bool {
        self.ended
    }
    /// The player of the present element.
    pub fn player(&self) -> &SkillPlayer {
        &self.player
    }
    #[cfg(feature = "engine")]
    pub(crate) fn player_mut(&mut self) -> &mut SkillPlayer {
        &mut self.player
    }
    /// What happened since this was last asked.
    pub fn take_news(&mut self) -> Option<ProgramNews> {
        self.news.take()
    }

    /// Puts the body at the start of the first element.
    pub fn begin(&mut self, sim: &mut Simulator<f64>, heading: Heading<f64>, place: DVec3) {
        self.enter(0);
        self.ended = false;
        self.player.begin(sim, heading, place, self.elements[0].speed);
        self.command();
        self.news = Some(ProgramNews::Began(0));
    }

    /// Goes on at another rate, see [`SkillPlayer::set_rate`].
    pub fn set_rate(&mut self, rate: f64) -> bool {
        let fits = self.skills.iter().all(|skill| SkillPlayer::new(skill.clone(), rate).is_some());
        let changed = fits && self.player.set_rate(rate);
        if changed {
            self.rate = rate;
        }
        changed
    }

    /// What it remembers; the program and its skills are not part of it.
    pub fn write_state(&self, out: &mut StateWriter) {
        out.count(self.now);
        out.count(self.age);
        out.switch(self.ended);
        out.number(self.rate);
        out.option(self.news, |out, news| match news {
            ProgramNews::Began(element) => out.count(element + 1),
            ProgramNews::Ended => out.count(0),
        });
        self.player.write_state(out);
    }

    /// Goes to where a player of the same program was.
    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        let count = self.elements.len();
        let now = from.below("element of the program", count)?;
        let age = from.below("decisions in the element", 1 << 31)?;
        self.ended = from.switch("whether the program has ended")?;
        let rate = from.number("rate of the program")?;
        self.news = from.option("news of the program", |from| {
            Ok(match from.below("news of the program", count + 1)? {
                0 => ProgramNews::Ended,
                begun => ProgramNews::Began(begun - 1),
            })
        })?;
        self.player = SkillPlayer::new(self.skills[now].clone(), rate)
            .ok_or_else(|| StateError::value("rate of the program", rate, "a rate that fits the skill"))?;
        (self.now, self.age, self.rate) = (now, age, rate);
        self.player.read_state(from)
    }

    /// Makes an element the present one. Its player is made anew where it is another skill's.
    fn enter(&mut self, element: usize) {
        (self.now, self.age) = (element, 0);
        // The rate has fitted every skill before.
        if let Some(player) = SkillPlayer::new(self.skills[element].clone(), self.rate) {
            self.player = player;
        }
    }

    fn command(&mut self) {
        let (element, player) = (&self.elements[self.now], &mut self.player);
        if let Some(speed) = element.speed {
            player.set_speed(speed);
        }
        player.set_steering(element.steering.to_radians());
    }

    /// Sets the servo targets of the coming step. Call it before each step.
    pub fn drive(&mut self, sim: &mut Simulator<f64>) -> Result<(), PolicyError> {
        if self.player.at_decision() {
            self.prepare(sim);
        }
        self.player.drive(sim)
    }

    /// What comes before a decision: going on to the next element, where it is time.
    pub(crate) fn prepare(&mut self, sim: &mut Simulator<f64>) {
        self.go_on(sim);
        self.age += 1;
    }

    /// Call it after each step.
    pub fn after_step(&mut self, sim: &Simulator<f64>) {
        self.player.after_step(sim);
    }

    /// Goes on to the next element where the present one is to be left.
    fn go_on(&mut self, sim: &mut Simulator<f64>) {
        let (element, skill) = (&self.elements[self.now], self.player.skill());
        let enough = match skill.motion.cycle() {
            Some(_) => self.age as f64 >= element.seconds * skill.definition.control_rate,
            None => self.player.is_finished(),
        };
        if !enough || self.ended {
            return;
        }
        let Some(transition) = self.transitions.get(self.now).copied() else {
            self.ended = true;
            self.news = Some(ProgramNews::Ended);
            return;
        };
        if skill.motion.cycle().is_some() && self.player.tick() % skill.motion.last() != transition.leave {
            return;
        }
        self.enter(self.now + 1);
        self.player.join(sim, transition.enter);
        self.command();
        self.news = Some(ProgramNews::Began(self.now));
    }
}
