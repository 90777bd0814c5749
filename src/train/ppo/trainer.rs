//! The loop: play, learn, measure, keep the best.

use crate::asset::dense_layers::DenseLayers;
use crate::asset::policy_contract::{ObservationBlock, PolicyContract};
use crate::math::RandomStream;
use crate::train::nn::{Activation, Adam, Network};
use crate::train::ppo::evaluate::{EvaluationReport, MeanActor, evaluate, row_seed};
use crate::train::ppo::learner::{Learner, UpdateOptions};
use crate::train::ppo::normalizer::Normalizer;
use crate::train::ppo::rollout::{Lanes, POD_ROWS, Player, Pod};
use crate::train::ppo::sampling::StartSampler;
use crate::train::ppo::task::{SkillTask, TaskError};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Instant;

/// Iterations in which only the critic learns where the actor was there before: some hundred updates.
const CRITIC_FIRST: usize = 10;

/// Measured survival from which a motion can be done: what is left is to make it robust.
const ABLE: f64 = 0.9;

/// With how many times the trials a measurement of a policy that may be the best is repeated.
const AGAIN: usize = 3;

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
    /// 90 %), smaller changes of the policy make it robust, larger ones undo as much as they gain.
    pub settled: (f32, f32),
    /// Samples, since the motion can be done, over which they fall.
    pub settle_samples: f64,
    /// Iterations after which the normaliser stays.
    pub normalizer_iterations: usize,
    /// Part of the trials that begin anywhere in the motion and at any of its speeds, 0 to 1; the others begin shortly ahead
    /// of where, and at the speeds at which, trials fail.
    pub even_starts: f64,
    /// Part of the trials that begin exactly as one began that failed within two seconds, once the motion can be done (a
    /// measured survival of 90 %); a start that has been lasted through is forgotten.
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
            sigma: (0.2, 0.08),
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

/// Why training could not begin or go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainError {
    /// The skill's trials cannot be made.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// An option cannot be used.
    #[error("train: {option} is {found}; {valid}")]
    Option {
        /// The option.
        option: &'static str,
        /// What it was.
        found: String,
        /// What would be valid.
        valid: &'static str,
    },
    /// A policy to begin with does not fit this task.
    #[error("policy to begin with: {what} is {found}; valid: {expected}")]
    Start {
        /// What differs.
        what: &'static str,
        /// In the policy.
        found: String,
        /// In the task.
        expected: String,
    },
    /// A checkpoint does not belong to this task.
    #[error("checkpoint: {what} is {found}; the task has {expected}")]
    Checkpoint {
        /// What differs.
        what: &'static str,
        /// In the checkpoint.
        found: String,
        /// In the task.
        expected: String,
    },
}

/// One line of the training curve.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Iteration {
    /// Number, from one.
    pub number: usize,
    /// Control samples so far.
    pub samples: u64,
    /// Seconds of training so far.
    pub seconds: f64,
    /// Mean reward per tick of the trials that ended, with exploration.
    pub reward: f64,
    /// Mean length of those trials, s.
    pub length: f64,
    /// Part of those trials that failed.
    pub failed: f64,
    /// Divergence of the update.
    pub divergence: f32,
    /// Learning rate.
    pub rate: f32,
    /// Standard deviation of the exploration.
    pub sigma: f32,
    /// Critic's mean squared error.
    pub critic_loss: f32,
    /// Measured survival (0 to 1) and reward per tick, where this iteration was measured.
    pub evaluation: Option<(f64, f64)>,
    /// Seconds of this iteration in: simulation, inference, learning.
    pub parts: [f64; 3],
}

/// A policy that can be played.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Trained {
    /// The network.
    pub actor: Network,
    /// Its normaliser.
    pub normalizer: Normalizer,
    /// Measured survival and reward per tick.
    pub evaluation: (f64, f64),
    /// Iteration it comes from.
    pub iteration: usize,
}

