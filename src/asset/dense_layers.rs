//! A plain feed-forward network: what a trainer hands over to be written as a policy file.

use serde::{Deserialize, Serialize};

/// What follows every layer but the last, element by element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// tanh(x).
    Tanh,
    /// x where x > 0, exp(x) - 1 elsewhere (Clevert, Unterthiner, Hochreiter 2016, with alpha = 1).
    Elu,
    /// max(x, 0).
    Relu,
}

/// One layer: y = weights x + bias.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DenseLayer {
    /// out x in numbers, row-major: row r holds what output r takes from each input.
    pub weights: Vec<f32>,
    /// One number for each output.
    pub bias: Vec<f32>,
}

/// Dense layers with an activation between them; the last one is linear.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DenseLayers {
    /// Widths: the input, every hidden layer, the output.
    pub sizes: Vec<usize>,
    /// Follows every layer but the last.
    pub activation: Activation,
    /// Layer k takes `sizes[k]` numbers to `sizes[k + 1]`.
    pub layers: Vec<DenseLayer>,
}

/// Why layers are no network.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LayersError {
    /// The number of layers does not fit the widths.
    #[error("network: {layers} layers for {sizes} widths; valid: at least one layer, and one width more than layers")]
    Depth {
        /// Number of layers.
        layers: usize,
        /// Number of widths.
        sizes: usize,
    },
    /// A layer holds more or fewer numbers than its widths ask for.
    #[error("network: layer {layer}: {found} {what}; valid: {valid}")]
    Count {
        /// The layer, from 0.
        layer: usize,
        /// `weights` or `biases`.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// What would be valid.
        valid: String,
    },
    /// A weight or bias is not a finite number.
    #[error("network: layer {layer}: {what} {index} is {value}; valid: finite numbers")]
    NotFinite {
        /// The layer, from 0.
        layer: usize,
        /// `weight` or `bias`.
        what: &'static str,
        /// Its place, from 0.
        index: usize,
        /// What it holds.
        value: f32,
    },
}

impl DenseLayers {
    /// Width of the input.
    pub fn inputs(&self) -> usize {
        self.sizes.first().copied().unwrap_or(0)
    }

    /// Width of the output.
    pub fn outputs(&self) -> usize {
        self.sizes.last().copied().unwrap_or(0)
    }

    /// The same network with `more` outputs behind those it has, which are always zero.
    pub fn with_idle_outputs(mut self, more: usize) -> Self {
        if let (Some(last), [.., inputs, outputs]) = (self.layers.last_mut(), &mut self.sizes[..]) {
            *outputs += more;
            last.weights.resize(last.weights.len() + *inputs * more, 0.0);
            last.bias.resize(last.bias.len() + more, 0.0);
        }
        self
    }

    /// Checks that every layer fits its widths and holds finite numbers only.
    pub fn check(&self) -> Result<(), LayersError> {
        if self.layers.is_empty() || self.sizes.len() != self.layers.len() + 1 {
            return Err(LayersError::Depth { layers: self.layers.len(), sizes: self.sizes.len() });
        }
        for (layer, (widths, numbers)) in self.sizes.windows(2).zip(&self.layers).enumerate() {
            let (from, to) = (widths[0], widths[1]);
            let count = |what, found, valid| Err(LayersError::Count { layer, what, found, valid });
            if to == 0 || from.checked_mul(to) != Some(numbers.weights.len()) || numbers.weights.is_empty() {
                return count("weights", numbers.weights.len(), format!("{to} x {from}, at least one"));
            }
            if numbers.bias.len() != to {
                return count("biases", numbers.bias.len(), to.to_string());
            }
            for (what, values) in [("weight", &numbers.weights), ("bias", &numbers.bias)] {
                if let Some((index, value)) = values.iter().copied().enumerate().find(|(_, v)| !v.is_finite()) {
                    return Err(LayersError::NotFinite { layer, what, index, value });
                }
            }
        }
        Ok(())
    }
}
