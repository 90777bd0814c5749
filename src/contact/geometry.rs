//! Signed distances to solids, over lanes.

mod height_field;

use crate::math::{Mat3, Real, Vec3};
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;

pub use height_field::{HeightField, HeightFieldError};

/// The shape of a solid. World frame, metres.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// The half space below a plane.
    Plane {
        /// A point of the plane.
        point: DVec3,
        /// Unit normal, out of the ground.
        normal: DVec3,
    },
    /// A box.
    Box {
        /// Centre.
        center: DVec3,
        /// Half of the edge lengths.
        half_extents: DVec3,
        /// Box axes to world axes.
        rotation: DQuat,
    },
    /// A ball.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius.
        radius: f64,
    },
    /// Heights over a horizontal grid.
    HeightField(Arc<HeightField>),
}

/// Distance and outward normal at a point.
#[derive(Clone, Copy, Debug)]
pub struct GeometryHit<R> {
    /// Signed distance, m; negative inside.
    pub distance: R,
    /// Outward unit normal of the nearest surface.
    pub normal: Vec3<R>,
}

impl Geometry {
    /// Signed distance from `point` (world frame, m), negative inside.
    #[inline]
    pub fn signed_distance<R: Real>(&self, point: Vec3<R>) -> GeometryHit<R> {
        match self {
            Geometry::Plane { point: origin, normal } => {
                let n = Vec3::splat(*normal);
                GeometryHit { distance: n.dot(point) - R::splat(normal.dot(*origin)), normal: n }
            }
            Geometry::Sphere { center, radius } => {
                let r = point - Vec3::splat(*center);
                let length = r.length();
                // At the very centre any direction is as good: up.
                let at_center = length.lt(R::splat(1e-9));
                let inverse = R::select(at_center, R::one(), length).recip();
                let up = Vec3::splat(DVec3::Y);
                GeometryHit { distance: length - R::splat(*radius), normal: Vec3::select(at_center, up, r * inverse) }
            }
            Geometry::Box { center, half_extents, rotation } => {
                box_distance(point - Vec3::splat(*center), *half_extents, &DMat3::from_quat(*rotation))
            }
            Geometry::HeightField(field) => field.signed_distance(point),
        }
    }

    /// A lower bound of the distance from `point` (world frame, m) to the surface where it lies outside.
    #[inline]
    pub fn clearance<R: Real>(&self, point: Vec3<R>) -> R {
        match self {
            Geometry::HeightField(field) => field.clearance(point),
            _ => self.signed_distance(point).distance,
        }
    }
}

/// Outside: the distance to the nearest point of the box. Inside: the face that is least deep.
fn box_distance<R: Real>(from_center: Vec3<R>, half: DVec3, rotation: &DMat3) -> GeometryHit<R> {
    let to_world = Mat3::splat(*rotation);
    let p = to_world.tr_mul_vec(from_center);
    let zero = R::zero();
    let sign = |x: R| R::select(x.lt(zero), -R::one(), R::one());
    let s = Vec3::new(sign(p.x), sign(p.y), sign(p.z));
    let q = Vec3::new(p.x.abs() - R::splat(half.x), p.y.abs() - R::splat(half.y), p.z.abs() - R::splat(half.z));
    let outside = Vec3::new(q.x.max(zero), q.y.max(zero), q.z.max(zero));
    let length = outside.length();
    let is_outside = zero.lt(length);

    // Inside, the largest (least negative) of the three.
    let x_wins = !(q.x.lt(q.y)) & !(q.x.lt(q.z));
    let y_wins = !x_wins & !(q.y.lt(q.z));
    let z_wins = !x_wins & !y_wins;
    let one = R::one();
    let face = Vec3::new(one.masked(x_wins), one.masked(y_wins), one.masked(z_wins));
    let depth = q.x.max(q.y).max(q.z);

    let inverse = R::select(is_outside, length, one).recip();
    let n = Vec3::select(is_outside, outside * inverse, face);
    let n = Vec3::new(n.x * s.x, n.y * s.y, n.z * s.z);
    GeometryHit { distance: R::select(is_outside, length, depth), normal: to_world.mul_vec(n) }
}
