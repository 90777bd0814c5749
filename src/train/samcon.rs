//! Sampling-based control reconstruction.
//!
//! Liu, Yin, van de Panne, Shao, Xu 2010, "Sampling-based Contact-rich Motion Control"; the first stage of Liu, Yin,
//! van de Panne, Guo 2012, "Terrain Runner". A clip is cut into windows of some hundredths of a second. In each, many offsets to the
//! servo targets are tried from several kept states; the best end states are kept and the next window begins. Where no
//! sample stays close, the search goes back a few windows and draws anew, wider.
//!
//! Samples run in the lanes of 4 x f64, unfused, on all threads. Each draws from a stream of its own, named by
//! (attempt, window, sample), so the result does not depend on the number of threads; and a scalar f64 simulation of
//! the result has the same bits.

use crate::asset::clip::MotionClip;
use crate::contact::World;
use crate::control::{
    ControlPlayer, Offset, ReconstructedControl, Reference, apply_initial_state, fallen, joint_weights, tracking_error,
};
use crate::dynamics::State;
use crate::math::{F64x4, Quat, RandomStream, Real, Vec3};
use crate::model::{CharacterModel, SharedModel};
use crate::sim::{SimulationSettings, Simulator, step};
use crate::train::samcon_cost::{CostScales, CostTarget, cost};
use crate::train::samcon_options::{ReconstructError, ReconstructOptions, STIFF_GAINS, check};
use glam::{DQuat, DVec3};

/// News from the search.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Window that has just been finished.
    pub window: usize,
    /// Windows in all.
    pub windows: usize,
    /// Cost of the best sample.
    pub cost: f64,
    /// Times the search went back so far.
    pub backtracks: usize,
    /// Number of the attempt, from zero.
    pub attempt: usize,
}

/// How well the simulation of a control follows its clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReconstructionReport {
    /// Length of the motion, s.
    pub seconds: f64,
    /// Largest distance of the root, m.
    pub worst_root: f64,
    /// Mean angle between joint rotations over all joints and ticks, rad.
    pub mean_joint: f64,
    /// Time at which the character fell (root more than 0.35 m too low or turned by more than 80 degrees), s.
    pub fell_at: Option<f64>,
    /// Longest time without any contact, s.
    pub longest_flight: f64,
    /// Times the search went back.
    pub backtracks: usize,
}

/// A control and how well it does.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// The control.
    pub control: ReconstructedControl,
    /// Measured by playing it from its start in scalar f64.
    pub report: ReconstructionReport,
    /// Fingerprint of the state in which the search's own best sample ended; a replay in scalar f64 ends in the same.
    pub end_fingerprint: u64,
    /// The search was stopped before the end of the clip; the control is that of its beginning.
    pub stopped: bool,
}

/// A kept state after a window.
#[derive(Clone)]
struct Elite {
    state: State<f64>,
    offsets: Vec<Offset>,
    /// Index of the elite it grew from in the window before.
    parent: usize,
    cost: f64,
}

/// One worker's simulator and the buffer of its samples' results.
struct Worker {
    sim: Simulator<F64x4>,
    results: Vec<Elite>,
}

struct Search<'a> {
    model: &'a CharacterModel,
    world: &'a World,
    options: &'a ReconstructOptions,
    reference: &'a Reference,
    targets: Vec<CostTarget>,
    ends: Vec<usize>,
    weights: Vec<f64>,
    scales: CostScales,
    steps_per_tick: usize,
}

