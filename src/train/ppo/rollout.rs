//! Gathering experience: batches of environments play with the present policy.

use crate::math::{F32x8Fused, RandomStream, Real};
use crate::train::nn::{Activations, Network};
use crate::train::ppo::environment::{Environment, Episode, EpisodeStatus, Outcome};
use crate::train::ppo::experience::Experience;
use crate::train::ppo::normalizer::Normalizer;
use crate::train::ppo::sampling::{StartCounts, StartSampler};
use crate::train::ppo::task::SkillTask;
use std::sync::Arc;

/// The lane type of training.
pub(crate) type Lanes = F32x8Fused;
/// Environments in a batch.
const ENVIRONMENTS: usize = 8;
/// Episodes that a batch runs at once.
pub(crate) const BATCH_ROWS: usize = ENVIRONMENTS * Lanes::LANES;

/// What a policy is made of while it learns.
pub(crate) struct Player<'a> {
    pub actor: &'a Network,
    pub critic: &'a Network,
    pub normalizer: &'a Normalizer,
    /// Standard deviation of the exploration.
    pub action_std: f32,
    pub gamma: f32,
    pub lambda: f32,
    /// Observations are also kept as they were seen, for the normaliser.
    pub keeps_raw: bool,
}

/// What a rollout needs of an environment: episodes side by side in lanes, a row of numbers each.
pub(crate) trait EpisodeLanes {
    /// Episodes at once.
    fn lanes(&self) -> usize;
    /// Writes what each lane sees (lanes x size). It changes nothing that a later tick or look would show.
    fn observe(&mut self, rows: &mut [f32]);
    /// One tick of every lane under these actions (lanes x size).
    fn tick(&mut self, actions: &[f32]) -> Vec<Outcome>;
    /// Where a lane is: its tick of the motion and its part (0 to 1) of the range of speeds.
    fn place(&self, lane: usize) -> (usize, f64);
    /// The episode of a lane that ended so.
    fn episode(&self, lane: usize, status: EpisodeStatus) -> Episode;
    /// Begins a lane's next episode.
    fn reset(&mut self, lane: usize, starts: &StartSampler);
}

impl<R: Real> EpisodeLanes for Environment<R> {
    fn lanes(&self) -> usize {
        R::LANES
    }
    fn observe(&mut self, rows: &mut [f32]) {
        Environment::observe(self, rows);
    }
    fn tick(&mut self, actions: &[f32]) -> Vec<Outcome> {
        Environment::tick(self, actions)
    }
    fn place(&self, lane: usize) -> (usize, f64) {
        (self.tracker.tick(lane), self.speed_part(lane))
    }
    fn episode(&self, lane: usize, status: EpisodeStatus) -> Episode {
        Environment::episode(self, lane, status)
    }
    fn reset(&mut self, lane: usize, starts: &StartSampler) {
        Environment::reset(self, lane, starts);
    }
}

/// Environments that one thread plays together, and what they saw in the last rollout.
pub(crate) struct EnvBatch<E = Environment<Lanes>> {
    environments: Vec<E>,
    random: RandomStream,
    actor_scratch: Activations,
    critic_scratch: Activations,
    pub experience: Experience,
    /// Observations as they were seen, where the normaliser still learns.
    pub raw: Vec<f32>,
    /// Last observations of truncated episodes, and the rows after which they were made.
    last_seen: (Vec<f32>, Vec<usize>),
    /// What all lanes of an environment see where one of them was truncated.
    seen: Vec<f32>,
    pub episodes: Vec<Episode>,
    pub counts: StartCounts,
    /// Seconds spent in the simulation and in the networks.
    pub seconds: (f64, f64),
}

impl EnvBatch {
    pub fn new(task: &Arc<SkillTask>, seed: u64, number: u64, starts: &StartSampler) -> Self {
        let environments = (0..ENVIRONMENTS as u64)
            .map(|k| Environment::new(task.clone(), seed, 1_000 + number * 64 + k, starts))
            .collect();
        Self::of(environments, RandomStream::new(seed, 500 + number), starts)
    }
}

impl<E: EpisodeLanes> EnvBatch<E> {
    /// A batch of these environments, all with the same number of lanes; `random` explores.
    pub fn of(environments: Vec<E>, random: RandomStream, starts: &StartSampler) -> Self {
        Self {
            environments,
            random,
            actor_scratch: Activations::default(),
            critic_scratch: Activations::default(),
            experience: Experience::default(),
            raw: Vec::new(),
            last_seen: (Vec::new(), Vec::new()),
            seen: Vec::new(),
            episodes: Vec::new(),
            counts: starts.counts(),
            seconds: (0.0, 0.0),
        }
    }

    /// Episodes that run at once.
    pub fn width(&self) -> usize {
        self.environments.iter().map(E::lanes).sum()
    }

