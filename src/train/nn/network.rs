//! A dense network over one flat vector of parameters.

mod activations;

use std::sync::atomic::{AtomicU64, Ordering};

use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::activation::Activation;
use super::bits;
use super::init::orthogonal;
use super::instructions::arch;
use super::product::{Activate, Differentiate, add_column_sums, add_outer_product, product};
use super::strips::Strips;
use crate::asset::dense_layers::DenseLayers;
use crate::math::RandomStream;
use activations::{BackwardWeights, ForwardWeights};

pub use activations::Activations;
pub(crate) use activations::{Batch, LaidOut};

/// Dense layers with an activation between them and none after the last.
///
/// Parameters are one vector: for each layer its weights (outputs x inputs, row-major), then its bias. Batches are rows x columns, row-major.
/// It is serialised exactly (parameters as bit patterns).
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Stored")]
pub struct Network {
    sizes: Vec<usize>,
    activation: Activation,
    #[serde(serialize_with = "bits::serialize")]
    parameters: Vec<f32>,
    /// Names the present parameters: no two different sets share a number, so that `Activations` sees when they have changed.
    #[serde(skip)]
    version: u64,
}

impl PartialEq for Network {
    fn eq(&self, other: &Self) -> bool {
        (&self.sizes, self.activation, &self.parameters) == (&other.sizes, other.activation, &other.parameters)
    }
}

/// What is wrong with a stored network.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// Fewer than two sizes, or a size of zero.
    #[error("network sizes {sizes:?}: at least an input and an output size are needed, all of them positive")]
    Sizes {
        /// The sizes given.
        sizes: Vec<usize>,
    },
    /// The parameters do not fit the sizes.
    #[error("network of sizes {sizes:?} holds {found} parameters, {expected} would be valid")]
    Parameters {
        /// The sizes given.
        sizes: Vec<usize>,
        /// Parameters present.
        found: usize,
        /// Parameters that the sizes ask for.
        expected: usize,
    },
    /// The function between layers is none that can be trained.
    #[error("network: its activation is {found}; valid: Tanh, Elu")]
    Activation {
        /// What it is.
        found: &'static str,
    },
}

/// A network as it is stored.
#[derive(Deserialize)]
struct Stored {
    sizes: Vec<usize>,
    activation: Activation,
    #[serde(deserialize_with = "bits::deserialize")]
    parameters: Vec<f32>,
}

impl TryFrom<&DenseLayers> for Network {
    type Error = NetworkError;

    fn try_from(layers: &DenseLayers) -> Result<Self, NetworkError> {
        use crate::asset::dense_layers::Activation as Layers;
        let activation = match layers.activation {
            Layers::Tanh => Activation::Tanh,
            Layers::Elu => Activation::Elu,
            Layers::Relu => return Err(NetworkError::Activation { found: "Relu" }),
        };
        let parameters = layers.layers.iter().flat_map(|l| l.weights.iter().chain(&l.bias)).copied().collect();
        Stored { sizes: layers.sizes.clone(), activation, parameters }.try_into()
    }
}

impl TryFrom<Stored> for Network {
    type Error = NetworkError;

    fn try_from(stored: Stored) -> Result<Self, NetworkError> {
        let Stored { sizes, activation, parameters } = stored;
        let count = sizes
            .windows(2)
            .try_fold(0usize, |sum, pair| pair[0].checked_add(1)?.checked_mul(pair[1])?.checked_add(sum));
        let expected = match count {
            Some(expected) if sizes.len() >= 2 && !sizes.contains(&0) => expected,
            _ => return Err(NetworkError::Sizes { sizes }),
        };
        if parameters.len() != expected {
            return Err(NetworkError::Parameters { found: parameters.len(), expected, sizes });
        }
        Ok(Self { sizes, activation, parameters, version: new_version() })
    }
}

fn new_version() -> u64 {
    static VERSIONS: AtomicU64 = AtomicU64::new(0);
    VERSIONS.fetch_add(1, Ordering::Relaxed)
}

