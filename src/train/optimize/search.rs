//! Window after window: find a way, improve two windows, keep the first.

use super::checkpoint::{Checkpoint, fingerprint};
use super::plan::TICK_RATE;
use super::spline::{KnotGrid, ORDER};
use super::trial::{Trial, TrialCosts, bounded};
use super::{OptimizeError, OptimizeOptions, Plan};
use crate::contact::World;
use crate::control::joint_weights;
use crate::control::{Offset, ReconstructedControl, Reference, apply_initial_state};
use crate::dynamics::State;
use crate::math::{F64x4, Real};
use crate::sim::Simulator;
use crate::train::cma_es::{CmaEs, CmaOptions};
use crate::train::samcon::{continue_from, reconstruct};
use crate::train::{ReconstructError, ReconstructOptions};
use glam::DVec3;
use std::time::Instant;

/// Standard deviation of all variables, rad, below which a search is over.
const FOUND: f64 = 1e-4;

/// News from an optimisation.
#[derive(Debug)]
pub enum News<'a> {
    /// The first control is being searched for.
    First(crate::train::Progress),
    /// A generation is done.
    Generation {
        /// Window that is being optimised, together with the next one.
        window: usize,
        /// Generations done for it.
        generation: u64,
        /// Cost of the pair of windows before the search.
        before: f64,
        /// Best cost so far.
        best: f64,
    },
    /// A window is done; this may be saved.
    Window(&'a Checkpoint),
}

/// Which control was kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// The optimised one.
    Optimized,
    /// The one that the search began with, because it costs less over the whole motion.
    First,
}

/// The result of an optimisation.
#[derive(Clone, Debug)]
pub struct Optimized {
    /// The control that costs less.
    pub control: ReconstructedControl,
    /// Which one that is.
    pub kept: Kept,
    /// What the control costs that the search began with.
    pub before: TrialCosts,
    /// What the optimised control costs.
    pub after: TrialCosts,
    /// Variables of the largest pair of windows.
    pub dimension: usize,
    /// Candidates that were simulated.
    pub candidates: u64,
}

struct Search<'a> {
    plan: &'a Plan,
    world: &'a World,
    options: &'a OptimizeOptions,
    seed: u64,
    iterations: u64,
    grid: KnotGrid,
    /// Control points and weights at each tick.
    basis: Vec<[(Option<usize>, f64); ORDER]>,
    weights: Vec<f64>,
    gains: Option<(f64, f64)>,
    base: Vec<Vec<Offset>>,
    points: Vec<Vec<Offset>>,
    workers: Vec<Trial<F64x4>>,
    scalar: Trial<f64>,
    dimension: usize,
    candidates: u64,
}

/// The offset of a link at a tick: what the spline is added to, and the spline.
fn spline<'p>(basis: &[(Option<usize>, f64); ORDER], point: impl Fn(usize) -> &'p [Offset], link: usize) -> Offset {
    let parts = basis.iter().filter_map(|(j, w)| j.map(|j| point(j)[link] * *w));
    parts.fold(DVec3::ZERO, |sum, part| sum + part)
}

