//! The update of actor and critic: proximal policy optimisation.
//!
//! Schulman, Wolski, Dhariwal, Radford, Klimov 2017, "Proximal Policy Optimization Algorithms", equation 7: with the ratio
//! `r = p(a|s) / p_old(a|s)` and the advantage A, the actor maximises `min(r A, clip(r, 1 - e, 1 + e) A)`. The policy is a
//! Gaussian around the network's output with a standard deviation given from outside, so
//! `d log p / d mean = (a - mean) / std^2`. The critic's loss is half the squared error of the return.
//!
//! A policy that shakes gains nothing by it: half the squared distance of the mean action to the old ones at the ticks before
//! and after is added to the loss, by a weight (Mysore et al. 2021, equation 2, with the neighbours' actions as constants).

use crate::math::RandomStream;
use crate::train::nn::{Activations, Adam, Batch, LaidOut, Network, clip_norm};
use crate::train::ppo::experience::Experience;

/// Rows whose gradients are computed by one thread at a time; fixed, so that sums do not depend on the threads.
const SHARD: usize = 256;

/// Numbers of the update.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UpdateOptions {
    pub minibatch: usize,
    pub epochs: usize,
    pub clip: f32,
    pub learning_rate: f32,
    pub critic_rate: f32,
    pub largest_kl: f32,
    pub largest_gradient: f32,
    pub action_std: f32,
    pub smoothness: f32,
    pub threads: usize,
}

/// What an update did.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct UpdateReport {
    /// Mean Kullback-Leibler divergence of the last minibatch from the old policy.
    pub kl: f32,
    /// Part of the ratios that were clipped.
    pub clipped: f32,
    /// Mean squared error of the critic.
    pub critic_loss: f32,
    /// Updates made.
    pub updates: usize,
}

/// Rows of a minibatch side by side, and the gradients of one shard.
#[derive(Default)]
struct Shard {
    actor_scratch: Activations,
    critic_scratch: Activations,
    observations: Batch,
    d_mean: Vec<f32>,
    d_value: Vec<f32>,
    actor_gradient: Vec<f32>,
    critic_gradient: Vec<f32>,
    kl: f32,
    clipped: f32,
    critic_loss: f32,
}

/// Actor, critic, their optimisers and work space.
pub(crate) struct Learner {
    pub actor: Network,
    pub critic: Network,
    pub actor_adam: Adam,
    pub critic_adam: Adam,
    actor_weights: LaidOut,
    critic_weights: LaidOut,
    shards: Vec<Shard>,
}

impl Learner {
    pub fn new(actor: Network, critic: Network) -> Self {
        let (a, c) = (actor.parameters().len(), critic.parameters().len());
        Self {
            actor_adam: Adam::new(a),
            critic_adam: Adam::new(c),
            actor,
            critic,
            actor_weights: LaidOut::default(),
            critic_weights: LaidOut::default(),
            shards: Vec::new(),
        }
    }

    /// Goes over the batches' experience `epochs` times in minibatches.
    pub fn update(
        &mut self,
        experience: &[&Experience],
        options: &UpdateOptions,
        random: &mut RandomStream,
    ) -> UpdateReport {
        let per_batch = experience[0].rows();
        let total = per_batch * experience.len();
        let (mean, deviation) = moments(experience);
        let mut order: Vec<u32> = (0..total as u32).collect();
        let minibatch = options.minibatch.min(total);
        let shards = minibatch.div_ceil(SHARD);
        self.shards.resize_with(shards, Shard::default);
        self.actor_weights.update(&self.actor);
        self.critic_weights.update(&self.critic);
        let mut report = UpdateReport::default();
        'epochs: for _ in 0..options.epochs {
            for k in (1..total).rev() {
                order.swap(k, random.below(k + 1));
            }
            for batch in order.chunks_exact(minibatch) {
                let networks = [(&self.actor, &self.actor_weights), (&self.critic, &self.critic_weights)];
                let threads = options.threads.clamp(1, shards);
                let per_thread = shards.div_ceil(threads);
                let work = |first: usize, part: &mut [Shard]| {
                    for (k, shard) in part.iter_mut().enumerate() {
                        let from = (first + k) * SHARD;
                        let rows = &batch[from..(from + SHARD).min(batch.len())];
                        shard.run(networks, experience, per_batch, rows, batch.len(), (mean, deviation), options);
                    }
                };
                std::thread::scope(|scope| {
                    let mut parts = self.shards.chunks_mut(per_thread).enumerate();
                    let mine = parts.next();
                    for (n, part) in parts {
                        scope.spawn(move || work(n * per_thread, part));
                    }
                    if let Some((n, part)) = mine {
                        work(n * per_thread, part);
                    }
                });
                let total = |of: fn(&Shard) -> f32| self.shards.iter().map(of).sum::<f32>();
                report.kl = total(|s| s.kl);
                report.clipped = total(|s| s.clipped);
                report.critic_loss = total(|s| s.critic_loss);
                if report.kl > options.largest_kl {
                    break 'epochs;
                }
                let (mut of_actor, mut of_critic): (Vec<_>, Vec<_>) =
                    self.shards.iter_mut().map(|s| (&mut s.actor_gradient[..], &mut s.critic_gradient[..])).unzip();
                let (actor, adam, weights) = (&mut self.actor, &mut self.actor_adam, &mut self.actor_weights);
                let mut actor =
                    || descend(actor, adam, weights, &mut of_actor, options.learning_rate, options.largest_gradient);
                let (critic, adam, weights) = (&mut self.critic, &mut self.critic_adam, &mut self.critic_weights);
                let mut critic =
                    || descend(critic, adam, weights, &mut of_critic, options.critic_rate, options.largest_gradient);
                let descended = std::thread::scope(|scope| {
                    if threads == 1 {
                        return [actor(), critic()];
                    }
                    let critic = scope.spawn(critic);
                    // A panic in the thread is passed on.
                    [actor(), critic.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))]
                });
                if descended != [true; 2] {
                    break 'epochs;
                }
                report.updates += 1;
            }
        }
        report
    }
}

