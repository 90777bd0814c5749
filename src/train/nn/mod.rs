//! Small dense networks and their optimiser: what the learner spends most of its time in.
//!
//! Products are plain loops over register tiles that the compiler turns into vector instructions; no library, no unsafe
//! code, and the same code in WASM.

mod adam;
mod network;
mod product;
mod tanh;

pub use adam::{Adam, clip_norm};
pub use network::{Activation, Activations, Network};
pub use tanh::tanh;
