//! One body through the skills that are chosen for it.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::contact::Terrain;
use crate::control::PolicyError;
use crate::control::terms::ObservationTerm;
use crate::control::tracking::Heading;
use crate::model::CharacterModel;
use crate::sim::Simulator;
use crate::skill::director::{
    BodyView, Choice, Course, DirectorEvent, DirectorInput, DirectorKind, Program, Single, Steering,
};
use crate::skill::{
    BadParameter, Entry, GraphError, NoEntry, ProgramDefinition, ProgramError, SkillGraph, SkillPlayer, TrainedSkill,
};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

/// Performs skills with one body: the same sequence for a command line and a game, [`Director::drive`] before each step,
/// [`Director::after_step`] after it. Clones share the graph.
#[derive(Clone, Debug)]
pub struct Director {
    graph: Arc<SkillGraph>,
    kind: DirectorKind,
    input: DirectorInput,
    player: SkillPlayer,
    /// Index of the present skill.
    now: usize,
    /// Decisions in it.
    decisions: usize,
    /// Steps per second.
    rate: f64,
    events: VecDeque<DirectorEvent>,
    /// Whether the end was told.
    ended: bool,
    /// Whether the present skill has the parameters that are wished for, and what is wrong with them was told.
    heard: bool,
}

impl Director {
    /// A director at the start. `rate`: steps per second of the simulation.
    pub fn new(graph: Arc<SkillGraph>, kind: DirectorKind, rate: f64) -> Result<Self, GraphError> {
        graph.check_rate(rate)?;
        let input = DirectorInput::default();
        let (now, _) = kind.start(&input);
        let first = &graph.skills()[now].skill;
        let decisions = first.definition.control_rate;
        let player = SkillPlayer::new(first.clone(), rate).ok_or_else(|| GraphError::Rate {
            skill: first.name().to_owned(),
            rate,
            decisions,
        })?;
        let events = VecDeque::from([DirectorEvent::Began(now)]);
        Ok(Self { graph, kind, input, player, now, decisions: 0, rate, events, ended: false, heard: true })
    }

    /// One skill, over and over if it repeats.
    pub fn single(skill: Arc<TrainedSkill>, rate: f64) -> Result<Self, GraphError> {
        let graph = SkillGraph::new(vec![skill], &[])?;
        Self::new(Arc::new(graph), DirectorKind::Single(Single), rate)
    }

    /// A program whose skills are given by name.
    pub fn program(
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
        let (mut performed, mut places): (Vec<Arc<TrainedSkill>>, Vec<usize>) = (Vec::new(), Vec::new());
        for (k, element) in program.elements.iter().enumerate() {
            let skill = skills.get(&element.skill).ok_or_else(|| {
                let known = skills.keys().cloned().collect::<Vec<_>>().join(", ");
                value(format!("element {}, skill", k + 1), element.skill.clone(), format!("one of {known}"))
            })?;
            let known = performed.iter().position(|s| s.name() == skill.name());
            places.push(known.unwrap_or_else(|| {
                performed.push(skill.clone());
                performed.len() - 1
            }));
        }
        let fault = |source: GraphError| ProgramError::Graph { program: program.name.clone(), source };
        let names: Vec<String> = performed.iter().map(|s| s.name().to_owned()).collect();
        let links: Vec<(&str, &str)> =
            places.windows(2).map(|pair| (names[pair[0]].as_str(), names[pair[1]].as_str())).collect();
        let graph = SkillGraph::new(performed, &links).map_err(fault)?;
        let kind = DirectorKind::Program(Program::new(&program.elements, places));
        Self::new(Arc::new(graph), kind, rate).map_err(fault)
    }

    /// Skills by wish: it begins with the first. Where a curve is known to one side only, its image is used for the other.
    pub fn steering(skills: Vec<Arc<TrainedSkill>>, model: &CharacterModel, rate: f64) -> Result<Self, GraphError> {
        let graph = SkillGraph::both_sides(skills, model)?;
        Self::new(Arc::new(graph), DirectorKind::Steering(Steering::default()), rate)
    }

    /// A run over obstacles: the first skill runs, the others clear what their files say (`clears`), each to either side.
    pub fn course(skills: Vec<Arc<TrainedSkill>>, model: &CharacterModel, rate: f64) -> Result<Self, GraphError> {
        let graph = SkillGraph::around(skills, model)?;
        let kind = DirectorKind::Course(Course::new(&graph));
        Self::new(Arc::new(graph), kind, rate)
    }

