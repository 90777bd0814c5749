//! A body through a fixed tick: the checks before it, the sequence around each step, the checks after it.
//!
//! The step itself is either that of the body's own simulator or that of a common one in whose lane the body is
//! (`lane_steps.rs`). Both ways call the same functions in the same order.

use crate::contact::Terrain;
use crate::control::tracking::{AllLanes, OneLane};
use crate::engine::body::still;
use crate::engine::controller::Controller;
use crate::engine::event_detector::{BodyEvent, Touches};
use crate::engine::ground::Ground;
use crate::engine::quarantine::bad_input;
use crate::engine::{AthleteBody, AthleteDetail, AthleteSettings, QuarantineReason};
use crate::math::{Real, Vec3};
use crate::sim::{Simulator, step};
use std::time::Duration;

impl AthleteBody {
    /// Stops the body for a reason; told once.
    pub(super) fn stop(&mut self, reason: QuarantineReason) {
        if self.quarantine.is_none() {
            self.quarantine = Some(reason);
            self.events.push(BodyEvent::Quarantined { time: self.simulator.state.time, reason });
        }
    }

    /// The number of whole steps that are due after another `dt`; none for a body that is stopped, paused or frozen.
    pub(super) fn begin_tick(&mut self, dt: Duration, settings: &AthleteSettings) -> u32 {
        self.last_tick = 0.0;
        if self.quarantine.is_some() || settings.paused || self.detail == AthleteDetail::Frozen {
            return 0;
        }
        if let Some(reason) = bad_input(&self.simulator) {
            self.stop(reason);
            return 0;
        }
        self.follow_detail();
        self.simulator.forget_terrain_failures();
        let rate = self.simulator.settings().rate;
        let due = self.clock.take(dt, rate);
        self.last_tick = f64::from(due) / rate;
        due
    }

    /// Goes on at the rate of its level of detail, as soon as that can be done without a seam.
    fn follow_detail(&mut self) {
        if matches!(self.controller, Controller::Play { .. }) {
            return;
        }
        let part = if self.detail == AthleteDetail::Reduced { AthleteDetail::REDUCED_RATE } else { 1.0 };
        let (now, wanted) = (self.simulator.settings().rate, self.full_rate() * part);
        if now != wanted && self.controller.set_rate(wanted) {
            self.simulator.change_rate(wanted);
            self.clock.change_rate(now, wanted);
        }
    }

    /// Gets ready for the decision before the coming step on this ground; false if there is none to make. The simulator has to be
    /// up to date where there is.
    pub(super) fn prepare_decision(&mut self, terrain: &impl Terrain<f64>) -> bool {
        if self.quarantine.is_some() || !self.controller.at_decision() {
            return false;
        }
        if !self.simulator.is_sane(0) {
            self.stop(self.what_went_wrong());
            return false;
        }
        let Controller::Direct { director, .. } = &mut self.controller else { return false };
        director.prepare(&mut self.simulator, terrain);
        director.player_mut().look_ahead(&mut self.simulator, terrain);
        true
    }

    /// Lets the policy look at the body as it is in lane `lane` of `sim`, kinematics up to date.
    pub(super) fn observe<R: Real>(&mut self, sim: &Simulator<R>, lane: usize, com_velocity: Vec3<R>) {
        if let Controller::Direct { director, .. } = &mut self.controller {
            director.player_mut().observe(&OneLane::of(sim, lane, com_velocity));
        }
    }

    /// Decides about what was observed, alone.
    pub(super) fn decide_alone(&mut self) {
        let Some(director) = self.director_mut() else { return };
        let player = director.player_mut();
        if player.decide_alone().is_err() || player.bad_action() {
            self.stop(QuarantineReason::Policy);
        }
    }

    /// Decides what the policy said about what was observed; `None` if it could not be asked.
    pub(super) fn decide(&mut self, action: Option<&[f32]>) {
        let Some(director) = self.director_mut() else { return };
        let player = director.player_mut();
        if let Some(action) = action {
            player.decide(action);
        }
        if action.is_none() || player.bad_action() {
            self.stop(QuarantineReason::Policy);
        }
    }