impl Search<'_> {
    fn windows(&self) -> usize {
        self.targets.len()
    }

    /// Ticks in window `w`; the last one may be shorter.
    fn ticks_in(&self, w: usize) -> usize {
        let n = self.options.ticks_per_window;
        (self.reference.ticks.len() - 1 - w * n).min(n)
    }

    /// Tries samples `first..last` of a window, four at a time.
    fn run_samples(
        &self,
        worker: &mut Worker,
        window: usize,
        attempt: u64,
        spread: f64,
        elites: &[Elite],
        range: core::ops::Range<usize>,
    ) {
        const LANES: usize = F64x4::LANES;
        let links = self.model.links.len();
        worker.results.clear();
        let mut offsets = vec![vec![DVec3::ZERO; links]; LANES];
        let mut parents = [0; LANES];
        for group in range.step_by(LANES) {
            for lane in 0..LANES {
                let stream = ((attempt * 4096 + window as u64) << 24) + (group + lane) as u64;
                let mut random = RandomStream::new(self.options.seed, stream);
                // Better elites have more children.
                let u = random.uniform();
                let parent = ((u * u.sqrt()) * elites.len() as f64) as usize;
                parents[lane] = parent.min(elites.len() - 1);
                let from = &elites[parents[lane]];
                // A quarter of the samples search nearby, a quarter far away.
                let scale = spread * [0.35, 0.7, 1.0, 1.4][random.below(4)];
                let joints = offsets[lane].iter_mut().zip(&from.offsets).zip(&self.weights).skip(1);
                for ((offset, before), weight) in joints {
                    let deviation = self.options.deviation * weight * scale;
                    let draw = DVec3::new(random.normal(), random.normal(), random.normal()) * deviation;
                    *offset = (*before * self.options.persistence + draw).clamp_length_max(1.6);
                }
                worker.sim.state.copy_lane(lane, &from.state, 0);
            }
            worker.sim.state.time = 0.0;
            worker.sim.state_changed();
            self.simulate_window(&mut worker.sim, window, &offsets, &parents, elites);
            for lane in 0..LANES {
                let target = &self.targets[window];
                let cost = cost(&mut worker.sim, lane, target, &self.ends, &self.weights, &self.scales);
                worker.results.push(Elite {
                    state: worker.sim.state.lane(self.model, lane),
                    offsets: offsets[lane].clone(),
                    parent: parents[lane],
                    // The past counts a little, so that a lucky end does not hide a bad way.
                    cost: cost + 0.1 * elites[parents[lane]].cost.min(1e5),
                });
            }
        }
    }

    fn simulate_window(
        &self,
        sim: &mut Simulator<F64x4>,
        window: usize,
        offsets: &[Vec<Offset>],
        parents: &[usize],
        elites: &[Elite],
    ) {
        let n = self.options.ticks_per_window;
        for tick in 0..self.ticks_in(window) {
            let at = window * n + tick;
            let blend = crate::control::window_blend(tick, n);
            let target = &self.reference.ticks[(at + 1).min(self.reference.ticks.len() - 1)];
            for i in 1..self.model.links.len() {
                let command = &mut sim.commands[i];
                let mut rotation = Quat::identity();
                for (lane, offset) in offsets.iter().enumerate() {
                    let before = elites[parents[lane]].offsets[i];
                    let q: DQuat =
                        target.pose.joints[i] * crate::control::offset_rotation(before.lerp(offset[i], blend));
                    rotation.set_lane(lane, q);
                }
                command.rotation = rotation;
                command.velocity = Vec3::splat(target.velocity.joints[i]);
            }
            for _ in 0..self.steps_per_tick {
                step(sim, self.world);
            }
        }
    }

    /// One window over all threads: the kept states, best first.
    fn run_window(
        &self,
        workers: &mut [Worker],
        window: usize,
        attempt: u64,
        spread: f64,
        samples: usize,
        elites: &[Elite],
    ) -> Vec<Elite> {
        let share = samples.div_ceil(workers.len()).next_multiple_of(F64x4::LANES);
        std::thread::scope(|scope| {
            for (n, worker) in workers.iter_mut().enumerate() {
                let range = (n * share).min(samples)..((n + 1) * share).min(samples);
                scope.spawn(move || self.run_samples(worker, window, attempt, spread, elites, range));
            }
        });
        let mut order: Vec<(usize, usize)> =
            workers.iter().enumerate().flat_map(|(w, worker)| (0..worker.results.len()).map(move |k| (w, k))).collect();
        let cost_of = |&(w, k): &(usize, usize)| workers[w].results[k].cost;
        order.sort_by(|a, b| cost_of(a).total_cmp(&cost_of(b)).then(a.cmp(b)));
        order.truncate(self.options.keep);
        order.into_iter().map(|(w, k)| workers[w].results[k].clone()).collect()
    }
}

/// Searches for a control whose simulation on `world` follows `clip`.
///
/// `progress` is called after each window and may stop the search by returning false. What was found until then is the result: the
/// best control of an earlier attempt, else one as long as the windows that were passed
/// ([`Cancelled`](ReconstructError::Cancelled) before the first). `world_name` is what the control
/// file says of the world.
pub fn reconstruct(
    model: &SharedModel,
    world: &World,
    world_name: &str,
    clip: &MotionClip,
    options: &ReconstructOptions,
    mut progress: impl FnMut(Progress) -> bool,
) -> Result<Reconstruction, ReconstructError> {
    let mut best: Option<Reconstruction> = None;
    let mut failure = None;
    for attempt in 0..options.attempts.max(1) {
        let varied = ReconstructOptions {
            seed: options.seed.wrapping_add(attempt as u64),
            gains: if attempt == 1 { options.gains.or(Some(STIFF_GAINS)) } else { options.gains },
            samples: if attempt == 2 { options.samples.saturating_mul(2) } else { options.samples },
            keep: if attempt == 2 { options.keep.saturating_mul(2) } else { options.keep },
            ..options.clone()
        };
        let search =
            search_once(model, world, world_name, clip, &varied, |news| progress(Progress { attempt, ..news }));
        match search {
            Ok(found) => {
                let of = |r: &ReconstructionReport| {
                    options.tolerance.excess(r.fell_at.is_some(), r.worst_root, r.mean_joint)
                };
                let excess = of(&found.report);
                let stopped = found.stopped;
                // A control of the whole clip is worth more than one of its beginning.
                if best.as_ref().is_none_or(|b| !stopped && excess < of(&b.report)) {
                    best = Some(found);
                }
                if stopped || excess <= 1.0 {
                    break;
                }
            }
            Err(ReconstructError::Cancelled) => break,
            Err(dead_end @ ReconstructError::DeadEnd { .. }) => failure = Some(dead_end),
            Err(error) => return Err(error),
        }
    }
    match (best, failure) {
        (Some(found), _) => Ok(found),
        (None, Some(error)) => Err(error),
        (None, None) => Err(ReconstructError::Cancelled),
    }
}

