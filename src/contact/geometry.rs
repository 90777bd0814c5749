//! Signed distances to solids, over lanes.

mod column;
mod height_field;

use crate::math::{Mat3, Real, Vec3};
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;

pub use column::Column;
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
    /// A level rod with round ends.
    Rail {
        /// Middle of its axis.
        center: DVec3,
        /// From the middle of the axis to the centre of one round end; horizontal.
        half: DVec3,
        /// Radius.
        radius: f64,
    },
    /// Level ground between two lines across the way: everything below `top` from z = `near` down to z = `far`. Infinite where
    /// the number is.
    Strip {
        /// Height of the ground.
        top: f64,
        /// Where it begins, the larger z.
        near: f64,
        /// Where it ends, the smaller z.
        far: f64,
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
                let to_world = Mat3::splat(DMat3::from_quat(*rotation));
                box_distance(point - Vec3::splat(*center), Vec3::splat(*half_extents), &to_world)
            }
            Geometry::Rail { center, half, radius } => {
                let length = half.length();
                let along = Vec3::splat(if length > 0.0 { *half / length } else { DVec3::X });
                rail_distance(point, Vec3::splat(*center), along, R::splat(length), R::splat(*radius))
            }
            Geometry::Strip { top, near, far } => {
                strip_distance(point, R::splat(*top), R::splat(near.min(1e9)), R::splat(far.max(-1e9)))
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

    /// A lower bound of the distance that costs little, m: of what has an end, by the ball round it.
    #[inline]
    pub(crate) fn at_least<R: Real>(&self, point: Vec3<R>) -> R {
        let (center, radius) = match self {
            Geometry::Box { center, half_extents, .. } => (*center, half_extents.length()),
            Geometry::Sphere { center, radius } => (*center, *radius),
            Geometry::Rail { center, half, radius } => (*center, half.length() + radius),
            Geometry::Plane { .. } | Geometry::Strip { .. } | Geometry::HeightField(_) => return R::splat(-1e9),
        };
        let d = point - Vec3::splat(center);
        // Rounding may not make it more than the distance.
        d.x.abs().max(d.y.abs()).max(d.z.abs()) - R::splat(radius + 1e-4)
    }

    /// The part of the vertical line through `point` (world frame, m) that lies inside.
    #[inline]
    pub fn column<R: Real>(&self, point: Vec3<R>) -> Column<R> {
        match self {
            Geometry::Plane { point: origin, normal } => Column::plane(point, *origin, *normal),
            Geometry::Sphere { center, radius } => Column::swept_ball(point, Vec3::splat(*center), R::splat(*radius)),
            Geometry::Box { center, half_extents, rotation } => {
                let to_world = Mat3::splat(DMat3::from_quat(*rotation));
                Column::block(point, Vec3::splat(*center), Vec3::splat(*half_extents), &to_world)
            }
            Geometry::Rail { center, half, radius } => {
                let length = half.length();
                let along = Vec3::splat(if length > 0.0 { *half / length } else { DVec3::X });
                let axis = rail_point(point, Vec3::splat(*center), along, R::splat(length));
                Column::swept_ball(point, axis, R::splat(*radius))
            }
            Geometry::Strip { top, near, far } => {
                let (near, far) = (R::splat(near.min(1e9)), R::splat(far.max(-1e9)));
                let meets = !near.lt(point.z) & !point.z.lt(far);
                Column { meets, ..Column::ground(R::splat(*top), Vec3::splat(DVec3::Y)) }
            }
            Geometry::HeightField(field) => {
                let (height, normal) = field.surface(point);
                Column::ground(height, normal)
            }
        }
    }
}

/// How far down and in from the edges of a box's top its edges reach, m: what the fingers close round.
pub(crate) const EDGE: f64 = 0.05;

/// Whether a point at or on a box is at an edge of its top; arguments as those of [`box_distance`].
#[inline]
pub(crate) fn near_top_edge<R: Real>(from_center: Vec3<R>, half: Vec3<R>, to_world: &Mat3<R>) -> R::Mask {
    let p = to_world.tr_mul_vec(from_center);
    let edge = R::splat(-EDGE);
    let side = (p.x.abs() - half.x).max(p.z.abs() - half.z);
    edge.lt(p.y - half.y) & edge.lt(side)
}

/// The point of a level rod's axis that is nearest to a point.
#[inline]
pub(crate) fn rail_point<R: Real>(point: Vec3<R>, center: Vec3<R>, along: Vec3<R>, half_length: R) -> Vec3<R> {
    let at = (point - center).dot(along).clamp(-half_length, half_length);
    center + along * at
}

/// Distance to a level rod with round ends; `along` is its unit axis.
#[inline]
pub(crate) fn rail_distance<R: Real>(
    point: Vec3<R>,
    center: Vec3<R>,
    along: Vec3<R>,
    half_length: R,
    radius: R,
) -> GeometryHit<R> {
    let r = point - rail_point(point, center, along, half_length);
    let length = r.length();
    let on_axis = length.lt(R::splat(1e-9));
    let inverse = R::select(on_axis, R::one(), length).recip();
    let normal = Vec3::select(on_axis, Vec3::splat(DVec3::Y), r * inverse);
    GeometryHit { distance: length - radius, normal }
}

/// Distance to level ground between two lines across the way.
#[inline]
pub(crate) fn strip_distance<R: Real>(point: Vec3<R>, top: R, near: R, far: R) -> GeometryHit<R> {
    let (zero, one) = (R::zero(), R::one());
    let up = point.y - top;
    let (before, behind) = (point.z - near, far - point.z);
    let side = before.max(behind);
    let sign = R::select(before.lt(behind), -one, one);
    let (out_up, out_side) = (up.max(zero), side.max(zero));
    let length = (out_up * out_up + out_side * out_side).sqrt();
    let is_outside = zero.lt(length);
    let inverse = R::select(is_outside, length, one).recip();
    // Inside, the face that is least deep.
    let top_wins = !up.lt(side);
    let y = R::select(is_outside, out_up * inverse, one.masked(top_wins));
    let z = R::select(is_outside, out_side * inverse, one.masked(!top_wins)) * sign;
    GeometryHit { distance: R::select(is_outside, length, up.max(side)), normal: Vec3::new(zero, y, z) }
}

/// Outside: the distance to the nearest point of the box. Inside: the face that is least deep.
#[inline]
pub(crate) fn box_distance<R: Real>(from_center: Vec3<R>, half: Vec3<R>, to_world: &Mat3<R>) -> GeometryHit<R> {
    let p = to_world.tr_mul_vec(from_center);
    let zero = R::zero();
    let sign = |x: R| R::select(x.lt(zero), -R::one(), R::one());
    let s = Vec3::new(sign(p.x), sign(p.y), sign(p.z));
    let q = Vec3::new(p.x.abs() - half.x, p.y.abs() - half.y, p.z.abs() - half.z);
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
