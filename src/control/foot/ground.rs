//! The ground under a foot, as a plane.

use crate::contact::Terrain;
use crate::math::Vec3;
use glam::DVec3;

/// A plane: the ground as a foot feels it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundPlane {
    /// A point of it, world frame, m.
    pub point: DVec3,
    /// Unit normal, out of the ground, world frame.
    pub normal: DVec3,
}

impl GroundPlane {
    /// Level ground at the height y = 0.
    pub const LEVEL: Self = Self { point: DVec3::ZERO, normal: DVec3::Y };

    /// Signed distance of a point (world frame, m), negative below.
    pub fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.point)
    }

    /// The plane that touches the surface nearest to `point` (world frame, m): on a slope the slope, on a ball its tangent plane.
    /// `None` where nothing is within `reach` (m).
    pub fn under(terrain: &impl Terrain<f64>, point: DVec3, reach: f64) -> Option<Self> {
        let hit = terrain.query(Vec3::<f64>::splat(point));
        let normal = hit.normal.lane(0);
        let near = hit.distance < reach && normal.is_finite() && (normal.length_squared() - 1.0).abs() < 1e-6;
        near.then(|| Self { point: point - normal * hit.distance, normal })
    }
}
