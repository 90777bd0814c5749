//! The simulation of one athlete.

use crate::contact::BladeEdge;
use crate::control::balance::{AnkleStance, Balance, BalanceError, BalanceSettings, Stance};
use crate::control::tracking::Heading;
use crate::control::{ControlError, ControlPlayer, ReconstructedControl, TrackingError, tracking_error};
use crate::engine::controller::Controller;
use crate::engine::event_detector::{BodyEvent, EventDetector};
use crate::engine::step_clock::StepClock;
use crate::engine::{AthleteDetail, AthleteSettings, AthleteTargets, LinkId, Placement, QuarantineReason};
use crate::math::{Quat, Vec3};
use crate::model::{LinkTransform, SharedModel};
use crate::sim::{SimulationSettings, Simulator};
use crate::skill::{Director, DirectorEvent, Entry, NoEntry, SkillPlayer};
use bevy::math::{DQuat, DVec3};
use bevy::prelude::{Component, Reflect, ReflectComponent, Transform};
use std::sync::Arc;

/// Whether a body is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Reflect)]
pub enum BodyStatus {
    /// It is.
    #[default]
    Running,
    /// Its state went bad; it waits for a reset.
    Quarantined,
}

/// The simulation of one athlete: scalar f64, unfused, the same bits everywhere.
///
/// Added by the plugin once the athlete's files have arrived.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(opaque)]
#[reflect(Component)]
pub struct AthleteBody {
    pub(super) simulator: Simulator<f64>,
    pub(super) placement: Placement,
    pub(super) controller: Controller,
    /// The controller as it was given, for snapshots.
    pub(super) given: Arc<Controller>,
    pub(super) clock: StepClock,
    pub(super) detector: EventDetector,
    pub(super) quarantine: Option<QuarantineReason>,
    /// Set by a reset: nothing is interpolated across it.
    pub(super) jumped: bool,
    pub(super) detail: AthleteDetail,
    /// Simulated time of the last tick, s.
    pub(super) last_tick: f64,
    /// A reset was asked for, maybe to another place.
    pub(super) reset_request: Option<Option<Transform>>,
    /// Skills that were asked for since the last tick.
    pub(super) requests: Vec<String>,
    pub(super) events: Vec<BodyEvent>,
    /// Name of the skill that was told to have begun.
    pub(super) performs: Option<String>,
}

impl AthleteBody {
    /// A body that stands in its zero pose at a place and holds it.
    pub fn new(model: SharedModel, placement: Placement) -> Self {
        let settings = SimulationSettings::of(&model);
        let mut body = Self {
            detector: EventDetector::new(&model),
            simulator: Simulator::new(model, settings),
            placement,
            controller: Controller::Hold,
            given: Arc::new(Controller::Hold),
            clock: StepClock::default(),
            quarantine: None,
            jumped: true,
            detail: AthleteDetail::Full,
            last_tick: 0.0,
            reset_request: None,
            requests: Vec::new(),
            events: Vec::with_capacity(8),
            performs: None,
        };
        body.reset();
        body
    }

    /// The simulator: model, state, settings, what touches.
    pub fn simulator(&self) -> &Simulator<f64> {
        &self.simulator
    }
    /// The simulator, to push the athlete or to change its state; call `state_changed` after the latter.
    pub fn simulator_mut(&mut self) -> &mut Simulator<f64> {
        &mut self.simulator
    }
    /// The character.
    pub fn model(&self) -> &SharedModel {
        self.simulator.model()
    }
    /// The link of this name.
    pub fn link(&self, name: &str) -> Option<LinkId> {
        LinkId::of(self.model(), name)
    }
    /// Where its own frame lies.
    pub fn placement(&self) -> &Placement {
        &self.placement
    }
    /// Whether it is stepped.
    pub fn status(&self) -> BodyStatus {
        if self.quarantine.is_some() { BodyStatus::Quarantined } else { BodyStatus::Running }
    }
    /// Why it is not stepped; `None` while it is.
    pub fn quarantine_reason(&self) -> Option<QuarantineReason> {
        self.quarantine
    }
    /// Simulated time since the start of the control, s.
    pub fn time(&self) -> f64 {
        self.simulator.state.time
    }
    /// Edge of a blade by its index in the character.
    pub fn blade_edge(&self, blade: usize) -> BladeEdge {
        self.simulator.blade_edge(blade, 0)
    }
    /// Velocity of the root link, world axes, m/s.
    pub fn root_velocity(&self) -> DVec3 {
        self.simulator.state.root_velocity.linear.lane(0)
    }
    /// Seconds since the control ended, s; `None` while it plays, or without one.
    pub fn since_control_end(&self) -> Option<f64> {
        match &self.controller {
            Controller::Play { finished: Some(at), .. } | Controller::Direct { finished: Some(at), .. } => {
                Some(self.time() - at)
            }
            _ => None,
        }
    }
    /// Length of the control that plays, s.
    pub fn control_seconds(&self) -> Option<f64> {
        match &self.controller {
            Controller::Play { player, .. } => Some(player.reference().duration()),
            Controller::Hold | Controller::Direct { .. } | Controller::Balance { .. } => None,
        }
    }

