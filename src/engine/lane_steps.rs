//! Stepping many bodies: those that can step together share a simulator with a lane for each, and the groups are split
//! over the threads of the compute pool.
//!
//! A lane has the bits of a run alone, so neither the grouping nor the number of threads shows in any result; bodies in
//! lanes cost little more than one alone. Bodies of single precision are in lanes of eight even where they are alone.
//! The last bits of a network's output may depend on how many rows it is asked for at once. Who decides at the same steps
//! by the same policy is put into the same group, and they decide together where the machine gives each row the bits that
//! it has alone, else one by one.

use crate::contact::World as Surroundings;
use crate::control::tracking::com_velocity;
use crate::engine::event_detector::Touches;
use crate::engine::{AthleteBody, AthletePrecision, AthleteSettings};
use crate::math::{F32x8Fused, F64x4, Real};
use crate::model::SharedModel;
use crate::sim::{SimulationSettings, Simulator, step};
use crate::skill::{Rhythm, SkillPlayer};
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
    /// What it stands on.
    pub world: &'a Surroundings,
}

/// Common simulators that wait for their next use. What they hold is written over.
#[derive(Debug, Default)]
pub(super) struct LaneSimulators {
    double: Waiting<F64x4>,
    single: Waiting<F32x8Fused>,
}

/// Simulators of one kind of lane.
#[derive(Debug)]
struct Waiting<R: Real>(Mutex<Vec<Common<R>>>);

/// A common simulator, and room for what the policies of those in its lanes see and say.
#[derive(Debug)]
struct Common<R: Real> {
    sim: Simulator<R>,
    /// Lanes that decide by the same policy, what it sees of them, and what it says.
    lanes: Vec<usize>,
    rows: Vec<f32>,
    actions: Vec<f32>,
}

impl<R: Real> Default for Waiting<R> {
    fn default() -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

impl<R: Real> Waiting<R> {
    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Common<R>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Steps a group with a simulator that waits, or a new one.
    fn step(&self, group: &mut [Due]) {
        let (model, settings) = (group[0].body.model(), *group[0].body.simulator().settings());
        let mut common = self.take(model, settings);
        common.step(group);
        self.lock().push(common);
    }

    fn take(&self, model: &SharedModel, settings: SimulationSettings) -> Common<R> {
        let mut free = self.lock();
        let found = free.iter().position(|c| Arc::ptr_eq(c.sim.model(), model)).map(|at| free.swap_remove(at));
        drop(free);
        let mut common = found.unwrap_or_else(|| Common::new(Simulator::new(model.clone(), settings)));
        common.sim.set_settings(settings);
        common
    }

