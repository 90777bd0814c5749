//! A course: the first skill of the graph runs, the others clear what is in its way. Nobody says where obstacles are or how high: the heights
//! of the ground ahead do.
//!
//! At every decision of the run the next obstacle is read from the heights ahead, and the step planner finds the skill that clears it and the running
//! speeds up to it (Liu, Yin, van de Panne, Guo 2012, Section 6, equation 15). Where the run's phase is that at which the skill can begin, and the obstacle is as
//! far away as the skill can have it, the skill begins, with the parameters `height`, `distance` and `depth` of what is really there. At its end the run goes on.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::skill::director::{BodyView, Choice, CourseView, DirectorInput, Single};
use crate::skill::planner::{Clearance, Obstacle, Plan, Refusal, StepLaw, plan};
use crate::skill::{Entry, SkillGraph, SkillParameters, TrainedSkill};

/// How far ahead the ground is looked at, m, and how finely, m.
const SIGHT: (f64, f64) = (12.0, 0.05);
/// Largest change of speed from one step to the next, m/s.
const CHANGE: f64 = 0.5;
/// Skills that succeed in fewer trials than this are not used, 0 to 1.
const LEAST_CHANCE: f64 = 0.5;
/// An obstacle that nothing clears is stopped at with this deceleration (m/s^2), this far before it (m).
const STOP: (f64, f64) = (0.7, 2.0);

/// Nearer to what it clears it does not turn any more, m.
const STRAIGHT: f64 = 4.0;
/// How far an obstacle may be from where a skill without a parameter `distance` has it, m.
const CLOSE: f64 = 0.05;
/// How far out of its room a skill may still begin where after another step it would be farther out, m.
const REACH: f64 = 0.15;

/// How far out of a range.
fn beside(x: f64, (low, high): (f64, f64)) -> f64 {
    (low - x).max(x - high).max(0.0)
}

/// How far a motion has gone ahead at a tick, m.
fn way_to(skill: &TrainedSkill, tick: usize) -> f64 {
    -skill.motion.tick(tick).pose.root_position.z
}

/// Runs, and clears what is ahead.
#[derive(Clone, Debug, Default)]
pub struct Course {
    /// What can be cleared, and the skill of each by its index in the graph.
    clears: Vec<Clearance>,
    skills: Vec<usize>,
    /// Length of a step over speed.
    law: Option<StepLaw>,
    /// Heights ahead against the support, m.
    heights: Vec<f64>,
    distances: Vec<f64>,
    /// What the obstacle that is being cleared is like.
    parameters: SkillParameters,
    view: Option<CourseView>,
    /// The speed of the present step, m/s.
    speed: Option<f64>,
    /// What was told last: the skill, or that there is none.
    told: Option<Option<usize>>,
}

impl Course {
    /// For a graph whose first skill runs: what its other skills clear.
    pub fn new(graph: &SkillGraph) -> Self {
        let (mut clears, mut skills) = (Vec::new(), Vec::new());
        for (k, s) in graph.skills().iter().enumerate().filter(|(_, s)| !s.is_image()) {
            let Some(c) = s.skill.definition.clears.clone() else { continue };
            // The middle of what the skill can have, and the room on either side; seen from where it is entered.
            let distance = s.skill.definition.parameters.iter().find(|p| p.name == "distance").map(|p| p.range);
            let (near, far) = distance.unwrap_or((c.take_off - CLOSE, c.take_off + CLOSE));
            let enter = graph.transition(0, k).map_or(0, |t| t.enter);
            let take_off = 0.5 * (near + far) - way_to(&s.skill, enter);
            let skill = s.skill.definition.name.clone();
            clears.push(Clearance { skill, take_off, slack: 0.5 * (far - near), ..c });
            skills.push(k);
        }
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
            clears,
            skills,
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
        (self.view, self.told, self.speed) = (None, None, None);
        self.parameters.clear();
    }

