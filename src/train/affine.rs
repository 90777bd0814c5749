//! Affine policies by covariance matrix adaptation: one matrix and an offset, found by trying them out.
//!
//! An action is `M s + b`, with s the normalised observation. Liu, Yin, van de Panne, Guo 2012, "Terrain Runner", Section 3, find such a
//! feedback for each skill by CMA-ES; here the terms of the observation are those of the skill file, and a candidate's cost is what it
//! lacks of a perfect episode, on the same random episodes for all candidates of a generation.

use crate::math::{RandomStream, Real};
use crate::train::cma_es::{CmaError, CmaEs, CmaOptions};
use crate::train::nn::{Activation, Network};
use crate::train::ppo::{
    Environment, EpisodeStatus, Lanes, MeanActor, Normalizer, SkillTask, StartSampler, TaskError, Trained, evaluate,
};
use std::sync::Arc;

/// Ticks over which the normaliser watches the body without feedback.
const WATCH_TICKS: usize = 120;
/// Parameters from which on the covariance stays diagonal.
const LARGE: usize = 600;

/// How to search.
#[derive(Clone, Debug, PartialEq)]
pub struct AffineOptions {
    /// Candidates in a generation; `None` takes `4 + 3 ln n`.
    pub population: Option<usize>,
    /// Episodes that a candidate is tried on, rounded up to whole lanes.
    pub episodes: usize,
    /// First step size, action per standard deviation of a number of the observation.
    pub sigma: f64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
}

impl Default for AffineOptions {
    fn default() -> Self {
        Self { population: None, episodes: 16, sigma: 0.1, seed: 1, threads: crate::train::default_threads() }
    }
}

/// Why a search cannot begin or go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AffineError {
    /// The episodes cannot be made.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// The search itself.
    #[error(transparent)]
    Search(#[from] CmaError),
}

/// What a generation brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Generation {
    /// Its number, from one.
    pub number: u64,
    /// Survival (0 to 1) and reward per tick of the mean of the search.
    pub mean: (f64, f64),
    /// The same of its best candidate.
    pub best: (f64, f64),
    /// Control samples so far.
    pub samples: u64,
}

/// A search under way.
pub struct AffineSearch {
    task: Arc<SkillTask>,
    options: AffineOptions,
    normalizer: Normalizer,
    search: CmaEs,
    samples: u64,
    /// The best mean of the search so far.
    best: Option<Trained>,
}

impl AffineSearch {
    /// Begins a search.
    pub fn new(task: SkillTask, options: AffineOptions) -> Result<Self, AffineError> {
        let task = Arc::new(task);
        let normalizer = watch(&task, options.seed);
        let size = (task.layout.size() + 1) * task.action_size();
        let cma = CmaOptions {
            population: options.population,
            sigma: options.sigma,
            separable: size > LARGE,
            seed: options.seed,
            ..CmaOptions::default()
        };
        let search = CmaEs::new(vec![0.0; size], cma)?;
        Ok(Self { task, options, normalizer, search, samples: 0, best: None })
    }

    /// Numbers that are searched for.
    pub fn dimension(&self) -> usize {
        self.search.dimension()
    }

    /// The task.
    pub fn task(&self) -> &Arc<SkillTask> {
        &self.task
    }

    /// The best policy so far: a mean of the search, not its luckiest candidate.
    pub fn best(&self) -> Option<&Trained> {
        self.best.as_ref()
    }

    fn network(&self, parameters: &[f64]) -> Network {
        let sizes = [self.task.layout.size(), self.task.action_size()];
        let mut network = Network::new(&sizes, Activation::Tanh, 0.0, &mut RandomStream::new(1, 1));
        for (mine, value) in network.parameters_mut().iter_mut().zip(parameters) {
            *mine = *value as f32;
        }
        network
    }

    /// One generation: tries every candidate, and the mean that comes of them.
    pub fn iterate(&mut self) -> Result<Generation, AffineError> {
        let candidates = self.search.ask();
        let seed = self.options.seed.wrapping_add(self.search.generation() << 20);
        let results = self.try_out(&candidates, seed);
        let costs: Vec<f64> = results.iter().map(|r| cost(r.0)).collect();
        self.search.tell(&candidates, &costs)?;
        self.samples += results.iter().map(|r| r.1).sum::<u64>();
        let first = results.iter().map(|r| r.0).reduce(|a, b| if cost(b) < cost(a) { b } else { a });

        // The mean is judged on episodes that no candidate was chosen by.
        let mean = self.search.mean().to_vec();
        let (found, ticks) = self.try_out(core::slice::from_ref(&mean), seed ^ 0x6d65_616e)[0];
        self.samples += ticks;
        if self.best.as_ref().is_none_or(|b| cost(found) <= cost(b.evaluation)) {
            self.best = Some(Trained {
                actor: self.network(&mean),
                normalizer: self.normalizer.clone(),
                evaluation: found,
                iteration: self.search.generation() as usize,
            });
        }
        Ok(Generation {
            number: self.search.generation(),
            mean: found,
            best: first.unwrap_or_default(),
            samples: self.samples,
        })
    }

    /// Survival and reward of each candidate, and its control samples. Does not depend on the number of threads.
    fn try_out(&self, candidates: &[Vec<f64>], seed: u64) -> Vec<((f64, f64), u64)> {
        let threads = self.options.threads.clamp(1, candidates.len().max(1));
        let each = candidates.len().div_ceil(threads);
        let one = |parameters: &Vec<f64>| {
            let network = self.network(parameters);
            let actor = MeanActor(&network, &self.normalizer);
            let report = evaluate::<Lanes, _>(&self.task, &actor, self.options.episodes, seed, 1);
            ((report.survival(), report.reward), report.ticks as u64)
        };
        std::thread::scope(|scope| {
            let parts: Vec<_> = candidates
                .chunks(each.max(1))
                .map(|part| scope.spawn(move || part.iter().map(one).collect::<Vec<_>>()))
                .collect();
            // A panic in a thread is passed on.
            let join = |part: std::thread::ScopedJoinHandle<'_, Vec<_>>| {
                part.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            };
            parts.into_iter().flat_map(join).collect()
        })
    }
}

/// What is missing to episodes that all last and are perfect.
fn cost((survival, reward): (f64, f64)) -> f64 {
    2.0 - survival - reward
}

/// The normaliser after some seconds of the body without feedback: every number about zero, with its own deviation.
fn watch(task: &Arc<SkillTask>, seed: u64) -> Normalizer {
    let starts = StartSampler::uniform(task.motion.last(), task.motion.cycle().is_some());
    let mut env = Environment::<Lanes>::new(task.clone(), seed, 0x7761_7463, &starts);
    let mut normalizer = Normalizer::new(task.layout.size());
    let mut rows = vec![0.0; Lanes::LANES * task.layout.size()];
    let nothing = vec![0.0; Lanes::LANES * task.action_size()];
    for _ in 0..WATCH_TICKS {
        env.observe(&mut rows);
        if rows.iter().all(|x| x.is_finite()) {
            normalizer.update(&rows);
        }
        for (lane, outcome) in env.tick(&nothing).into_iter().enumerate() {
            if outcome.status != EpisodeStatus::Running {
                env.reset(lane, &starts);
            }
        }
    }
    normalizer
}