    /// Simulators of models that nobody uses any more go.
    fn keep(&self, groups: &[Vec<Due>]) {
        self.lock().retain(|c| groups.iter().any(|g| Arc::ptr_eq(g[0].body.model(), c.sim.model())));
    }
}

/// Runs the steps of a tick for all bodies.
pub(super) fn step_all(due: Vec<Due>, lanes: bool, kept: &LaneSimulators) {
    let groups = group(due, lanes);
    kept.double.keep(&groups);
    kept.single.keep(&groups);
    let run = |mut group: Vec<Due>| {
        match group.as_mut_slice() {
            several if is_single(&several[0]) => kept.single.step(several),
            [due] => due.body.step_alone(due.steps, &mut &*due.world),
            several => kept.double.step(several),
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

/// Outside forces are common to all lanes: a body that has any steps alone. So does one that balances.
fn goes_together(due: &Due) -> bool {
    due.body.simulator().external.is_empty() && !due.body.steps_alone()
}

/// Whether the steps of this tick are of single precision.
fn is_single(due: &Due) -> bool {
    due.settings.precision == AthletePrecision::Single && goes_together(due)
}

fn fit(a: &Due, b: &Due) -> bool {
    let (x, y) = (a.body.simulator(), b.body.simulator());
    let same = a.steps == b.steps && is_single(a) == is_single(b) && std::ptr::eq(a.world, b.world);
    same && Arc::ptr_eq(x.model(), y.model()) && x.settings() == y.settings()
}

fn lanes_for(due: &Due) -> usize {
    if is_single(due) { F32x8Fused::LANES } else { F64x4::LANES }
}

/// Bodies in the order in which they are put into groups. First those of whom a whole group decides at the same steps by
/// the same policy; then the others by where they are in their motions, since contact is solved for the blades of all lanes.
fn in_rhythm(mut due: Vec<Due>) -> Vec<Due> {
    let rhythm = |d: &Due| d.body.skill_player().map(SkillPlayer::rhythm);
    // Those of one world together; which world comes first does not matter.
    due.sort_by_key(|d| (std::ptr::from_ref(d.world).addr(), rhythm(d)));
    let keys: Vec<_> = due.iter().map(|d| (std::ptr::from_ref(d.world).addr(), rhythm(d))).collect();
    let mut whole = vec![false; due.len()];
    let beat = |(world, rhythm): &(usize, Option<Rhythm>)| (*world, rhythm.map(|r| (r.policy, r.step)));
    let together = |a: &(usize, Option<Rhythm>), b: &(usize, Option<Rhythm>)| beat(a) == beat(b);
    let mut start = 0;
    for run in keys.chunk_by(together) {
        let size = lanes_for(&due[start]);
        whole[start..start + run.len() / size * size].fill(true);
        start += run.len();
    }
    let mut whole = whole.into_iter();
    let (mut order, mut rest): (Vec<_>, Vec<_>) = due.into_iter().partition(|_| whole.next() == Some(true));
    rest.sort_by_key(|d| (std::ptr::from_ref(d.world).addr(), rhythm(d).map(|r| (r.policy, r.tick, r.step))));
    order.append(&mut rest);
    order
}

/// Groups of bodies that can step together; without lanes, of one.
fn group(due: Vec<Due>, lanes: bool) -> Vec<Vec<Due>> {
    let due = if lanes { in_rhythm(due) } else { due };
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
                let size = lanes_for(&due);
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

impl<R: Real> Common<R> {
    fn new(sim: Simulator<R>) -> Self {
        Self { sim, lanes: Vec::new(), rows: Vec::new(), actions: Vec::new() }
    }

    /// The steps of bodies that fit each other, each in a lane; lanes that are left over repeat the last body.
    fn step(&mut self, group: &mut [Due]) {
        let (last, world) = (group.len() - 1, group[0].world);
        for lane in 0..R::LANES {
            self.sim.put_lane(lane, group[lane.min(last)].body.simulator(), 0);
        }
        self.sim.forget_terrain_failures();
        for _ in 0..group[0].steps {
            self.decide(group);
            let sim = &mut self.sim;
            for (lane, due) in group.iter_mut().enumerate() {
                if due.body.drive() {
                    put_commands(sim, lane, last, due.body);
                }
            }
            step(sim, world);
            let touches = Touches::of(sim, &group[0].body.detector);
            for (lane, due) in group.iter_mut().enumerate() {
                let body = &mut *due.body;
                // One that was stopped in the middle of the tick stays where it was; its lane goes on unseen.
                if body.quarantine.is_some() {
                    continue;
                }
                body.watch_step(sim, lane, &touches, world);
                if body.looks_at_state() {
                    body.simulator.take_lane(sim, lane);
                }
                if body.after_step(world) {
                    put_commands(sim, lane, last, body);
                }
            }
        }
        for (lane, due) in group.iter_mut().enumerate() {
            if due.body.quarantine.is_none() {
                due.body.simulator.take_lane(&self.sim, lane);
            }
        }
    }

    /// The decisions that are due before a step.
    fn decide(&mut self, group: &mut [Due]) {
        // The velocity of the centre of mass is asked for once, if anybody decides.
        let mut velocity = None;
        self.lanes.clear();
        for (lane, due) in group.iter_mut().enumerate() {
            if due.body.prepare_decision(&due.world) {
                let velocity = *velocity.get_or_insert_with(|| com_velocity(&mut self.sim));
                due.body.observe(&self.sim, lane, velocity);
                self.lanes.push(lane);
            }
        }
        while let Some(&first) = self.lanes.first() {
            self.decide_like(first, group);
        }
    }

    /// Lets all lanes that are left decide who have the policy of lane `first`.
    fn decide_like(&mut self, first: usize, group: &mut [Due]) {
        let Some(skill) = group[first].body.skill_player().map(|player| player.skill().clone()) else {
            self.lanes.retain(|lane| *lane != first);
            return;
        };
        self.rows.clear();
        let mut asked = 0_u32;
        for &lane in &self.lanes {
            if let Some(player) = group[lane].body.skill_player()
                && player.skill().policy.is(&skill.policy)
            {
                self.rows.extend_from_slice(player.observation());
                asked |= 1 << lane;
            }
        }
        self.lanes.retain(|lane| asked >> lane & 1 == 0);
        let result = skill.policy.act_each(&self.rows, asked.count_ones() as usize, &mut self.actions);
        let mut actions = self.actions.chunks_exact(skill.policy.contract().action_size());
        for (lane, due) in group.iter_mut().enumerate() {
            if asked >> lane & 1 == 1 {
                due.body.decide(if result.is_ok() { actions.next() } else { None });
            }
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