/// Whether a policy of this survival and reward is at least as good as another.
fn is_as_good(one: (f64, f64), other: Option<(f64, f64)>) -> bool {
    let score = |e: (f64, f64)| e.0 + 0.5 * e.1;
    other.is_none_or(|o| score(one) >= score(o))
}

/// Everything a training needs to go on later.
#[derive(Serialize, Deserialize)]
struct Checkpoint {
    version: u32,
    skill: String,
    options: TrainOptions,
    actor: Network,
    /// Running mean of the actors; absent in files of older trainings.
    #[serde(default)]
    mean: Option<Network>,
    critic: Network,
    actor_adam: Adam,
    critic_adam: Adam,
    normalizer: Normalizer,
    starts: StartSampler,
    curve: Vec<Iteration>,
    /// Samples since the motion can be done; absent in files of older trainings.
    #[serde(default)]
    able_samples: f64,
    /// Simulated steps of measurements; absent in files of older trainings.
    #[serde(default)]
    measured_steps: f64,
    rate: f32,
    best: Option<Trained>,
}

/// A training under way.
pub struct Trainer {
    task: Arc<SkillTask>,
    rows: Vec<Arc<SkillTask>>,
    options: TrainOptions,
    learner: Learner,
    /// Running mean of the actors.
    mean: Network,
    normalizer: Normalizer,
    starts: StartSampler,
    pods: Vec<Pod>,
    random: RandomStream,
    rate: f32,
    curve: Vec<Iteration>,
    /// Samples since the motion can be done (a measured survival of 90 %).
    able_samples: f64,
    /// Simulated steps of all measurements.
    measured_steps: f64,
    best: Option<Trained>,
    /// The best policy was measured by the training that this one resumes.
    best_from_before: bool,
}

impl Trainer {
    /// Begins a training.
    pub fn new(task: SkillTask, options: TrainOptions) -> Result<Self, TrainError> {
        check(&options)?;
        // Measured as it will be judged and played, at the character's own rate.
        let judged = task.at_rate(task.model.step_rate)?;
        let rows = judged.trials()?.into_iter().map(|(_, row)| row).collect();
        let task = Arc::new(task);
        let (inputs, outputs) = (task.layout.size(), task.action_size());
        let sizes = |last: usize| -> Vec<usize> {
            core::iter::once(inputs).chain(options.hidden.iter().copied()).chain([last]).collect()
        };
        let mut random = RandomStream::new(options.seed, 1);
        let actor = Network::new(&sizes(outputs), Activation::Tanh, 0.01, &mut random);
        let critic = Network::new(&sizes(1), Activation::Tanh, 1.0, &mut random);
        let starts = StartSampler::new(task.motion.last(), task.motion.cycle().is_some(), options.even_starts);
        let mut trainer = Self {
            mean: actor.clone(),
            learner: Learner::new(actor, critic),
            normalizer: Normalizer::new(inputs),
            starts,
            pods: Vec::new(),
            random: RandomStream::new(options.seed, 2),
            rate: options.rate,
            curve: Vec::new(),
            able_samples: 0.0,
            measured_steps: 0.0,
            best: None,
            best_from_before: false,
            rows,
            task,
            options,
        };
        trainer.open_pods(0);
        Ok(trainer)
    }

