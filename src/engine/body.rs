//! The simulation of one athlete.

use crate::contact::BladeEdge;
use crate::control::{ControlError, ControlPlayer, ReconstructedControl, ReferenceTick, TrackingError, tracking_error};
use crate::engine::ground::Ground;
use crate::engine::performer::Performer;
use crate::engine::watch::{Happening, Watch};
use crate::engine::{AthleteSettings, AthleteTargets, Placement};
use crate::math::{Quat, Vec3};
use crate::model::{CharacterModel, LinkTransform, ModelPose, SharedModel};
use crate::sim::{SimulationSettings, Simulator, step};
use crate::skill::SkillPlayer;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::{Component, Transform};
use std::time::Duration;

/// Whether a body is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BodyStatus {
    /// It is.
    #[default]
    Running,
    /// Its state went bad; it waits for a reset.
    Quarantined,
}

/// What tells the joints where to go, as the body keeps it.
#[derive(Clone, Debug)]
enum Driver {
    /// Nobody: the commands stay.
    Hold,
    /// A control, in the character's frame and as moved to the placement.
    Play { control: std::sync::Arc<ReconstructedControl>, player: Box<ControlPlayer>, finished: Option<f64> },
    /// Trained skills.
    Perform { performer: Performer, finished: Option<f64> },
}

/// The simulation of one athlete: scalar f64, unfused, the same bits everywhere.
///
/// Added by the plugin once the athlete's files have arrived.
#[derive(Component, Clone, Debug)]
pub struct AthleteBody {
    simulator: Simulator<f64>,
    placement: Placement,
    driver: Driver,
    clock: StepClock,
    watch: Watch,
    status: BodyStatus,
    /// Set by a reset: nothing is interpolated across it.
    jumped: bool,
    /// A reset was asked for, maybe to another place.
    pub(super) reset_request: Option<Option<Transform>>,
    pub(super) happened: Vec<Happening>,
    /// Name of the skill that was told to have begun.
    performs: Option<String>,
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
            clock: StepClock::default(),
            status: BodyStatus::Running,
            jumped: true,
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
        self.status
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

