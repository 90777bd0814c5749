//! Why a row cannot be measured.

use crate::asset::CourseError;
use crate::cli::SkillInputError;
use crate::control::PolicyError;
use crate::control::balance::BalanceError;
use crate::skill::GraphError;

/// Why a row cannot be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FeetError {
    /// The body cannot be balanced.
    #[error(transparent)]
    Balance(#[from] BalanceError),
    /// The walk cannot be loaded.
    #[error(transparent)]
    Skill(#[from] SkillInputError),
    /// The walk does not fit the body's rate.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// The ground cannot be built.
    #[error(transparent)]
    Course(#[from] CourseError),
    /// The policy gave no numbers.
    #[error(transparent)]
    Policy(#[from] PolicyError),
}
