//! Making motions: methods that search for controls. Feature `train`.

pub mod cma_es;
#[cfg(feature = "policy")]
mod export_onnx;
pub mod nn;
pub mod objectives;
pub mod optimize;
pub mod ppo;
mod samcon;
mod samcon_cost;
mod symmetric_eigen;

#[cfg(feature = "policy")]
pub use export_onnx::{ExportError, policy_bytes, save_policy};
pub use samcon::{
    Progress, ReconstructError, ReconstructOptions, Reconstruction, ReconstructionReport, STIFF_GAINS, Tolerance,
    reconstruct,
};
