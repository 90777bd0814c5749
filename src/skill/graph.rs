//! The skill graph: skills, and where each can be left for another. It is checked when it is made; whoever chooses what plays
//! only asks it.

use crate::control::tracking::Heading;
use crate::model::CharacterModel;
use crate::skill::transition::{Transition, best_transition};
use crate::skill::{SkillPlayer, TrainedSkill, Way};
use glam::DVec3;
use std::sync::Arc;

/// A way that turns faster than this is a curve, rad/s.
const CURVE: f64 = 0.1;

/// Why skills make no graph.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphError {
    /// There is none.
    #[error("a skill graph without skills; valid: at least one")]
    Empty,
    /// Two skills have one name.
    #[error("two skills are called {skill}; valid: a name for each")]
    Twice {
        /// The name.
        skill: String,
    },
    /// A transition leads from or to a skill that is not there.
    #[error("there is no skill {skill}; valid: {}", known.join(", "))]
    Unknown {
        /// The name.
        skill: String,
        /// The skills that are there.
        known: Vec<String>,
    },
    /// Skills of bodies that differ in their joints.
    #[error(
        "{skill} is a skill of a body with {found} joints, {first} of one with {wanted}; valid: skills of one body"
    )]
    Bodies {
        /// The skill.
        skill: String,
        /// Its joints.
        found: usize,
        /// The first skill.
        first: String,
        /// The joints of the first.
        wanted: usize,
    },
    /// The simulation's steps are not those of a skill's decisions.
    #[error("{rate} steps per second do not fit the {decisions} decisions per second of {skill}; valid: a multiple of {}", decisions * crate::control::tracking::TARGET_SUBSTEPS as f64)]
    Rate {
        /// The skill.
        skill: String,
        /// Steps per second of the simulation.
        rate: f64,
        /// Decisions per second of the skill.
        decisions: f64,
    },
}

/// Where a skill can begin.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// At this decision.
    Now {
        /// Tick of its motion at which it is entered.
        tick: usize,
    },
    /// Later: once the present skill is where it can be left, and those that lead there have been passed.
    After {
        /// Time until then, s.
        seconds: f64,
    },
    /// Not at all.
    Never(NoEntry),
}

/// Why a skill does not begin.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "engine", derive(bevy::reflect::Reflect))]
#[non_exhaustive]
pub enum NoEntry {
    /// The graph has no such skill.
    #[error("there is no such skill; valid: {}", known.join(", "))]
    Unknown {
        /// The skills that there are.
        known: Vec<String>,
    },
    /// It plays already, and repeats.
    #[error("it plays already")]
    Playing,
    /// No transition leads from the present skill to it.
    #[error("no transition leads there from {from}")]
    NoTransition {
        /// The present skill.
        from: String,
    },
    /// What chooses the skills takes no requests.
    #[error("what plays takes no requests; valid: an athlete that is steered")]
    NotSteered,
    /// Another one was asked for before it began.
    #[error("{by} was asked for instead")]
    Replaced {
        /// The other one.
        by: String,
    },
    /// The athlete is not simulated: its files are on their way, or it was stopped.
    #[error("the athlete is not simulated")]
    NotSimulated,
    /// The athlete was put back to its start, or given something else to do, before it began.
    #[error("the athlete began anew")]
    Restarted,
}

/// A skill, and what the graph knows of its motion.
#[derive(Clone, Debug)]
pub struct GraphSkill {
    /// The skill.
    pub skill: Arc<TrainedSkill>,
    /// Which way the pelvis faces while travelling.
    pub way: Way,
    /// How fast its way turns, rad/s, positive to the left; zero for a motion that ends.
    pub curve: f64,
}

impl GraphSkill {
    fn of(skill: Arc<TrainedSkill>) -> Self {
        let motion = &skill.motion;
        let along: f64 = (0..=motion.last())
            .map(|k| {
                let t = motion.tick(k);
                (t.pose.root_rotation * DVec3::NEG_Z).dot(t.travel)
            })
            .sum();
        let turned = motion.cycle().map_or(0.0, |c| Heading::<f64> { c: c.turn.0, s: c.turn.1 }.angle());
        let curve = turned / motion.duration().max(1e-3);
        Self { way: if along >= 0.0 { Way::Forward } else { Way::Backward }, curve, skill }
    }

    fn image(&self, model: &CharacterModel) -> Self {
        Self { skill: Arc::new(self.skill.mirrored(model)), way: self.way, curve: -self.curve }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        self.skill.name()
    }
    /// Whether its motion repeats.
    pub fn repeats(&self) -> bool {
        self.skill.motion.cycle().is_some()
    }
    /// Whether it is performed to the other side than it was learnt.
    pub fn is_image(&self) -> bool {
        self.skill.mirror.is_some()
    }
    /// Whether its way is a curve.
    pub fn is_curve(&self) -> bool {
        self.curve.abs() > CURVE
    }
}

/// Skills, and the transitions between them.
#[derive(Clone, Debug)]
pub struct SkillGraph {
    skills: Vec<GraphSkill>,
    /// From skill a to skill b, at `a * skills + b`.
    transitions: Vec<Option<Transition>>,
}

impl SkillGraph {
    /// Skills that may follow each other as `links` says: pairs of names, from and to.
    pub fn new(skills: Vec<Arc<TrainedSkill>>, links: &[(&str, &str)]) -> Result<Self, GraphError> {
        let mut graph = Self::check(skills.into_iter().map(GraphSkill::of).collect())?;
        for (from, to) in links {
            let place = |name: &str| {
                let unknown = || GraphError::Unknown { skill: name.to_owned(), known: graph.names() };
                graph.index(name).ok_or_else(unknown)
            };
            let (from, to) = (place(from)?, place(to)?);
            graph.link(from, to);
        }
        Ok(graph)
    }