impl Search<'_> {
    fn windows(&self) -> usize {
        self.plan.windows.len()
    }

    /// The state at the end of windows `first..last`, played from `state`.
    fn play(&mut self, state: &State<f64>, first: usize, last: usize) -> State<f64> {
        let Self { scalar, plan, world, basis, base, points, .. } = self;
        scalar.restart(state);
        scalar.run(plan, world, (first, last), |tick, _, link| {
            bounded(base[tick][link] + spline(&basis[tick], |j| &points[j], link))
        });
        scalar.sim.state.clone()
    }

    /// Sets `base` in a window so that the character stays on its feet from `state` on, the next window included. The
    /// spline as it is then adds nothing. Where no way is found, `base` stays zero.
    fn find_way(
        &mut self,
        samcon: &ReconstructOptions,
        state: &State<f64>,
        window: usize,
    ) -> Result<(), OptimizeError> {
        let ticks = self.plan.windows[window].ticks.clone();
        let end = self.plan.windows[(window + 1).min(self.windows() - 1)].ticks.end;
        let reference =
            Reference { tick_rate: TICK_RATE, ticks: self.plan.reference.ticks[ticks.start..=end].to_vec() };
        let before: Vec<Offset> = match ticks.start.checked_sub(1) {
            Some(t) => (0..self.weights.len())
                .map(|l| bounded(self.base[t][l] + spline(&self.basis[t], |j| &self.points[j], l)))
                .collect(),
            None => vec![DVec3::ZERO; self.weights.len()],
        };
        let options = ReconstructOptions {
            seed: self.seed.wrapping_add(1 + window as u64),
            threads: self.options.threads,
            gains: self.gains,
            ..samcon.clone()
        };
        let rows = match continue_from(&self.plan.model, self.world, &reference, state, &before, &options) {
            Ok(rows) => rows,
            Err(ReconstructError::DeadEnd { .. }) => return Ok(()),
            Err(error) => return Err(error.into()),
        };
        for (tick, row) in ticks.zip(rows) {
            for (link, offset) in row.into_iter().enumerate() {
                let already = spline(&self.basis[tick], |j| &self.points[j], link);
                self.base[tick][link] = offset - already;
            }
        }
        Ok(())
    }

    /// Costs of candidates for the control points of windows `first..last`, from one state.
    fn costs(&mut self, state: &State<f64>, (first, last): (usize, usize), candidates: &[Vec<f64>]) -> Vec<f64> {
        const LANES: usize = F64x4::LANES;
        let free = self.grid.points(first, last);
        let Self { plan, world, basis, base, points, workers, candidates: count, .. } = self;
        let (plan, world, basis, base, points) = (&**plan, *world, &*basis, &*base, &*points);
        *count += candidates.len() as u64;
        let links = plan.model.links.len();
        // The variables as control points: candidate, point, link.
        let moved: Vec<Vec<Vec<Offset>>> = candidates
            .iter()
            .map(|x| {
                let row = |at: &[f64]| {
                    core::iter::once(DVec3::ZERO).chain(at.chunks_exact(3).map(DVec3::from_slice)).collect()
                };
                x.chunks_exact(3 * (links - 1)).map(row).collect()
            })
            .collect();
        let groups: Vec<&[Vec<Vec<Offset>>]> = moved.chunks(LANES).collect();
        let threads = workers.len();
        let mut costs = vec![f64::INFINITY; candidates.len()];
        std::thread::scope(|scope| {
            let running: Vec<_> = workers
                .iter_mut()
                .enumerate()
                .map(|(n, worker)| {
                    let (groups, free) = (&groups, free.clone());
                    scope.spawn(move || {
                        let mut found = Vec::new();
                        for number in (n..groups.len()).step_by(threads) {
                            let group = groups[number];
                            worker.restart(state);
                            let tried = worker.run(plan, world, (first, last), |tick, lane, link| {
                                // A lane without a candidate of its own repeats the last one.
                                let mine = &group[lane.min(group.len() - 1)];
                                let point = |j: usize| {
                                    if free.contains(&j) { &mine[j - free.start][..] } else { &points[j][..] }
                                };
                                bounded(base[tick][link] + spline(&basis[tick], point, link))
                            });
                            found.push((number, tried));
                        }
                        found
                    })
                })
                .collect();
            for handle in running {
                // A worker that panicked leaves its candidates at infinity.
                for (number, tried) in handle.join().unwrap_or_default() {
                    for (slot, cost) in costs[number * LANES..].iter_mut().zip(&tried) {
                        *slot = cost.total();
                    }
                }
            }
        });
        costs
    }

    /// Improves the control points of a window and the next one.
    fn improve(
        &mut self,
        state: &State<f64>,
        window: usize,
        deadline: Option<(Instant, f64)>,
        progress: &mut dyn FnMut(News) -> bool,
    ) -> Result<(), OptimizeError> {
        let pair = (window, (window + 2).min(self.windows()));
        let free = self.grid.points(pair.0, pair.1);
        let links = self.weights.len();
        let scales: Vec<f64> = free.clone().flat_map(|_| self.weights[1..].iter().flat_map(|w| [*w; 3])).collect();
        let mean: Vec<f64> =
            self.points[free.clone()].iter().flat_map(|p| &p[1..]).flat_map(|o| o.to_array()).collect();
        self.dimension = self.dimension.max(mean.len());
        let before = self.costs(state, pair, std::slice::from_ref(&mean))[0];
        if self.iterations == 0 || links < 2 {
            return Ok(());
        }
        let mut search = CmaEs::new(
            mean.clone(),
            CmaOptions {
                population: Some(self.plan.record.population),
                sigma: self.plan.record.sigma,
                scales: Some(scales),
                separable: false,
                seed: self.seed.wrapping_add(window as u64),
            },
        )?;
        while search.generation() < self.iterations && search.spread() > FOUND {
            let mut candidates = search.ask();
            if search.generation() == 0 {
                candidates[0].clone_from(&mean);
            }
            let costs = self.costs(state, pair, &candidates);
            search.tell(&candidates, &costs)?;
            let best = search.best().map_or(f64::INFINITY, |b| b.cost);
            let news = News::Generation { window, generation: search.generation(), before, best };
            if !progress(news) {
                return Err(OptimizeError::Cancelled);
            }
            if deadline.is_some_and(|(begin, seconds)| begin.elapsed().as_secs_f64() > seconds) {
                break;
            }
        }
        if let Some(best) = search.best() {
            for (point, row) in self.points[free].iter_mut().zip(best.x.chunks_exact(3 * (links - 1))) {
                for (offset, o) in point[1..].iter_mut().zip(row.chunks_exact(3)) {
                    *offset = DVec3::from_slice(o);
                }
            }
        }
        Ok(())
    }

    /// Offsets of every tick, for each link.
    fn offsets(&self) -> Vec<Vec<Offset>> {
        let row = |tick: usize| {
            let at =
                |link: usize| bounded(self.base[tick][link] + spline(&self.basis[tick], |j| &self.points[j], link));
            (0..self.weights.len()).map(at).collect()
        };
        (0..self.plan.ticks()).map(row).collect()
    }
}