    pub(super) fn next(&mut self, body: &mut BodyView, graph: &SkillGraph, input: &DirectorInput) -> Choice {
        if body.skill != 0 {
            self.view = None;
            let back = graph.entry(body.skill, body.tick, 0);
            let enter = match back {
                Entry::Now { tick } => Some((0, tick)),
                _ => None,
            };
            return Choice { enter, speed: None, turn: 0.0 };
        }
        let run = &graph.skills()[0].skill;
        // On the way it goes where it is told; before an obstacle, straight on.
        let wished = input.speed.unwrap_or(run.motion.mean_speed());
        let Some(obstacle) = Obstacle::ahead(&self.distances, &self.heights) else {
            (self.view, self.speed) = (None, None);
            return Single.next(body, graph, input);
        };
        let mut enter = None;
        // Steps are planned where one ends: there a skill can begin, too.
        let ends = (1..graph.skills().len()).any(|k| matches!(graph.entry(0, body.tick, k), Entry::Now { .. }));
        if self.speed.is_none() || self.view.is_none() || ends {
            let before = self.view.and_then(|view| view.plan.ok());
            let planned = match (self.plan(body, &obstacle, run), before) {
                // What was planned for is gone on with, at the speed of its beginning.
                (Err(Refusal::TooNear { wanted, .. }), Some(skill)) => Ok((skill, wanted)),
                (planned, _) => planned,
            };
            self.view = Some(CourseView { obstacle, plan: planned.map(|(skill, _)| skill) });
            self.speed = planned.ok().map(|(_, speed)| speed);
            if let (Ok((skill, _)), true) = (planned, ends) {
                enter = self.enter(body, graph, skill, &obstacle);
            }
        }
        // Before what cannot be cleared it stands still.
        let stops = || (2.0 * STOP.0 * (obstacle.distance - STOP.1).max(0.0)).sqrt();
        let speed = self.speed.unwrap_or_else(|| wished.min(stops()));
        let straight = self.speed.is_some() && obstacle.distance < STRAIGHT;
        let turn = if straight { 0.0 } else { Single.turn(body, graph, input, speed) };
        Choice { enter, speed: Some(speed), turn }
    }

    /// The skill for an obstacle, by its index in the graph, and the speed of the coming step, m/s.
    fn plan(&self, body: &mut BodyView, obstacle: &Obstacle, run: &TrainedSkill) -> Result<(usize, f64), Refusal> {
        let speeds = run.definition.episode.speed.unwrap_or((run.motion.mean_speed(), run.motion.mean_speed()));
        let law = self.law.unwrap_or(StepLaw::PUBLISHED);
        let velocity = body.velocity();
        let speed = velocity.x.hypot(velocity.z).clamp(speeds.0, speeds.1);
        let planned = |change| plan(obstacle, speed, &self.clears, &law, speeds, change, LEAST_CHANCE);
        // What is too near for gentle steps is met as well as can be.
        let found = planned(CHANGE).or_else(|refusal| match refusal {
            Refusal::TooNear { .. } => planned(f64::INFINITY),
            refusal => Err(refusal),
        })?;
        let Plan { skill, speed_in, approach, .. } = found;
        Ok((self.skills[skill], approach.speeds.first().copied().unwrap_or(speed_in)))
    }

    /// Where a skill, or its image, can begin now with the obstacle where it is.
    fn enter(
        &mut self,
        body: &mut BodyView,
        graph: &SkillGraph,
        skill: usize,
        obstacle: &Obstacle,
    ) -> Option<(usize, usize)> {
        let policy = graph.skills()[skill].skill.policy.address();
        let velocity = body.velocity();
        let step = self.law.unwrap_or(StepLaw::PUBLISHED).length(velocity.x.hypot(velocity.z));
        let same = |k: &usize| graph.skills()[*k].skill.policy.address() == policy;
        for k in (1..graph.skills().len()).filter(same) {
            let Entry::Now { tick } = graph.entry(0, body.tick, k) else { continue };
            let wanted = &graph.skills()[k].skill;
            // The obstacle from where the motion begins.
            let distance = obstacle.distance + way_to(wanted, tick);
            let range = |name: &str| wanted.definition.parameters.iter().find(|p| p.name == name).map(|p| p.range);
            let clears = wanted.definition.clears.as_ref()?;
            let (near, far) = range("distance").unwrap_or((clears.take_off - CLOSE, clears.take_off + CLOSE));
            let (now, then) = (beside(distance, (near, far)), beside(distance - step, (near, far)));
            if now > 0.0 && (now > REACH || now >= then) {
                continue;
            }
            let distance = distance.clamp(near, far);
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
        out.option(self.speed, StateWriter::number);
        out.option(self.told, |out, told| out.option(told, StateWriter::count));
        self.heights.iter().for_each(|h| out.number(*h));
    }

    pub(super) fn read_state(&mut self, from: &mut StateReader, graph: &SkillGraph) -> Result<(), StateError> {
        self.parameters = SkillParameters::read_state(from)?;
        let count = graph.skills().len();
        self.speed = from.option("speed of the step", |from| from.number("speed of the step"))?;
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
