//! The scratch of one thread: what a forward pass leaves for the backward pass, and weights laid out for the products.

use super::Network;
use crate::train::nn::strips::{Strip, Strips, WIDTH};

/// Rows of inputs as the products read them: more than one network may be given the same.
#[derive(Clone, Default)]
pub(crate) struct Batch(pub(super) Strips);

impl Batch {
    /// Lays out rows of `columns` values each.
    pub fn gather<'a>(&mut self, rows: impl ExactSizeIterator<Item = &'a [f32]>, columns: usize) {
        self.0.gather(rows, columns);
    }
}

/// A network's weights as the products read them: more than one thread may use the same.
#[derive(Clone, Default)]
pub(crate) struct LaidOut {
    pub(super) forward: ForwardWeights,
    pub(super) backward: BackwardWeights,
}

impl LaidOut {
    /// Lays the network's weights out, unless they are here already.
    pub fn update(&mut self, network: &Network) {
        self.forward.update(network);
        self.backward.update(network);
    }
}

/// Scratch of forward and backward passes; it grows to the largest batch seen and allocates nothing after that.
///
/// One for each thread and network: it keeps that network's weights in the layout of the products until they change, and switching
/// networks lays them out anew (20 microseconds for 80,000 parameters).
#[derive(Clone, Default)]
pub struct Activations {
    /// The version and batch that `values` belong to, once a forward pass has run.
    pub(super) pass: Option<(u64, usize)>,
    /// The input; a batch that was laid out before is not copied here.
    pub(super) input: Batch,
    /// The output of each layer.
    pub(super) values: Vec<Strips>,
    /// The output, row-major.
    pub(super) output: Vec<f32>,
    /// Derivative of the loss with respect to the sums of the layer at hand, and of the layer before it.
    pub(super) delta: [Strips; 2],
    pub(super) weights: LaidOut,
}

/// Weights as the forward product reads them: inputs x outputs, and the biases as strips.
#[derive(Clone, Default)]
pub(super) struct ForwardWeights {
    version: Option<u64>,
    pub layers: Vec<(Strips, Vec<Strip>)>,
}

/// Weights as the backward product reads them: outputs x inputs.
#[derive(Clone, Default)]
pub(super) struct BackwardWeights {
    version: Option<u64>,
    pub layers: Vec<Strips>,
}

impl Activations {
    /// Empty scratch.
    pub fn new() -> Self {
        Self::default()
    }
}

impl ForwardWeights {
    /// Whether these are the network's weights.
    pub fn fit(&self, network: &Network) -> bool {
        self.version == Some(network.version())
    }

    /// Lays the network's weights out, unless they are here already.
    pub fn update(&mut self, network: &Network) {
        if self.fit(network) {
            return;
        }
        self.layers.resize_with(network.layers(), Default::default);
        for (layer, (weights, bias)) in self.layers.iter_mut().enumerate() {
            weights.pack_transposed(network.weights(layer), network.sizes()[layer]);
            bias.clear();
            bias.extend(network.bias(layer).chunks(WIDTH).map(|values| {
                let mut strip = Strip::ZERO;
                strip.0[..values.len()].copy_from_slice(values);
                strip
            }));
        }
        self.version = Some(network.version());
    }
}

impl BackwardWeights {
    /// Whether these are the network's weights.
    pub fn fit(&self, network: &Network) -> bool {
        self.version == Some(network.version())
    }

    /// Lays the weights out that derivatives pass through: all but the first layer's.
    pub fn update(&mut self, network: &Network) {
        if self.fit(network) {
            return;
        }
        self.layers.resize_with(network.layers(), Default::default);
        for (layer, weights) in self.layers.iter_mut().enumerate().skip(1) {
            weights.pack(network.weights(layer), network.sizes()[layer]);
        }
        self.version = Some(network.version());
    }
}
