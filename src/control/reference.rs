//! A clip at the rate of the controller: what the character should do at each tick.

use crate::asset::turn::rotation_vector;
use crate::math::{Real, half_angle_over_sine};
use crate::model::{CharacterModel, ModelClip, ModelPose, ModelVelocity};
use crate::sim::Simulator;
use glam::{DQuat, DVec3};

/// Pose and velocity of the reference at one tick.
#[derive(Clone, Debug)]
pub struct ReferenceTick {
    /// The pose.
    pub pose: ModelPose,
    /// How fast it changes.
    pub velocity: ModelVelocity,
}

/// A clip sampled at every tick of a controller, once, ahead of the simulation.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Ticks per second.
    pub tick_rate: f64,
    /// One entry per tick, from time zero; the last one is at the clip's end or beyond.
    pub ticks: Vec<ReferenceTick>,
}

impl Reference {
    /// Time over which velocities are taken, s: two frames of a 30 Hz clip. One frame of a captured clip is noise.
    pub const DIFFERENCE_SPAN: f64 = 1.0 / 15.0;

    /// Most ticks that a control or a search may ask for: more than a quarter of an hour at 100 per second, below 200 MB.
    pub const MAX_TICKS: usize = 100_000;

    /// Samples `seconds` of a clip (the whole clip if `None`); beyond its end the last pose is held.
    pub fn new(clip: &ModelClip, tick_rate: f64, seconds: Option<f64>) -> Self {
        let seconds = seconds.unwrap_or(clip.duration());
        let count = (seconds * tick_rate - 1e-9).ceil().max(0.0) as usize + 1;
        let ticks = (0..count)
            .map(|k| {
                let t = k as f64 / tick_rate;
                let velocity = velocity_over(clip, t, Self::DIFFERENCE_SPAN);
                ReferenceTick { pose: clip.sample(t), velocity }
            })
            .collect();
        Self { tick_rate, ticks }
    }

    /// Length, s.
    pub fn duration(&self) -> f64 {
        (self.ticks.len() - 1) as f64 / self.tick_rate
    }

    /// The tick at or before the time `t` (s), clamped.
    pub fn at(&self, t: f64) -> &ReferenceTick {
        let k = (t * self.tick_rate + 1e-6).max(0.0) as usize;
        &self.ticks[k.min(self.ticks.len() - 1)]
    }
}

/// Velocity of a clip at time `t` (s) by the difference of the poses half of `span` (s) before and after, one-sided at
/// the ends.
fn velocity_over(clip: &ModelClip, t: f64, span: f64) -> ModelVelocity {
    let end = clip.duration();
    let (t0, t1) = ((t - 0.5 * span).clamp(0.0, end), (t + 0.5 * span).clamp(0.0, end));
    let (a, b) = (clip.sample(t0), clip.sample(t1));
    let per_second = if t1 > t0 { 1.0 / (t1 - t0) } else { 0.0 };
    ModelVelocity {
        root_linear: (b.root_position - a.root_position) * per_second,
        root_angular: rotation_vector(b.root_rotation * a.root_rotation.conjugate()) * per_second,
        joints: a.joints.iter().zip(&b.joints).map(|(a, b)| rotation_vector(a.conjugate() * *b) * per_second).collect(),
    }
}

/// Distance between a simulated pose and its reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackingError {
    /// Distance of the roots, m.
    pub root: f64,
    /// Angle between the roots' rotations, rad.
    pub root_angle: f64,
    /// Mean angle between joint rotations, rad.
    pub joints: f64,
}

/// Angle of the rotation between two, rad, in [0, pi]; by polynomial, so the same bits everywhere.
pub(crate) fn angle_between(a: DQuat, b: DQuat) -> f64 {
    let d = a.conjugate() * b;
    2.0 * DVec3::new(d.x, d.y, d.z).length() * half_angle_over_sine(d.w.abs().min(1.0))
}

/// Compares lane `lane` of a simulation with a reference pose.
pub fn tracking_error<R: Real>(sim: &Simulator<R>, lane: usize, pose: &ModelPose) -> TrackingError {
    let model: &CharacterModel = sim.model();
    let joints = model.links.len() - 1;
    let sum: f64 =
        sim.state.joints.iter().zip(&pose.joints).skip(1).map(|(a, b)| angle_between(a.rotation.lane(lane), *b)).sum();
    TrackingError {
        root: sim.state.root_position.lane(lane).distance(pose.root_position),
        root_angle: angle_between(sim.state.root_rotation.lane(lane), pose.root_rotation),
        joints: if joints == 0 { 0.0 } else { sum / joints as f64 },
    }
}
