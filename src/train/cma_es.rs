//! CMA-ES: the covariance matrix adaptation evolution strategy.
//!
//! Hansen 2016, "The CMA Evolution Strategy: A Tutorial" (arXiv 1604.00772), with its active update (negative weights,
//! Section 4.1 and Table 1); the diagonal mode after Ros, Hansen 2008, "A Simple Modification in CMA-ES Achieving
//! Linear Time and Space Complexity". Equation numbers below are those of the tutorial.
//!
//! ```text
//! x_k = m + s B D z_k                 z_k ~ N(0, I), C = B D^2 B^T
//! y_k = (x_k - m) / s                 sorted: y_1 is the best
//! ```
//!
//! Symbols: `n` dimension, `lambda` candidates in a generation, `mu` of them parents, `m` mean, `s` step size (sigma), `C`
//! covariance, `p_s` and `p_c` the evolution paths, `w_k` weights (negative ones belong to the worse half).
//!
//! The method asks and is told; it holds no thread and calls nobody. Its whole state can be saved and read again, and goes on
//! with the same numbers: candidate `k` of generation `g` draws from the random stream named (seed, g, k), so there is no
//! generator to save either.

use crate::math::RandomStream;
use crate::math::symmetric_eigen;
use serde::{Deserialize, Serialize};

/// Most variables: the covariance of so many takes 32 MB.
pub const MAX_DIMENSION: usize = 2000;
/// Most candidates in a generation.
pub const MAX_POPULATION: usize = 1 << 16;
/// Largest ratio of the eigenvalues of C that double precision can tell apart; beyond it C is made rounder.
const MAX_CONDITION: f64 = 1e14;

/// How to search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CmaOptions {
    /// Candidates in a generation; `None` takes `4 + 3 ln n`.
    pub population: Option<usize>,
    /// First step size: about a third of the distance to where the best point may be.
    pub sigma: f64,
    /// Standard deviations of the variables relative to `sigma`; `None` is one for all.
    pub scales: Option<Vec<f64>>,
    /// Keeps the covariance diagonal: less to learn and nothing to decompose, but blind to how variables work together.
    pub separable: bool,
    /// Seed of all random streams.
    pub seed: u64,
}

impl Default for CmaOptions {
    fn default() -> Self {
        Self { population: None, sigma: 0.3, scales: None, separable: false, seed: 1 }
    }
}

/// Why a search cannot begin or go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CmaError {
    /// An option or a start cannot be used.
    #[error("CMA-ES: {field} is {found}; valid is {valid}")]
    Option {
        /// The field.
        field: &'static str,
        /// What it holds.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// What was told does not belong to what was asked.
    #[error("CMA-ES: told {found} {what}; expected {expected}")]
    Told {
        /// Candidates, costs or variables.
        what: &'static str,
        /// How many were told.
        found: usize,
        /// How many should be.
        expected: usize,
    },
}

/// A point and its cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The variables.
    pub x: Vec<f64>,
    /// The cost.
    pub cost: f64,
}

/// Constants that follow from dimension and population: Table 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Constants {
    lambda: usize,
    mu: usize,
    /// All weights; the first `mu` add up to one.
    weights: Vec<f64>,
    mu_eff: f64,
    c_s: f64,
    d_s: f64,
    c_c: f64,
    c_1: f64,
    c_mu: f64,
    /// Expected length of N(0, I).
    chi: f64,
    /// Generations between decompositions.
    lazy: u64,
}

