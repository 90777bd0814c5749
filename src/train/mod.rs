//! Making motions: methods that search for controls. Feature `train`.

pub mod cma_es;
pub mod objectives;
pub mod optimize;
mod samcon;
mod samcon_cost;
mod symmetric_eigen;

pub use samcon::{
    Progress, ReconstructError, ReconstructOptions, Reconstruction, ReconstructionReport, STIFF_GAINS, Tolerance,
    reconstruct,
};
