//! Adam (Kingma, Ba 2015) and the clipping of gradients.

use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::bits;
use super::instructions::arch;

/// Adam's moments for one vector of parameters. Serialised exactly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adam {
    /// Decay of the mean of gradients.
    pub beta1: f32,
    /// Decay of the mean of squared gradients.
    pub beta2: f32,
    /// Added to the root of the mean square: below it, small gradients make small steps.
    pub epsilon: f32,
    /// Mean of gradients, before the correction for its start at zero.
    #[serde(with = "bits")]
    m: Vec<f32>,
    /// Mean of squared gradients, likewise.
    #[serde(with = "bits")]
    v: Vec<f32>,
    /// Steps made.
    t: u64,
}

impl Adam {
    /// For so many parameters: decays 0.9 and 0.999, epsilon 1e-5.
    pub fn new(parameters: usize) -> Self {
        let zero = vec![0.0; parameters];
        Self { beta1: 0.9, beta2: 0.999, epsilon: 1e-5, m: zero.clone(), v: zero, t: 0 }
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.m.len().min(self.v.len())
    }

    /// Steps made.
    pub fn steps(&self) -> u64 {
        self.t
    }

    /// One step against the gradient (algorithm 1 of the paper):
    /// m = b1 m + (1 - b1) g, v = b2 v + (1 - b2) g^2, p -= rate * m / (1 - b1^t) / (sqrt(v / (1 - b2^t)) + epsilon).
    ///
    /// # Panics
    /// If the slices do not have the length given to `new`.
    pub fn step(&mut self, parameters: &mut [f32], gradient: &[f32], rate: f32) {
        assert_eq!(
            (parameters.len(), gradient.len()),
            (self.m.len(), self.m.len()),
            "parameters and gradients of Adam"
        );
        self.t += 1;
        let correction = |beta: f32| 1.0 - power(f64::from(beta), self.t);
        let root = correction(self.beta2).sqrt();
        // With both corrections moved out of the loop: p -= (rate root / c1) m / (sqrt(v) + epsilon root).
        let step = Step {
            rate: (f64::from(rate) * root / correction(self.beta1)) as f32,
            epsilon: (f64::from(self.epsilon) * root) as f32,
            adam: self,
            parameters,
            gradient,
        };
        arch().dispatch(step);
    }
}

/// x^n by squaring: the same on every machine.
fn power(mut x: f64, mut n: u64) -> f64 {
    let mut result = 1.0;
    while n > 0 {
        if n & 1 == 1 {
            result *= x;
        }
        x *= x;
        n >>= 1;
    }
    result
}

/// The loop of a step, compiled for each instruction set.
struct Step<'a> {
    rate: f32,
    epsilon: f32,
    adam: &'a mut Adam,
    parameters: &'a mut [f32],
    gradient: &'a [f32],
}

impl WithSimd for Step<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { rate, epsilon, adam, parameters, gradient } = self;
        let (beta1, beta2) = (simd.splat_f32s(adam.beta1), simd.splat_f32s(adam.beta2));
        let (rest1, rest2) = (simd.splat_f32s(1.0 - adam.beta1), simd.splat_f32s(1.0 - adam.beta2));
        let (rate, epsilon) = (simd.splat_f32s(rate), simd.splat_f32s(epsilon));
        let update = |p: &mut S::f32s, m: &mut S::f32s, v: &mut S::f32s, g: S::f32s| {
            *m = simd.mul_add_e_f32s(beta1, *m, simd.mul_f32s(rest1, g));
            *v = simd.mul_add_e_f32s(beta2, *v, simd.mul_f32s(rest2, simd.mul_f32s(g, g)));
            let direction = simd.div_f32s(*m, simd.add_f32s(simd.sqrt_f32s(*v), epsilon));
            *p = simd.negate_mul_add_e_f32s(rate, direction, *p);
        };
        let (p, p_tail) = S::as_mut_simd_f32s(parameters);
        let (m, m_tail) = S::as_mut_simd_f32s(&mut adam.m);
        let (v, v_tail) = S::as_mut_simd_f32s(&mut adam.v);
        let (g, g_tail) = S::as_simd_f32s(gradient);
        for (((p, m), v), g) in p.iter_mut().zip(m).zip(v).zip(g) {
            update(p, m, v, *g);
        }
        let [mut p, mut m, mut v] = [&*p_tail, &*m_tail, &*v_tail].map(|tail| simd.partial_load_f32s(tail));
        update(&mut p, &mut m, &mut v, simd.partial_load_f32s(g_tail));
        simd.partial_store_f32s(p_tail, p);
        simd.partial_store_f32s(m_tail, m);
        simd.partial_store_f32s(v_tail, v);
    }
}

/// Scales the gradients, taken together, to at most this Euclidean norm; returns the norm they had.
///
/// Where that is not finite they are left as they are: the caller must drop the step.
pub fn clip_norm(gradients: &mut [&mut [f32]], max_norm: f32) -> f32 {
    let norm = gradients.iter().map(|gradient| sum_of_squares(gradient)).sum::<f64>().sqrt();
    if norm.is_finite() && norm > f64::from(max_norm) {
        let scale = (f64::from(max_norm) / norm) as f32;
        for gradient in gradients.iter_mut() {
            gradient.iter_mut().for_each(|value| *value *= scale);
        }
    }
    norm as f32
}

/// In f64, over eight sums side by side: a fixed order, and room for squares beyond the range of f32.
fn sum_of_squares(values: &[f32]) -> f64 {
    let (groups, tail) = values.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for group in groups {
        for (sum, value) in sums.iter_mut().zip(group) {
            *sum += f64::from(*value) * f64::from(*value);
        }
    }
    sums.iter().sum::<f64>() + tail.iter().map(|value| f64::from(*value) * f64::from(*value)).sum::<f64>()
}