    /// Plays `ticks` ticks.
    pub fn play(&mut self, player: &Player<'_>, ticks: usize, starts: &StartSampler) {
        let (inputs, outputs) = (player.actor.inputs(), player.actor.outputs());
        let rows = self.width();
        self.experience.reshape(ticks, rows, inputs, outputs);
        self.raw.clear();
        self.last_seen.0.clear();
        self.last_seen.1.clear();
        self.episodes.clear();
        self.counts = starts.counts();
        self.seconds = (0.0, 0.0);
        let mut clock = std::time::Instant::now();
        for tick in 0..ticks {
            let experience = &mut self.experience;
            let observation = &mut experience.observations[tick * rows * inputs..(tick + 1) * rows * inputs];
            observe(&mut self.environments, observation, inputs);
            if player.keeps_raw {
                self.raw.extend_from_slice(observation);
            }
            player.normalizer.apply(observation);
            self.seconds.0 += lap(&mut clock);

            let values = player.critic.forward(&mut self.critic_scratch, observation, rows);
            experience.values[tick * rows..(tick + 1) * rows].copy_from_slice(values);
            let mean = player.actor.forward(&mut self.actor_scratch, observation, rows);
            experience.means[tick * rows * outputs..(tick + 1) * rows * outputs].copy_from_slice(mean);
            let actions = &mut experience.actions[tick * rows * outputs..(tick + 1) * rows * outputs];
            for row in 0..rows {
                let mut square = 0.0;
                for k in row * outputs..(row + 1) * outputs {
                    let z = self.random.normal() as f32;
                    actions[k] = mean[k] + player.action_std * z;
                    square += z * z;
                }
                experience.log_probabilities[tick * rows + row] = -0.5 * square;
            }
            self.seconds.1 += lap(&mut clock);

            self.tick(player.gamma, tick, starts, inputs, outputs);
            self.seconds.0 += lap(&mut clock);
        }

        // The states that the last tick led to, and those in which episodes were truncated.
        self.seen.resize(rows * inputs, 0.0);
        observe(&mut self.environments, &mut self.seen, inputs);
        player.normalizer.apply(&mut self.seen);
        let mut next_values = player.critic.forward(&mut self.critic_scratch, &self.seen, rows).to_vec();
        let (last_seen, after) = &mut self.last_seen;
        player.normalizer.apply(last_seen);
        for (seen, after) in last_seen.chunks(rows * inputs).zip(after.chunks(rows)) {
            let values = player.critic.forward(&mut self.critic_scratch, seen, after.len());
            for (row, value) in after.iter().zip(values) {
                self.experience.final_values[*row] = *value;
            }
        }
        self.experience.estimate_advantages(player.gamma, player.lambda, &mut next_values);
        self.seconds.1 += lap(&mut clock);
    }

    /// One tick of all environments under the actions of the experience's tick `tick`; lanes that ended begin anew.
    fn tick(&mut self, gamma: f32, tick: usize, starts: &StartSampler, inputs: usize, outputs: usize) {
        let mut first = tick * self.width();
        for env in &mut self.environments {
            let lanes = env.lanes();
            let outcomes = env.tick(&self.experience.actions[first * outputs..(first + lanes) * outputs]);
            if outcomes.iter().any(|o| o.status == EpisodeStatus::Truncated) {
                // The last state has to be seen before any lane is put elsewhere.
                self.seen.resize(lanes * inputs, 0.0);
                env.observe(&mut self.seen);
            }
            for (lane, outcome) in outcomes.into_iter().enumerate() {
                let row = first + lane;
                let (at, speed) = env.place(lane);
                self.counts.visit(at, speed, outcome.status == EpisodeStatus::Terminated);
                self.experience.rewards[row] = outcome.reward as f32 * (1.0 - gamma);
                self.experience.status[row] = outcome.status;
                if outcome.status == EpisodeStatus::Truncated {
                    self.last_seen.0.extend_from_slice(&self.seen[lane * inputs..(lane + 1) * inputs]);
                    self.last_seen.1.push(row);
                }
                if outcome.status != EpisodeStatus::Running {
                    self.episodes.push(env.episode(lane, outcome.status));
                    env.reset(lane, starts);
                }
            }
            first += lanes;
        }
    }
}

/// What all lanes of all environments see, row by row.
fn observe<E: EpisodeLanes>(environments: &mut [E], rows: &mut [f32], inputs: usize) {
    let mut rest = rows;
    for env in environments {
        let (part, after) = rest.split_at_mut(env.lanes() * inputs);
        env.observe(part);
        rest = after;
    }
}

fn lap(clock: &mut std::time::Instant) -> f64 {
    let now = std::time::Instant::now();
    let seconds = now.duration_since(*clock).as_secs_f64();
    *clock = now;
    seconds
}

