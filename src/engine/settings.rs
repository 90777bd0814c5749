//! Switches of one athlete.

use bevy::prelude::*;

/// With how many digits an athlete is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default)]
pub enum AthletePrecision {
    /// f64, up to four athletes in lanes.
    #[default]
    Double,
    /// f32, up to eight athletes in lanes: for crowds, nearly twice as many. It is the precision that policies are trained in.
    /// Places are exact to 0.03 mm at 500 m from the origin. The bits are other ones than with `Double`. As there they do not
    /// depend on the threads or on who else is there; but products and sums are fused where the processor can, as in
    /// training, so they are those of another machine only if both were built for the same instruction set.
    ///
    /// An athlete that holds on to something, is pushed by [`AthleteForces`](super::AthleteForces), or stands on a ground of
    /// its own is simulated in f64 meanwhile.
    Single,
}

/// Switches of one athlete.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct AthleteSettings {
    /// Stops this athlete alone; for all of them see [`PlaybackSpeed`](super::PlaybackSpeed).
    pub paused: bool,
    /// Whether poses between fixed ticks are interpolated. Without, they move in steps of the fixed timestep.
    pub interpolate: bool,
    /// Links that are not neighbours push each other apart.
    pub self_collision: bool,
    /// Joints resist leaving their range.
    pub joint_limits: bool,
    /// Factor on every friction coefficient (finite, not negative).
    pub friction_scale: f32,
    /// Starts the control again this many simulated seconds after its end, s; `None` holds the last targets.
    pub restart_after: Option<f32>,
    /// With how many digits it is simulated.
    pub precision: AthletePrecision,
}

impl Default for AthleteSettings {
    fn default() -> Self {
        Self {
            paused: false,
            interpolate: true,
            self_collision: true,
            joint_limits: true,
            friction_scale: 1.0,
            restart_after: None,
            precision: AthletePrecision::Double,
        }
    }
}
