//! Skills: what a trained athlete can do, described in a file; and the tests that say whether it was done.

/// The skating skills that ship, by name; the first is where a steered skater begins.
pub const SKATING_SKILLS: [&str; 6] = [
    "stroking",
    "forward_crossover",
    "backward_crossover",
    "forward_three_turn",
    "backward_three_turn",
    "double_salchow",
];

mod contract;
mod criteria;
mod definition;
#[cfg(feature = "policy")]
pub mod director;
pub(crate) mod disturb;
#[cfg(feature = "policy")]
mod graph;
#[cfg(feature = "policy")]
mod parameters;
mod performance;
pub mod planner;
mod prepare;
#[cfg(feature = "policy")]
mod program;
#[cfg(feature = "policy")]
mod trained;
mod transition;

pub use criteria::{
    Criterion, Flight, LIFT, SETTLE, SHORTEST_FLIGHT, Shortfall, Way, crossings, flights, strokes, yaw_over,
};
pub use definition::{
    EpisodeOptions, PELVIS, PushOptions, Range, RewardScales, SkillDefinition, SkillError, SkillParameter, SkillWarp,
    SteerOptions, TerminationLimits, TouchOptions, TrialOptions, TrialRow, WarpDirection,
};
#[cfg(feature = "policy")]
pub use director::{CourseView, Director, DirectorEvent, DirectorInput};
pub use disturb::Disturbance;
#[cfg(feature = "policy")]
pub use graph::{Entry, GraphError, GraphSkill, NoEntry, SkillGraph};
#[cfg(feature = "policy")]
pub use parameters::{BadParameter, SkillParameters};
pub use performance::{FootSample, PerformanceRecorder, PerformanceSample, blade_pair};
pub use prepare::{fitting_rate, forbidden_points};
#[cfg(feature = "policy")]
pub use program::{ProgramDefinition, ProgramElement, ProgramError};
#[cfg(feature = "engine")]
pub(crate) use trained::Rhythm;
#[cfg(feature = "policy")]
pub use trained::{SkillPlayer, TrainedSkill, TrainedSkillError};
pub use transition::{ENTRY, Transition, best_transition, tick_distance};
