//! The loop: play, learn, measure, keep the best.

use crate::asset::dense_layers::DenseLayers;
use crate::asset::policy_contract::PolicyContract;
use crate::asset::policy_fit::PolicyMisfit;
use crate::math::RandomStream;
use crate::skill::Range;
use crate::train::nn::{Activation, Adam, Network};
use crate::train::ppo::error::TrainError;
use crate::train::ppo::evaluate::{EvaluationReport, MeanActor, evaluate, row_seed};
use crate::train::ppo::learner::{Learner, UpdateOptions};
use crate::train::ppo::normalizer::Normalizer;
use crate::train::ppo::options::TrainOptions;
use crate::train::ppo::rollout::{BATCH_ROWS, EnvBatch, Lanes, Player};
use crate::train::ppo::sampling::{SPEED_PARTS, StartSampler};
use crate::train::ppo::task::SkillTask;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Instant;

/// Iterations in which only the critic learns where the actor was there before: some hundred updates.
const CRITIC_FIRST: usize = 10;

/// Least and largest learning rate that the divergence leads to.
const RATES: (f32, f32) = (5e-6, 1e-3);

/// Measured survival from which a motion can be done: what is left is to make it robust.
const ABLE: f64 = 0.9;

/// Survival of its worst row from which a training anneals: smaller changes teach what is missing there more slowly.
const ANNEALS: f64 = 0.8;

/// How much of the count of failures of each row is left after another measurement.
const ROWS_FADE: f64 = 0.8;

/// With how many times the trials a measurement of a policy that may be the best is repeated.
const AGAIN: usize = 3;

/// One line of the training curve.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Iteration {
    /// Number, from one.
    pub number: usize,
    /// Control samples so far.
    pub samples: u64,
    /// Seconds of training so far.
    pub seconds: f64,
    /// Mean reward per tick of the episodes that ended, with exploration.
    pub reward: f64,
    /// Mean length of those episodes, s.
    pub length: f64,
    /// Part of those episodes that were terminated.
    pub failed: f64,
    /// Kullback-Leibler divergence of the update.
    #[serde(alias = "divergence")]
    pub kl: f32,
    /// Learning rate.
    #[serde(alias = "rate")]
    pub learning_rate: f32,
    /// Standard deviation of the exploration.
    #[serde(alias = "sigma")]
    pub action_std: f32,
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

/// Version of the checkpoints that are written. Those of version 1 have older names of the same fields, and are still read.
const CHECKPOINT_VERSION: u32 = 2;

/// The version of any checkpoint.
#[derive(Deserialize)]
struct CheckpointVersion {
    version: u32,
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
    /// Measured trials of each row, and how many of them failed; absent in files of older trainings.
    #[serde(default)]
    measured_rows: Vec<[f64; 2]>,
    #[serde(alias = "rate")]
    learning_rate: f32,
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
    batches: Vec<EnvBatch>,
    random: RandomStream,
    learning_rate: f32,
    curve: Vec<Iteration>,
    /// Samples with which the motion could be done: a measured survival of 90 %, and of [`ANNEALS`] in every row.
    able_samples: f64,
    /// Simulated steps of all measurements.
    measured_steps: f64,
    /// Measured trials of each row, and how many of them failed; old ones fade.
    measured_rows: Vec<[f64; 2]>,
    best: Option<Trained>,
    /// The best policy was measured by the training that this one resumes.
    best_from_before: bool,
}

impl Trainer {
    /// Begins a training.
    pub fn new(task: SkillTask, options: TrainOptions) -> Result<Self, TrainError> {
        options.check()?;
        // Measured as it will be judged and played, at the character's own rate.
        let judged = task.at_play_rate()?;
        let rows: Vec<_> = judged.trials()?.into_iter().map(|(_, row)| row).collect();
        let task = Arc::new(task);
        let (inputs, outputs) = (task.layout.size(), task.action_size());
        let sizes = |last: usize| -> Vec<usize> {
            core::iter::once(inputs).chain(options.hidden.iter().copied()).chain([last]).collect()
        };
        let mut random = RandomStream::new(options.seed, 1);
        let actor = Network::new(&sizes(outputs), Activation::Tanh, 0.01, &mut random);
        let critic = Network::new(&sizes(1), Activation::Tanh, 1.0, &mut random);
        let starts = StartSampler::new(task.motion.last(), task.motion.cycle().is_some(), options.uniform_share);
        let mut trainer = Self {
            mean: actor.clone(),
            learner: Learner::new(actor, critic),
            normalizer: Normalizer::new(inputs),
            starts,
            batches: Vec::new(),
            random: RandomStream::new(options.seed, 2),
            learning_rate: options.learning_rate,
            curve: Vec::new(),
            able_samples: 0.0,
            measured_steps: 0.0,
            measured_rows: vec![[0.0; 2]; rows.len()],
            best: None,
            best_from_before: false,
            rows,
            task,
            options,
        };
        trainer.open_batches(0);
        Ok(trainer)
    }