    /// Begins with a policy that was there before, of this skill or of another (see
    /// [`load_layers`](crate::train::load_layers)). Its normaliser stays; its layers replace [`TrainOptions::hidden`];
    /// the critic learns alone for a while. It is the best policy until a better one is measured.
    pub fn from_policy(
        task: SkillTask,
        mut options: TrainOptions,
        layers: &DenseLayers,
        contract: &PolicyContract,
    ) -> Result<Self, TrainError> {
        let differs = |what, found: String, expected: String| Err(TrainError::Start { what, found, expected });
        let blocks = |blocks: &[ObservationBlock]| -> String {
            blocks.iter().map(|b| format!("{} ({})", b.name, b.size)).collect::<Vec<_>>().join(", ")
        };
        if blocks(&contract.observation) != blocks(&task.layout.blocks) {
            return differs("observation", blocks(&contract.observation), blocks(&task.layout.blocks));
        }
        if contract.character != task.model.name {
            return differs("character", contract.character.clone(), task.model.name.clone());
        }
        if contract.action.scale != task.skill.action_scale {
            let expected = task.skill.action_scale.to_string();
            return differs("scale of the action", contract.action.scale.to_string(), expected);
        }
        let ends = (task.layout.size(), task.action_size());
        if (layers.inputs(), layers.outputs()) != ends {
            return differs("network", format!("{:?}", layers.sizes), format!("{} to {} numbers", ends.0, ends.1));
        }
        let actor = match Network::try_from(layers) {
            Ok(actor) => actor,
            Err(e) => return differs("network", e.to_string(), "layers that can be trained".into()),
        };
        options.hidden = layers.sizes[1..layers.sizes.len() - 1].to_vec();
        options.normalizer_iterations = 0;
        options.critic_first = CRITIC_FIRST;
        let mut trainer = Self::new(task, options)?;
        let known = &contract.normaliser;
        trainer.normalizer = Normalizer::fixed(known.mean.clone(), known.scale.clone(), known.clip);
        trainer.mean = actor.clone();
        trainer.learner = Learner::new(actor, trainer.learner.critic);
        trainer.best = Some(trainer.present());
        trainer.best_from_before = true;
        Ok(trainer)
    }

    /// Goes on from what [`Trainer::checkpoint`] gave. Trials begin anew, so the continuation is not that of an
    /// uninterrupted training, bit for bit. `change` may change the learning options; the layers stay.
    pub fn resume(
        task: SkillTask,
        checkpoint: &str,
        change: impl FnOnce(&mut TrainOptions),
    ) -> Result<Self, TrainError> {
        let broken = |found: String| TrainError::Checkpoint { what: "text", found, expected: "a checkpoint".into() };
        let mut saved: Checkpoint = serde_json::from_str(checkpoint).map_err(|e| broken(e.to_string()))?;
        let smoothness = saved.options.smoothness;
        change(&mut saved.options);
        if saved.options.smoothness != smoothness {
            // The best policy was not learnt for what is asked now.
            saved.best = None;
        }
        let differs = |what, found: &dyn core::fmt::Display, expected: &dyn core::fmt::Display| {
            Err(TrainError::Checkpoint { what, found: found.to_string(), expected: expected.to_string() })
        };
        if saved.version != 1 {
            return differs("version", &saved.version, &1);
        }
        if saved.skill != task.skill.name {
            return differs("skill", &saved.skill, &task.skill.name);
        }
        if saved.actor.inputs() != task.layout.size() || saved.normalizer.shift.len() != task.layout.size() {
            return differs("observation", &saved.actor.inputs(), &task.layout.size());
        }
        if saved.actor.outputs() != task.action_size() {
            return differs("action", &saved.actor.outputs(), &task.action_size());
        }
        if (saved.critic.inputs(), saved.critic.outputs()) != (task.layout.size(), 1) {
            return differs("critic's output", &saved.critic.outputs(), &1);
        }
        if saved.mean.as_ref().is_some_and(|m| m.parameters().len() != saved.actor.parameters().len()) {
            return differs("mean of the actors", &"of other layers", &"of the actor's");
        }
        for (adam, network) in [(&saved.actor_adam, &saved.actor), (&saved.critic_adam, &saved.critic)] {
            if adam.parameters() != network.parameters().len() {
                return differs("optimiser's length", &adam.parameters(), &network.parameters().len());
            }
        }
        let mut trainer = Self::new(task, saved.options)?;
        trainer.mean = saved.mean.unwrap_or_else(|| saved.actor.clone());
        trainer.learner = Learner::new(saved.actor, saved.critic);
        trainer.learner.actor_adam = saved.actor_adam;
        trainer.learner.critic_adam = saved.critic_adam;
        trainer.normalizer = saved.normalizer;
        if saved.starts.fits(&trainer.starts) {
            trainer.starts = saved.starts;
            trainer.starts.set_even(trainer.options.even_starts);
        }
        trainer.curve = saved.curve;
        trainer.able_samples = saved.able_samples;
        trainer.measured_steps = saved.measured_steps;
        trainer.rate = saved.rate;
        trainer.best = saved.best;
        trainer.best_from_before = true;
        let done = trainer.curve.len() as u64;
        trainer.random = RandomStream::new(trainer.options.seed, 2 + (done << 32));
        trainer.open_pods(done);
        Ok(trainer)
    }

