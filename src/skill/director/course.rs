//! A course: the first skill of the graph runs, the others clear what is in its way. Nobody says where obstacles are or how high: the heights
//! of the ground ahead do.
//!
//! At every decision of the run the next obstacle is read from the heights ahead, and the step planner finds the skill that clears it and the running
//! speeds up to it (Liu, Yin, van de Panne, Guo 2012, Section 6, equation 15). Where the run's phase is that at which the skill can begin, and the obstacle is as
//! far away as the skill can have it, the skill begins, with the parameters `height`, `distance` and `depth` of what is really there. At its end the run goes on.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::skill::director::{BodyView, Choice, DirectorInput, Single};
use crate::skill::planner::{Clearance, Obstacle, Plan, Refusal, StepLaw, plan};
use crate::skill::{Entry, GraphSkill, SkillGraph, SkillParameters, TrainedSkill};

/// How far ahead the ground is looked at, m, and how finely, m.
const SIGHT: (f64, f64) = (12.0, 0.1);
/// Largest change of speed from one step to the next, m/s.
const CHANGE: f64 = 0.5;
/// Skills that succeed in fewer trials than this are not used, 0 to 1.
const LEAST_CHANCE: f64 = 0.5;
/// An obstacle that nothing clears is stopped at with this deceleration (m/s^2), this far before it (m).
const STOP: (f64, f64) = (1.0, 1.0);

/// What is thought of the obstacle ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseView {
    /// The obstacle.
    pub obstacle: Obstacle,
    /// The skill that will clear it, by its index in the graph, or why none does.
    pub plan: Result<usize, Refusal>,
}

/// Runs, and clears what is ahead.
#[derive(Clone, Debug, Default)]
pub struct Course {
    /// Clearances, and the skill of each by its index in the graph.
    skills: Vec<(usize, Clearance)>,
    /// Length of a step over speed.
    law: Option<StepLaw>,
    /// Heights ahead against the support, m.
    heights: Vec<f64>,
    distances: Vec<f64>,
    /// What the obstacle that is being cleared is like.
    parameters: SkillParameters,
    view: Option<CourseView>,
    /// What was told last: the skill, or that there is none.
    told: Option<Option<usize>>,
}

impl Course {
    /// For a graph whose first skill runs: what its other skills clear.
    pub fn new(graph: &SkillGraph) -> Self {
        let clears = |(k, s): (usize, &GraphSkill)| {
            let definition = &s.skill.definition;
            definition.clears.clone().map(|c| (k, Clearance { skill: definition.name.clone(), ..c }))
        };
        let points: Vec<(f64, f64)> = graph.skills()[0]
            .skill
            .motion
            .levels()
            .iter()
            .filter(|level| level.speed > 0.5)
            // Two steps a cycle.
            .map(|level| (level.speed, 0.5 * level.speed * level.seconds))
            .collect();
        let count = (SIGHT.0 / SIGHT.1) as usize;
        Self {
            skills: graph.skills().iter().enumerate().filter(|(_, s)| !s.is_image()).filter_map(clears).collect(),
            law: StepLaw::fitted(&points),
            distances: (0..count).map(|k| SIGHT.1 * k as f64).collect(),
            heights: vec![0.0; count],
            ..Self::default()
        }
    }

    /// How far ahead it looks, m.
    pub fn sight(&self) -> f64 {
        SIGHT.0
    }
    /// Where it looks, m ahead of the root, and the heights found there against the support, m.
    pub fn profile(&mut self) -> (&[f64], &mut [f64]) {
        (&self.distances, &mut self.heights)
    }
    /// The obstacle ahead, and what is planned for it; `None` while nothing is ahead, or something is being cleared.
    pub fn view(&self) -> Option<&CourseView> {
        self.view.as_ref()
    }
    /// Parameters of the skill that clears something.
    pub fn parameters(&self) -> &SkillParameters {
        &self.parameters
    }
    /// A plan that is new.
    pub(super) fn take_news(&mut self) -> Option<CourseView> {
        let now = self.view.map(|view| view.plan.ok());
        let new = now != self.told;
        self.told = now;
        self.view.filter(|_| new)
    }
    pub(super) fn restart(&mut self) {
        (self.view, self.told) = (None, None);
        self.parameters.clear();
    }