/// A control that plays `offsets`, tick by tick.
fn control_of(
    plan: &Plan,
    world_name: &str,
    gains: Option<(f64, f64)>,
    offsets: Vec<Vec<Offset>>,
) -> ReconstructedControl {
    ReconstructedControl {
        version: 1,
        character: plan.model.name.clone(),
        world: world_name.to_owned(),
        rate: plan.settings.rate,
        tick_rate: TICK_RATE,
        ticks_per_window: 1,
        seconds: plan.seconds(),
        gains,
        clip: plan.clip.clone(),
        offsets,
    }
}

/// What a control costs over the whole plan, played in scalar f64.
pub(super) fn assess(plan: &Plan, world: &World, control: &ReconstructedControl) -> TrialCosts {
    let mut trial = Trial::<f64>::new(plan, control.gains);
    apply_initial_state(&mut trial.sim, &plan.reference.ticks[0]);
    let n = control.ticks_per_window;
    let zero = vec![DVec3::ZERO; plan.model.links.len()];
    let costs = trial.run(plan, world, (0, plan.windows.len()), |tick, _, link| {
        let (window, blend) = (tick / n, crate::control::window_blend(tick % n, n));
        let from = if window == 0 { &zero } else { control.offsets.get(window - 1).unwrap_or(&zero) };
        from[link].lerp(control.offsets.get(window).unwrap_or(&zero)[link], blend)
    });
    costs.into_iter().next().unwrap_or_default()
}