    /// Begins with a policy that was there before, of this skill or of another (see
    /// [`load_layers`](crate::train::load_layers)). Its normaliser stays; its layers replace [`TrainOptions::hidden`];
    /// the critic learns alone for a while. It is the best policy until a better one is measured. One that sets no servo gains may begin a skill
    /// whose policy does: it leaves them as they are at first.
    pub fn from_policy(
        task: SkillTask,
        mut options: TrainOptions,
        layers: &DenseLayers,
        contract: &PolicyContract,
    ) -> Result<Self, TrainError> {
        let differs =
            |what: &str, found: String, expected: String| Err(TrainError::Start { what: what.into(), found, expected });
        let mut contract = contract.clone();
        let mut layers = layers.clone();
        if contract.action.gains.is_none() {
            contract.action.gains.clone_from(&task.skill.gain_action);
            layers = layers.with_idle_outputs(task.layout.gains.links.len());
        }
        if let Err(PolicyMisfit { field, found, valid }) = contract.check_numbers(&task.skill.policy_use(&task.model)) {
            return Err(TrainError::Start { what: field, found, expected: valid });
        }
        let ends = (task.layout.size(), task.action_size());
        if (layers.inputs(), layers.outputs()) != ends {
            return differs("network", format!("{:?}", layers.sizes), format!("{} to {} numbers", ends.0, ends.1));
        }
        let actor = match Network::try_from(&layers) {
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

    /// Goes on from what [`Trainer::checkpoint`] gave. Episodes begin anew, so the continuation is not that of an
    /// uninterrupted training, bit for bit. `change` may change the learning options; the layers stay.
    pub fn resume(
        task: SkillTask,
        checkpoint: &str,
        change: impl FnOnce(&mut TrainOptions),
    ) -> Result<Self, TrainError> {
        let broken = |found: String| TrainError::Checkpoint { what: "text", found, expected: "a checkpoint".into() };
        let found: CheckpointVersion = serde_json::from_str(checkpoint).map_err(|e| broken(e.to_string()))?;
        if !(1..=CHECKPOINT_VERSION).contains(&found.version) {
            return Err(TrainError::CheckpointVersion { found: found.version, newest: CHECKPOINT_VERSION });
        }
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
            trainer.starts.set_uniform_share(trainer.options.uniform_share);
        }
        trainer.curve = saved.curve;
        trainer.able_samples = saved.able_samples;
        trainer.measured_steps = saved.measured_steps;
        if saved.measured_rows.len() == trainer.rows.len() {
            trainer.measured_rows = saved.measured_rows;
        }
        trainer.learning_rate = saved.learning_rate;
        trainer.best = saved.best;
        trainer.best_from_before = true;
        let done = trainer.curve.len() as u64;
        trainer.random = RandomStream::new(trainer.options.seed, 2 + (done << 32));
        trainer.open_batches(done);
        Ok(trainer)
    }

    fn open_batches(&mut self, done: u64) {
        let (task, seed, starts) = (&self.task, self.options.seed, &self.starts);
        let batch = |n| EnvBatch::new(task, seed, n + (done << 32), starts);
        self.batches = (0..self.options.env_batches as u64).map(batch).collect();
    }

    /// The whole state but the episodes under way, as JSON.
    pub fn checkpoint(&self) -> String {
        let saved = Checkpoint {
            version: CHECKPOINT_VERSION,
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
            measured_rows: self.measured_rows.clone(),
            learning_rate: self.learning_rate,
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
        let faded = self.faded().min(1.0) as f32;
        let annealed = (self.able_samples / o.anneal_samples).min(1.0) as f32;
        let action_std = o.action_std.0 * (o.action_std.1 / o.action_std.0).powf(faded) * o.anneal.0.powf(annealed);
        let largest_kl = o.kl * o.anneal.1.powf(annealed);

        // Play.
        let player = Player {
            actor: &self.learner.actor,
            critic: &self.learner.critic,
            normalizer: &self.normalizer,
            action_std,
            gamma: o.gamma,
            lambda: o.lambda,
            keeps_raw: self.curve.len() < o.normalizer_iterations,
        };
        let (starts, ticks) = (&self.starts, o.ticks);
        let per_thread = self.batches.len().div_ceil(o.threads.max(1));
        std::thread::scope(|scope| {
            for part in self.batches.chunks_mut(per_thread) {
                let player = &player;
                scope.spawn(move || part.iter_mut().for_each(|batch| batch.play(player, ticks, starts)));
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
            learning_rate: if critic_only {
                0.0
            } else {
                self.learning_rate * ((self.curve.len() + 1) as f32 / 8.0).min(1.0)
            },
            critic_rate: 1e-3,
            largest_kl,
            largest_gradient: 1.0,
            action_std,
            // What cannot be done yet need not be done smoothly.
            smoothness: o.smoothness * self.starts.ripeness() as f32,
            threads: o.threads,
        };
        let experience: Vec<_> = self.batches.iter().map(|b| &b.experience).collect();
        let report = self.learner.update(&experience, &update, &mut self.random);
        if critic_only {
            // Nothing was learnt about the rate.
        } else if report.kl > largest_kl {
            self.learning_rate = (self.learning_rate / 1.2).max(RATES.0);
        } else if report.kl < 0.5 * largest_kl {
            self.learning_rate = (self.learning_rate * 1.1).min(RATES.1);
        }
        // A mean over few iterations at first, so that it does not hold on to the beginning.
        let over = self.options.average.clamp(1, 1 + self.curve.len() / 4) as f32;
        self.mean.approach(&self.learner.actor, over.recip());
        let learning = learning.elapsed().as_secs_f64();

        if self.best.as_ref().is_some_and(|b| b.evaluation.0 >= ABLE) {
            self.starts.set_replay_share(self.options.replay_share);
            if self.measured_rows.iter().all(|[trials, failed]| *failed <= (1.0 - ANNEALS) * trials) {
                self.able_samples += (self.batches.len() * BATCH_ROWS * ticks) as f64;
            }
        }
        let counts: Vec<_> = self.batches.iter().map(|b| b.counts.clone()).collect();
        self.starts.add(&counts);
        if self.curve.len() < o.normalizer_iterations {
            for batch in &self.batches {
                self.normalizer.update(&batch.raw);
            }
        }

        let episodes: Vec<_> = self.batches.iter().flat_map(|b| &b.episodes).collect();
        let ended = episodes.len().max(1) as f64;
        let all_ticks: usize = episodes.iter().map(|t| t.ticks).sum();
        let shares: (f64, f64) = self.batches.iter().fold((1e-9, 1e-9), |s, b| (s.0 + b.seconds.0, s.1 + b.seconds.1));
        let simulation = playing * shares.0 / (shares.0 + shares.1);
        let number = self.curve.len() + 1;
        let mut iteration = Iteration {
            number,
            samples: before.samples + (self.batches.len() * BATCH_ROWS * ticks) as u64,
            seconds: before.seconds,
            reward: episodes.iter().map(|t| t.reward).sum::<f64>() / all_ticks.max(1) as f64,
            length: all_ticks as f64 / ended / self.task.skill.control_rate,
            failed: episodes.iter().filter(|t| t.failed).count() as f64 / ended,
            kl: report.kl,
            learning_rate: self.learning_rate,
            action_std,
            critic_loss: report.critic_loss,
            evaluation: None,
            parts: [simulation, playing - simulation, learning],
        };
        if number.is_multiple_of(self.options.evaluate_every.max(1)) && self.may_measure(iteration.samples) {
            if let Some(mut best) = self.best.take_if(|_| self.best_from_before) {
                // The character or the skill may have changed in between.
                best.evaluation = overall(&self.measure(&best, number, None));
                self.best = Some(best);
            }
            self.best_from_before = false;
            let mut present = self.present();
            let best = self.best.as_ref().map(|b| b.evaluation);
            let rows = self.measure(&present, number, best);
            self.note_rows(&rows);
            present.evaluation = overall(&rows);
            iteration.evaluation = Some(present.evaluation);
            if is_as_good(present.evaluation, best) {
                self.best = Some(present);
            }
        }
        iteration.seconds += began.elapsed().as_secs_f64();
        self.curve.push(iteration);
        iteration
    }

    /// How far exploration has fallen, from 0 to 1 and beyond.
    fn faded(&self) -> f64 {
        let (slow, fast) = (self.options.action_std_samples.recip(), self.options.action_std_able_samples.recip());
        let mut before = 0;
        let part = |i: &Iteration| {
            let samples = (i.samples - core::mem::replace(&mut before, i.samples)) as f64;
            samples * (slow * i.failed + fast * (1.0 - i.failed))
        };
        self.curve.iter().map(part).sum()
    }

    /// Whether the measurements until now left enough to the training, which has that many samples.
    fn may_measure(&self, samples: u64) -> bool {
        let trained = samples as f64 * self.task.steps_per_tick();
        self.measured_steps <= self.options.evaluation_share * (self.measured_steps + trained)
    }

    /// What a policy does without exploration on trials of their own, row by row. One that seems to be as good as `best`, and
    /// can do the motion, is tried [`AGAIN`] times as often again: of many policies that are tried shortly, the best
    /// looking is the luckiest.
    fn measure(&mut self, policy: &Trained, number: usize, best: Option<(f64, f64)>) -> Vec<EvaluationReport> {
        let each = self.options.evaluation_trials.div_ceil(self.rows.len().max(1));
        let seed = self.options.seed ^ (0x6d65_6173 + number as u64);
        let mut rows = self.try_out(policy, each, seed);
        let found = overall(&rows);
        if found.0 >= ABLE && is_as_good(found, best) {
            for (row, more) in rows.iter_mut().zip(self.try_out(policy, AGAIN * each, seed ^ 0x6167_6169_6e00_0000)) {
                row.add(&more);
            }
        }
        rows
    }

    /// So many trials of each row.
    fn try_out(&mut self, policy: &Trained, each: usize, seed: u64) -> Vec<EvaluationReport> {
        let actor = MeanActor(&policy.actor, &policy.normalizer);
        let tried = |(k, row): (usize, &Arc<SkillTask>)| {
            evaluate::<Lanes, _>(row, &actor, each, row_seed(seed, k), self.options.threads)
        };
        let rows: Vec<_> = self.rows.iter().enumerate().map(tried).collect();
        let ticks: usize = rows.iter().map(|r| r.ticks).sum();
        self.measured_steps += ticks as f64 * self.rows[0].steps_per_tick();
        rows
    }

    /// Trials begin more often at the speeds of rows that fail more often than the others.
    fn note_rows(&mut self, rows: &[EvaluationReport]) {
        for (count, row) in self.measured_rows.iter_mut().zip(rows) {
            let new = [row.trials as f64, (row.trials - row.survived) as f64];
            *count = [0, 1].map(|k| count[k] * ROWS_FADE + new[k]);
        }
        let drawn = self.task.drawn_speeds();
        let tried: Vec<_> = self.rows.iter().map(|row| row.drawn_speeds()).collect();
        self.starts.weigh_speeds(speed_weights(drawn, &tried, &self.measured_rows));
    }
}

/// Survival and reward over all rows.
fn overall(rows: &[EvaluationReport]) -> (f64, f64) {
    let mut whole = EvaluationReport::default();
    rows.iter().for_each(|row| whole.add(row));
    (whole.survival(), whole.reward)
}

/// How much more than the mean measured trials fail at each part of the speeds that trainings draw, from the speeds that each
/// row draws and its trials and failures.
fn speed_weights(drawn: Range, tried: &[Range], counts: &[[f64; 2]]) -> [f64; SPEED_PARTS] {
    let width = (drawn.1 - drawn.0) / SPEED_PARTS as f64;
    let rates: [f64; SPEED_PARTS] = core::array::from_fn(|k| {
        let (low, high) = (drawn.0 + k as f64 * width, drawn.0 + (k + 1) as f64 * width);
        let (mut all, mut failed) = (0.0, 0.0);
        for (range, [trials, failures]) in tried.iter().zip(counts) {
            // Of the row's trials, those at this part.
            let part = (range.1.min(high) - range.0.max(low)).max(0.0) / (range.1 - range.0).max(1e-9);
            all += part * trials;
            failed += part * failures;
        }
        // One failure more in 100 trials: few trials say little.
        (failed + 1.0) / (all + 100.0)
    });
    let mean = rates.iter().sum::<f64>() / SPEED_PARTS as f64;
    rates.map(|rate| rate / mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_fails_weighs_the_speeds_that_it_draws() {
        let rows: Vec<Range> = (0..5).map(|k| (0.9 * k as f64, 0.9 * (k + 1) as f64)).collect();
        let mut counts = [[300.0, 0.0]; 5];
        counts[0] = [300.0, 57.0];
        let weights = speed_weights((0.0, 4.5), &rows, &counts);
        // A third of the row's trials at each of its three parts: 20 of 200 against 1 of 200.
        assert!((weights[2] / weights[3] - 20.0).abs() < 1e-9, "{weights:?}");
        assert!((weights[0] / weights[14] - 20.0).abs() < 1e-9, "{weights:?}");
        assert!((weights.iter().sum::<f64>() - SPEED_PARTS as f64).abs() < 1e-9);
        // A row that draws all speeds tells nothing about any of them, nor does one of a single speed, or no trial.
        let even = |drawn, rows: &[Range], counts: &[[f64; 2]]| {
            speed_weights(drawn, rows, counts).iter().all(|w| (w - 1.0).abs() < 1e-9)
        };
        assert!(even((0.0, 2.5), &[(0.0, 2.5), (0.0, 2.5)], &[[100.0, 1.0], [100.0, 30.0]]));
        assert!(even((2.0, 2.0), &[(2.0, 2.0)], &[[100.0, 30.0]]));
        assert!(even((0.0, 4.5), &rows, &[[0.0; 2]; 5]));
    }
}