impl Network {
    /// A network of layers `sizes[0] -> sizes[1] -> ...` with orthogonal weights (Saxe, McClelland, Ganguli 2014) and zero biases:
    /// gain sqrt 2 between layers, `last_gain` at the end (small for a policy that should start near zero).
    ///
    /// # Panics
    /// With fewer than two sizes or a size of zero.
    pub fn new(sizes: &[usize], activation: Activation, last_gain: f32, random: &mut RandomStream) -> Self {
        assert!(sizes.len() >= 2 && !sizes.contains(&0), "network sizes {sizes:?}: two or more, all positive");
        let mut parameters = Vec::new();
        for (layer, pair) in sizes.windows(2).enumerate() {
            let gain = if layer + 2 == sizes.len() { f64::from(last_gain) } else { std::f64::consts::SQRT_2 };
            parameters.extend(orthogonal(pair[1], pair[0], random).into_iter().map(|weight| (gain * weight) as f32));
            parameters.resize(parameters.len() + pair[1], 0.0);
        }
        Self { sizes: sizes.to_vec(), activation, parameters, version: new_version() }
    }

    /// Inputs, the width of each hidden layer, outputs.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// The function between layers.
    pub fn activation(&self) -> Activation {
        self.activation
    }

    /// Columns of an input batch.
    pub fn inputs(&self) -> usize {
        self.sizes[0]
    }

    /// Columns of an output batch.
    pub fn outputs(&self) -> usize {
        self.sizes[self.sizes.len() - 1]
    }

    /// Dense layers: one fewer than sizes.
    pub fn layers(&self) -> usize {
        self.sizes.len() - 1
    }

    /// All parameters: layer by layer, the weights and then the bias.
    pub fn parameters(&self) -> &[f32] {
        &self.parameters
    }

    /// All parameters, to be changed. Each call makes every `Activations` lay the weights out anew.
    pub fn parameters_mut(&mut self) -> &mut [f32] {
        self.version = new_version();
        &mut self.parameters
    }

    /// Moves every parameter by a share of its way to another network's of the same layers.
    pub fn approach(&mut self, other: &Self, share: f32) {
        for (mine, theirs) in self.parameters_mut().iter_mut().zip(&other.parameters) {
            *mine += share * (theirs - *mine);
        }
    }

    /// Weights of a layer: outputs x inputs, row-major (the weights of output o are neighbours).
    pub fn weights(&self, layer: usize) -> &[f32] {
        let (start, middle, _) = self.span(layer);
        &self.parameters[start..middle]
    }

    /// Biases of a layer, one for each of its outputs.
    pub fn bias(&self, layer: usize) -> &[f32] {
        let (_, middle, end) = self.span(layer);
        &self.parameters[middle..end]
    }

    /// Start of a layer's weights, start and end of its bias.
    fn span(&self, layer: usize) -> (usize, usize, usize) {
        let start = self.sizes.windows(2).take(layer).map(|pair| (pair[0] + 1) * pair[1]).sum();
        let middle = start + self.sizes[layer] * self.sizes[layer + 1];
        (start, middle, middle + self.sizes[layer + 1])
    }

    pub(super) fn version(&self) -> u64 {
        self.version
    }