/// One search with one seed.
fn search_once(
    model: &SharedModel,
    world: &World,
    world_name: &str,
    clip: &MotionClip,
    options: &ReconstructOptions,
    progress: impl FnMut(Progress) -> bool,
) -> Result<Reconstruction, ReconstructError> {
    let settings = options.settings.unwrap_or_else(|| SimulationSettings::of(model));
    check(options, settings.rate)?;
    let model_clip = clip.to_model(model)?;
    let ticks = model_clip.duration() * options.tick_rate;
    if ticks > Reference::MAX_TICKS as f64 {
        return Err(ReconstructError::Option {
            option: "tick_rate",
            found: format!("{} on a clip of {} s", options.tick_rate, model_clip.duration()),
            valid: format!("at most {} target updates in all", Reference::MAX_TICKS),
        });
    }
    let reference = Reference::new(&model_clip, options.tick_rate, None);
    let mut start = Simulator::<f64>::new(model.clone(), settings);
    apply_initial_state(&mut start, &reference.ticks[0]);
    let first = Elite { state: start.state, offsets: vec![DVec3::ZERO; model.links.len()], parent: 0, cost: 0.0 };
    let way = find_way(model, world, &reference, first, options, progress)?;
    let control = ReconstructedControl {
        version: 1,
        character: model.name.clone(),
        world: world_name.to_string(),
        rate: settings.rate,
        tick_rate: options.tick_rate,
        ticks_per_window: options.ticks_per_window,
        seconds: match way.stopped {
            true => (way.offsets.len() * options.ticks_per_window) as f64 / options.tick_rate,
            false => reference.duration(),
        },
        gains: options.gains,
        clip: clip.clone(),
        offsets: way.offsets,
    };
    let mut report = assess(&control, model, world, settings)?;
    report.backtracks = way.backtracks;
    Ok(Reconstruction { control, report, end_fingerprint: way.end_fingerprint, stopped: way.stopped })
}

/// Offsets that follow `reference` from a state of the body on, one row (of an offset for each link) for each of its ticks
/// but the last; `before` holds the offsets that were in force until then.
pub(crate) fn continue_from(
    model: &SharedModel,
    world: &World,
    reference: &Reference,
    state: &State<f64>,
    before: &[Offset],
    options: &ReconstructOptions,
) -> Result<Vec<Vec<Offset>>, ReconstructError> {
    let settings = options.settings.unwrap_or_else(|| SimulationSettings::of(model));
    check(options, settings.rate)?;
    let first = Elite { state: state.clone(), offsets: before.to_vec(), parent: 0, cost: 0.0 };
    let way = find_way(model, world, reference, first, options, |_| true)?;
    let n = options.ticks_per_window;
    let row = |tick: usize| {
        let (window, blend) = (tick / n, crate::control::window_blend(tick % n, n));
        let from = if window == 0 { before } else { &way.offsets[window - 1] };
        from.iter().zip(&way.offsets[window]).map(|(a, b)| a.lerp(*b, blend)).collect()
    };
    Ok((0..reference.ticks.len() - 1).map(row).collect())
}

/// The best way that a search found.
struct Way {
    /// For each window, an offset for each link.
    offsets: Vec<Vec<Offset>>,
    backtracks: usize,
    end_fingerprint: u64,
    /// The search was stopped before the last window.
    stopped: bool,
}

