//! Gathering experience: pods of environments play with the present policy.

use crate::math::{F32x8Fused, RandomStream, Real};
use crate::train::nn::{Activations, Network};
use crate::train::ppo::environment::{Ending, Environment, Trial};
use crate::train::ppo::normalizer::Normalizer;
use crate::train::ppo::sampling::{StartCounts, StartSampler};
use crate::train::ppo::task::SkillTask;
use std::sync::Arc;

/// The lane type of training.
pub(crate) type Lanes = F32x8Fused;
/// Environments in a pod.
const BATCHES: usize = 8;
/// Trials that a pod runs at once.
pub(crate) const POD_ROWS: usize = BATCHES * Lanes::LANES;

/// What a policy is made of while it learns.
pub(crate) struct Player<'a> {
    pub actor: &'a Network,
    pub critic: &'a Network,
    pub normalizer: &'a Normalizer,
    /// Standard deviation of the exploration.
    pub sigma: f32,
    pub gamma: f32,
    pub lambda: f32,
    /// Observations are also kept as they were seen, for the normaliser.
    pub keeps_raw: bool,
}

/// One pod: its trials, and the experience of the last rollout (tick by tick, `POD_ROWS` rows each).
pub(crate) struct Pod {
    environments: Vec<Environment<Lanes>>,
    random: RandomStream,
    actor_scratch: Activations,
    critic_scratch: Activations,
    pub observations: Vec<f32>,
    /// Observations as they were seen, where the normaliser still learns.
    pub raw: Vec<f32>,
    pub actions: Vec<f32>,
    /// The actions without exploration.
    pub means: Vec<f32>,
    pub log_probabilities: Vec<f32>,
    pub values: Vec<f32>,
    pub advantages: Vec<f32>,
    pub returns: Vec<f32>,
    rewards: Vec<f32>,
    /// 1 where the next tick belongs to the same trial.
    goes_on: Vec<f32>,
    pub trials: Vec<Trial>,
    pub counts: StartCounts,
    /// Seconds spent in the simulation and in the networks.
    pub seconds: (f64, f64),
}

impl Pod {
    pub fn new(task: &Arc<SkillTask>, seed: u64, number: u64, starts: &StartSampler) -> Self {
        let environments = (0..BATCHES as u64)
            .map(|k| Environment::new(task.clone(), seed, 1_000 + number * 64 + k, starts))
            .collect();
        Self {
            environments,
            random: RandomStream::new(seed, 500 + number),
            actor_scratch: Activations::default(),
            critic_scratch: Activations::default(),
            observations: Vec::new(),
            raw: Vec::new(),
            actions: Vec::new(),
            means: Vec::new(),
            log_probabilities: Vec::new(),
            values: Vec::new(),
            advantages: Vec::new(),
            returns: Vec::new(),
            rewards: Vec::new(),
            goes_on: Vec::new(),
            trials: Vec::new(),
            counts: starts.counts(),
            seconds: (0.0, 0.0),
        }
    }

