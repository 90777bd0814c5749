//! Making motions: methods that search for controls. Feature `train`.

/// Threads where nothing else is asked: one for each core.
pub fn default_threads() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}

mod affine;
pub mod cma_es;
#[cfg(feature = "policy")]
mod export_onnx;
#[cfg(feature = "policy")]
mod import_onnx;
pub mod nn;
pub mod objectives;
pub mod optimize;
pub mod ppo;
mod samcon;
mod samcon_cost;
mod samcon_options;

pub use affine::{AffineError, AffineOptions, AffineSearch, Generation};
#[cfg(feature = "policy")]
pub use export_onnx::{ExportError, policy_bytes, save_policy};
#[cfg(feature = "policy")]
pub use import_onnx::{ImportError, layers_from_bytes, load_layers};
pub use samcon::{Progress, Reconstruction, ReconstructionReport, reconstruct};
pub use samcon_options::{ReconstructError, ReconstructOptions, STIFF_GAINS, Tolerance};
