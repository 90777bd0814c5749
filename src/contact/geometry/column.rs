//! Where a vertical line enters and leaves a solid.

use crate::math::{Mat3, Real, Vec3};
use glam::DVec3;

/// The part of a vertical line that lies inside a solid.
#[derive(Clone, Copy, Debug)]
pub struct Column<R: Real> {
    /// Where the solid begins, world frame, m.
    pub bottom: R,
    /// Where it ends, world frame, m.
    pub top: R,
    /// Outward unit normal at the top.
    pub normal: Vec3<R>,
    /// True where the line meets the solid.
    pub meets: R::Mask,
}

/// Where solids without an underside begin, m.
const DEEP: f64 = -1e9;

impl<R: Real> Column<R> {
    /// No underside: ground.
    #[inline]
    pub(crate) fn ground(top: R, normal: Vec3<R>) -> Self {
        Self { bottom: R::splat(DEEP), top, normal, meets: R::zero().lt(R::one()) }
    }

    /// A plane through `origin` with a unit normal; one that does not face up is met nowhere.
    #[inline]
    pub(crate) fn plane(point: Vec3<R>, origin: DVec3, normal: DVec3) -> Self {
        if normal == DVec3::Y {
            return Self::ground(R::splat(origin.y), Vec3::splat(normal));
        }
        let slope = |n: f64| R::splat(if normal.y > 1e-6 { n / normal.y } else { 0.0 });
        let top = R::splat(origin.y)
            - slope(normal.x) * (point.x - R::splat(origin.x))
            - slope(normal.z) * (point.z - R::splat(origin.z));
        let meets = R::splat(1e-6).lt(R::splat(normal.y));
        Self { meets, ..Self::ground(top, Vec3::splat(normal)) }
    }

    /// A ball swept along a level segment: `across` is the horizontal distance from the line to the segment, the normal at
    /// the top leans from `axis_point` (world frame, m), the nearest point of the segment in plan.
    #[inline]
    pub(crate) fn swept_ball(point: Vec3<R>, axis_point: Vec3<R>, radius: R) -> Self {
        let zero = R::zero();
        let across = Vec3::new(point.x - axis_point.x, zero, point.z - axis_point.z);
        let square = radius * radius - across.length_squared();
        let meets = zero.lt(square);
        let half = square.max(zero).sqrt();
        let top = axis_point.y + half;
        let lean = across + Vec3::new(zero, half, zero);
        let normal = Vec3::select(meets, lean * radius.max(R::splat(1e-9)).recip(), Vec3::splat(DVec3::Y));
        Self { bottom: axis_point.y - half, top, normal, meets }
    }

    /// A box (`to_world` takes box axes to world axes), by the slabs of its faces (Kay, Kajiya 1986, "Ray tracing complex
    /// scenes").
    #[inline]
    pub(crate) fn block(point: Vec3<R>, center: Vec3<R>, half: Vec3<R>, to_world: &Mat3<R>) -> Self {
        let (zero, one) = (R::zero(), R::one());
        // The line at the height of the centre, so that the top of an upright box is exact.
        let line = Vec3::new(point.x - center.x, zero, point.z - center.z);
        let from = to_world.tr_mul_vec(line);
        let along = to_world.tr_mul_vec(Vec3::splat(DVec3::Y));
        let far = R::splat(-DEEP);
        let (mut enter, mut leave, mut meets) = (-far, far, zero.lt(one));
        let mut face = Vec3::splat(DVec3::Y);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        for (axis, (at, (up, half))) in [from.x, from.y, from.z]
            .into_iter()
            .zip([along.x, along.y, along.z].into_iter().zip([half.x, half.y, half.z]))
            .enumerate()
        {
            let level = up.abs().lt(R::splat(1e-9));
            let inverse = R::select(level, one, up).recip();
            let (a, b) = ((-half - at) * inverse, (half - at) * inverse);
            let beside = level & half.lt(at.abs());
            enter = R::select(level, enter, enter.max(a.min(b)));
            let first = !level & a.max(b).lt(leave);
            leave = R::select(first, a.max(b), leave);
            let sign = R::select(up.lt(zero), -one, one);
            face = Vec3::select(first, Vec3::splat(axes[axis]) * sign, face);
            meets = meets & !beside;
        }
        let meets = meets & enter.lt(leave);
        Self { bottom: center.y + enter, top: center.y + leave, normal: to_world.mul_vec(face), meets }
    }
}
