//! Small dense networks on the processor: forward, gradient, Adam.
mod activation;
mod activations;
mod adam;
mod bits;
mod init;
mod network;
mod product;
mod strips;

pub use activation::Activation;
pub use activations::Activations;
pub use adam::{Adam, clip_norm};
pub use network::{Network, NetworkError};