    /// The skills and their transitions.
    pub fn graph(&self) -> &SkillGraph {
        &self.graph
    }
    /// The way it chooses.
    pub fn kind(&self) -> &DirectorKind {
        &self.kind
    }
    /// The program it goes through, if it does.
    pub fn as_program(&self) -> Option<&Program> {
        match &self.kind {
            DirectorKind::Program(program) => Some(program),
            _ => None,
        }
    }
    /// Index of the present skill in the graph.
    pub fn skill(&self) -> usize {
        self.now
    }
    /// The player of the present skill.
    pub fn player(&self) -> &SkillPlayer {
        &self.player
    }
    #[cfg(feature = "engine")]
    pub(crate) fn player_mut(&mut self) -> &mut SkillPlayer {
        &mut self.player
    }
    /// What is wished for.
    pub fn input(&self) -> &DirectorInput {
        &self.input
    }
    /// Wishes; they count from the next decision on.
    pub fn set_input(&mut self, input: DirectorInput) {
        self.heard &= input.parameters == self.input.parameters;
        self.input = input;
    }
    /// Whether it has come to its end; what steers or repeats has none.
    pub fn is_finished(&self) -> bool {
        self.kind.is_finished(self.player.is_finished())
    }
    /// What happened since this was last asked, one after the other.
    pub fn take_event(&mut self) -> Option<DirectorEvent> {
        self.events.pop_front()
    }

    /// The same with these wishes.
    pub fn with_input(mut self, input: DirectorInput) -> Self {
        self.set_input(input);
        self
    }
    /// Forgets a request that is open; its skill.
    pub fn drop_request(&mut self) -> Option<String> {
        let k = self.kind.drop_request()?;
        Some(self.graph.skills()[k].name().to_owned())
    }

    /// When the skill of this name would begin, were it asked for now.
    pub fn entry(&self, sim: &mut Simulator<f64>, skill: &str) -> Entry {
        let Some(k) = self.graph.index(skill) else { return Entry::Never(self.unknown()) };
        self.kind.entry(k, &self.view(sim), &self.graph)
    }

    /// Asks for the skill of this name, once, in place of one that was asked for before. What comes of it is told by an event:
    /// it began, or it was refused.
    pub fn request(&mut self, sim: &mut Simulator<f64>, skill: &str) -> Entry {
        let asked = self.graph.index(skill);
        let before = self.kind.request();
        let entry = match asked {
            None => Entry::Never(self.unknown()),
            Some(k) => {
                let view = self.view(sim);
                self.kind.ask(k, &view, &self.graph)
            }
        };
        match (&entry, before) {
            (Entry::Never(reason), _) => {
                self.events.push_back(DirectorEvent::Refused { skill: skill.to_owned(), reason: reason.clone() });
            }
            (_, Some(before)) if Some(before) != asked => {
                self.refuse(before, NoEntry::Replaced { by: skill.to_owned() });
            }
            _ => {}
        }
        entry
    }

    fn refuse(&mut self, skill: usize, reason: NoEntry) {
        let skill = self.graph.skills()[skill].name().to_owned();
        self.events.push_back(DirectorEvent::Refused { skill, reason });
    }

    fn unknown(&self) -> NoEntry {
        NoEntry::Unknown { known: self.graph.names() }
    }