    /// Skills of which each may follow each.
    pub fn complete(skills: Vec<Arc<TrainedSkill>>) -> Result<Self, GraphError> {
        Self::check(skills.into_iter().map(GraphSkill::of).collect()).map(Self::linked)
    }

    /// [`SkillGraph::complete`], and where a curve is known to one side only, the images of what repeats, so that an athlete
    /// can be steered to both.
    pub fn both_sides(skills: Vec<Arc<TrainedSkill>>, model: &CharacterModel) -> Result<Self, GraphError> {
        let mut known: Vec<GraphSkill> = skills.into_iter().map(GraphSkill::of).collect();
        // What repeats on a curve can be performed on the other hand too, unless that is among the skills itself; the
        // straight skills too, so that a transition between images is the image of one that was learnt.
        let curves = |k: &GraphSkill| k.repeats() && k.is_curve();
        let one_handed = |k: &GraphSkill| {
            !known.iter().any(|other| curves(other) && other.way == k.way && other.curve.signum() != k.curve.signum())
        };
        if known.iter().any(|k| curves(k) && one_handed(k)) {
            let missing = |k: &&GraphSkill| k.repeats() && (!curves(k) || one_handed(k));
            let images: Vec<GraphSkill> = known.iter().filter(missing).map(|k| k.image(model)).collect();
            known.extend(images);
        }
        Self::check(known).map(Self::linked)
    }

    /// A skill that repeats, and others between its cycles, each to either side: links lead from the first to the others and back.
    pub fn around(skills: Vec<Arc<TrainedSkill>>, model: &CharacterModel) -> Result<Self, GraphError> {
        let known: Vec<GraphSkill> = skills.into_iter().map(GraphSkill::of).collect();
        let images: Vec<GraphSkill> = known.iter().skip(1).filter(|k| !k.is_image()).map(|k| k.image(model)).collect();
        let mut graph = Self::check(known.into_iter().chain(images).collect())?;
        for k in 1..graph.skills.len() {
            graph.link(0, k);
            graph.link(k, 0);
        }
        Ok(graph)
    }

    fn check(skills: Vec<GraphSkill>) -> Result<Self, GraphError> {
        let first = skills.first().ok_or(GraphError::Empty)?;
        let joints = |s: &GraphSkill| s.skill.motion.tick(0).pose.joints.len().saturating_sub(1);
        for (k, skill) in skills.iter().enumerate() {
            if skills[..k].iter().any(|other| other.name() == skill.name()) {
                return Err(GraphError::Twice { skill: skill.name().to_owned() });
            }
            let (found, wanted) = (joints(skill), joints(first));
            if found != wanted {
                let (skill, first) = (skill.name().to_owned(), first.name().to_owned());
                return Err(GraphError::Bodies { skill, found, first, wanted });
            }
        }
        let transitions = vec![None; skills.len() * skills.len()];
        Ok(Self { skills, transitions })
    }

    fn link(&mut self, from: usize, to: usize) {
        let (a, b) = (&self.skills[from].skill, &self.skills[to].skill);
        let at = from * self.skills.len() + to;
        if self.transitions[at].is_none() {
            self.transitions[at] = Some(best_transition(&a.motion, a.exit_tick(), &b.motion, b.entry_ticks()));
        }
    }

    fn linked(mut self) -> Self {
        for from in 0..self.skills.len() {
            (0..self.skills.len()).for_each(|to| self.link(from, to));
        }
        self
    }

    /// Whether every skill can be played at `rate` steps per second.
    pub fn check_rate(&self, rate: f64) -> Result<(), GraphError> {
        match self.skills.iter().find(|k| SkillPlayer::new(k.skill.clone(), rate).is_none()) {
            None => Ok(()),
            Some(k) => {
                let decisions = k.skill.definition.control_rate;
                Err(GraphError::Rate { skill: k.name().to_owned(), rate, decisions })
            }
        }
    }

    /// The skills, by index.
    pub fn skills(&self) -> &[GraphSkill] {
        &self.skills
    }
    /// Names of the skills, by index.
    pub fn names(&self) -> Vec<String> {
        self.skills.iter().map(|k| k.name().to_owned()).collect()
    }
    /// The skill of this name.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.skills.iter().position(|k| k.name() == name)
    }
    /// The transition from one skill to another; `None` where there is none.
    pub fn transition(&self, from: usize, to: usize) -> Option<&Transition> {
        self.transitions[from * self.skills.len() + to].as_ref()
    }

    /// When skill `to` can begin after skill `from`, which is at tick `tick` of its motion.
    pub fn entry(&self, from: usize, tick: usize, to: usize) -> Entry {
        let Some(transition) = self.transition(from, to) else {
            return Entry::Never(NoEntry::NoTransition { from: self.skills[from].name().to_owned() });
        };
        let skill = &self.skills[from].skill;
        let last = skill.motion.last().max(1);
        let ticks = match skill.motion.cycle() {
            Some(_) => (transition.leave + last - tick % last) % last,
            None => transition.leave.saturating_sub(tick),
        };
        // The phase of a gait goes by more than a tick in a decision: it may have gone past since the last one.
        let passed = (last - ticks) % last;
        match ticks {
            0 => Entry::Now { tick: transition.enter },
            _ if skill.motion.cycle().is_some() && passed < skill.motion.most_ticks() => {
                Entry::Now { tick: transition.enter }
            }
            _ => Entry::After { seconds: ticks as f64 * skill.motion.tick_seconds() },
        }
    }
}
