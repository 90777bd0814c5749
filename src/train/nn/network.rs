//! A dense network over one flat vector of parameters.

use std::sync::atomic::{AtomicU64, Ordering};

use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::activation::Activation;
use super::activations::Activations;
use super::bits;
use super::init::orthogonal;
use super::product::{Activate, Differentiate, add_column_sums, add_outer_product, product};
use crate::asset::dense_layers::DenseLayers;
use crate::math::RandomStream;

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
        Arch::new().dispatch(Forward { network: self, scratch: &mut *scratch, input, rows });
        &scratch.output
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
        assert_eq!(
            scratch.pass,
            Some((self.version, rows)),
            "backward needs the forward pass of the same parameters and rows"
        );
        assert_eq!(input.len(), rows * self.inputs(), "{rows} rows of {} inputs", self.inputs());
        assert_eq!(d_output.len(), rows * self.outputs(), "{rows} rows of {} outputs", self.outputs());
        assert_eq!(gradient.len(), self.parameters.len(), "a gradient for each parameter");
        Arch::new().dispatch(Backward { network: self, scratch, d_output, gradient });
    }
}

/// The forward pass, compiled for each instruction set.
struct Forward<'a> {
    network: &'a Network,
    scratch: &'a mut Activations,
    input: &'a [f32],
    rows: usize,
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { network, scratch, input, rows } = self;
        scratch.forward.update(network);
        scratch.values.resize_with(network.sizes.len(), Default::default);
        scratch.values[0].pack(input, network.inputs());
        for (layer, (weights, bias)) in scratch.forward.layers.iter().enumerate() {
            let activation = (layer + 1 < network.layers()).then_some(network.activation);
            let (done, open) = scratch.values.split_at_mut(layer + 1);
            open[0].reshape(rows, network.sizes[layer + 1]);
            product(simd, &done[layer], weights, &Activate { bias, activation }, &mut open[0]);
        }
        scratch.output.resize(rows * network.outputs(), 0.0);
        scratch.values[network.layers()].unpack(&mut scratch.output);
        scratch.pass = Some((network.version, rows));
    }
}

/// The backward pass, compiled for each instruction set.
struct Backward<'a> {
    network: &'a Network,
    scratch: &'a mut Activations,
    d_output: &'a [f32],
    gradient: &'a mut [f32],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { network, scratch, d_output, gradient } = self;
        scratch.backward.update(network);
        let [delta, before] = &mut scratch.delta;
        delta.pack(d_output, network.outputs());
        for layer in (0..network.layers()).rev() {
            let (start, middle, end) = network.span(layer);
            let values = &scratch.values[layer];
            add_outer_product(simd, delta, values, &mut gradient[start..middle]);
            add_column_sums(simd, delta, &mut gradient[middle..end]);
            if layer > 0 {
                before.reshape(values.rows(), network.sizes[layer]);
                let finish = Differentiate { values, activation: network.activation };
                product(simd, delta, &scratch.backward.layers[layer], &finish, before);
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
        let mut scratch = Activations::new();
        let mut gradient = vec![0.0; network.parameters().len()];
        Simd::vectorize(simd, Forward { network: &network, scratch: &mut scratch, input: &input, rows });
        let pass = Backward { network: &network, scratch: &mut scratch, d_output: &d_output, gradient: &mut gradient };
        Simd::vectorize(simd, pass);
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect();
        (bits(&scratch.output), bits(&gradient))
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