    fn view<'a>(&self, simulator: &'a mut Simulator<f64>) -> BodyView<'a> {
        // A tick whose decision has been made is over as far as choices go.
        let tick = self.player.tick() + usize::from(!self.player.at_decision());
        let finished = self.player.is_finished();
        BodyView { simulator, way: self.player.way(), skill: self.now, tick, finished, decisions: self.decisions }
    }

    /// Puts the body at the start of the first skill.
    pub fn begin(&mut self, sim: &mut Simulator<f64>, heading: Heading<f64>, place: DVec3) {
        self.events.clear();
        if let Some(open) = self.kind.restart() {
            self.refuse(open, NoEntry::Restarted);
        }
        let (first, speed) = self.kind.start(&self.input);
        self.heard = false;
        self.enter(first);
        self.ended = false;
        self.player.begin(sim, heading, place, speed);
    }

    /// Makes a skill the present one, with a player of its own.
    fn enter(&mut self, skill: usize) {
        (self.now, self.decisions) = (skill, 0);
        // The rate has fitted every skill before.
        if let Some(player) = SkillPlayer::new(self.graph.skills()[skill].skill.clone(), self.rate) {
            self.player = player;
        }
        self.events.push_back(DirectorEvent::Began(skill));
        self.choose_parameters();
    }

    /// Gives the present skill the parameters that are wished for. What is wrong with one is told; names that no skill has, once.
    fn choose_parameters(&mut self) {
        let first = !std::mem::replace(&mut self.heard, true);
        let (wished, events) = (self.kind.parameters().unwrap_or(&self.input.parameters), &mut self.events);
        let mut tell = |name: &str, reason| {
            events.push_back(DirectorEvent::Parameter { name: name.to_owned(), reason });
        };
        self.player.choose_parameters(wished, &mut tell);
        if first {
            let parameters = || self.graph.skills().iter().flat_map(|s| &s.skill.definition.parameters);
            for (name, _) in wished.iter().filter(|(name, _)| parameters().all(|p| p.name != *name)) {
                let known: BTreeSet<_> = parameters().map(|p| p.name.clone()).collect();
                tell(name, BadParameter::Unknown { known: known.into_iter().collect() });
            }
        }
    }

    /// Goes on at another rate, see [`SkillPlayer::set_rate`].
    pub fn set_rate(&mut self, rate: f64) -> bool {
        let changed = self.graph.check_rate(rate).is_ok() && self.player.set_rate(rate);
        if changed {
            self.rate = rate;
        }
        changed
    }

    /// Sets the servo targets of the coming step, after a look at what is ahead where there is a decision to make. Call it before each
    /// step.
    pub fn drive(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) -> Result<(), PolicyError> {
        if self.player.at_decision() {
            self.prepare(sim, terrain);
        }
        self.player.drive(sim, terrain)
    }

    /// What comes before a decision: going over to another skill where it is time, its speed and its turn.
    pub(crate) fn prepare(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) {
        if let Some((distances, heights)) = self.kind.profile() {
            self.player.profile(sim, terrain, distances, heights);
        }
        let mut view = self.view(sim);
        let Choice { enter, speed, turn } = self.kind.next(&mut view, &self.graph, &self.input);
        if let Some(plan) = self.kind.take_plan() {
            self.events.push_back(DirectorEvent::Plan(plan));
        }
        if let Some((skill, tick)) = enter {
            let support = self.player.support();
            self.enter(skill);
            self.player.set_support(&support);
            self.player.join(sim, tick);
        }
        if !self.heard {
            self.choose_parameters();
        }
        if let Some(speed) = speed {
            self.player.set_speed(speed);
        }
        self.player.set_steering(turn);
        self.decisions += 1;
        if self.is_finished() && !std::mem::replace(&mut self.ended, true) {
            self.events.push_back(DirectorEvent::Ended);
        }
    }

    /// Steps per second at which a character performs its skills: the rate nearest to its own that fits their decisions.
    pub fn simulation_rate(&self, model: &CharacterModel) -> f64 {
        self.player.skill().definition.simulation_rate(model)
    }

    /// Call it after each step, on what the step was made.
    pub fn after_step(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) {
        self.player.after_step(sim, terrain);
    }

    /// How far from its root one of the skills looks at the ground, m; zero where none does.
    pub fn sees_ground_within(&self) -> f64 {
        let terms = self.graph.skills().iter().flat_map(|s| &s.skill.layout.terms);
        terms.flat_map(ObservationTerm::heights_ahead).fold(self.kind.sight(), |far, d| far.max(d.abs()))
    }

    /// A name for people; what it is made of is written to `out`.
    pub fn identity(&self, out: &mut StateWriter) -> String {
        for known in self.graph.skills() {
            out.text(known.name());
            out.text(known.skill.policy.fingerprint());
            out.count(known.skill.motion.last());
        }
        self.kind.write_identity(out);
        self.kind.describe(&self.graph)
    }

    /// What it remembers; the graph is not part of it.
    pub fn write_state(&self, out: &mut StateWriter) {
        out.count(self.now);
        out.count(self.decisions);
        out.number(self.rate);
        out.switch(self.ended);
        self.input.write_state(out);
        self.kind.write_state(out);
        // What is not told yet is found again.
        let untold = |event: &DirectorEvent| matches!(event, DirectorEvent::Parameter { .. });
        out.switch(self.heard && !self.events.iter().any(untold));
        let began = |event: &DirectorEvent| matches!(event, DirectorEvent::Began(_));
        out.switch(self.events.iter().any(began));
        self.player.write_state(out);
    }

    /// Goes to where a director of the same graph was.
    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        let now = from.below("skill that is performed", self.graph.skills().len())?;
        let decisions = from.below("decisions in the skill", 1 << 31)?;
        let rate = from.number("rate of the skills")?;
        self.ended = from.switch("whether the end was told")?;
        self.input = DirectorInput::read_state(from)?;
        self.kind.read_state(from, &self.graph)?;
        self.heard = from.switch("whether the parameters were told")?;
        self.events.clear();
        if from.switch("whether the skill was told to have begun")? {
            self.events.push_back(DirectorEvent::Began(now));
        }
        self.player = SkillPlayer::new(self.graph.skills()[now].skill.clone(), rate)
            .ok_or_else(|| StateError::value("rate of the skills", rate, "a rate that fits the skill"))?;
        (self.now, self.decisions, self.rate) = (now, decisions, rate);
        self.player.read_state(from)
    }
}