    /// The player of the trained skill that is performed.
    pub fn skill_player(&self) -> Option<&SkillPlayer> {
        match &self.controller {
            Controller::Direct { director, .. } => Some(director.player()),
            _ => None,
        }
    }

    /// Deviation from the reference of the control that plays or the skill that is performed, at the present time.
    pub fn tracking_error(&self) -> Option<TrackingError> {
        let pose = match &self.controller {
            Controller::Hold | Controller::Balance { .. } => return None,
            Controller::Play { player, .. } => &player.reference().at(self.time()).pose,
            Controller::Direct { director, .. } => &director.player().reference_pose(),
        };
        Some(tracking_error(&self.simulator, 0, pose))
    }

    /// Where the reference of the control that plays has the links at time `t` (s), or that of the skill at the
    /// last fixed tick, world frame, by link index; false and an empty list without either.
    pub fn reference_links(&self, t: f64, out: &mut Vec<LinkTransform>) -> bool {
        out.clear();
        let player = match &self.controller {
            Controller::Hold | Controller::Balance { .. } => return false,
            Controller::Direct { director, .. } => {
                director.player().reference_pose().link_transforms(self.model(), out);
                return true;
            }
            Controller::Play { player, .. } => player,
        };
        let reference = player.reference();
        let next = reference.at(t + 1.0 / reference.tick_rate);
        let before = reference.at(t);
        let s = (t * reference.tick_rate).fract().clamp(0.0, 1.0);
        before.pose.mix(&next.pose, s).link_transforms(self.model(), out);
        true
    }

    /// Makes a control drive the body, from its first pose on.
    pub fn play(&mut self, control: Arc<ReconstructedControl>) -> Result<(), ControlError> {
        let placed = self.placement;
        let player = ControlPlayer::new(&placed.move_control(&control), self.simulator.model())?;
        self.give(Controller::Play { control, player, placed, finished: None });
        self.reset();
        Ok(())
    }

    /// Makes trained skills drive the body, from their start on.
    pub fn direct(&mut self, director: Director) {
        self.give(Controller::Direct { director: Box::new(director), finished: None });
        self.reset();
    }

    /// Keeps the body standing from where it is, by control of momentum; a body that stands so already takes the stance of `balance`.
    pub fn balance(&mut self, stance: Stance) -> Result<(), BalanceError> {
        if let Controller::Balance { balance, stance: wanted, .. } = &mut self.controller {
            balance.assume(stance.clone())?;
            *wanted = stance;
            return Ok(());
        }
        let mut balance = Balance::new(self.simulator.model(), BalanceSettings::default())?;
        balance.assume(stance.clone())?;
        self.give(Controller::Balance { balance: Box::new(balance), stance, begun: false });
        Ok(())
    }

    /// What its feet are asked to stand on while it balances, by their number in the character; `None` while it does not.
    pub fn feet_asked(&self) -> Option<&[AnkleStance]> {
        match &self.controller {
            Controller::Balance { stance, .. } => Some(&stance.feet),
            _ => None,
        }
    }

