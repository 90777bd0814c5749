//! Level of detail: how much of an athlete is simulated, and what decides about it.

use bevy::prelude::*;

/// How much of an athlete is simulated. Written by the plugin where there is an [`AthleteLod`]; read it as you like.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Reflect)]
#[reflect(Component, Default)]
pub enum AthleteDetail {
    /// It stands still, in mid-movement if need be, and goes on from there later.
    Frozen,
    /// At half its rate of steps, the rate that policies are trained at; decisions and time go on as ever. What plays a
    /// control stays at full rate: a control is only right at its own.
    Reduced,
    /// At its own rate.
    #[default]
    Full,
}

impl AthleteDetail {
    /// Rate of steps at [`AthleteDetail::Reduced`], as part of the character's.
    pub const REDUCED_RATE: f64 = 0.5;
}

/// Gives an athlete a level of detail by its distance to the nearest viewer: an [`AthleteViewer`] or, with the feature
/// `render`, a `Camera3d`. Without any viewer all are at full rate. Takes part in the [`AthleteBudget`].
///
/// An athlete that comes nearer changes at these distances; one that moves away, a tenth later.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default)]
#[require(AthleteDetail)]
pub struct AthleteLod {
    /// Up to this distance at full rate, m.
    pub full: f32,
    /// Up to this distance at reduced rate, beyond it frozen, m.
    pub reduced: f32,
}

impl Default for AthleteLod {
    fn default() -> Self {
        Self { full: 40.0, reduced: 120.0 }
    }
}

/// Marks what looks at athletes where there are no cameras, on a server for instance: its `Transform` says where it is.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Default)]
#[require(Transform)]
pub struct AthleteViewer;

/// How much time on the clock the steps of a frame may take. Where it is not enough for all athletes with an
/// [`AthleteLod`], the farthest go to reduced rate first, and are frozen first if that does not do.
///
/// What fits depends on the machine and its load: with a budget, the same ticks no longer give the same bits.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Default)]
pub struct AthleteBudget {
    /// Milliseconds per frame; `None` is no limit.
    pub milliseconds: Option<f32>,
}

/// What level of detail did in the last fixed tick.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Default)]
pub struct AthleteLodReport {
    /// Athletes at full rate, among those with an [`AthleteLod`].
    pub full: usize,
    /// At reduced rate.
    pub reduced: usize,
    /// Frozen.
    pub frozen: usize,
    /// Those that would be at a higher level, did the budget allow it.
    pub degraded: usize,
    /// Time that a frame's steps take at these levels, as far as can be told from the ticks before, ms.
    pub milliseconds: f32,
}
