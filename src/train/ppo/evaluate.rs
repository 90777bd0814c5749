//! Measuring a policy without exploration, on trials that training has not seen.

use crate::math::Real;
use crate::train::nn::{Activations, Network};
use crate::train::ppo::environment::{Environment, EpisodeStatus};
use crate::train::ppo::normalizer::Normalizer;
use crate::train::ppo::sampling::StartSampler;
use crate::train::ppo::task::SkillTask;
use std::collections::BTreeMap;
use std::sync::Arc;

/// How a policy does.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct EvaluationReport {
    /// Trials, all counted.
    pub trials: usize,
    /// Trials that lasted to their end.
    pub survived: usize,
    /// Ticks that they took together.
    pub ticks: usize,
    /// Mean reward per tick, a failed trial's missing ticks counting zero.
    pub reward: f64,
    /// Root mean square of the action, rad.
    pub residual: f64,
    /// What the others lacked, and how many of them; of a fall, the condition is `no fall`.
    pub shortfalls: BTreeMap<&'static str, usize>,
    /// Where in the motion failed trials ended, ticks.
    pub failed_at: Vec<usize>,
}

impl EvaluationReport {
    /// Part of the trials that lasted.
    pub fn survival(&self) -> f64 {
        self.survived as f64 / self.trials.max(1) as f64
    }

    /// Counts another row's trials in; means are weighted by trials.
    pub fn add(&mut self, other: &Self) {
        let (a, b) = (self.trials as f64, other.trials as f64);
        let mean = |x: f64, y: f64| (x * a + y * b) / (a + b).max(1.0);
        self.reward = mean(self.reward, other.reward);
        self.residual = mean(self.residual, other.residual);
        self.trials += other.trials;
        self.ticks += other.ticks;
        self.survived += other.survived;
        self.failed_at.extend(&other.failed_at);
        for (condition, count) in &other.shortfalls {
            *self.shortfalls.entry(condition).or_insert(0) += count;
        }
    }
}

/// What turns observations into actions.
pub trait Actor: Sync {
    /// Work space of one thread.
    type Scratch: Default + Send;
    /// Actions (rows x outputs) for observations as the environment gives them (rows x inputs; may be changed).
    fn act<'a>(&'a self, scratch: &'a mut Self::Scratch, observations: &'a mut [f32], rows: usize) -> &'a [f32];
}

/// Actor network and normaliser.
pub(crate) struct MeanActor<'a>(pub &'a Network, pub &'a Normalizer);

impl Actor for MeanActor<'_> {
    type Scratch = Activations;
    fn act<'a>(&'a self, scratch: &'a mut Activations, observations: &'a mut [f32], rows: usize) -> &'a [f32] {
        self.1.apply(observations);
        self.0.forward(scratch, observations, rows)
    }
}

/// Seed of the trials of a row of the table: rows are independent of each other.
pub(crate) fn row_seed(seed: u64, row: usize) -> u64 {
    seed.wrapping_add((row as u64) << 32)
}

/// Runs `trials` trials of a task, without exploration; see [`SkillTask::trials`] for
/// tasks that are judged. Results do not depend on the number of threads.
pub fn evaluate<R: Real, A: Actor>(
    task: &Arc<SkillTask>,
    actor: &A,
    trials: usize,
    seed: u64,
    threads: usize,
) -> EvaluationReport {
    evaluate_until::<R, A>(task, actor, trials, seed, threads, &|| false)
}

