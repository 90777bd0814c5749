//! The simulation of one athlete.

use crate::contact::BladeEdge;
use crate::control::{ControlError, ControlPlayer, ReconstructedControl, TrackingError, tracking_error};
use crate::engine::driver::Driver;
use crate::engine::performer::Performer;
use crate::engine::step_clock::StepClock;
use crate::engine::watch::{Happening, Watch};
use crate::engine::{AthleteDetail, AthleteSettings, AthleteTargets, Placement, QuarantineReason};
use crate::math::{Quat, Vec3};
use crate::model::{CharacterModel, LinkTransform, SharedModel};
use crate::sim::{SimulationSettings, Simulator};
use crate::skill::SkillPlayer;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::{Component, Transform};
use std::sync::Arc;

/// Whether a body is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
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
#[derive(Component, Clone, Debug)]
pub struct AthleteBody {
    pub(super) simulator: Simulator<f64>,
    pub(super) placement: Placement,
    pub(super) driver: Driver,
    /// The driver as it was given, for snapshots.
    pub(super) given: Arc<Driver>,
    pub(super) clock: StepClock,
    pub(super) watch: Watch,
    pub(super) quarantine: Option<QuarantineReason>,
    /// Set by a reset: nothing is interpolated across it.
    pub(super) jumped: bool,
    pub(super) detail: AthleteDetail,
    /// Simulated time of the last tick, s.
    pub(super) last_tick: f64,
    /// A reset was asked for, maybe to another place.
    pub(super) reset_request: Option<Option<Transform>>,
    pub(super) happened: Vec<Happening>,
    /// Name of the skill that was told to have begun.
    pub(super) performs: Option<String>,
}

impl AthleteBody {
    /// A body that stands in its zero pose at a place and holds it.
    pub fn new(model: SharedModel, placement: Placement) -> Self {
        let settings = SimulationSettings::of(&model);
        let mut body = Self {
            watch: Watch::new(&model),
            simulator: Simulator::new(model, settings),
            placement,
            driver: Driver::Hold,
            given: Arc::new(Driver::Hold),
            clock: StepClock::default(),
            quarantine: None,
            jumped: true,
            detail: AthleteDetail::Full,
            last_tick: 0.0,
            reset_request: None,
            happened: Vec::with_capacity(8),
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
        match &self.driver {
            Driver::Play { finished: Some(at), .. } | Driver::Perform { finished: Some(at), .. } => {
                Some(self.time() - at)
            }
            _ => None,
        }
    }
    /// Length of the control that plays, s.
    pub fn control_seconds(&self) -> Option<f64> {
        match &self.driver {
            Driver::Play { player, .. } => Some(player.reference().duration()),
            Driver::Hold | Driver::Perform { .. } => None,
        }
    }

    /// The player of the trained skill that is performed.
    pub fn skill_player(&self) -> Option<&SkillPlayer> {
        match &self.driver {
            Driver::Perform { performer, .. } => Some(performer.player()),
            _ => None,
        }
    }

    /// Deviation from the reference of the control that plays or the skill that is performed, at the present time.
    pub fn tracking_error(&self) -> Option<TrackingError> {
        let pose = match &self.driver {
            Driver::Hold => return None,
            Driver::Play { player, .. } => &player.reference().at(self.time()).pose,
            Driver::Perform { performer, .. } => &performer.player().reference_pose(),
        };
        Some(tracking_error(&self.simulator, 0, pose))
    }

    /// Where the reference of the control that plays has the links at time `t` (s), or that of the skill at the
    /// last fixed tick, world frame, by link index; false and an empty list without either.
    pub fn reference_links(&self, t: f64, out: &mut Vec<LinkTransform>) -> bool {
        out.clear();
        let player = match &self.driver {
            Driver::Hold => return false,
            Driver::Perform { performer, .. } => {
                performer.player().reference_pose().link_transforms(self.model(), out);
                return true;
            }
            Driver::Play { player, .. } => player,
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
        self.give(Driver::Play { control, player, placed, finished: None });
        self.reset();
        Ok(())
    }

    /// Makes trained skills drive the body, from their start on.
    pub(super) fn perform(&mut self, performer: Performer) {
        self.give(Driver::Perform { performer, finished: None });
        self.reset();
    }

    fn give(&mut self, driver: Driver) {
        self.given = Arc::new(driver.clone());
        self.driver = driver;
    }

    /// What performs trained skills, to tell it of wishes.
    pub(super) fn performer_mut(&mut self) -> Option<&mut Performer> {
        match &mut self.driver {
            Driver::Perform { performer, .. } => Some(performer),
            _ => None,
        }
    }

    /// Lets go of a control; the joints keep their present targets, standing still.
    pub fn hold(&mut self) {
        if !matches!(self.driver, Driver::Hold) {
            self.give(Driver::Hold);
        }
        still(&mut self.simulator);
    }

    /// Moves the place it starts from; acts at the next reset.
    pub fn set_placement(&mut self, placement: Placement) {
        self.placement = placement;
        self.driver.place(&placement, &self.simulator);
    }

    /// Back to the first pose of the control, or to rest in the zero pose; lifts a quarantine.
    pub fn reset(&mut self) {
        let model = self.simulator.model().clone();
        let settings = *self.simulator.settings();
        if self.quarantine.is_some() {
            // Commands and pushes may be what made it go bad.
            self.simulator = Simulator::new(model.clone(), settings);
        }
        match &mut self.driver {
            Driver::Play { control, player, finished, .. } => {
                *finished = None;
                self.simulator.set_settings(SimulationSettings { rate: control.rate, ..settings });
                player.restart(&mut self.simulator);
            }
            Driver::Perform { performer, finished } => {
                *finished = None;
                self.performs = None;
                self.simulator.set_settings(SimulationSettings { rate: model.step_rate, ..settings });
                performer.begin(&mut self.simulator, &self.placement);
                // At the start of a decision every rate that fits can be gone to.
                performer.set_rate(model.step_rate);
            }
            Driver::Hold => {
                let mut fresh: Simulator<f64> =
                    Simulator::new(model.clone(), SimulationSettings { rate: model.step_rate, ..settings });
                let height = DVec3::new(0.0, model.rest_root_height(), 0.0);
                let joints = vec![DQuat::IDENTITY; model.links.len()];
                fresh.state.set_pose(0, self.placement.point(height), self.placement.heading, &joints);
                fresh.state_changed();
                self.simulator = fresh;
            }
        }
        self.quarantine = None;
        self.clock = StepClock::default();
        self.watch.restart();
        self.jumped = true;
    }

    /// Hands the targets of a user to the servos.
    pub(super) fn take_targets(&mut self, targets: &AthleteTargets) {
        if !matches!(self.driver, Driver::Hold) {
            self.give(Driver::Hold);
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

/// Standing height of the centre of mass above the lowest contact point in the zero pose, m.
pub(super) fn standing_height(model: &CharacterModel) -> f64 {
    let places = model.rest_positions();
    let moment: f64 = model.links.iter().zip(&places).map(|(l, p)| l.mass * (p.y + l.com.y)).sum();
    model.rest_root_height() + moment / model.mass()
}
