//! A dense network.

use crate::math::RandomStream;
use crate::train::nn::product::{add_product, transpose};
use crate::train::nn::tanh::tanh;
use serde::{Deserialize, Serialize};

/// What lies between the layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Activation {
    /// Hyperbolic tangent.
    Tanh,
}

/// Dense layers with an activation between them; the last one is linear.
///
/// The parameters are one vector: for each layer its weights (outputs x inputs, row by row), then its bias.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Network {
    sizes: Vec<usize>,
    activation: Activation,
    parameters: Vec<f32>,
}

/// Work space of one thread; grows as needed.
#[derive(Clone, Debug, Default)]
pub struct Activations {
    layers: Vec<Vec<f32>>,
    transposed: Vec<f32>,
    delta: Vec<f32>,
    delta_before: Vec<f32>,
}

impl Network {
    /// A network with these sizes, inputs first. Weights are normal with variance `1 / inputs`, those of the last layer
    /// times `last_gain`; biases are zero.
    pub fn new(sizes: &[usize], activation: Activation, last_gain: f32, random: &mut RandomStream) -> Self {
        let mut parameters = Vec::new();
        for (k, pair) in sizes.windows(2).enumerate() {
            let gain = if k + 2 == sizes.len() { last_gain } else { 1.0 };
            let deviation = gain / (pair[0] as f32).sqrt();
            parameters.extend((0..pair[0] * pair[1]).map(|_| deviation * random.normal() as f32));
            parameters.extend(std::iter::repeat_n(0.0, pair[1]));
        }
        Self { sizes: sizes.to_vec(), activation, parameters }
    }

    /// Sizes of the layers, inputs first.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }
    /// What lies between the layers.
    pub fn activation(&self) -> Activation {
        self.activation
    }
    /// Numbers that go in.
    pub fn inputs(&self) -> usize {
        self.sizes.first().copied().unwrap_or(0)
    }
    /// Numbers that come out.
    pub fn outputs(&self) -> usize {
        self.sizes.last().copied().unwrap_or(0)
    }
    /// All parameters.
    pub fn parameters(&self) -> &[f32] {
        &self.parameters
    }
    /// All parameters, to be changed.
    pub fn parameters_mut(&mut self) -> &mut [f32] {
        &mut self.parameters
    }
    /// Layers of weights.
    pub fn depth(&self) -> usize {
        self.sizes.len().saturating_sub(1)
    }
    /// Where the parameters of a layer begin.
    fn start(&self, layer: usize) -> usize {
        self.sizes.windows(2).take(layer).map(|p| (p[0] + 1) * p[1]).sum()
    }
    /// Weights of a layer: outputs x inputs, row by row.
    pub fn weights(&self, layer: usize) -> &[f32] {
        let at = self.start(layer);
        &self.parameters[at..at + self.sizes[layer] * self.sizes[layer + 1]]
    }
    /// Bias of a layer.
    pub fn bias(&self, layer: usize) -> &[f32] {
        let at = self.start(layer) + self.sizes[layer] * self.sizes[layer + 1];
        &self.parameters[at..at + self.sizes[layer + 1]]
    }
    /// Whether the parameters belong to the sizes and are finite: a file may say anything.
    pub fn is_valid(&self) -> bool {
        self.sizes.len() >= 2
            && self.sizes.iter().all(|s| (1..=65_536).contains(s))
            && self.parameters.len() == self.start(self.depth())
            && self.parameters.iter().all(|p| p.is_finite())
    }

    /// The outputs (rows x outputs) for these inputs (rows x inputs). The activations stay in `scratch` for
    /// [`Network::backward`].
    pub fn forward<'a>(&self, scratch: &'a mut Activations, input: &[f32], rows: usize) -> &'a [f32] {
        let depth = self.depth();
        scratch.layers.resize_with(depth, Vec::new);
        for layer in 0..depth {
            let (inputs, outputs) = (self.sizes[layer], self.sizes[layer + 1]);
            transpose(self.weights(layer), outputs, inputs, &mut scratch.transposed);
            let (before, rest) = scratch.layers.split_at_mut(layer);
            let from = before.last().map_or(input, |b| b);
            let to = &mut rest[0];
            to.clear();
            for _ in 0..rows {
                to.extend_from_slice(self.bias(layer));
            }
            add_product(from, &scratch.transposed, to, rows, inputs, outputs);
            if layer + 1 < depth {
                match self.activation {
                    Activation::Tanh => to.iter_mut().for_each(|x| *x = tanh(*x)),
                }
            }
        }
        scratch.layers.last().map_or(&[], |l| l)
    }

    /// Adds to `gradient` (laid out like the parameters) that of a loss whose derivative by the outputs is `d_output` (rows x
    /// outputs). `scratch` must come from [`Network::forward`] with the same input.
    pub fn backward(
        &self,
        scratch: &mut Activations,
        input: &[f32],
        rows: usize,
        d_output: &[f32],
        gradient: &mut [f32],
    ) {
        let Activations { layers, transposed, delta, delta_before } = scratch;
        delta.clear();
        delta.extend_from_slice(d_output);
        for layer in (0..self.depth()).rev() {
            let (inputs, outputs) = (self.sizes[layer], self.sizes[layer + 1]);
            let at = self.start(layer);
            let (weights, rest) = gradient[at..].split_at_mut(inputs * outputs);
            let from: &[f32] = if layer == 0 { input } else { &layers[layer - 1] };
            transpose(delta, rows, outputs, transposed);
            add_product(transposed, from, weights, outputs, rows, inputs);
            for row in delta.chunks_exact(outputs) {
                for (sum, d) in rest.iter_mut().zip(row) {
                    *sum += d;
                }
            }
            if layer > 0 {
                delta_before.clear();
                delta_before.resize(rows * inputs, 0.0);
                add_product(delta, self.weights(layer), delta_before, rows, outputs, inputs);
                match self.activation {
                    Activation::Tanh => {
                        for (d, y) in delta_before.iter_mut().zip(&layers[layer - 1]) {
                            *d *= 1.0 - y * y;
                        }
                    }
                }
                core::mem::swap(delta, delta_before);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradient_against_central_differences() {
        let mut random = RandomStream::new(3, 0);
        let mut network = Network::new(&[5, 9, 7, 3], Activation::Tanh, 1.0, &mut random);
        let rows = 4;
        let mut draw = |n: usize| -> Vec<f32> { (0..n).map(|_| random.normal() as f32).collect() };
        let (input, d) = (draw(rows * 5), draw(rows * 3));
        let mut scratch = Activations::default();
        let mut gradient = vec![0.0; network.parameters().len()];
        network.forward(&mut scratch, &input, rows);
        network.backward(&mut scratch, &input, rows, &d, &mut gradient);
        let (h, mut worst) = (1e-2_f32, 0.0_f32);
        for (k, gradient) in gradient.iter().enumerate() {
            let mut loss = |shift: f32| -> f64 {
                network.parameters_mut()[k] += shift;
                let out = network.forward(&mut scratch, &input, rows);
                let sum = out.iter().zip(&d).map(|(o, d)| f64::from(*o) * f64::from(*d)).sum();
                network.parameters_mut()[k] -= shift;
                sum
            };
            let slope = ((loss(h) - loss(-h)) / (2.0 * f64::from(h))) as f32;
            worst = worst.max((slope - gradient).abs());
        }
        println!("gradient against differences: {worst:.2e} (allowed 3e-3)");
        assert!(worst < 3e-3, "{worst}");
    }
}
