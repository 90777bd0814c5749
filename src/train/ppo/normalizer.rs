//! Observations brought to mean zero and variance one.

use serde::{Deserialize, Serialize};

/// Running mean and variance of every number of an observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Normalizer {
    count: f64,
    mean: Vec<f64>,
    square: Vec<f64>,
    /// What is subtracted.
    pub shift: Vec<f32>,
    /// What the rest is multiplied by.
    pub scale: Vec<f32>,
    /// Where the result is cut.
    pub clip: f32,
}

/// Smallest standard deviation that is believed: a constant number stays small when it moves at last.
const LEAST_DEVIATION: f64 = 0.02;

impl Normalizer {
    /// Passes observations of this size through unchanged, until [`Normalizer::update`].
    pub fn new(size: usize) -> Self {
        Self {
            count: 0.0,
            mean: vec![0.0; size],
            square: vec![0.0; size],
            shift: vec![0.0; size],
            scale: vec![1.0; size],
            clip: 6.0,
        }
    }

    /// One that is known already and stays.
    pub(crate) fn fixed(shift: Vec<f32>, scale: Vec<f32>, clip: f32) -> Self {
        Self { shift, scale, clip, ..Self::new(0) }
    }

    /// Counts rows in (rows x size).
    pub fn update(&mut self, rows: &[f32]) {
        let size = self.mean.len();
        for row in rows.chunks_exact(size) {
            for ((mean, square), x) in self.mean.iter_mut().zip(&mut self.square).zip(row) {
                let x = f64::from(*x);
                *mean += x;
                *square += x * x;
            }
        }
        self.count += (rows.len() / size) as f64;
        for k in 0..size {
            let mean = self.mean[k] / self.count;
            let variance = (self.square[k] / self.count - mean * mean).max(0.0);
            self.shift[k] = mean as f32;
            self.scale[k] = (1.0 / variance.sqrt().max(LEAST_DEVIATION)) as f32;
        }
    }

    /// Normalises rows in place.
    pub fn apply(&self, rows: &mut [f32]) {
        let size = self.shift.len();
        for row in rows.chunks_exact_mut(size) {
            for ((x, shift), scale) in row.iter_mut().zip(&self.shift).zip(&self.scale) {
                *x = ((*x - shift) * scale).clamp(-self.clip, self.clip);
            }
        }
    }
}