    pub(super) fn next(&mut self, body: &mut BodyView, graph: &SkillGraph, input: &DirectorInput) -> Choice {
        if body.skill != 0 {
            self.view = None;
            let back = graph.entry(body.skill, body.tick, 0);
            let enter = match back {
                Entry::Now { tick } if body.finished => Some((0, tick)),
                _ => None,
            };
            return Choice { enter, speed: None, turn: 0.0 };
        }
        let run = &graph.skills()[0].skill;
        // On the way it goes where it is told; before an obstacle, straight on.
        let mut choice = Single.next(body, graph, input);
        let wished = choice.speed.unwrap_or(run.motion.mean_speed());
        let Some(obstacle) = Obstacle::ahead(&self.distances, &self.heights) else {
            self.view = None;
            return choice;
        };
        let planned = self.plan(body, &obstacle, run);
        self.view = Some(CourseView { obstacle, plan: planned.as_ref().map(|(k, _)| *k).map_err(|e| *e) });
        match planned {
            Ok((skill, plan)) => {
                choice.turn = 0.0;
                choice.speed = Some(plan.approach.speeds.first().copied().unwrap_or(plan.speed_in));
                choice.enter = self.enter(body, graph, skill, &obstacle);
            }
            Err(_) => {
                let way = (obstacle.distance - STOP.1).max(0.0);
                choice.speed = Some(wished.min((2.0 * STOP.0 * way).sqrt()));
            }
        }
        choice
    }

    fn plan(&self, body: &mut BodyView, obstacle: &Obstacle, run: &TrainedSkill) -> Result<(usize, Plan), Refusal> {
        let speeds = run.definition.episode.speed.unwrap_or((run.motion.mean_speed(), run.motion.mean_speed()));
        let law = self.law.unwrap_or(StepLaw::PUBLISHED);
        let velocity = body.velocity();
        let speed = velocity.x.hypot(velocity.z).clamp(speeds.0, speeds.1);
        let known: Vec<Clearance> = self.skills.iter().map(|(_, c)| c.clone()).collect();
        let found = plan(obstacle, speed, &known, &law, speeds, CHANGE, LEAST_CHANCE)?;
        Ok((self.skills[found.skill].0, found))
    }

    /// Where a skill, or its image, can begin now with the obstacle where it is.
    fn enter(
        &mut self,
        body: &BodyView,
        graph: &SkillGraph,
        skill: usize,
        obstacle: &Obstacle,
    ) -> Option<(usize, usize)> {
        let policy = graph.skills()[skill].skill.policy.address();
        let same = |k: &usize| graph.skills()[*k].skill.policy.address() == policy;
        for k in (1..graph.skills().len()).filter(same) {
            let Entry::Now { tick } = graph.entry(0, body.tick, k) else { continue };
            let wanted = &graph.skills()[k].skill;
            // The obstacle from where the motion begins.
            let gone = -wanted.motion.tick(tick).pose.root_position.z;
            let distance = obstacle.distance + gone;
            let range = |name: &str| wanted.definition.parameters.iter().find(|p| p.name == name).map(|p| p.range);
            let clears = wanted.definition.clears.as_ref()?;
            let (near, far) = range("distance").unwrap_or((clears.take_off - 0.05, clears.take_off + 0.05));
            if !(near..=far).contains(&distance) {
                continue;
            }
            self.parameters.clear();
            for (name, value) in [("height", obstacle.height.abs()), ("distance", distance), ("depth", obstacle.depth)]
            {
                if range(name).is_some() {
                    self.parameters.set(name, value);
                }
            }
            return Some((k, tick));
        }
        None
    }

    pub(super) fn write_state(&self, out: &mut StateWriter) {
        self.parameters.write_state(out);
        out.option(self.told, |out, told| out.option(told, StateWriter::count));
        self.heights.iter().for_each(|h| out.number(*h));
    }

    pub(super) fn read_state(&mut self, from: &mut StateReader, graph: &SkillGraph) -> Result<(), StateError> {
        self.parameters = SkillParameters::read_state(from)?;
        let count = graph.skills().len();
        self.told = from.option("plan that was told", |from| {
            from.option("skill that was told", |from| from.below("skill that was told", count))
        })?;
        for height in &mut self.heights {
            *height = from.number("height ahead")?;
        }
        self.view = None;
        Ok(())
    }
}
