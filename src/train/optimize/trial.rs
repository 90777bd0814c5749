//! Playing offsets from a state and measuring what the windows ask for.

use super::Plan;
use crate::contact::World;
use crate::control::{Offset, fallen, offset_rotation, tracking_error};
use crate::dynamics::State;
use crate::math::{Real, Vec3};
use crate::model::{CharacterModel, ContactKind};
use crate::sim::{Simulator, step};
use crate::train::objectives::{Meter, Target};
use glam::DVec3;

/// What a fall costs at the end of what is tried; twice as much at its beginning.
pub(super) const FALL_COST: f64 = 1000.0;
/// Largest offset of a target, rad.
const MAX_OFFSET: f64 = 1.6;

/// An offset within its bound.
pub(super) fn bounded(offset: DVec3) -> DVec3 {
    offset.clamp_length_max(MAX_OFFSET)
}

/// Costs of the windows that were tried, in one lane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialCosts {
    /// For each window, the weighted cost of each of its objectives.
    pub windows: Vec<Vec<f64>>,
    /// Tick in which the character fell; nothing is measured from there on.
    pub fell_at: Option<usize>,
    /// What the fall costs.
    pub fall: f64,
}

impl TrialCosts {
    /// Everything added up.
    pub fn total(&self) -> f64 {
        self.fall + self.windows.iter().flatten().sum::<f64>()
    }
}

/// Simulates windows in the lanes of one simulator.
pub(super) struct Trial<R: Real> {
    pub sim: Simulator<R>,
    meter: Meter,
}

impl<R: Real> Trial<R> {
    pub fn new(plan: &Plan, gains: Option<(f64, f64)>) -> Self {
        let mut sim = Simulator::new(plan.model.clone(), plan.settings);
        if let Some((kp, kd)) = gains {
            for command in &mut sim.commands {
                command.kp = R::splat(kp);
                command.kd = R::splat(kd);
            }
        }
        Self { sim, meter: Meter::new(&plan.model) }
    }

    /// Puts every lane into a state.
    pub fn restart(&mut self, state: &State<f64>) {
        for lane in 0..R::LANES {
            self.sim.state.copy_lane(lane, state, 0);
        }
        self.sim.state.time = state.time;
        self.sim.state_changed();
    }

    /// Sets the targets of a tick, as [`crate::control::ControlPlayer`] does: `offset` says what lane and link are off.
    fn command(&mut self, plan: &Plan, tick: usize, mut offset: impl FnMut(usize, usize) -> Offset) {
        let target = &plan.reference.ticks[(tick + 1).min(plan.reference.ticks.len() - 1)];
        for (i, command) in self.sim.commands.iter_mut().enumerate().skip(1) {
            for lane in 0..R::LANES {
                command.rotation.set_lane(lane, target.pose.joints[i] * offset_rotation(offset(lane, i)));
            }
            command.velocity = Vec3::splat(target.velocity.joints[i]);
        }
    }

    /// Plays windows `first..last` from the present state and measures them. `offset(tick, lane, link)` is the offset of a
    /// target, within its bound. Ends early where every lane has fallen.
    pub fn run(
        &mut self,
        plan: &Plan,
        world: &World,
        (first, last): (usize, usize),
        mut offset: impl FnMut(usize, usize, usize) -> Offset,
    ) -> Vec<TrialCosts> {
        let windows = &plan.windows[first..last.min(plan.windows.len())];
        let empty: Vec<Vec<f64>> = windows.iter().map(|w| vec![0.0; w.objectives.len()]).collect();
        let mut costs = vec![TrialCosts { windows: empty, ..TrialCosts::default() }; R::LANES];
        let (Some(begin), Some(end)) = (windows.first().map(|w| w.ticks.start), windows.last().map(|w| w.ticks.end))
        else {
            return costs;
        };
        for (number, window) in windows.iter().enumerate() {
            for tick in window.ticks.clone() {
                self.command(plan, tick, |lane, link| offset(tick, lane, link));
                for _ in 0..plan.steps_per_tick {
                    step(&mut self.sim, world);
                }
                let aim = &plan.reference.ticks[(tick + 1).min(plan.reference.ticks.len() - 1)];
                for (lane, cost) in costs.iter_mut().enumerate() {
                    if cost.fell_at.is_none() && self.is_down(lane, &aim.pose) {
                        cost.fell_at = Some(tick);
                        cost.fall = FALL_COST * (1.0 + (end - tick) as f64 / (end - begin) as f64);
                    }
                }
                if costs.iter().all(|c| c.fell_at.is_some()) {
                    return costs;
                }
                let target = Target::<R>::new(aim);
                for (k, objective) in window.objectives.iter().enumerate() {
                    let (weight, at_end) = objective.weight();
                    if weight == 0.0 || (at_end && tick + 1 != window.ticks.end) {
                        continue;
                    }
                    let share = if at_end { weight } else { weight / window.ticks.len() as f64 };
                    let value = self.meter.measure(&mut self.sim, objective, &target);
                    for (lane, cost) in costs.iter_mut().enumerate().filter(|(_, c)| c.fell_at.is_none()) {
                        cost.windows[number][k] += share * value.lane(lane);
                    }
                }
            }
        }
        costs
    }

    /// Whether a lane has fallen: far from its reference, out of range, or a skater on the ice with more than its
    /// blades.
    fn is_down(&self, lane: usize, pose: &crate::model::ModelPose) -> bool {
        let error = tracking_error(&self.sim, lane, pose);
        fallen(&self.sim, lane, pose, &error).is_some() || touches(self.sim.model(), &self.sim, lane)
    }
}

fn touches<R: Real>(model: &CharacterModel, sim: &Simulator<R>, lane: usize) -> bool {
    let touching = |(index, point): (usize, &crate::model::ContactPoint)| {
        point.kind == ContactKind::Point && sim.contact_force(index, lane) != DVec3::ZERO
    };
    !model.blades.is_empty() && model.contact_points.iter().enumerate().any(touching)
}
