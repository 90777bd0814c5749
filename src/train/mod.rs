//! Making motions: methods that search for controls. Feature `train`.

pub mod nn;
pub mod ppo;
mod samcon;
mod samcon_cost;

pub use samcon::{
    Progress, ReconstructError, ReconstructOptions, Reconstruction, ReconstructionReport, STIFF_GAINS, Tolerance,
    reconstruct,
};