    /// The outputs (rows x outputs) for `rows` rows of `input` (rows x inputs). `scratch` keeps what `backward` needs.
    ///
    /// The result of a row does not depend on the other rows or their number.
    ///
    /// # Panics
    /// If `input` is not rows x inputs.
    pub fn forward<'a>(&self, scratch: &'a mut Activations, input: &[f32], rows: usize) -> &'a [f32] {
        assert_eq!(input.len(), rows * self.inputs(), "{rows} rows of {} inputs", self.inputs());
        let Activations { pass, input: batch, values, output, weights, .. } = scratch;
        batch.0.pack(input, self.inputs());
        weights.forward.update(self);
        arch().dispatch(Forward { network: self, weights: &weights.forward, input: &batch.0, values, output });
        *pass = Some((self.version, rows));
        output
    }

    /// [`Network::forward`] of rows and with weights that were laid out before.
    pub(crate) fn forward_batch<'a>(
        &self,
        weights: &LaidOut,
        scratch: &'a mut Activations,
        batch: &Batch,
    ) -> &'a [f32] {
        assert!(weights.forward.fit(self), "weights of other parameters");
        assert_eq!(batch.0.columns(), self.inputs(), "a batch of {} inputs", self.inputs());
        let Activations { pass, values, output, .. } = scratch;
        arch().dispatch(Forward { network: self, weights: &weights.forward, input: &batch.0, values, output });
        *pass = Some((self.version, batch.0.rows()));
        output
    }

    /// Adds to `gradient` (laid out as the parameters) the derivative of a loss, given its derivative `d_output` (rows x outputs) with
    /// respect to the outputs of the last `forward` with this scratch. `input` and `rows` are that pass's.
    ///
    /// # Panics
    /// If the last pass of `scratch` was not of these parameters and this many rows, or a slice does not fit.
    pub fn backward(
        &self,
        scratch: &mut Activations,
        input: &[f32],
        rows: usize,
        d_output: &[f32],
        gradient: &mut [f32],
    ) {
        assert_eq!(input.len(), rows * self.inputs(), "{rows} rows of {} inputs", self.inputs());
        self.check_backward(scratch, rows, d_output, gradient);
        let Activations { input: batch, values, delta, weights, .. } = scratch;
        weights.backward.update(self);
        let weights = &weights.backward;
        arch().dispatch(Backward { network: self, weights, input: &batch.0, values, delta, d_output, gradient });
    }

    /// [`Network::backward`] after [`Network::forward_batch`] with the same weights and rows.
    pub(crate) fn backward_batch(
        &self,
        weights: &LaidOut,
        scratch: &mut Activations,
        batch: &Batch,
        d_output: &[f32],
        gradient: &mut [f32],
    ) {
        assert!(weights.backward.fit(self), "weights of other parameters");
        self.check_backward(scratch, batch.0.rows(), d_output, gradient);
        let Activations { values, delta, .. } = scratch;
        let weights = &weights.backward;
        arch().dispatch(Backward { network: self, weights, input: &batch.0, values, delta, d_output, gradient });
    }

    fn check_backward(&self, scratch: &Activations, rows: usize, d_output: &[f32], gradient: &[f32]) {
        assert_eq!(
            scratch.pass,
            Some((self.version, rows)),
            "backward needs the forward pass of the same parameters and rows"
        );
        assert_eq!(d_output.len(), rows * self.outputs(), "{rows} rows of {} outputs", self.outputs());
        assert_eq!(gradient.len(), self.parameters.len(), "a gradient for each parameter");
    }
}

/// The forward pass, compiled for each instruction set.
struct Forward<'a> {
    network: &'a Network,
    weights: &'a ForwardWeights,
    input: &'a Strips,
    values: &'a mut Vec<Strips>,
    output: &'a mut Vec<f32>,
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { network, weights, input, values, output } = self;
        let rows = input.rows();
        values.resize_with(network.layers(), Default::default);
        for (layer, (weights, bias)) in weights.layers.iter().enumerate() {
            let activation = (layer + 1 < network.layers()).then_some(network.activation);
            let (done, open) = values.split_at_mut(layer);
            let before = done.last().unwrap_or(input);
            open[0].reshape(rows, network.sizes[layer + 1]);
            product(simd, before, weights, &Activate { bias, activation }, &mut open[0]);
        }
        output.resize(rows * network.outputs(), 0.0);
        values[network.layers() - 1].unpack(output);
    }
}