    fn give(&mut self, controller: Controller) {
        self.refuse_request(NoEntry::Restarted);
        self.given = Arc::new(controller.clone());
        if self.steps_alone() {
            // Torques and loose servos were its own.
            let model = self.simulator.model().clone();
            for (command, link) in self.simulator.commands.iter_mut().zip(&model.links) {
                command.torque = Vec3::zero();
                (command.kp, command.kd) = (link.gains.kp, link.gains.kd);
            }
        }
        self.controller = controller;
    }

    /// What chooses the trained skills that are performed.
    pub fn director(&self) -> Option<&Director> {
        match &self.controller {
            Controller::Direct { director, .. } => Some(director),
            _ => None,
        }
    }

    pub(super) fn director_mut(&mut self) -> Option<&mut Director> {
        match &mut self.controller {
            Controller::Direct { director, .. } => Some(director),
            _ => None,
        }
    }

    /// When a skill would begin, were it asked for now ([`PerformSkill`](super::PerformSkill)).
    pub fn entry(&mut self, skill: &str) -> Entry {
        match &self.controller {
            _ if self.quarantine.is_some() => Entry::Never(NoEntry::NotSimulated),
            Controller::Direct { director, .. } => director.entry(&mut self.simulator, skill),
            Controller::Hold | Controller::Play { .. } | Controller::Balance { .. } => {
                Entry::Never(NoEntry::NotSteered)
            }
        }
    }

    /// Answers what was asked for since the last tick.
    pub(super) fn answer_requests(&mut self) {
        let time = self.time();
        for skill in std::mem::take(&mut self.requests) {
            let reason = match &mut self.controller {
                _ if self.quarantine.is_some() => NoEntry::NotSimulated,
                Controller::Direct { director, .. } => {
                    director.request(&mut self.simulator, &skill);
                    continue;
                }
                Controller::Hold | Controller::Play { .. } | Controller::Balance { .. } => NoEntry::NotSteered,
            };
            self.events.push(BodyEvent::SkillRefused { time, skill, reason });
        }
        self.collect_events();
    }

    /// Tells whoever asked for a skill that it will not begin.
    fn refuse_request(&mut self, reason: NoEntry) {
        let time = self.time();
        if let Some(director) = self.director_mut()
            && let Some(skill) = director.drop_request()
        {
            self.events.push(BodyEvent::SkillRefused { time, skill, reason });
        }
    }

    /// Takes over what the director did.
    pub(super) fn collect_events(&mut self) {
        let time = self.simulator.state.time;
        let Controller::Direct { director, .. } = &mut self.controller else { return };
        while let Some(event) = director.take_event() {
            match event {
                DirectorEvent::Began(skill) => {
                    let skill = director.graph().skills()[skill].name().to_owned();
                    let before = self.performs.replace(skill.clone());
                    self.events.extend(before.map(|skill| BodyEvent::SkillEnded { time, skill }));
                    self.events.push(BodyEvent::SkillStarted { time, skill });
                }
                DirectorEvent::Refused { skill, reason } => {
                    self.events.push(BodyEvent::SkillRefused { time, skill, reason });
                }
                DirectorEvent::Parameter { name: parameter, reason } => {
                    let skill = director.player().skill().name().to_owned();
                    self.events.push(BodyEvent::Parameter { time, skill, parameter, reason });
                }
                DirectorEvent::Plan(view) => {
                    let name = |k: usize| director.graph().skills()[k].name().to_owned();
                    self.events.push(BodyEvent::Plan { time, obstacle: view.obstacle, plan: view.plan.map(name) });
                }
                DirectorEvent::Ended => {}
            }
        }
    }

    /// Lets go of a control; the joints keep their present targets, standing still.
    pub fn hold(&mut self) {
        if !matches!(self.controller, Controller::Hold) {
            self.give(Controller::Hold);
        }
        still(&mut self.simulator);
    }

    /// Moves the place it starts from; acts at the next reset.
    pub fn set_placement(&mut self, placement: Placement) {
        self.placement = placement;
        self.controller.place(&placement, &self.simulator);
    }

    /// Steps per second at full detail: the character's, or the nearest that fits the decisions of its skills.
    pub(super) fn full_rate(&self) -> f64 {
        match &self.controller {
            Controller::Direct { director, .. } => director.simulation_rate(self.model()),
            Controller::Hold | Controller::Play { .. } | Controller::Balance { .. } => self.model().step_rate,
        }
    }