/// One step of a network against the sum of its shards' gradients; false, and no step, where that is no number.
fn descend(
    network: &mut Network,
    adam: &mut Adam,
    weights: &mut LaidOut,
    gradients: &mut [&mut [f32]],
    rate: f32,
    largest: f32,
) -> bool {
    let Some((sum, rest)) = gradients.split_first_mut() else { return false };
    rest.iter().for_each(|part| add(sum, part));
    if !clip_norm(&mut [&mut **sum], largest).is_finite() {
        return false;
    }
    adam.step(network.parameters_mut(), sum, rate);
    weights.update(network);
    true
}

fn add(sum: &mut [f32], part: &[f32]) {
    for (a, b) in sum.iter_mut().zip(part) {
        *a += b;
    }
}

/// Mean and standard deviation of all advantages.
fn moments(experience: &[&Experience]) -> (f32, f32) {
    let (mut n, mut sum, mut square) = (0.0, 0.0, 0.0);
    for a in experience.iter().flat_map(|e| &e.advantages) {
        let a = f64::from(*a);
        n += 1.0;
        sum += a;
        square += a * a;
    }
    let mean = sum / n;
    (mean as f32, (square / n - mean * mean).max(1e-12).sqrt() as f32)
}

impl Shard {
    /// Gradients of these rows; `count` is the size of the whole minibatch.
    fn run(
        &mut self,
        [(actor, actor_weights), (critic, critic_weights)]: [(&Network, &LaidOut); 2],
        experience: &[&Experience],
        per_batch: usize,
        rows: &[u32],
        count: usize,
        (mean, deviation): (f32, f32),
        options: &UpdateOptions,
    ) {
        let (inputs, outputs) = (actor.inputs(), actor.outputs());
        let observation = |&row: &u32| {
            let (own, at) = (experience[row as usize / per_batch], row as usize % per_batch);
            &own.observations[at * inputs..(at + 1) * inputs]
        };
        self.observations.gather(rows.iter().map(observation), inputs);
        self.actor_gradient.clear();
        self.actor_gradient.resize(actor.parameters().len(), 0.0);
        self.critic_gradient.clear();
        self.critic_gradient.resize(critic.parameters().len(), 0.0);
        (self.kl, self.clipped, self.critic_loss) = (0.0, 0.0, 0.0);
        let share = 1.0 / count as f32;
        let precision = 1.0 / (options.action_std * options.action_std);

        let out = actor.forward_batch(actor_weights, &mut self.actor_scratch, &self.observations);
        self.d_mean.clear();
        for (k, &row) in rows.iter().enumerate() {
            let (own, at) = (experience[row as usize / per_batch], row as usize % per_batch);
            let action = &own.actions[at * outputs..(at + 1) * outputs];
            let mine = &out[k * outputs..(k + 1) * outputs];
            let square: f32 = action.iter().zip(mine).map(|(a, m)| (a - m) * (a - m)).sum();
            let log_ratio = -0.5 * precision * square - own.log_probabilities[at];
            let ratio = log_ratio.clamp(-20.0, 20.0).exp();
            let advantage = (own.advantages[at] - mean) / (deviation + 1e-6);
            // The unclipped term is the smaller one unless the ratio has left the interval in the advantage's direction.
            let outside =
                (advantage > 0.0 && ratio > 1.0 + options.clip) || (advantage < 0.0 && ratio < 1.0 - options.clip);
            let factor = if outside { 0.0 } else { -ratio * advantage * precision * share };
            let from = self.d_mean.len();
            self.d_mean.extend(action.iter().zip(mine).map(|(a, m)| factor * (a - m)));
            if options.smoothness > 0.0 {
                for other in own.neighbours(at).into_iter().flatten() {
                    let theirs = &own.means[other * outputs..(other + 1) * outputs];
                    for ((d, m), t) in self.d_mean[from..].iter_mut().zip(mine).zip(theirs) {
                        *d += options.smoothness * share * (m - t);
                    }
                }
            }
            // Schulman's estimate of the Kullback-Leibler divergence: always positive, small variance.
            self.kl += (ratio - 1.0 - log_ratio) * share;
            self.clipped += f32::from(u8::from(outside)) * share;
        }
        let (batch, gradient) = (&self.observations, &mut self.actor_gradient);
        actor.backward_batch(actor_weights, &mut self.actor_scratch, batch, &self.d_mean, gradient);

        let out = critic.forward_batch(critic_weights, &mut self.critic_scratch, &self.observations);
        self.d_value.clear();
        for (k, &row) in rows.iter().enumerate() {
            let (own, at) = (experience[row as usize / per_batch], row as usize % per_batch);
            let error = out[k] - own.returns[at];
            self.critic_loss += error * error * share;
            self.d_value.push(error * share);
        }
        let (batch, gradient) = (&self.observations, &mut self.critic_gradient);
        critic.backward_batch(critic_weights, &mut self.critic_scratch, batch, &self.d_value, gradient);
    }
}
