//! The numbers of a training, and which of them can be used.

use crate::train::ppo::trainer::TrainError;
use serde::{Deserialize, Serialize};

/// How to learn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainOptions {
    /// Seed of all random streams.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// Pods of 64 trials.
    pub pods: usize,
    /// Ticks of every trial in an iteration.
    pub ticks: usize,
    /// Rows of a minibatch.
    pub minibatch: usize,
    /// Passes over the experience of an iteration.
    pub epochs: usize,
    /// Hidden layers.
    pub hidden: Vec<usize>,
    /// Discount of a tick.
    pub gamma: f32,
    /// Decay of the advantage estimate.
    pub lambda: f32,
    /// Bound of the probability ratio.
    pub clip: f32,
    /// First learning rate; it follows the divergence.
    pub rate: f32,
    /// Divergence at which an iteration's update stops and the learning rate falls; below half of it the rate rises.
    pub divergence: f32,
    /// How strongly an action is drawn to those before and after it (Mysore, Mabsout, Mancuso, Saenko 2021, "Regularizing
    /// Action Policies for Smooth Control", equation 2); 0 not at all.
    pub smoothness: f32,
    /// The policy that is measured and kept is a running mean of the actor's parameters over about so many iterations.
    pub average: usize,
    /// Standard deviation of the exploration at the start and in the end, in units of the action.
    pub sigma: (f32, f32),
    /// Samples over which it falls from the first to the last.
    pub sigma_samples: f64,
    /// What exploration and divergence are multiplied by in the end. Once the motion can be done (a measured survival of
    /// 90 %, and of 80 % in every row), smaller changes of the policy make it robust, larger ones undo as much as they gain.
    pub settled: (f32, f32),
    /// Samples with which the motion can be done, over which they fall.
    pub settle_samples: f64,
    /// Iterations after which the normaliser stays.
    pub normalizer_iterations: usize,
    /// Part of the trials that begin anywhere in the motion and at any of its speeds, 0 to 1; the others begin shortly ahead
    /// of where, and at the speeds at which, trials fail.
    pub even_starts: f64,
    /// Part of the trials that begin exactly as one began that failed (within two seconds, where the motion repeats), once the
    /// motion can be done (a measured survival of 90 %); a start that has been lasted through is forgotten.
    pub hard_starts: f64,
    /// Iterations at the beginning in which only the critic learns: for an actor that can do something already.
    pub critic_first: usize,
    /// Trials of a measurement.
    pub evaluation_trials: usize,
    /// Iterations between measurements.
    pub evaluate_every: usize,
    /// How large a part of the simulated steps may be those of measurements: one whose turn it is is left out where earlier
    /// ones took more.
    pub evaluation_share: f64,
}

impl Default for TrainOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            threads: crate::train::default_threads(),
            pods: 4,
            ticks: 32,
            minibatch: 1024,
            epochs: 2,
            hidden: vec![128, 128, 128],
            gamma: 0.97,
            lambda: 0.95,
            clip: 0.2,
            rate: 3e-4,
            divergence: 0.06,
            smoothness: 0.1,
            average: 20,
            sigma: (0.4, 0.08),
            sigma_samples: 4e6,
            settled: (0.6, 0.33),
            settle_samples: 1e7,
            normalizer_iterations: 60,
            even_starts: 0.4,
            hard_starts: 0.25,
            critic_first: 0,
            evaluation_trials: 128,
            evaluate_every: 20,
            evaluation_share: 0.1,
        }
    }
}

impl TrainOptions {
    /// Whether every option can be used.
    pub(crate) fn check(&self) -> Result<(), TrainError> {
        let bad = |option, found: String, valid| Err(TrainError::Option { option, found, valid });
        if !(1..=256).contains(&self.threads) {
            return bad("threads", self.threads.to_string(), "1 to 256");
        }
        if !(1..=4096).contains(&self.pods) {
            return bad("pods", self.pods.to_string(), "1 to 4096");
        }
        if !(1..=4096).contains(&self.ticks) {
            return bad("ticks", self.ticks.to_string(), "1 to 4096");
        }
        if !(1..=1 << 20).contains(&self.minibatch) {
            return bad("minibatch", self.minibatch.to_string(), "1 to 1048576");
        }
        if self.hidden.is_empty() || self.hidden.len() > 8 || self.hidden.iter().any(|h| !(1..=4096).contains(h)) {
            return bad("hidden", format!("{:?}", self.hidden), "1 to 8 layers of 1 to 4096");
        }
        if !(0.0..1.0).contains(&self.gamma) || !(0.0..=1.0).contains(&self.lambda) {
            return bad("gamma, lambda", format!("{}, {}", self.gamma, self.lambda), "from 0 to 1");
        }
        if !(self.sigma.0 > 0.0 && self.sigma.1 > 0.0 && self.sigma.0.is_finite() && self.sigma.1.is_finite()) {
            return bad("sigma", format!("{:?}", self.sigma), "two positive numbers");
        }
        for (option, number) in [("clip", self.clip), ("rate", self.rate), ("divergence", self.divergence)] {
            if !(number > 0.0 && number.is_finite()) {
                return bad(option, number.to_string(), "more than 0");
            }
        }
        let factor = |f: f32| f > 0.0 && f <= 1.0;
        if !(factor(self.settled.0) && factor(self.settled.1)) {
            return bad("settled", format!("{:?}", self.settled), "two numbers, more than 0 and up to 1");
        }
        if !(self.smoothness >= 0.0 && self.smoothness.is_finite()) {
            return bad("smoothness", self.smoothness.to_string(), "0 or more");
        }
        let shares = [
            ("even_starts", self.even_starts),
            ("hard_starts", self.hard_starts),
            ("evaluation_share", self.evaluation_share),
        ];
        for (option, share) in shares {
            if !(0.0..=1.0).contains(&share) {
                return bad(option, share.to_string(), "0 to 1");
            }
        }
        if self.settle_samples.is_nan() || self.settle_samples <= 0.0 {
            return bad("settle_samples", self.settle_samples.to_string(), "more than 0");
        }
        if !(1..=10_000).contains(&self.average) {
            return bad("average", self.average.to_string(), "1 to 10000 iterations");
        }
        Ok(())
    }
}
