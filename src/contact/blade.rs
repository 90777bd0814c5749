//! The skate blade: a knife edge that turns with lean.
//!
//! Yu, Park, Lee 2019, Section 4: the blade may move along its line only (equation 3), and leaning turns the line
//! (equations 4 and 5, made proportional because the tangent is unstable). Here the edge is a curve of curvature kappa
//! on the ice, and each end of the blade may move along the curve's tangent there:
//!
//! ```text
//! v . (s - kappa x t) = 0      t along the blade, s across it towards the inside edge, x the end's place on the blade
//! ```
//!
//! Both ends together say that the blade travels along t and yaws by kappa per metre: the paper's rotated line, with
//! forces that are square to the motion and so do no work.

use crate::math::{Real, Vec3, half_angle_over_sine};
use crate::model::LeanLaw;

/// Which edge of a blade is on the ice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "engine", derive(bevy::reflect::Reflect))]
pub enum BladeEdge {
    /// Not on the ice with both ends.
    #[default]
    Off,
    /// Upright within [`BladeEdge::FLAT_LEAN`].
    Flat,
    /// Leaning towards the body's midline.
    Inside,
    /// Leaning outwards.
    Outside,
}

impl BladeEdge {
    /// Lean below which an edge counts as flat, rad (5 degrees).
    pub const FLAT_LEAN: f64 = 5.0 * core::f64::consts::PI / 180.0;

    /// The edge of a blade on the ice with this lean (rad, positive towards the inside edge).
    pub fn of_lean(lean: f64) -> Self {
        if lean > Self::FLAT_LEAN {
            Self::Inside
        } else if lean < -Self::FLAT_LEAN {
            Self::Outside
        } else {
            Self::Flat
        }
    }
}

/// A blade during one step.
#[derive(Clone, Copy, Debug)]
pub struct BladeContact<R: Real> {
    /// Both ends are within 5 mm of the ice.
    pub on_ice: R::Mask,
    /// Along the blade towards the toe, in the ice plane, unit.
    pub along: Vec3<R>,
    /// Across the blade towards the inside edge, in the ice plane, unit.
    pub across: Vec3<R>,
    /// Lean, rad, positive towards the inside edge.
    pub lean: R,
    /// Curvature of the line to follow, 1/m, positive towards `across`.
    pub curvature: R,
}

/// Curvature of a leaning blade's line, 1/m, positive towards the inside edge; `lean` in rad.
#[inline(always)]
pub fn carve_curvature<R: Real>(law: &LeanLaw, lean: R, sine: R) -> R {
    match *law {
        LeanLaw::DeadZone { dead_zone, gain } => {
            let beyond = (lean.abs() - R::splat(dead_zone)).max(R::zero()) * R::splat(gain);
            R::select(lean.lt(R::zero()), -beyond, beyond)
        }
        LeanLaw::Rocker { radius } => sine * R::splat(1.0 / radius),
    }
}

impl<R: Real> BladeContact<R> {
    /// A blade whose ends are (where the mask holds) on the ice.
    ///
    /// `blade` is the vector from heel to toe and `inside` the unit vector towards the inside edge, `normal` that of
    /// the ice; world axes.
    #[inline(always)]
    pub fn new(on_ice: R::Mask, blade: Vec3<R>, inside: Vec3<R>, normal: Vec3<R>, law: &LeanLaw) -> Self {
        let flat = blade - normal * blade.dot(normal);
        // A blade that stands on its tip has no line; such lanes are masked by `on_ice`.
        let length = flat.length().max(R::splat(1e-6));
        let along = flat * length.recip();
        let left = normal.cross(along);
        let across = left * R::select(left.dot(inside).lt(R::zero()), -R::one(), R::one());
        let sine = (-inside.dot(normal)).clamp(-R::one(), R::one());
        let cosine = (R::one() - sine * sine).max(R::zero()).sqrt();
        let lean = sine * half_angle_over_sine(cosine);
        Self { on_ice, along, across, lean, curvature: carve_curvature(law, lean, sine) }
    }

    /// The directions along and across the edge at the place `x` on the blade (m, positive towards the toe).
    #[inline(always)]
    pub fn edge_frame(&self, x: R) -> (Vec3<R>, Vec3<R>) {
        let slope = self.curvature * x;
        let scale = slope.mul_add(slope, R::one()).sqrt().recip();
        ((self.along + self.across * slope) * scale, (self.across - self.along * slope) * scale)
    }
}