/// Searches window by window from one state.
fn find_way(
    model: &SharedModel,
    world: &World,
    reference: &Reference,
    first: Elite,
    options: &ReconstructOptions,
    mut progress: impl FnMut(Progress) -> bool,
) -> Result<Way, ReconstructError> {
    let settings = options.settings.unwrap_or_else(|| SimulationSettings::of(model));
    let ends = model.end_links();
    let n = options.ticks_per_window;
    let windows = (reference.ticks.len() - 1).div_ceil(n).max(1);
    let last = reference.ticks.len() - 1;
    let search = Search {
        model,
        world,
        options,
        targets: (1..=windows).map(|w| CostTarget::new(model, &ends, &reference.ticks[(w * n).min(last)])).collect(),
        reference,
        weights: joint_weights(model),
        ends,
        scales: CostScales::default(),
        steps_per_tick: (settings.rate / options.tick_rate).round() as usize,
    };

    let mut wide = Simulator::<F64x4>::new(model.clone(), settings);
    if let Some((kp, kd)) = options.gains {
        for command in &mut wide.commands {
            command.kp = F64x4::splat(kp);
            command.kd = F64x4::splat(kd);
        }
    }
    let mut workers: Vec<Worker> =
        (0..options.threads).map(|_| Worker { sim: wide.clone(), results: Vec::new() }).collect();

    // The kept states after each window; entry 0 is the start.
    let mut history: Vec<Vec<Elite>> = vec![vec![first]];
    let mut tries = vec![0_u32; search.windows()];
    let mut backtracks = 0;
    while history.len() <= search.windows() {
        let window = history.len() - 1;
        let attempt = u64::from(tries[window]);
        // Wider and more with each try.
        let spread = 1.0 + 0.25 * f64::from(tries[window].min(4));
        let samples = options.samples << tries[window].min(2);
        let elites = search.run_window(&mut workers, window, attempt, spread, samples, &history[window]);
        let best = elites[0].cost;
        if !progress(Progress { window, windows: search.windows(), cost: best, backtracks, attempt: 0 }) {
            if window == 0 {
                return Err(ReconstructError::Cancelled);
            }
            break;
        }
        tries[window] += 1;
        if best < 1e4 {
            let good = elites.iter().take_while(|e| e.cost < 1e4).count();
            history.push(elites[..good].to_vec());
            continue;
        }
        // Dead end: back by one window more with each failure here.
        backtracks += 1;
        if backtracks > options.backtracks {
            return Err(ReconstructError::DeadEnd {
                window,
                windows: search.windows(),
                time: (window * n) as f64 / options.tick_rate,
                backtracks: backtracks - 1,
                cost: best,
            });
        }
        let back = (tries[window] as usize + 1).min(window);
        history.truncate(history.len() - back);
    }

    // The best end, and the way to it.
    let mut offsets = Vec::with_capacity(search.windows());
    let mut at = 0;
    for w in (1..history.len()).rev() {
        let elite = &history[w][at];
        offsets.push(elite.offsets.clone());
        at = elite.parent;
    }
    offsets.reverse();
    let end_fingerprint = history[history.len() - 1][0].state.fingerprint(0);
    let stopped = offsets.len() < search.windows();
    Ok(Way { offsets, backtracks, end_fingerprint, stopped })
}

/// Plays a control in scalar f64 and measures it.
pub(crate) fn assess(
    control: &ReconstructedControl,
    model: &SharedModel,
    world: &World,
    settings: SimulationSettings,
) -> Result<ReconstructionReport, ReconstructError> {
    let mut sim = Simulator::<f64>::new(model.clone(), settings);
    let mut player = ControlPlayer::new(control, model)?;
    player.restart(&mut sim);
    let (mut worst_root, mut joint_sum, mut ticks) = (0.0_f64, 0.0, 0);
    let (mut flight, mut longest_flight) = (0.0_f64, 0.0_f64);
    let mut fell_at = None;
    let per_tick = (control.rate / control.tick_rate).round() as u64;
    let mut steps = 0_u64;
    while !player.is_finished() {
        player.drive(&mut sim);
        step(&mut sim, world);
        steps += 1;
        flight = if sim.loaded_points(0) == 0 { flight + sim.step_seconds() } else { 0.0 };
        longest_flight = longest_flight.max(flight);
        if steps.is_multiple_of(per_tick) {
            let tick = &player.reference().ticks[(steps / per_tick) as usize];
            let error = tracking_error(&sim, 0, &tick.pose);
            worst_root = worst_root.max(error.root);
            joint_sum += error.joints;
            ticks += 1;
            if fell_at.is_none() && fallen(&sim, 0, &tick.pose, &error).is_some() {
                fell_at = Some(sim.state.time);
            }
        }
    }
    Ok(ReconstructionReport {
        seconds: control.seconds,
        worst_root,
        mean_joint: joint_sum / f64::from(ticks.max(1)),
        fell_at,
        longest_flight,
        backtracks: 0,
    })
}
