//! The ways to choose what plays.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::skill::director::{BodyView, Choice, Course, CourseView, DirectorInput, Program, Single, Steering};
use crate::skill::{Entry, NoEntry, SkillGraph, SkillParameters};

/// A way to choose what plays, with what it remembers.
#[derive(Clone, Debug)]
pub enum DirectorKind {
    /// One skill.
    Single(Single),
    /// One skill after the other.
    Program(Program),
    /// Skills by a wished direction and speed, and on request.
    Steering(Steering),
    /// A run, and what clears the obstacles on its way.
    Course(Course),
}

impl DirectorKind {
    /// What plays from this decision on: `next(body, graph) -> skill, entry, speed, turn`.
    pub fn next(&mut self, body: &mut BodyView, graph: &SkillGraph, input: &DirectorInput) -> Choice {
        match self {
            Self::Single(single) => single.next(body, graph, input),
            Self::Program(program) => program.next(body, graph),
            Self::Steering(steering) => steering.next(body, graph, input),
            Self::Course(course) => course.next(body, graph, input),
        }
    }

    /// The skill it begins with and the speed it begins with, m/s; `None` is that of its motion.
    pub(super) fn start(&self, input: &DirectorInput) -> (usize, Option<f64>) {
        match self {
            Self::Single(_) | Self::Course(_) => (0, input.speed),
            Self::Program(program) => program.start(),
            Self::Steering(_) => (0, None),
        }
    }

    /// Back to the start; a request that was open.
    pub(super) fn restart(&mut self) -> Option<usize> {
        match self {
            Self::Single(_) => None,
            Self::Program(program) => {
                program.restart();
                None
            }
            Self::Steering(steering) => steering.restart(),
            Self::Course(course) => {
                course.restart();
                None
            }
        }
    }

    /// The request that is open, by its index in the graph.
    pub fn request(&self) -> Option<usize> {
        match self {
            Self::Steering(steering) => steering.request(),
            Self::Single(_) | Self::Program(_) | Self::Course(_) => None,
        }
    }

    /// Forgets the request that is open, and says which it was.
    pub(super) fn drop_request(&mut self) -> Option<usize> {
        match self {
            Self::Steering(steering) => steering.drop_request(),
            Self::Single(_) | Self::Program(_) | Self::Course(_) => None,
        }
    }

    /// When a skill would begin, were it asked for.
    pub fn entry(&self, skill: usize, body: &BodyView, graph: &SkillGraph) -> Entry {
        match self {
            Self::Single(_) | Self::Program(_) | Self::Course(_) => Entry::Never(NoEntry::NotSteered),
            Self::Steering(steering) => steering.entry(skill, body, graph),
        }
    }

    /// Asks for a skill; when it begins.
    pub(super) fn ask(&mut self, skill: usize, body: &BodyView, graph: &SkillGraph) -> Entry {
        match self {
            Self::Single(_) | Self::Program(_) | Self::Course(_) => Entry::Never(NoEntry::NotSteered),
            Self::Steering(steering) => steering.ask(skill, body, graph),
        }
    }

    /// Whether all has been played; `ended` says whether the present skill, one that ends, has.
    pub(super) fn is_finished(&self, ended: bool) -> bool {
        match self {
            Self::Single(_) => ended,
            Self::Program(program) => program.is_finished(),
            Self::Steering(_) | Self::Course(_) => false,
        }
    }

    /// The parameters that it has chosen itself; `None` where those that are wished for count.
    pub(super) fn parameters(&self) -> Option<&SkillParameters> {
        match self {
            Self::Course(course) => Some(course.parameters()),
            Self::Single(_) | Self::Program(_) | Self::Steering(_) => None,
        }
    }

    /// Where it wants to know the ground, m ahead of the root, and the heights to be filled in, m against the support.
    pub(super) fn profile(&mut self) -> Option<(&[f64], &mut [f64])> {
        match self {
            Self::Course(course) => Some(course.profile()),
            Self::Single(_) | Self::Program(_) | Self::Steering(_) => None,
        }
    }

    /// How far ahead it looks at the ground, m.
    pub(super) fn sight(&self) -> f64 {
        match self {
            Self::Course(course) => course.sight(),
            Self::Single(_) | Self::Program(_) | Self::Steering(_) => 0.0,
        }
    }

    /// What it plans for an obstacle, where that is new.
    pub(super) fn take_plan(&mut self) -> Option<CourseView> {
        match self {
            Self::Course(course) => course.take_news(),
            Self::Single(_) | Self::Program(_) | Self::Steering(_) => None,
        }
    }

    /// What it is, for people.
    pub(super) fn describe(&self, graph: &SkillGraph) -> String {
        match self {
            Self::Single(_) => format!("the skill {}", graph.skills()[0].name()),
            Self::Program(program) => format!("a program of {} elements", program.elements().len()),
            Self::Steering(_) => format!("steering among {} skills", graph.skills().len()),
            Self::Course(_) => format!("a course with {} skills", graph.skills().len()),
        }
    }

    /// What it is, in numbers; not what it remembers.
    pub(super) fn write_identity(&self, out: &mut StateWriter) {
        match self {
            Self::Single(_) => out.byte(0),
            Self::Program(program) => {
                out.byte(1);
                for (element, skill) in program.elements().iter().zip(program.skills()) {
                    out.count(*skill);
                    out.number(element.seconds);
                    out.option(element.speed, StateWriter::number);
                    out.number(element.steering);
                }
            }
            Self::Steering(_) => out.byte(2),
            Self::Course(_) => out.byte(3),
        }
    }

    /// What it remembers.
    pub(super) fn write_state(&self, out: &mut StateWriter) {
        match self {
            Self::Single(_) => {}
            Self::Program(program) => program.write_state(out),
            Self::Steering(steering) => steering.write_state(out),
            Self::Course(course) => course.write_state(out),
        }
    }

    /// Goes to where one like it was.
    pub(super) fn read_state(&mut self, from: &mut StateReader, graph: &SkillGraph) -> Result<(), StateError> {
        match self {
            Self::Single(_) => Ok(()),
            Self::Program(program) => program.read_state(from),
            Self::Steering(steering) => steering.read_state(from, graph),
            Self::Course(course) => course.read_state(from, graph),
        }
    }
}
