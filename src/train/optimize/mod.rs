//! Trajectory optimisation: from key poses and their windows to a motion that was simulated.
//!
//! Yu, Park, Lee 2019, "Figure Skating Simulation from Video", Section 6.1, after Al Borno, de Lasa, Hertzmann 2013, "Trajectory
//! Optimization for Full-Body Movements with Complex Contacts": the decision variables are control points of a cubic B-spline,
//! here of offsets to the servo targets that the key poses give; CMA-ES changes them until the simulated motion costs as
//! little as can be found. Two windows are optimised at a time, the first is kept, and the next two begin in the state where
//! it ended.
//!
//! With [`OptimizeOptions::samcon`] the search does not begin at the bare key poses: [`crate::train::reconstruct`] first finds
//! a control that stays on its feet, window by window, and the spline is added to that.
//!
//! | file | what is in it |
//! | --- | --- |
//! | `plan.rs` | key poses to windows in ticks |
//! | `spline.rs` | knots and basis |
//! | `trial.rs` | playing offsets in the lanes of a simulator, measuring the objectives |
//! | `search.rs` | window after window |
//! | `checkpoint.rs` | what is saved between windows |
//!
//! Candidates run in the lanes of 4 x f64, unfused, on all threads; each draws from a random stream of its own. The
//! result depends on the seed alone (and on the time, where a limit is set), and a scalar replay of it has the same bits.

mod checkpoint;
mod plan;
mod search;
mod spline;
mod trial;

pub use checkpoint::Checkpoint;
pub use plan::{Plan, PlannedWindow};
pub use search::{Kept, News, Optimized, optimize};
pub use trial::TrialCosts;

use crate::asset::clip::ClipError;
use crate::control::ControlError;
use crate::model::KeyPoseError;
use crate::train::cma_es::CmaError;
use crate::train::{ReconstructError, ReconstructOptions};

/// How to optimise; what the key pose file says of it is in [`Plan::record`].
#[derive(Clone, Debug)]
pub struct OptimizeOptions {
    /// Generations for each pair of windows, in place of the file's.
    pub iterations: Option<u64>,
    /// Seed in place of the file's.
    pub seed: Option<u64>,
    /// Threads.
    pub threads: usize,
    /// Time after which generations end early, s: each pair of windows gets its share of what is left. The result then
    /// depends on the machine.
    pub seconds: Option<f64>,
    /// How the first control is found; `None` begins at the key poses. Its seed and threads are set from those above.
    pub samcon: Option<ReconstructOptions>,
}

impl Default for OptimizeOptions {
    fn default() -> Self {
        let samcon = ReconstructOptions::default();
        Self { iterations: None, seed: None, threads: samcon.threads, seconds: None, samcon: Some(samcon) }
    }
}

/// Why an optimisation cannot begin or go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OptimizeError {
    /// The key poses cannot be used.
    #[error(transparent)]
    KeyPoses(#[from] KeyPoseError),
    /// The clip of the key poses does not fit the character.
    #[error(transparent)]
    Clip(#[from] ClipError),
    /// The result does not fit the character.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The search refused its input.
    #[error(transparent)]
    Cma(#[from] CmaError),
    /// The first control could not be searched for.
    #[error(transparent)]
    Reconstruct(#[from] ReconstructError),
    /// A value cannot be used.
    #[error("optimize: {place}: {found}; valid is {valid}")]
    Value {
        /// What it is.
        place: String,
        /// What was found.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// A checkpoint could not be read or written, or belongs to something else.
    #[error("{path}: {reason}")]
    Checkpoint {
        /// The file.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// The caller's progress function asked to stop.
    #[error("cancelled")]
    Cancelled,
}

impl OptimizeError {
    fn value(place: &str, found: impl ToString, valid: &str) -> Self {
        Self::Value { place: place.to_owned(), found: found.to_string(), valid: valid.to_owned() }
    }
}
