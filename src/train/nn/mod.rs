//! Small dense networks on the processor: forward, gradient, Adam.
//!
//! ```
//! use bevy_athlete::math::RandomStream;
//! use bevy_athlete::train::nn::{Activation, Activations, Adam, Network};
//!
//! let mut network = Network::new(&[2, 16, 1], Activation::Tanh, 1.0, &mut RandomStream::new(1, 0));
//! let mut adam = Adam::new(network.parameters().len());
//! let mut scratch = Activations::new();
//! let (input, target) = ([0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0], [0.0, 1.0, 1.0, 0.0]);
//! for _ in 0..300 {
//!     let output = network.forward(&mut scratch, &input, 4);
//!     let d_output: Vec<f32> = output.iter().zip(&target).map(|(y, t)| y - t).collect();
//!     let mut gradient = vec![0.0; network.parameters().len()];
//!     network.backward(&mut scratch, &input, 4, &d_output, &mut gradient);
//!     adam.step(network.parameters_mut(), &gradient, 0.01);
//! }
//! let output = network.forward(&mut scratch, &input, 4);
//! assert!(output.iter().zip(&target).all(|(y, t)| (y - t).abs() < 0.1));
//! ```
//!
//! # Threads
//!
//! Nothing here starts a thread. Cut a minibatch into shards of a fixed number of rows, give each shard its own gradient and each
//! thread and network its own [`Activations`], and add the gradients in the order of the shards: the result then has the same bits for any number of
//! threads. AVX2 and AVX-512 (found at run time) give the same bits too.
//!
//! # Speed
//!
//! One core of a Zen 5 server processor with AVX-512, 256 rows, network 300-128-128-128-51, microseconds and GF/s for the products of
//! one pass. Ours include biases, activations and their slopes, which the others would need further passes for.
//!
//! | products | forward | back through layers | weights | all |
//! | --- | --- | --- | --- | --- |
//! | this module, AVX-512 | 156 | 79 | 169 | 404, 246 GF/s |
//! | this module, AVX2 | 350 | 162 | 346 | 857, 116 GF/s |
//! | the same tiles over `wide` (AVX2, products only) | 321 | 158 | 324 | 803, 124 GF/s |
//! | `gemm` 0.19 with AVX-512 (products only) | 159 | 74 | 163 | 396, 251 GF/s |
//! | `matrixmultiply` 0.3 (products only) | 219 | 101 | 181 | 501, 199 GF/s |
//!
//! `gemm` is as fast, but its interface is unsafe and has no place for the activation. A minibatch of 1,024 rows in four shards (forward, backward,
//! sums, Adam), actor and critic (one output) together: 3.2 ms on one thread, 1.8 ms on two (before rows and weights were laid out once
//! for both networks and all threads in training). Inference of 64 rows: 40 microseconds.
//! `cargo run --release --no-default-features --features train --example learner_speed` measures this module's figures again.

mod activation;
mod adam;
mod bits;
mod init;
mod instructions;
mod network;
mod product;
mod strips;

pub use activation::Activation;
pub use adam::{Adam, clip_norm};
pub use instructions::{INSTRUCTIONS_VARIABLE, InstructionsError, instructions, known_instructions, use_instructions};
pub use network::{Activations, Network, NetworkError};
pub(crate) use network::{Batch, LaidOut};
