//! Why training cannot begin or go on.

use crate::train::ppo::task::TaskError;

/// Why training could not begin or go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainError {
    /// The skill's trials cannot be made.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// An option cannot be used.
    #[error("train: {option} is {found}; {valid}")]
    Option {
        /// The option.
        option: &'static str,
        /// What it was.
        found: String,
        /// What would be valid.
        valid: &'static str,
    },
    /// A policy to begin with does not fit this task.
    #[error("policy to begin with: {what} is {found}; valid: {expected}")]
    Start {
        /// What differs: a field of its contract, or its network.
        what: String,
        /// In the policy.
        found: String,
        /// In the task.
        expected: String,
    },
    /// A checkpoint is of a version that is not read.
    #[error("checkpoint: its version is {found}; valid: 1 to {newest}")]
    CheckpointVersion {
        /// Its version.
        found: u32,
        /// The newest that is read.
        newest: u32,
    },
    /// A checkpoint does not belong to this task.
    #[error("checkpoint: {what} is {found}; the task has {expected}")]
    Checkpoint {
        /// What differs.
        what: &'static str,
        /// In the checkpoint.
        found: String,
        /// In the task.
        expected: String,
    },
}