    fn open_pods(&mut self, done: u64) {
        let (task, seed, starts) = (&self.task, self.options.seed, &self.starts);
        self.pods = (0..self.options.pods as u64).map(|n| Pod::new(task, seed, n + (done << 32), starts)).collect();
    }

    /// The whole state but the trials under way, as JSON.
    pub fn checkpoint(&self) -> String {
        let saved = Checkpoint {
            version: 1,
            skill: self.task.skill.name.clone(),
            options: self.options.clone(),
            actor: self.learner.actor.clone(),
            mean: Some(self.mean.clone()),
            critic: self.learner.critic.clone(),
            actor_adam: self.learner.actor_adam.clone(),
            critic_adam: self.learner.critic_adam.clone(),
            normalizer: self.normalizer.clone(),
            starts: self.starts.clone(),
            curve: self.curve.clone(),
            able_samples: self.able_samples,
            measured_steps: self.measured_steps,
            rate: self.rate,
            best: self.best.clone(),
        };
        serde_json::to_string(&saved).unwrap_or_default()
    }

    /// The task.
    pub fn task(&self) -> &Arc<SkillTask> {
        &self.task
    }
    /// The curve so far.
    pub fn curve(&self) -> &[Iteration] {
        &self.curve
    }
    /// The best policy so far, by the measurements.
    pub fn best(&self) -> Option<&Trained> {
        self.best.as_ref()
    }
    /// The policy as it is now: the mean of the last actors.
    pub fn present(&self) -> Trained {
        Trained {
            actor: self.mean.clone(),
            normalizer: self.normalizer.clone(),
            evaluation: (0.0, 0.0),
            iteration: self.curve.len(),
        }
    }