impl Constants {
    fn new(n: usize, lambda: usize, separable: bool) -> Self {
        let d = n as f64;
        let mu = lambda / 2;
        // (49): half of the candidates weigh positively, the others negatively.
        let raw: Vec<f64> = (1..=lambda).map(|i| (0.5 * (lambda as f64 + 1.0)).ln() - (i as f64).ln()).collect();
        let effective = |w: &[f64]| {
            let (sum, squares): (f64, f64) = (w.iter().sum(), w.iter().map(|x| x * x).sum());
            if squares > 0.0 { sum * sum / squares } else { 0.0 }
        };
        let (mu_eff, mu_eff_minus) = (effective(&raw[..mu]), effective(&raw[mu..]));
        let c_c = (4.0 + mu_eff / d) / (d + 4.0 + 2.0 * mu_eff / d);
        // A diagonal has n numbers to learn instead of n^2: it may learn faster (Ros, Hansen 2008, Section 3).
        let faster = if separable { (d + 2.0) / 3.0 } else { 1.0 };
        let c_1 = (faster * 2.0 / ((d + 1.3).powi(2) + mu_eff)).min(0.5);
        let c_mu = (faster * 2.0 * (0.25 + mu_eff + 1.0 / mu_eff - 2.0) / ((d + 2.0).powi(2) + mu_eff)).min(1.0 - c_1);
        // (50) to (53): the negative weights add up to at most what keeps C positive.
        let alpha_mu = 1.0 + c_1 / c_mu;
        let alpha_mu_eff = 1.0 + 2.0 * mu_eff_minus / (mu_eff + 2.0);
        let alpha_positive = (1.0 - c_1 - c_mu) / (d * c_mu);
        let alpha = alpha_mu.min(alpha_mu_eff).min(alpha_positive);
        let positive: f64 = raw.iter().filter(|w| **w > 0.0).sum();
        let negative: f64 = -raw.iter().filter(|w| **w < 0.0).sum::<f64>();
        let weights =
            raw.iter().map(|&w| if w >= 0.0 { w / positive } else { w * alpha / negative.max(1e-300) }).collect();
        let c_s = (mu_eff + 2.0) / (d + mu_eff + 5.0);
        Self {
            lambda,
            mu,
            weights,
            mu_eff,
            c_s,
            d_s: 1.0 + 2.0 * (((mu_eff - 1.0) / (d + 1.0)).sqrt() - 1.0).max(0.0) + c_s,
            c_c,
            c_1,
            c_mu,
            chi: d.sqrt() * (1.0 - 1.0 / (4.0 * d) + 1.0 / (21.0 * d * d)),
            // As long as C changes by no more than half of itself in all: decompositions then cost no more than the rest.
            lazy: ((0.5 / (d * (c_1 + c_mu))) as u64).max(1),
        }
    }
}

/// A running search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CmaEs {
    options: CmaOptions,
    constants: Constants,
    generation: u64,
    mean: Vec<f64>,
    sigma: f64,
    path_s: Vec<f64>,
    path_c: Vec<f64>,
    /// C by rows; its diagonal alone in the separable mode.
    covariance: Vec<f64>,
    /// B: unit axes one after the other; none in the separable mode.
    axes: Vec<f64>,
    /// D: standard deviation along each axis, at the time of the last decomposition.
    lengths: Vec<f64>,
    decomposed_at: u64,
    best: Option<Point>,
}

impl CmaEs {
    /// A search that begins around `mean`.
    pub fn new(mean: Vec<f64>, options: CmaOptions) -> Result<Self, CmaError> {
        let n = mean.len();
        let bad = |field, found: String, valid: &str| Err(CmaError::Option { field, found, valid: valid.into() });
        if !(1..=MAX_DIMENSION).contains(&n) {
            return bad("number of variables", n.to_string(), "1 to 2000");
        }
        if let Some(x) = mean.iter().find(|x| !x.is_finite()) {
            return bad("mean", x.to_string(), "finite");
        }
        if !(options.sigma.is_finite() && options.sigma > 0.0) {
            return bad("sigma", options.sigma.to_string(), "a positive number");
        }
        let lambda = options.population.unwrap_or(4 + (3.0 * (n as f64).ln()) as usize);
        if !(4..=MAX_POPULATION).contains(&lambda) {
            return bad("population", lambda.to_string(), "4 to 65536");
        }
        let scales = options.scales.clone().unwrap_or_else(|| vec![1.0; n]);
        if scales.len() != n {
            return bad("scales", format!("{} numbers", scales.len()), &format!("one for each of {n} variables"));
        }
        if let Some(s) = scales.iter().find(|s| !(s.is_finite() && **s > 0.0)) {
            return bad("scales", s.to_string(), "positive numbers");
        }
        let (mut covariance, mut axes) = (scales.iter().map(|s| s * s).collect::<Vec<_>>(), Vec::new());
        if !options.separable {
            axes = vec![0.0; n * n];
            let mut whole = vec![0.0; n * n];
            for i in 0..n {
                axes[i * n + i] = 1.0;
                whole[i * n + i] = covariance[i];
            }
            covariance = whole;
        }
        Ok(Self {
            constants: Constants::new(n, lambda, options.separable),
            generation: 0,
            sigma: options.sigma,
            path_s: vec![0.0; n],
            path_c: vec![0.0; n],
            covariance,
            axes,
            lengths: scales,
            decomposed_at: 0,
            best: None,
            mean,
            options,
        })
    }

