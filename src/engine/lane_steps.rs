//! Stepping many bodies: those that can step together share a simulator with a lane for each, and the groups are split
//! over the threads of the compute pool.
//!
//! A lane has the bits of a run alone, so neither the grouping nor the number of threads shows in any result; bodies in
//! lanes cost little more than one alone. Bodies of single precision are in lanes of eight even where they are alone.
//! Policies decide body by body: the last bits of a network's output depend on how many rows it is asked for at once.

use crate::contact::World as Surroundings;
use crate::engine::watch::Touches;
use crate::engine::{AthleteBody, AthletePrecision, AthleteSettings};
use crate::math::{F32x8, F64x4, Real};
use crate::model::SharedModel;
use crate::sim::{SimulationSettings, Simulator, step};
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPool};
use std::sync::{Arc, Mutex, PoisonError};

/// Whether bodies of one model may step together in lanes. The results are the same bits either way; a switch for
/// measurements.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default)]
pub struct AthleteLanes(pub bool);

impl Default for AthleteLanes {
    fn default() -> Self {
        Self(true)
    }
}

/// A body with steps to do.
pub(super) struct Due<'a> {
    pub body: &'a mut AthleteBody,
    pub settings: &'a AthleteSettings,
    pub steps: u32,
}

/// Common simulators that wait for their next use. What they hold is written over.
#[derive(Debug, Default)]
pub(super) struct LaneSimulators {
    double: Waiting<F64x4>,
    single: Waiting<F32x8>,
}

/// Simulators of one kind of lane.
#[derive(Debug)]
struct Waiting<R: Real>(Mutex<Vec<Simulator<R>>>);

impl<R: Real> Default for Waiting<R> {
    fn default() -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

impl<R: Real> Waiting<R> {
    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Simulator<R>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Steps a group with a simulator that waits, or a new one.
    fn step(&self, group: &mut [Due], surroundings: &Surroundings) {
        let (model, settings) = (group[0].body.model(), *group[0].body.simulator().settings());
        let mut sim = self.take(model, settings);
        step_together(group, &mut sim, surroundings);
        self.lock().push(sim);
    }

    fn take(&self, model: &SharedModel, settings: SimulationSettings) -> Simulator<R> {
        let mut free = self.lock();
        let found = free.iter().position(|s| Arc::ptr_eq(s.model(), model)).map(|at| free.swap_remove(at));
        drop(free);
        let mut sim = found.unwrap_or_else(|| Simulator::new(model.clone(), settings));
        sim.set_settings(settings);
        sim
    }

    /// Simulators of models that nobody uses any more go.
    fn keep(&self, groups: &[Vec<Due>]) {
        self.lock().retain(|s| groups.iter().any(|g| Arc::ptr_eq(g[0].body.model(), s.model())));
    }
}

/// Runs the steps of a tick for all bodies.
pub(super) fn step_all(due: Vec<Due>, lanes: bool, surroundings: &Surroundings, kept: &LaneSimulators) {
    let groups = group(due, lanes);
    kept.double.keep(&groups);
    kept.single.keep(&groups);
    let run = |mut group: Vec<Due>| {
        match group.as_mut_slice() {
            several if is_single(&several[0]) => kept.single.step(several, surroundings),
            [due] => due.body.step_alone(due.steps, &mut &*surroundings),
            several => kept.double.step(several, surroundings),
        }
        for due in &mut group {
            due.body.end_tick(due.settings);
        }
    };
    if groups.len() == 1 {
        groups.into_iter().for_each(run);
    } else {
        let run = &run;
        ComputeTaskPool::get_or_init(TaskPool::default)
            .scope(|scope| groups.into_iter().for_each(|group| scope.spawn(async move { run(group) })));
    }
}

/// Grips and outside forces are common to all lanes: a body that has any steps alone.
fn goes_together(due: &Due) -> bool {
    let sim = due.body.simulator();
    sim.external.is_empty() && sim.state.grip_anchors.iter().all(Option::is_none)
}

/// Whether the steps of this tick are of single precision.
fn is_single(due: &Due) -> bool {
    due.settings.precision == AthletePrecision::Single && goes_together(due)
}

fn fit(a: &Due, b: &Due) -> bool {
    let (x, y) = (a.body.simulator(), b.body.simulator());
    let same = a.steps == b.steps && is_single(a) == is_single(b);
    same && Arc::ptr_eq(x.model(), y.model()) && x.settings() == y.settings()
}

/// Groups of bodies that can step together; without lanes, of one.
fn group(due: Vec<Due>, lanes: bool) -> Vec<Vec<Due>> {
    let mut groups: Vec<Vec<Due>> = Vec::with_capacity(due.len());
    // Those that have room left.
    let mut open: Vec<usize> = Vec::new();
    for due in due {
        if !lanes || !goes_together(&due) {
            groups.push(vec![due]);
            continue;
        }
        match open.iter().position(|&g| fit(&groups[g][0], &due)) {
            Some(k) => {
                let size = if is_single(&due) { F32x8::LANES } else { F64x4::LANES };
                let members = &mut groups[open[k]];
                members.push(due);
                if members.len() == size {
                    open.swap_remove(k);
                }
            }
            None => {
                open.push(groups.len());
                groups.push(vec![due]);
            }
        }
    }
    groups
}

/// The steps of bodies that fit each other, each in a lane; lanes that are left over repeat the last body.
fn step_together<R: Real>(group: &mut [Due], sim: &mut Simulator<R>, surroundings: &Surroundings) {
    let last = group.len() - 1;
    for lane in 0..R::LANES {
        sim.put_lane(lane, group[lane.min(last)].body.simulator(), 0);
    }
    sim.state.grip_anchors.fill(None);
    sim.forget_terrain_failures();
    for _ in 0..group[0].steps {
        for (lane, due) in group.iter_mut().enumerate() {
            if due.body.drive() {
                put_commands(sim, lane, last, due.body);
            }
        }
        step(sim, surroundings);
        let touches = Touches::of(sim, &group[0].body.watch);
        for (lane, due) in group.iter_mut().enumerate() {
            let body = &mut *due.body;
            // One that was stopped in the middle of the tick stays where it was; its lane goes on unseen.
            if body.quarantine.is_some() {
                continue;
            }
            body.watch_step(sim, lane, &touches, surroundings);
            if body.looks_at_state() {
                body.simulator.take_lane(sim, lane);
            }
            if body.after_step() {
                put_commands(sim, lane, last, body);
            }
        }
    }
    for (lane, due) in group.iter_mut().enumerate() {
        if due.body.quarantine.is_none() {
            due.body.simulator.take_lane(sim, lane);
        }
    }
}

/// The commands of a body into its lane, and of the last one into those that repeat it.
fn put_commands<R: Real>(sim: &mut Simulator<R>, lane: usize, last: usize, body: &AthleteBody) {
    let repeated = if lane == last { R::LANES - 1 } else { lane };
    for to in lane..=repeated {
        sim.put_commands(to, body.simulator(), 0);
    }
}
