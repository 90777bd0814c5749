//! The numbers of a training, and which of them can be used.

use crate::train::ppo::error::TrainError;
use serde::{Deserialize, Serialize};

/// How to learn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainOptions {
    /// Seed of all random streams.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// Batches of 64 episodes side by side.
    #[serde(alias = "pods")]
    pub env_batches: usize,
    /// Ticks of every lane in an iteration.
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
    #[serde(alias = "rate")]
    pub learning_rate: f32,
    /// Kullback-Leibler divergence of the new policy from the old at which an iteration's update stops and the learning rate
    /// falls; below half of it the rate rises.
    #[serde(alias = "divergence")]
    pub kl: f32,
    /// How strongly an action is drawn to those before and after it (Mysore, Mabsout, Mancuso, Saenko 2021, "Regularizing
    /// Action Policies for Smooth Control", equation 2); 0 not at all.
    pub smoothness: f32,
    /// The policy that is measured and kept is a running mean of the actor's parameters over about so many iterations.
    pub average: usize,
    /// Standard deviation of the exploration at the start and in the end, in units of the action.
    #[serde(alias = "sigma")]
    pub action_std: (f32, f32),
    /// Samples over which it falls from the first to the last while every episode fails.
    #[serde(alias = "sigma_samples")]
    pub action_std_samples: f64,
    /// Samples over which it falls where no episode fails; in between the mean of both speeds counts by the episodes that failed. What is
    /// hard to find needs to be explored for long, what is found early is only disturbed by it.
    pub action_std_able_samples: f64,
    /// What exploration and divergence are multiplied by in the end. Once the motion can be done (a measured survival of
    /// 90 %, and of 80 % in every row), smaller changes of the policy make it robust, larger ones undo as much as they gain.
    #[serde(alias = "settled")]
    pub anneal: (f32, f32),
    /// Samples with which the motion can be done, over which they fall.
    #[serde(alias = "settle_samples")]
    pub anneal_samples: f64,
    /// Iterations after which the normaliser stays.
    pub normalizer_iterations: usize,
    /// Part of the episodes that begin anywhere in the motion and at any of its speeds, 0 to 1; the others begin shortly ahead
    /// of where, and at the speeds at which, episodes fail.
    #[serde(alias = "even_starts")]
    pub uniform_share: f64,
    /// Part of the episodes that begin exactly as one began that failed (within two seconds, where the motion repeats), once the
    /// motion can be done (a measured survival of 90 %); a start that has been lasted through is forgotten.
    #[serde(alias = "hard_starts")]
    pub replay_share: f64,
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
            env_batches: 4,
            ticks: 16,
            minibatch: 1024,
            epochs: 2,
            hidden: vec![128, 128, 128],
            gamma: 0.97,
            lambda: 0.95,
            clip: 0.2,
            learning_rate: 3e-4,
            kl: 0.06,
            smoothness: 0.1,
            average: 20,
            action_std: (0.4, 0.08),
            action_std_samples: 4e6,
            action_std_able_samples: 1.2e6,
            anneal: (0.6, 0.33),
            anneal_samples: 1e7,
            normalizer_iterations: 60,
            uniform_share: 0.4,
            replay_share: 0.25,
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
        if !(1..=4096).contains(&self.env_batches) {
            return bad("env_batches", self.env_batches.to_string(), "1 to 4096");
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
        if ![self.action_std.0, self.action_std.1].iter().all(|s| *s > 0.0 && s.is_finite()) {
            return bad("action_std", format!("{:?}", self.action_std), "two positive numbers");
        }
        for (option, number) in [("clip", self.clip), ("learning_rate", self.learning_rate), ("kl", self.kl)] {
            if !(number > 0.0 && number.is_finite()) {
                return bad(option, number.to_string(), "more than 0");
            }
        }
        let factor = |f: f32| f > 0.0 && f <= 1.0;
        if !(factor(self.anneal.0) && factor(self.anneal.1)) {
            return bad("anneal", format!("{:?}", self.anneal), "two numbers, more than 0 and up to 1");
        }
        if !(self.smoothness >= 0.0 && self.smoothness.is_finite()) {
            return bad("smoothness", self.smoothness.to_string(), "0 or more");
        }
        let shares = [
            ("uniform_share", self.uniform_share),
            ("replay_share", self.replay_share),
            ("evaluation_share", self.evaluation_share),
        ];
        for (option, share) in shares {
            if !(0.0..=1.0).contains(&share) {
                return bad(option, share.to_string(), "0 to 1");
            }
        }
        let lengths = [
            ("action_std_samples", self.action_std_samples),
            ("action_std_able_samples", self.action_std_able_samples),
            ("anneal_samples", self.anneal_samples),
        ];
        for (option, samples) in lengths {
            if samples.is_nan() || samples <= 0.0 {
                return bad(option, samples.to_string(), "more than 0");
            }
        }
        if !(1..=10_000).contains(&self.average) {
            return bad("average", self.average.to_string(), "1 to 10000 iterations");
        }
        Ok(())
    }
}