    /// Number of variables.
    pub fn dimension(&self) -> usize {
        self.mean.len()
    }
    /// Candidates in a generation.
    pub fn population(&self) -> usize {
        self.constants.lambda
    }
    /// Generations that were told.
    pub fn generation(&self) -> u64 {
        self.generation
    }
    /// The mean: the point that the method itself would recommend.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }
    /// The step size.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }
    /// The best point that was ever told.
    pub fn best(&self) -> Option<&Point> {
        self.best.as_ref()
    }
    /// The largest standard deviation along any axis: where it is far below what matters, the search is over.
    pub fn spread(&self) -> f64 {
        self.sigma * self.lengths.iter().fold(0.0_f64, |m, x| m.max(*x))
    }

    /// The candidates of this generation: the same ones until [`CmaEs::tell`].
    pub fn ask(&self) -> Vec<Vec<f64>> {
        let n = self.dimension();
        (0..self.population())
            .map(|k| {
                let mut random = RandomStream::new(self.options.seed, (self.generation << 16) + k as u64);
                let mut x = self.mean.clone();
                for axis in 0..n {
                    let step = self.sigma * self.lengths[axis] * random.normal();
                    if self.options.separable {
                        x[axis] += step;
                    } else {
                        add_scaled(&mut x, step, &self.axes[axis * n..(axis + 1) * n]);
                    }
                }
                x
            })
            .collect()
    }