#[cfg(test)]
mod tests {
    //! The critic learns what states are worth: also that in which an episode is cut, which no row of the experience begins
    //! with, and after which it begins anew elsewhere. A chain of two states has values in closed form.

    use super::*;
    use crate::train::nn::Activation;
    use crate::train::ppo::learner::{Learner, UpdateOptions};

    const GAMMA: f32 = 0.9;
    const REWARDS: [f64; 2] = [1.0, 0.25];

    /// Eight lanes that go to and fro between two states, whatever is done, and end after `limit` ticks, beginning at the first.
    struct Chain {
        lanes: [(usize, usize); 8],
        limit: usize,
        end: EpisodeStatus,
    }

    impl EpisodeLanes for Chain {
        fn lanes(&self) -> usize {
            self.lanes.len()
        }
        fn observe(&mut self, rows: &mut [f32]) {
            for ((state, _), row) in self.lanes.iter().zip(rows.chunks_exact_mut(2)) {
                row.fill(0.0);
                row[*state] = 1.0;
            }
        }
        fn tick(&mut self, _: &[f32]) -> Vec<Outcome> {
            let (limit, end) = (self.limit, self.end);
            let step = |(state, age): &mut (usize, usize)| {
                let reward = REWARDS[*state];
                (*state, *age) = (1 - *state, *age + 1);
                Outcome { reward, status: if *age >= limit { end } else { EpisodeStatus::Running } }
            };
            self.lanes.iter_mut().map(step).collect()
        }
        fn place(&self, _: usize) -> (usize, f64) {
            (0, 0.0)
        }
        fn episode(&self, lane: usize, status: EpisodeStatus) -> Episode {
            Episode { ticks: self.lanes[lane].1, reward: 0.0, failed: status == EpisodeStatus::Terminated }
        }
        fn reset(&mut self, lane: usize, _: &StartSampler) {
            self.lanes[lane] = (0, 0);
        }
    }

    /// What the critic says of the two states after it has learnt.
    fn learnt_values(limit: usize, end: EpisodeStatus) -> [f32; 2] {
        let starts = StartSampler::uniform(1, true);
        let mut random = RandomStream::new(3, 0);
        let network = |last, random: &mut _| Network::new(&[2, 8, last], Activation::Tanh, 1.0, random);
        let mut learner = Learner::new(network(1, &mut random), network(1, &mut random));
        let chain = || Chain { lanes: [(0, 0); 8], limit, end };
        let mut batch = EnvBatch::of(vec![chain(), chain()], RandomStream::new(3, 1), &starts);
        let normalizer = Normalizer::new(2);
        let options = UpdateOptions {
            minibatch: 64,
            epochs: 4,
            clip: 0.2,
            learning_rate: 1e-4,
            critic_rate: 2e-3,
            largest_kl: 1.0,
            largest_gradient: 1.0,
            action_std: 0.3,
            smoothness: 0.0,
            threads: 1,
        };
        for _ in 0..300 {
            let Learner { actor, critic, .. } = &learner;
            let (gamma, lambda, action_std) = (GAMMA, 0.8, options.action_std);
            let player = Player { actor, critic, normalizer: &normalizer, action_std, gamma, lambda, keeps_raw: false };
            batch.play(&player, 7, &starts);
            assert!(batch.episodes.iter().all(|e| e.failed == (end == EpisodeStatus::Terminated)));
            learner.update(&[&batch.experience], &options, &mut random);
        }
        let mut scratch = Activations::default();
        let values = learner.critic.forward(&mut scratch, &[1.0, 0.0, 0.0, 1.0], 2);
        [values[0], values[1]]
    }

    fn assert_near(found: [f32; 2], expected: [f32; 2], what: &str) {
        println!("{what}: {found:?}, in closed form {expected:?} (allowed 0.01)");
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 0.01), "{what}: {found:?} {expected:?}");
    }

    #[test]
    fn a_truncated_episode_is_worth_what_an_endless_one_is() {
        // A = (1 - g) a + g B, B = (1 - g) b + g A.
        let [a, b] = REWARDS.map(|r| r as f32);
        let endless = [(a + GAMMA * b) / (1.0 + GAMMA), (b + GAMMA * a) / (1.0 + GAMMA)];
        // Cut in either state, in the middle of a rollout and at its last tick.
        for limit in [2, 3, 7] {
            assert_near(learnt_values(limit, EpisodeStatus::Truncated), endless, &format!("cut after {limit}"));
        }
    }

    #[test]
    fn nothing_follows_a_terminated_episode() {
        let [a, b] = REWARDS.map(|r| (1.0 - GAMMA) * r as f32);
        assert_near(learnt_values(2, EpisodeStatus::Terminated), [a + GAMMA * b, b], "ended after 2");
    }
}
