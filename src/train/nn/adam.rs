//! The optimiser Adam.

use serde::{Deserialize, Serialize};

const FIRST: f32 = 0.9;
const SECOND: f32 = 0.999;
/// Keeps the step finite where a gradient has always been zero.
const LEAST: f32 = 1e-5;

/// Kingma, Ba 2015, "Adam: A Method for Stochastic Optimization", algorithm 1: running means of the gradient and of its
/// square, both corrected for their start at zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adam {
    first: Vec<f32>,
    second: Vec<f32>,
    steps: i32,
}

impl Adam {
    /// For so many parameters.
    pub fn new(parameters: usize) -> Self {
        Self { first: vec![0.0; parameters], second: vec![0.0; parameters], steps: 0 }
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.first.len()
    }

    /// One step down the gradient.
    pub fn step(&mut self, parameters: &mut [f32], gradient: &[f32], rate: f32) {
        self.steps = self.steps.saturating_add(1);
        let first_part = 1.0 / (1.0 - FIRST.powi(self.steps));
        let second_part = 1.0 / (1.0 - SECOND.powi(self.steps));
        let moments = self.first.iter_mut().zip(&mut self.second);
        for ((p, g), (m, v)) in parameters.iter_mut().zip(gradient).zip(moments) {
            *m = FIRST * *m + (1.0 - FIRST) * g;
            *v = SECOND * *v + (1.0 - SECOND) * g * g;
            *p -= rate * *m * first_part / ((*v * second_part).sqrt() + LEAST);
        }
    }
}

/// Scales gradients together so that their norm is at most `largest`; returns the norm they had.
pub fn clip_norm(gradients: &mut [&mut [f32]], largest: f32) -> f32 {
    let norm = gradients.iter().flat_map(|g| g.iter()).map(|x| x * x).sum::<f32>().sqrt();
    if norm > largest {
        let scale = largest / norm;
        gradients.iter_mut().flat_map(|g| g.iter_mut()).for_each(|x| *x *= scale);
    }
    norm
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_step_is_the_rate_and_a_quadratic_is_solved() {
        let mut adam = Adam::new(2);
        let mut x = [3.0_f32, -2.0];
        adam.step(&mut x, &[6.0, -4.0], 0.1);
        assert!((x[0] - 2.9).abs() < 1e-4 && (x[1] + 1.9).abs() < 1e-4, "{x:?}");
        for _ in 0..2000 {
            let gradient = [2.0 * x[0], 2.0 * x[1]];
            adam.step(&mut x, &gradient, 0.01);
        }
        assert!(x[0].abs() < 1e-2 && x[1].abs() < 1e-2, "{x:?}");
    }

    #[test]
    fn norms_are_cut() {
        let (mut a, mut b) = ([3.0_f32], [4.0_f32]);
        assert_eq!(clip_norm(&mut [&mut a, &mut b], 1.0), 5.0);
        assert!((a[0] - 0.6).abs() < 1e-6 && (b[0] - 0.8).abs() < 1e-6);
    }
}