/// Optimises a plan on `world`, which a control calls `world_name`. `resume` goes on after a window that was saved.
///
/// `progress` hears of every generation and window, and may stop the search by returning false.
pub fn optimize(
    plan: &Plan,
    world: &World,
    world_name: &str,
    options: &OptimizeOptions,
    resume: Option<Checkpoint>,
    mut progress: impl FnMut(News) -> bool,
) -> Result<Optimized, OptimizeError> {
    if !(1..=256).contains(&options.threads) {
        return Err(OptimizeError::value("threads", options.threads, "1 to 256"));
    }
    if let Some(seconds) = options.seconds
        && !(seconds.is_finite() && seconds > 0.0)
    {
        return Err(OptimizeError::value("time limit", seconds, "more than 0 s"));
    }
    let begin = Instant::now();
    let seed = options.seed.unwrap_or(plan.record.seed);
    let iterations = options.iterations.unwrap_or(plan.record.iterations);
    let ends: Vec<usize> = plan.windows.iter().map(|w| w.ticks.end).collect();
    let grid = KnotGrid::new(&ends, plan.record.knot_spacing * TICK_RATE);
    let print = fingerprint(plan, options, iterations, seed);
    let zero = vec![DVec3::ZERO; plan.model.links.len()];

    // Where to begin: a saved window, a control that stays on its feet, or the key poses.
    let mut saved = match (resume, &options.samcon) {
        (Some(saved), _) => {
            saved.check(plan, print, grid.count())?;
            saved
        }
        (None, samcon) => Checkpoint {
            version: 1,
            fingerprint: print,
            done: 0,
            first: match samcon {
                Some(samcon) => first_control(plan, world, world_name, options.threads, seed, samcon, &mut progress)?,
                None => control_of(plan, world_name, plan.record.gains, Vec::new()),
            },
            base: vec![zero.clone(); plan.ticks()],
            points: vec![zero; grid.count()],
        },
    };
    let gains = saved.first.gains;
    let middle = |tick: usize| tick as f64 + 0.5;
    let mut search = Search {
        plan,
        world,
        options,
        seed,
        iterations,
        basis: (0..plan.ticks()).map(|tick| grid.basis(middle(tick))).collect(),
        grid,
        weights: joint_weights(&plan.model),
        gains,
        base: saved.base.clone(),
        points: saved.points.clone(),
        workers: (0..options.threads).map(|_| Trial::new(plan, gains)).collect(),
        scalar: Trial::new(plan, gains),
        dimension: 0,
        candidates: 0,
    };

    let mut start = Simulator::<f64>::new(plan.model.clone(), plan.settings);
    apply_initial_state(&mut start, &plan.reference.ticks[0]);
    let mut state = start.state;
    if saved.done > 0 {
        state = search.play(&state, 0, saved.done);
    }
    for window in saved.done..search.windows() {
        if let Some(samcon) = &options.samcon {
            if window == 0 {
                search.find_way(samcon, &state, 0)?;
            }
            if window + 1 < search.windows() {
                let next = search.play(&state, window, window + 1);
                search.find_way(samcon, &next, window + 1)?;
            }
        }
        let share = options.seconds.map(|seconds| {
            let left = (seconds - begin.elapsed().as_secs_f64()).max(0.0);
            (Instant::now(), left / (search.windows() - window) as f64)
        });
        search.improve(&state, window, share, &mut progress)?;
        state = search.play(&state, window, window + 1);
        saved.done = window + 1;
        saved.base.clone_from(&search.base);
        saved.points.clone_from(&search.points);
        if !progress(News::Window(&saved)) {
            return Err(OptimizeError::Cancelled);
        }
    }

    let control = control_of(plan, world_name, gains, search.offsets());
    let (before, after) = (assess(plan, world, &saved.first), assess(plan, world, &control));
    let better = after.total() < before.total();
    Ok(Optimized {
        control: if better { control } else { saved.first },
        kept: if better { Kept::Optimized } else { Kept::First },
        before,
        after,
        dimension: search.dimension,
        candidates: search.candidates,
    })
}

/// A control for the whole motion by sampling; its gains are those of the search that follows.
fn first_control(
    plan: &Plan,
    world: &World,
    world_name: &str,
    threads: usize,
    seed: u64,
    samcon: &ReconstructOptions,
    progress: &mut dyn FnMut(News) -> bool,
) -> Result<ReconstructedControl, OptimizeError> {
    let gains = samcon.gains.or(plan.record.gains);
    let options = ReconstructOptions { seed, threads, tick_rate: TICK_RATE, settings: None, gains, ..samcon.clone() };
    let found = reconstruct(&plan.model, world, world_name, &plan.clip, &options, |news| progress(News::First(news)));
    match found {
        Ok(found) => Ok(found.control),
        Err(ReconstructError::Cancelled) => Err(OptimizeError::Cancelled),
        // Where sampling gives up, the search begins at the key poses, with the gains asked for.
        Err(ReconstructError::DeadEnd { .. }) => Ok(control_of(plan, world_name, gains, Vec::new())),
        Err(error) => Err(error.into()),
    }
}