    /// One iteration: play, learn, and now and then measure.
    pub fn iterate(&mut self) -> Iteration {
        let began = Instant::now();
        let before = self.curve.last().copied().unwrap_or_default();
        let o = &self.options;
        let faded = (before.samples as f64 / o.sigma_samples).min(1.0) as f32;
        let settled = (self.able_samples / o.settle_samples).min(1.0) as f32;
        let sigma = o.sigma.0 * (o.sigma.1 / o.sigma.0).powf(faded) * o.settled.0.powf(settled);
        let largest_divergence = o.divergence * o.settled.1.powf(settled);

        // Play.
        let player = Player {
            actor: &self.learner.actor,
            critic: &self.learner.critic,
            normalizer: &self.normalizer,
            sigma,
            gamma: o.gamma,
            lambda: o.lambda,
        };
        let (starts, ticks) = (&self.starts, o.ticks);
        let per_thread = self.pods.len().div_ceil(o.threads.max(1));
        std::thread::scope(|scope| {
            for part in self.pods.chunks_mut(per_thread) {
                let player = &player;
                scope.spawn(move || part.iter_mut().for_each(|pod| pod.play(player, ticks, starts)));
            }
        });
        let playing = began.elapsed().as_secs_f64();

        // Learn.
        let learning = Instant::now();
        let critic_only = self.curve.len() < o.critic_first;
        let update = UpdateOptions {
            minibatch: o.minibatch,
            epochs: o.epochs,
            clip: o.clip,
            // The first updates are small: Adam's second moments are not known yet.
            rate: if critic_only { 0.0 } else { self.rate * ((self.curve.len() + 1) as f32 / 8.0).min(1.0) },
            critic_rate: 1e-3,
            largest_divergence,
            largest_gradient: 1.0,
            sigma,
            // What cannot be done yet need not be done smoothly.
            smoothness: o.smoothness * self.starts.ripeness() as f32,
            threads: o.threads,
        };
        let report = self.learner.update(&self.pods, &update, &mut self.random);
        if critic_only {
            // Nothing was learnt about the rate.
        } else if report.divergence > largest_divergence {
            self.rate = (self.rate / 1.2).max(2e-5);
        } else if report.divergence < 0.5 * largest_divergence {
            self.rate = (self.rate * 1.1).min(1e-3);
        }
        // A mean over few iterations at first, so that it does not hold on to the beginning.
        let over = self.options.average.clamp(1, 1 + self.curve.len() / 4) as f32;
        self.mean.approach(&self.learner.actor, over.recip());
        let learning = learning.elapsed().as_secs_f64();

        if self.best.as_ref().is_some_and(|b| b.evaluation.0 >= ABLE) {
            self.able_samples += (self.pods.len() * POD_ROWS * ticks) as f64;
            self.starts.set_again(self.options.hard_starts);
        }
        let counts: Vec<_> = self.pods.iter().map(|p| p.counts.clone()).collect();
        self.starts.add(&counts);
        if self.curve.len() < o.normalizer_iterations {
            for pod in &self.pods {
                self.normalizer.update(&pod.raw);
            }
        }

        let trials: Vec<_> = self.pods.iter().flat_map(|p| &p.trials).collect();
        let ended = trials.len().max(1) as f64;
        let all_ticks: usize = trials.iter().map(|t| t.ticks).sum();
        let shares: (f64, f64) = self.pods.iter().fold((1e-9, 1e-9), |s, p| (s.0 + p.seconds.0, s.1 + p.seconds.1));
        let simulation = playing * shares.0 / (shares.0 + shares.1);
        let number = self.curve.len() + 1;
        let mut iteration = Iteration {
            number,
            samples: before.samples + (self.pods.len() * POD_ROWS * ticks) as u64,
            seconds: before.seconds,
            reward: trials.iter().map(|t| t.reward).sum::<f64>() / all_ticks.max(1) as f64,
            length: all_ticks as f64 / ended / self.task.skill.control_rate,
            failed: trials.iter().filter(|t| t.failed).count() as f64 / ended,
            divergence: report.divergence,
            rate: self.rate,
            sigma,
            critic_loss: report.critic_loss,
            evaluation: None,
            parts: [simulation, playing - simulation, learning],
        };
        if number.is_multiple_of(self.options.evaluate_every.max(1)) && self.may_measure(iteration.samples) {
            if let Some(mut best) = self.best.take_if(|_| self.best_from_before) {
                // The character or the skill may have changed in between.
                best.evaluation = self.measure(&best, number, None);
                self.best = Some(best);
            }
            self.best_from_before = false;
            let mut present = self.present();
            let best = self.best.as_ref().map(|b| b.evaluation);
            present.evaluation = self.measure(&present, number, best);
            iteration.evaluation = Some(present.evaluation);
            if is_as_good(present.evaluation, best) {
                self.best = Some(present);
            }
        }
        iteration.seconds += began.elapsed().as_secs_f64();
        self.curve.push(iteration);
        iteration
    }

    /// Whether the measurements until now left enough to the training, which has that many samples.
    fn may_measure(&self, samples: u64) -> bool {
        let trained = samples as f64 * self.task.steps_per_tick();
        self.measured_steps <= self.options.evaluation_share * (self.measured_steps + trained)
    }