    /// What the candidates cost; begins the next generation. A cost that is not finite counts as worse than all others.
    ///
    /// The candidates need not be exactly those of [`CmaEs::ask`]: they may have been moved back into bounds, or one may
    /// be replaced by a good point from elsewhere.
    pub fn tell(&mut self, candidates: &[Vec<f64>], costs: &[f64]) -> Result<(), CmaError> {
        let (n, lambda) = (self.dimension(), self.population());
        let told = |what, found, expected| Err(CmaError::Told { what, found, expected });
        if candidates.len() != lambda {
            return told("candidates", candidates.len(), lambda);
        }
        if costs.len() != lambda {
            return told("costs", costs.len(), lambda);
        }
        if let Some(x) = candidates.iter().find(|x| x.len() != n || !x.iter().all(|v| v.is_finite())) {
            return told("finite variables", x.iter().filter(|v| v.is_finite()).count(), n);
        }
        let cost = |k: usize| if costs[k].is_finite() { costs[k] } else { f64::INFINITY };
        let mut order: Vec<usize> = (0..lambda).collect();
        order.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)).then(a.cmp(&b)));
        let first = order[0];
        if costs[first].is_finite() && self.best.as_ref().is_none_or(|best| costs[first] < best.cost) {
            self.best = Some(Point { x: candidates[first].clone(), cost: costs[first] });
        }

        let c = &self.constants;
        let inverse = 1.0 / self.sigma;
        let y: Vec<Vec<f64>> = order
            .iter()
            .map(|&k| candidates[k].iter().zip(&self.mean).map(|(x, m)| (x - m) * inverse).collect())
            .collect();

        // (41), (42): the mean goes to the weighted mean of the better half.
        let mut step = vec![0.0; n];
        for (y, w) in y.iter().zip(&c.weights[..c.mu]) {
            add_scaled(&mut step, *w, y);
        }
        add_scaled(&mut self.mean, self.sigma, &step);

        // (43), (44): steps that keep one direction ask for larger ones.
        let white = self.whitened(&step);
        let gain = (c.c_s * (2.0 - c.c_s) * c.mu_eff).sqrt();
        for (p, w) in self.path_s.iter_mut().zip(&white) {
            *p = (1.0 - c.c_s) * *p + gain * w;
        }
        let length = squared(&self.path_s).sqrt();
        self.generation += 1;
        let settled = (1.0 - (1.0 - c.c_s).powf(2.0 * self.generation as f64)).sqrt();
        let slow = length / settled < (1.4 + 2.0 / (n as f64 + 1.0)) * c.chi;

        // (45): the path of the mean, held while it runs away.
        let gain = if slow { (c.c_c * (2.0 - c.c_c) * c.mu_eff).sqrt() } else { 0.0 };
        for (p, s) in self.path_c.iter_mut().zip(&step) {
            *p = (1.0 - c.c_c) * *p + gain * s;
        }

        // (46), (47): C learns from the path and from all candidates; bad ones take their direction away.
        let held = if slow { 0.0 } else { c.c_c * (2.0 - c.c_c) };
        let total: f64 = c.weights.iter().sum();
        let keep = 1.0 + c.c_1 * held - c.c_1 - c.c_mu * total;
        let scaled: Vec<f64> = y
            .iter()
            .zip(&c.weights)
            .map(|(y, &w)| {
                let scale = if w >= 0.0 { 1.0 } else { n as f64 / squared(&self.whitened(y)).max(1e-300) };
                c.c_mu * w * scale
            })
            .collect();
        let ranks: Vec<(f64, &[f64])> = std::iter::once((c.c_1, &self.path_c[..]))
            .chain(scaled.iter().zip(&y).map(|(w, y)| (*w, &y[..])))
            .collect();
        if self.options.separable {
            for (i, x) in self.covariance.iter_mut().enumerate() {
                *x = keep * *x + ranks.iter().map(|(w, y)| w * y[i] * y[i]).sum::<f64>();
            }
        } else {
            for (i, row) in self.covariance.chunks_exact_mut(n).enumerate() {
                let row = &mut row[..=i];
                row.iter_mut().for_each(|x| *x *= keep);
                for (w, y) in &ranks {
                    add_scaled(row, w * y[i], &y[..=i]);
                }
            }
        }

        self.sigma *= (c.c_s / c.d_s * (length / c.chi - 1.0)).min(1.0).exp();
        if self.options.separable || self.generation - self.decomposed_at >= self.constants.lazy {
            self.decompose();
        }
        Ok(())
    }

    /// `C^(-1/2) v` by the last decomposition, in the coordinates of the axes turned back: `B D^-1 B^T v`.
    fn whitened(&self, v: &[f64]) -> Vec<f64> {
        let n = v.len();
        if self.options.separable {
            return v.iter().zip(&self.lengths).map(|(v, d)| v / d).collect();
        }
        let mut white = vec![0.0; n];
        for (axis, length) in self.axes.chunks_exact(n).zip(&self.lengths) {
            let along: f64 = axis.iter().zip(v).map(|(a, b)| a * b).sum();
            add_scaled(&mut white, along / length, axis);
        }
        white
    }

    /// Axes and lengths of the present C. Where rounding made it indefinite or too long for its width, it is made
    /// rounder first.
    fn decompose(&mut self) {
        let n = self.dimension();
        self.decomposed_at = self.generation;
        let values = if self.options.separable {
            self.covariance.clone()
        } else {
            let Some(eigen) = symmetric_eigen(&self.covariance, n) else { return };
            self.axes = eigen.vectors;
            eigen.values
        };
        let longest = values.iter().fold(0.0_f64, |m, x| m.max(*x)).max(1e-300);
        let least = longest / MAX_CONDITION;
        let shortest = values.iter().fold(f64::INFINITY, |m, x| m.min(*x));
        let rounder = (least - shortest).max(0.0);
        if rounder > 0.0 {
            let stride = if self.options.separable { 1 } else { n + 1 };
            self.covariance.iter_mut().step_by(stride).for_each(|x| *x += rounder);
        }
        self.lengths = values.iter().map(|x| (x + rounder).sqrt()).collect();
    }
}

fn add_scaled(to: &mut [f64], factor: f64, from: &[f64]) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += factor * f;
    }
}

fn squared(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum()
}