    /// Sets the targets of the coming step; true if any changed.
    pub(super) fn drive(&mut self) -> bool {
        self.quarantine.is_none() && self.controller.drive(&mut self.simulator)
    }

    /// Looks at the step that lane `lane` of `sim` has done for this body.
    pub(super) fn watch_step<R: Real>(
        &mut self,
        sim: &mut Simulator<R>,
        lane: usize,
        touches: &Touches<R>,
        surroundings: &impl Terrain<f64>,
    ) {
        self.simulator.state.time += self.simulator.step_seconds();
        let time = self.simulator.state.time;
        let rolls = self.controller.rolls();
        self.detector.observe(sim, lane, time, rolls, touches, surroundings, &mut self.events);
    }

    /// Whether it looks at body and ground before every step, and has to be stepped alone.
    pub(super) fn steps_alone(&self) -> bool {
        matches!(self.controller, Controller::Balance { .. })
    }

    /// Whether the controller looks at the state after this step.
    pub(super) fn looks_at_state(&self) -> bool {
        self.controller.at_decision()
    }

    /// Lets the controller move on after a step; true if it changed targets.
    pub(super) fn after_step(&mut self, terrain: &impl Terrain<f64>) -> bool {
        if let Controller::Direct { director, .. } = &mut self.controller {
            director.after_step(&mut self.simulator, terrain);
        }
        self.collect_events();
        let time = self.simulator.state.time;
        match &mut self.controller {
            Controller::Balance { balance, .. } => {
                self.detector.observe_balance(balance.outside(), time, &mut self.events);
                false
            }
            Controller::Direct { director, finished } => {
                if finished.is_none() && director.is_finished() {
                    *finished = Some(time);
                    self.events.extend(self.performs.take().map(|skill| BodyEvent::SkillEnded { time, skill }));
                    self.events.push(BodyEvent::Finished { time });
                }
                false
            }
            Controller::Play { player, finished, .. } if finished.is_none() && player.is_finished() => {
                *finished = Some(time);
                still(&mut self.simulator);
                self.events.push(BodyEvent::Finished { time });
                true
            }
            Controller::Hold | Controller::Play { .. } => false,
        }
    }

    /// Runs the steps of a tick with the body's own simulator.
    pub(super) fn step_alone(&mut self, due: u32, ground: &mut impl Ground) {
        for _ in 0..due {
            if self.prepare_decision(ground) {
                if let Controller::Direct { director, .. } = &mut self.controller {
                    director.player_mut().observe(&AllLanes::of(&mut self.simulator));
                }
                self.decide_alone();
            }
            self.drive();
            if self.quarantine.is_some() {
                return;
            }
            self.controller.before_step(&mut self.simulator, ground);
            step(&mut self.simulator, ground);
            ground.stepped(&self.simulator);
            let touches = Touches::of(&self.simulator, &self.detector);
            let time = self.simulator.state.time;
            let rolls = self.controller.rolls();
            self.detector.observe(&mut self.simulator, 0, time, rolls, &touches, ground, &mut self.events);
            self.after_step(ground);
        }
    }

    /// The whole tick on a ground of its own.
    #[cfg(feature = "avian")]
    pub(super) fn advance(&mut self, dt: Duration, ground: &mut impl Ground, settings: &AthleteSettings) {
        let due = self.begin_tick(dt, settings);
        if due > 0 {
            self.step_alone(due, ground);
            self.end_tick(settings);
        }
    }

    /// After the steps of a tick: whether it is still sound, and whether it starts over.
    pub(super) fn end_tick(&mut self, settings: &AthleteSettings) {
        if self.quarantine.is_some() {
            return;
        }
        if self.simulator.terrain_failed(0) || !self.simulator.is_sane(0) {
            self.stop(self.what_went_wrong());
        } else if let (Some(wait), Some(since)) = (settings.restart_after, self.since_control_end())
            && since >= f64::from(wait)
        {
            self.reset();
        }
    }

    fn what_went_wrong(&self) -> QuarantineReason {
        if self.simulator.terrain_failed(0) { QuarantineReason::Terrain } else { QuarantineReason::Unstable }
    }
}
