//! Stepping many bodies: those that can step together share a simulator with a lane for each, and the groups are split
//! over the threads of the compute pool.
//!
//! A lane of four has the bits of a scalar run, so neither the grouping nor the number of threads shows in any result; four
//! bodies in lanes cost little more than one alone. Policies decide body by body: the last bits of a network's output
//! depend on how many rows it is asked for at once.

use crate::contact::World as Surroundings;
use crate::engine::watch::Touches;
use crate::engine::{AthleteBody, AthleteSettings};
use crate::math::{F64x4, Real};
use crate::model::SharedModel;
use crate::sim::{SimulationSettings, Simulator, step};
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPool};
use std::sync::{Arc, Mutex, PoisonError};

/// Bodies in a group.
const LANES: usize = <F64x4 as Real>::LANES;

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
pub(super) struct LaneSimulators(Vec<Simulator<F64x4>>);

/// Runs the steps of a tick for all bodies.
pub(super) fn step_all(due: Vec<Due>, lanes: bool, surroundings: &Surroundings, kept: &mut LaneSimulators) {
    let groups = group(due, if lanes { LANES } else { 1 });
    // Simulators of models that nobody uses any more go.
    kept.0.retain(|s| groups.iter().any(|g| Arc::ptr_eq(g[0].body.model(), s.model())));
    let free = Mutex::new(std::mem::take(&mut kept.0));
    let run = |mut group: Vec<Due>| {
        match group.as_mut_slice() {
            [due] => due.body.step_alone(due.steps, &mut &*surroundings),
            several => {
                let mut sim = take(&free, several[0].body.model(), *several[0].body.simulator().settings());
                step_together(several, &mut sim, surroundings);
                lock(&free).push(sim);
            }
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
    kept.0 = free.into_inner().unwrap_or_else(PoisonError::into_inner);
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn take(free: &Mutex<Vec<Simulator<F64x4>>>, model: &SharedModel, settings: SimulationSettings) -> Simulator<F64x4> {
    let mut free = lock(free);
    let found = free.iter().position(|s| Arc::ptr_eq(s.model(), model)).map(|at| free.swap_remove(at));
    drop(free);
    let mut sim = found.unwrap_or_else(|| Simulator::new(model.clone(), settings));
    sim.set_settings(settings);
    sim
}

/// Grips and outside forces are common to all lanes: a body that has any steps alone.
fn goes_together(due: &Due) -> bool {
    let sim = due.body.simulator();
    sim.external.is_empty() && sim.state.grip_anchors.iter().all(Option::is_none)
}

fn fit(a: &Due, b: &Due) -> bool {
    let (x, y) = (a.body.simulator(), b.body.simulator());
    a.steps == b.steps && Arc::ptr_eq(x.model(), y.model()) && x.settings() == y.settings()
}

/// Groups of up to `size` bodies that can step together.
fn group(due: Vec<Due>, size: usize) -> Vec<Vec<Due>> {
    let mut groups: Vec<Vec<Due>> = Vec::with_capacity(due.len());
    // Those that have room left.
    let mut open: Vec<usize> = Vec::new();
    for due in due {
        if size == 1 || !goes_together(&due) {
            groups.push(vec![due]);
            continue;
        }
        match open.iter().position(|&g| fit(&groups[g][0], &due)) {
            Some(k) => {
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

/// The steps of two to four bodies that fit each other, each in a lane; lanes that are left over repeat the last body.
fn step_together(group: &mut [Due], sim: &mut Simulator<F64x4>, surroundings: &Surroundings) {
    let last = group.len() - 1;
    for lane in 0..LANES {
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
fn put_commands(sim: &mut Simulator<F64x4>, lane: usize, last: usize, body: &AthleteBody) {
    let repeated = if lane == last { LANES - 1 } else { lane };
    for to in lane..=repeated {
        sim.put_commands(to, body.simulator(), 0);
    }
}