/// [`evaluate`] that begins no more trials once `stop` says so. Every thread finishes the trials that it has begun, and begins some, so
/// there are fewer trials, but of those that there are none is left out.
pub(crate) fn evaluate_until<R: Real, A: Actor>(
    task: &Arc<SkillTask>,
    actor: &A,
    trials: usize,
    seed: u64,
    threads: usize,
    stop: &(dyn Fn() -> bool + Sync),
) -> EvaluationReport {
    let batches = trials.div_ceil(R::LANES).max(1);
    let threads = threads.clamp(1, batches);
    let per_thread = batches.div_ceil(threads);
    let run = |first: usize, count: usize| -> Vec<Tried> {
        let mut scratch = A::Scratch::default();
        (first..(first + count).min(batches))
            .take_while(|batch| *batch == first || !stop())
            .flat_map(|batch| {
                let wanted = trials.max(1).saturating_sub(batch * R::LANES).min(R::LANES);
                run_batch::<R, A>(task, actor, &mut scratch, seed, batch as u64, wanted)
            })
            .collect()
    };
    let mut results = Vec::new();
    std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads)
            .map(|n| {
                scope.spawn({
                    let run = &run;
                    move || run(n * per_thread, per_thread)
                })
            })
            .collect();
        for handle in handles {
            // A panic in a thread is passed on.
            results.extend(handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
    });
    let count = results.len();
    let ticks: usize = results.iter().map(|r| r.ticks).sum();
    let mut shortfalls = BTreeMap::new();
    for failure in results.iter().filter_map(|r| r.failure) {
        *shortfalls.entry(failure).or_insert(0) += 1;
    }
    EvaluationReport {
        trials: count,
        ticks,
        survived: results.iter().filter(|r| r.failure.is_none()).count(),
        reward: results.iter().map(|r| r.reward).sum::<f64>() / count as f64,
        residual: (results.iter().map(|r| r.effort).sum::<f64>() / ticks.max(1) as f64).sqrt()
            * task.skill.action_scale,
        shortfalls,
        failed_at: results.iter().filter(|r| r.failure.is_some()).map(|r| r.tick).collect(),
    }
}

/// A trial.
#[derive(Clone, Debug, Default)]
struct Tried {
    failure: Option<&'static str>,
    /// Mean, missing ticks counting zero.
    reward: f64,
    /// Sum of mean square actions.
    effort: f64,
    ticks: usize,
    /// Where in the motion it ended.
    tick: usize,
}

/// One trial in each of the first `wanted` lanes.
fn run_batch<R: Real, A: Actor>(
    task: &Arc<SkillTask>,
    actor: &A,
    scratch: &mut A::Scratch,
    seed: u64,
    batch: u64,
    wanted: usize,
) -> Vec<Tried> {
    let starts = StartSampler::uniform(task.motion.last(), task.motion.cycle().is_some());
    let mut env = Environment::<R>::new(task.clone(), seed, 0x4556_0000 + batch, &starts);
    let size = task.layout.size();
    let mut rows = vec![0.0; R::LANES * size];
    let mut open: Vec<bool> = (0..R::LANES).map(|lane| lane < wanted).collect();
    let mut effort = vec![0.0; R::LANES];
    let mut results = vec![Tried::default(); R::LANES];
    while open.iter().any(|o| *o) {
        env.observe(&mut rows);
        let actions = actor.act(scratch, &mut rows, R::LANES).to_vec();
        let per = actions.len() / R::LANES;
        let outcomes = env.tick(&actions);
        for (lane, outcome) in outcomes.into_iter().enumerate() {
            if !open[lane] {
                continue;
            }
            let action = &actions[lane * per..(lane + 1) * per];
            effort[lane] += action.iter().map(|a| f64::from(a * a)).sum::<f64>() / per as f64;
            if outcome.status != EpisodeStatus::Running {
                open[lane] = false;
                let trial = env.episode(lane, outcome.status);
                let lacked = env.shortfall(lane).map_or("limits", |s| s.condition);
                results[lane] = Tried {
                    failure: trial.failed.then_some(lacked),
                    reward: trial.reward / env.limit(lane) as f64,
                    effort: effort[lane],
                    ticks: trial.ticks,
                    tick: env.tracker.tick(lane),
                };
                // Something sane to go on with while the others finish.
                env.reset(lane, &starts);
            }
        }
    }
    results.truncate(wanted);
    results
}