    /// Back to the first pose of the control, or to rest in the zero pose; lifts a quarantine.
    pub fn reset(&mut self) {
        let model = self.simulator.model().clone();
        let settings = *self.simulator.settings();
        if self.quarantine.is_some() {
            // Commands and pushes may be what made it go bad.
            self.simulator = Simulator::new(model.clone(), settings);
        }
        match &mut self.controller {
            Controller::Play { control, player, finished, .. } => {
                *finished = None;
                self.simulator.set_settings(SimulationSettings { rate: control.rate, ..settings });
                player.restart(&mut self.simulator);
            }
            Controller::Direct { director, finished } => {
                *finished = None;
                self.performs = None;
                let rate = director.simulation_rate(&model);
                self.simulator.set_settings(SimulationSettings { rate, ..settings });
                let heading = Heading::of(Quat::<f64>::splat(self.placement.heading));
                self.simulator.state.time = 0.0;
                director.begin(&mut self.simulator, heading, self.placement.point(DVec3::ZERO));
                // At the start of a decision every rate that fits can be gone to.
                director.set_rate(rate);
            }
            Controller::Hold | Controller::Balance { .. } => {
                let mut fresh: Simulator<f64> =
                    Simulator::new(model.clone(), SimulationSettings { rate: model.step_rate, ..settings });
                let height = DVec3::new(0.0, model.rest_root_height(), 0.0);
                let joints = vec![DQuat::IDENTITY; model.links.len()];
                fresh.state.set_pose(0, self.placement.point(height), self.placement.heading, &joints);
                fresh.state_changed();
                self.simulator = fresh;
                if let Controller::Balance { begun, .. } = &mut self.controller {
                    *begun = false;
                }
            }
        }
        self.quarantine = None;
        self.clock = StepClock::default();
        self.detector.restart();
        self.jumped = true;
    }

    /// Hands the targets of a user to the servos.
    pub(super) fn take_targets(&mut self, targets: &AthleteTargets) {
        if !matches!(self.controller, Controller::Hold) {
            self.give(Controller::Hold);
        }
        for (i, command) in self.simulator.commands.iter_mut().enumerate().skip(1) {
            if let Some(rotation) = targets.rotations.get(i) {
                command.rotation = Quat::splat(rotation.normalize());
            }
            command.velocity = Vec3::splat(targets.velocities.get(i).copied().unwrap_or(DVec3::ZERO));
        }
    }

    /// Brings the switches of the user into the simulator.
    pub(super) fn apply_settings(&mut self, settings: &AthleteSettings) {
        let mut wanted = *self.simulator.settings();
        wanted.limits = settings.joint_limits.then(|| wanted.limits.unwrap_or_default());
        wanted.self_collision = settings.self_collision.then(|| wanted.self_collision.unwrap_or_default());
        if wanted != *self.simulator.settings() {
            self.simulator.set_settings(wanted);
        }
        let scale = f64::from(settings.friction_scale);
        self.simulator.friction_scale = if scale.is_finite() { scale.max(0.0) } else { 1.0 };
    }

    /// True once after each jump of the state.
    pub(super) fn take_jump(&mut self) -> bool {
        std::mem::take(&mut self.jumped)
    }

    /// By how much the state is older than the fixed ticks it was advanced by, s.
    pub(super) fn lag(&self) -> f64 {
        self.clock.remainder_seconds(self.simulator.settings().rate)
    }

    /// Where all links are, by link index.
    pub(super) fn write_links(&mut self, out: &mut Vec<LinkTransform>) {
        let root = self.simulator.state.root_position;
        out.clear();
        out.extend(self.simulator.kinematics().iter().map(|link| LinkTransform {
            position: (root + link.origin).lane(0),
            rotation: DQuat::from_mat3(&link.rotation.lane(0)).normalize(),
        }));
    }
}

/// The joints' targets stop moving.
pub(super) fn still(simulator: &mut Simulator<f64>) {
    for command in &mut simulator.commands {
        command.velocity = Vec3::zero();
    }
}