    /// Plays `ticks` ticks.
    pub fn play(&mut self, player: &Player<'_>, ticks: usize, starts: &StartSampler) {
        let (inputs, outputs) = (player.actor.inputs(), player.actor.outputs());
        let rows = POD_ROWS;
        self.observations.resize(ticks * rows * inputs, 0.0);
        self.raw.clear();
        self.actions.resize(ticks * rows * outputs, 0.0);
        self.means.resize(ticks * rows * outputs, 0.0);
        for buffer in [
            &mut self.log_probabilities,
            &mut self.values,
            &mut self.rewards,
            &mut self.goes_on,
            &mut self.advantages,
            &mut self.returns,
        ] {
            buffer.resize(ticks * rows, 0.0);
        }
        self.trials.clear();
        self.counts = starts.counts();
        self.seconds = (0.0, 0.0);
        let mut clock = std::time::Instant::now();
        for tick in 0..ticks {
            let span = tick * rows * inputs..(tick + 1) * rows * inputs;
            let observation = &mut self.observations[span];
            for (env, part) in self.environments.iter_mut().zip(observation.chunks_exact_mut(Lanes::LANES * inputs)) {
                env.observe(part);
            }
            if player.keeps_raw {
                self.raw.extend_from_slice(observation);
            }
            player.normalizer.apply(observation);
            self.seconds.0 += lap(&mut clock);

            let at = tick * rows..(tick + 1) * rows;
            self.values[at.clone()].copy_from_slice(player.critic.forward(&mut self.critic_scratch, observation, rows));
            let mean = player.actor.forward(&mut self.actor_scratch, observation, rows);
            self.means[tick * rows * outputs..(tick + 1) * rows * outputs].copy_from_slice(mean);
            let actions = &mut self.actions[tick * rows * outputs..(tick + 1) * rows * outputs];
            for row in 0..rows {
                let mut square = 0.0;
                for k in row * outputs..(row + 1) * outputs {
                    let z = self.random.normal() as f32;
                    actions[k] = mean[k] + player.sigma * z;
                    square += z * z;
                }
                self.log_probabilities[tick * rows + row] = -0.5 * square;
            }
            self.seconds.1 += lap(&mut clock);

            let per = Lanes::LANES;
            for (b, env) in self.environments.iter_mut().enumerate() {
                let outcomes = env.tick(&actions[b * per * outputs..(b + 1) * per * outputs]);
                for (lane, outcome) in outcomes.into_iter().enumerate() {
                    let row = tick * rows + b * per + lane;
                    let failed = outcome.ending == Ending::Failed;
                    self.counts.visit(env.tracker.tick(lane), env.speed_part(lane), failed);
                    // Rewards are scaled so that values stay near one.
                    let mut reward = outcome.reward as f32 * (1.0 - player.gamma);
                    if outcome.ending == Ending::TimeUp {
                        // The trial would have gone on: the value of what follows is about that of now.
                        reward += player.gamma * self.values[row];
                    }
                    self.rewards[row] = reward;
                    self.goes_on[row] = f32::from(u8::from(outcome.ending == Ending::GoesOn));
                    if outcome.ending != Ending::GoesOn {
                        self.trials.push(env.trial(lane, outcome.ending));
                        env.reset(lane, starts);
                    }
                }
            }
            self.seconds.0 += lap(&mut clock);
        }

        // What comes after the last tick.
        let mut after = vec![0.0; rows * inputs];
        for (env, part) in self.environments.iter_mut().zip(after.chunks_exact_mut(Lanes::LANES * inputs)) {
            env.observe(part);
        }
        player.normalizer.apply(&mut after);
        let mut next_value = player.critic.forward(&mut self.critic_scratch, &after, rows).to_vec();
        self.estimate_advantages(player, ticks, &mut next_value);
        self.seconds.1 += lap(&mut clock);
    }

    /// Generalised advantage estimation (Schulman, Moritz, Levine, Jordan, Abbeel 2016, equation 16), backwards.
    fn estimate_advantages(&mut self, player: &Player<'_>, ticks: usize, next_value: &mut [f32]) {
        let rows = POD_ROWS;
        let mut advantage = vec![0.0_f32; rows];
        for tick in (0..ticks).rev() {
            for row in 0..rows {
                let at = tick * rows + row;
                let on = self.goes_on[at];
                let delta = self.rewards[at] + player.gamma * next_value[row] * on - self.values[at];
                advantage[row] = delta + player.gamma * player.lambda * on * advantage[row];
                self.advantages[at] = advantage[row];
                self.returns[at] = advantage[row] + self.values[at];
                next_value[row] = self.values[at];
            }
        }
    }

    /// The rows before and after a row that belong to the same trial.
    pub fn neighbours(&self, row: usize) -> [Option<usize>; 2] {
        let goes_on = |from: usize| self.goes_on[from] > 0.0;
        let before = row.checked_sub(POD_ROWS).filter(|b| goes_on(*b));
        let after = Some(row + POD_ROWS).filter(|a| *a < self.rows() && goes_on(row));
        [before, after]
    }

    pub fn rows(&self) -> usize {
        self.values.len()
    }
}

fn lap(clock: &mut std::time::Instant) -> f64 {
    let now = std::time::Instant::now();
    let seconds = now.duration_since(*clock).as_secs_f64();
    *clock = now;
    seconds
}
