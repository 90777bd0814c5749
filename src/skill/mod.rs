//! Skills: what a trained athlete can do, described in a file; and the tests that say whether it was done.

mod definition;

pub use definition::{
    EpisodeOptions, PushOptions, Range, RewardScales, SkillDefinition, SkillError, TerminationLimits,
};