    /// Survival and reward of a policy without exploration, on trials of their own. One that seems to be as good as `best`,
    /// and can do the motion, is tried [`AGAIN`] times as often again: of many policies that are tried shortly, the best
    /// looking is the luckiest.
    fn measure(&mut self, policy: &Trained, number: usize, best: Option<(f64, f64)>) -> (f64, f64) {
        let each = self.options.evaluation_trials.div_ceil(self.rows.len().max(1));
        let seed = self.options.seed ^ (0x6d65_6173 + number as u64);
        let mut whole = self.try_out(policy, each, seed);
        if whole.survival() >= ABLE && is_as_good((whole.survival(), whole.reward), best) {
            whole.add(&self.try_out(policy, AGAIN * each, seed ^ 0x6167_6169_6e00_0000));
        }
        (whole.survival(), whole.reward)
    }

    /// So many trials of each row.
    fn try_out(&mut self, policy: &Trained, each: usize, seed: u64) -> EvaluationReport {
        let actor = MeanActor(&policy.actor, &policy.normalizer);
        let mut whole = EvaluationReport::default();
        for (k, row) in self.rows.iter().enumerate() {
            whole.add(&evaluate::<Lanes, _>(row, &actor, each, row_seed(seed, k), self.options.threads));
        }
        self.measured_steps += whole.ticks as f64 * self.rows[0].steps_per_tick();
        whole
    }
}

fn check(o: &TrainOptions) -> Result<(), TrainError> {
    let bad = |option, found: String, valid| Err(TrainError::Option { option, found, valid });
    if !(1..=256).contains(&o.threads) {
        return bad("threads", o.threads.to_string(), "1 to 256");
    }
    if !(1..=4096).contains(&o.pods) {
        return bad("pods", o.pods.to_string(), "1 to 4096");
    }
    if !(1..=4096).contains(&o.ticks) {
        return bad("ticks", o.ticks.to_string(), "1 to 4096");
    }
    if !(1..=1 << 20).contains(&o.minibatch) {
        return bad("minibatch", o.minibatch.to_string(), "1 to 1048576");
    }
    if o.hidden.is_empty() || o.hidden.len() > 8 || o.hidden.iter().any(|h| !(1..=4096).contains(h)) {
        return bad("hidden", format!("{:?}", o.hidden), "1 to 8 layers of 1 to 4096");
    }
    if !(0.0..1.0).contains(&o.gamma) || !(0.0..=1.0).contains(&o.lambda) {
        return bad("gamma, lambda", format!("{}, {}", o.gamma, o.lambda), "from 0 to 1");
    }
    if !(o.sigma.0 > 0.0 && o.sigma.1 > 0.0 && o.sigma.0.is_finite() && o.sigma.1.is_finite()) {
        return bad("sigma", format!("{:?}", o.sigma), "two positive numbers");
    }
    let factor = |f: f32| f > 0.0 && f <= 1.0;
    if !(factor(o.settled.0) && factor(o.settled.1)) {
        return bad("settled", format!("{:?}", o.settled), "two numbers, more than 0 and up to 1");
    }
    if !(o.smoothness >= 0.0 && o.smoothness.is_finite()) {
        return bad("smoothness", o.smoothness.to_string(), "0 or more");
    }
    let shares =
        [("even_starts", o.even_starts), ("hard_starts", o.hard_starts), ("evaluation_share", o.evaluation_share)];
    for (option, share) in shares {
        if !(0.0..=1.0).contains(&share) {
            return bad(option, share.to_string(), "0 to 1");
        }
    }
    if o.settle_samples.is_nan() || o.settle_samples <= 0.0 {
        return bad("settle_samples", o.settle_samples.to_string(), "more than 0");
    }
    if !(1..=10_000).contains(&o.average) {
        return bad("average", o.average.to_string(), "1 to 10000 iterations");
    }
    Ok(())
}