    /// Where the reference of the control that plays has the links at time `t` (s), or that of the skill at its last
    /// decision, world frame, by link index; false and an empty list without either.
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
        mix(before, next, s).link_transforms(self.model(), out);
        true
    }

    /// Makes a control drive the body, from its first pose on.
    pub fn play(&mut self, control: std::sync::Arc<ReconstructedControl>) -> Result<(), ControlError> {
        let moved = self.placement.move_control(&control);
        let player = Box::new(ControlPlayer::new(&moved, self.simulator.model())?);
        self.driver = Driver::Play { control, player, finished: None };
        self.reset();
        Ok(())
    }

    /// Makes trained skills drive the body, from their start on.
    pub(super) fn perform(&mut self, performer: Performer) {
        self.driver = Driver::Perform { performer, finished: None };
        self.reset();
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
        self.driver = Driver::Hold;
        still(&mut self.simulator);
    }

    /// Moves the place it starts from; acts at the next reset.
    pub fn set_placement(&mut self, placement: Placement) {
        if placement == self.placement {
            return;
        }
        self.placement = placement;
        if let Driver::Play { control, player, .. } = &mut self.driver {
            let moved = placement.move_control(control);
            // The control fitted this character before it was moved.
            if let Ok(moved) = ControlPlayer::new(&moved, self.simulator.model()) {
                **player = moved;
            }
        }
    }

    /// Back to the first pose of the control, or to rest in the zero pose; lifts a quarantine.
    pub fn reset(&mut self) {
        let model = self.simulator.model().clone();
        let settings = *self.simulator.settings();
        if self.status == BodyStatus::Quarantined {
            // Commands and pushes may be what made it go bad.
            self.simulator = Simulator::new(model.clone(), settings);
        }
        match &mut self.driver {
            Driver::Play { control, player, finished } => {
                *finished = None;
                self.simulator.set_settings(SimulationSettings { rate: control.rate, ..settings });
                player.restart(&mut self.simulator);
            }
            Driver::Perform { performer, finished } => {
                *finished = None;
                self.performs = None;
                self.simulator.set_settings(SimulationSettings { rate: model.step_rate, ..settings });
                performer.begin(&mut self.simulator, &self.placement);
            }
            Driver::Hold => {
                let mut fresh: Simulator<f64> = Simulator::new(model.clone(), settings);
                let height = DVec3::new(0.0, model.rest_root_height(), 0.0);
                let joints = vec![DQuat::IDENTITY; model.links.len()];
                fresh.state.set_pose(0, self.placement.point(height), self.placement.heading, &joints);
                fresh.state_changed();
                self.simulator = fresh;
            }
        }
        self.status = BodyStatus::Running;
        self.clock = StepClock::default();
        self.watch.restart();
        self.jumped = true;
    }

    /// Hands the targets of a user to the servos.
    pub(super) fn take_targets(&mut self, targets: &AthleteTargets) {
        self.driver = Driver::Hold;
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

    /// Runs the whole steps that are due after another `dt`, and notes what happens.
    pub(super) fn advance(&mut self, dt: Duration, ground: &mut impl Ground, settings: &AthleteSettings) {
        if self.status == BodyStatus::Quarantined || settings.paused {
            return;
        }
        let due = self.clock.take(dt, self.simulator.settings().rate);
        for _ in 0..due {
            match &mut self.driver {
                Driver::Play { player, finished: None, .. } => player.drive(&mut self.simulator),
                // A network that fails leaves the joints their targets.
                Driver::Perform { performer, .. } => {
                    let _ = performer.drive(&mut self.simulator);
                }
                _ => {}
            }
            step(&mut self.simulator, ground);
            ground.stepped(&self.simulator);
            self.watch.observe(&mut self.simulator, ground, &mut self.happened);
            let time = self.simulator.state.time;
            if let Driver::Perform { performer, finished } = &mut self.driver {
                performer.after_step(&self.simulator);
                if let Some(skill) = performer.take_begun() {
                    let before = self.performs.replace(skill.clone());
                    self.happened.extend(before.map(|skill| Happening::SkillEnded { time, skill }));
                    self.happened.push(Happening::SkillStarted { time, skill });
                }
                if finished.is_none() && performer.is_finished() {
                    *finished = Some(time);
                    self.happened.extend(self.performs.take().map(|skill| Happening::SkillEnded { time, skill }));
                    self.happened.push(Happening::Finished { time });
                }
            }
            if let Driver::Play { player, finished, .. } = &mut self.driver
                && finished.is_none()
                && player.is_finished()
            {
                *finished = Some(time);
                still(&mut self.simulator);
                self.happened.push(Happening::Finished { time });
            }
        }
        if !self.simulator.is_sane(0) {
            self.status = BodyStatus::Quarantined;
            self.happened.push(Happening::Quarantined { time: self.simulator.state.time });
        } else if let (Some(wait), Some(since)) = (settings.restart_after, self.since_control_end())
            && since >= f64::from(wait)
        {
            self.reset();
        }
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
fn still(simulator: &mut Simulator<f64>) {
    for command in &mut simulator.commands {
        command.velocity = Vec3::zero();
    }
}

/// Between two poses of a reference.
fn mix(a: &ReferenceTick, b: &ReferenceTick, s: f64) -> ModelPose {
    let turn = |a: DQuat, b: DQuat| {
        let to = if a.dot(b) < 0.0 { -b } else { b };
        (a * (1.0 - s) + to * s).normalize()
    };
    ModelPose {
        root_position: a.pose.root_position.lerp(b.pose.root_position, s),
        root_rotation: turn(a.pose.root_rotation, b.pose.root_rotation),
        joints: a.pose.joints.iter().zip(&b.pose.joints).map(|(a, b)| turn(*a, *b)).collect(),
    }
}

/// Counts the steps that are due, in integers: nothing is lost, and no frame length matters.
#[derive(Clone, Copy, Debug, Default)]
struct StepClock {
    /// Time not yet stepped, in 1e-15 steps.
    remainder: u128,
}

impl StepClock {
    /// 1e9 ns/s times 1e6 (rates are counted in millionths of a hertz).
    const STEP: u128 = 1_000_000_000_000_000;

    fn take(&mut self, dt: Duration, rate: f64) -> u32 {
        self.remainder += dt.as_nanos() * (rate * 1e6).round().max(0.0) as u128;
        let due = self.remainder / Self::STEP;
        self.remainder %= Self::STEP;
        u32::try_from(due).unwrap_or(u32::MAX)
    }

    fn remainder_seconds(&self, rate: f64) -> f64 {
        self.remainder as f64 / Self::STEP as f64 / rate
    }
}

/// Standing height of the centre of mass above the lowest contact point in the zero pose, m.
pub(super) fn standing_height(model: &CharacterModel) -> f64 {
    let places = model.rest_positions();
    let moment: f64 = model.links.iter().zip(&places).map(|(l, p)| l.mass * (p.y + l.com.y)).sum();
    model.rest_root_height() + moment / model.mass()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_minute_of_ticks_is_a_minute_of_steps() {
        let mut clock = StepClock::default();
        let mut steps = 0;
        for _ in 0..64 * 60 {
            let due = clock.take(Duration::from_micros(15_625), 1200.0);
            assert!(due == 18 || due == 19);
            steps += due;
        }
        assert_eq!(steps, 1200 * 60);
        assert_eq!(clock.remainder, 0);
    }
}