/// The backward pass, compiled for each instruction set.
struct Backward<'a> {
    network: &'a Network,
    weights: &'a BackwardWeights,
    input: &'a Strips,
    values: &'a [Strips],
    delta: &'a mut [Strips; 2],
    d_output: &'a [f32],
    gradient: &'a mut [f32],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { network, weights, input, values, delta: [delta, before], d_output, gradient } = self;
        delta.pack(d_output, network.outputs());
        for layer in (0..network.layers()).rev() {
            let (start, middle, end) = network.span(layer);
            let values = if layer == 0 { input } else { &values[layer - 1] };
            add_outer_product(simd, delta, values, &mut gradient[start..middle]);
            add_column_sums(simd, delta, &mut gradient[middle..end]);
            if layer > 0 {
                before.reshape(values.rows(), network.sizes[layer]);
                let finish = Differentiate { values, activation: network.activation };
                product(simd, delta, &weights.layers[layer], &finish, before);
                std::mem::swap(delta, before);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outputs and the gradient of a fixed case, computed by one instruction set.
    fn computed_by<S: Simd>(simd: S) -> (Vec<u32>, Vec<u32>) {
        let mut random = RandomStream::new(5, 0);
        let mut network = Network::new(&[70, 40, 33, 3], Activation::Tanh, 1.0, &mut random);
        network.parameters_mut().iter_mut().for_each(|p| *p += 0.1 * random.normal() as f32);
        let rows = 21;
        let mut numbers = |count: usize| -> Vec<f32> { (0..count).map(|_| random.normal() as f32).collect() };
        let (input, d_output) = (numbers(rows * 70), numbers(rows * 3));
        let (mut weights, mut batch) = (LaidOut::default(), Batch::default());
        weights.update(&network);
        batch.gather(input.chunks_exact(70), 70);
        let (mut values, mut output, mut delta) = (Vec::new(), Vec::new(), Default::default());
        let mut gradient = vec![0.0; network.parameters().len()];
        let forward = Forward {
            network: &network,
            weights: &weights.forward,
            input: &batch.0,
            values: &mut values,
            output: &mut output,
        };
        Simd::vectorize(simd, forward);
        let backward = Backward {
            network: &network,
            weights: &weights.backward,
            input: &batch.0,
            values: &values,
            delta: &mut delta,
            d_output: &d_output,
            gradient: &mut gradient,
        };
        Simd::vectorize(simd, backward);
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect();
        (bits(&output), bits(&gradient))
    }

    #[test]
    fn a_batch_laid_out_before_gives_the_same_bits() {
        let mut random = RandomStream::new(6, 0);
        let network = Network::new(&[70, 40, 3], Activation::Tanh, 1.0, &mut random);
        let input: Vec<f32> = (0..21 * 70).map(|_| random.normal() as f32).collect();
        let d_output: Vec<f32> = (0..21 * 3).map(|_| random.normal() as f32).collect();
        let (mut one, mut other) = (Activations::new(), Activations::new());
        let mut gradients = [(); 2].map(|()| vec![0.0; network.parameters().len()]);
        let expected = network.forward(&mut one, &input, 21).to_vec();
        network.backward(&mut one, &input, 21, &d_output, &mut gradients[0]);
        let (mut weights, mut batch) = (LaidOut::default(), Batch::default());
        weights.update(&network);
        batch.gather(input.chunks_exact(70), 70);
        assert_eq!(network.forward_batch(&weights, &mut other, &batch), expected);
        network.backward_batch(&weights, &mut other, &batch, &d_output, &mut gradients[1]);
        assert_eq!(gradients[0], gradients[1]);
    }

    /// Checkpoints go from machine to machine: a processor with other vectors has to continue with the same bits.
    #[test]
    fn every_instruction_set_computes_the_same_bits() {
        let expected = computed_by(pulp::Scalar256b);
        assert_eq!(computed_by(pulp::Scalar128b), expected);
        #[cfg(target_arch = "x86_64")]
        {
            if let Some(avx2) = pulp::x86::V3::try_new() {
                assert_eq!(computed_by(avx2), expected, "AVX2");
            }
            if let Some(avx512) = pulp::x86::V4::try_new() {
                assert_eq!(computed_by(avx512), expected, "AVX-512");
            }
        }
    }
}
