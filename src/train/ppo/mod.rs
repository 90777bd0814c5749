//! Learning a policy by reinforcement: proximal policy optimisation over episodes in lanes.
//!
//! After Peng et al. 2018, "DeepMimic", and Yu, Park, Lee 2019, Section 6.2. What happens in an iteration: `rollout.rs` plays
//! (`environment.rs` runs episodes in lanes, `sampling.rs` says where they begin, `experience.rs` holds what was seen), `learner.rs` updates actor and critic,
//! `trainer.rs` repeats (by the numbers of `options.rs`), measures, and keeps the best.

#[cfg(feature = "policy")]
mod card;
mod curve;
mod environment;
mod error;
mod evaluate;
mod experience;
#[cfg(feature = "policy")]
mod export;
mod follow;
mod handover;
mod lane_courses;
mod learner;
mod normalizer;
mod options;
mod quality;
mod rollout;
mod sampling;
mod task;
mod trainer;

#[cfg(feature = "policy")]
pub use card::{CardReport, robustness_card, robustness_card_until};
pub use curve::curve_csv;
pub use environment::{Environment, Episode, EpisodeStatus, Outcome};
pub use error::TrainError;
pub(crate) use evaluate::MeanActor;
pub use evaluate::{Actor, EvaluationReport, evaluate};
#[cfg(feature = "policy")]
pub use export::{course_file, trained_policy};
pub use follow::follow_policy;
pub use handover::HandOver;
pub use normalizer::Normalizer;
pub use options::TrainOptions;
pub use quality::{JointLoad, MotionQuality, motion_quality};
pub(crate) use rollout::Lanes;
pub use sampling::StartSampler;
pub use task::{Predecessor, SkillTask, TaskError};
pub use trainer::{Iteration, Trained, Trainer};
