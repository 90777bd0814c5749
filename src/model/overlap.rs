//! Whether two solids overlap. Runs once per pair when a model is built, so it is written for brevity, not speed.

use super::Shape;
use glam::{DMat3, DQuat, DVec3};

/// Whether the interiors of two solids meet. Both in one frame.
pub(super) fn overlap(a: &Shape, b: &Shape) -> bool {
    // Most pairs are far apart: their bounding balls settle those.
    let ((center_a, reach_a), (center_b, reach_b)) = (bounds(a), bounds(b));
    if center_a.distance(center_b) > reach_a + reach_b {
        return false;
    }
    match (core(a), core(b)) {
        (Core::Box(a), Core::Box(b)) => boxes_meet(&a, &b),
        (Core::Segment(p, q, radius), Core::Box(solid)) | (Core::Box(solid), Core::Segment(p, q, radius)) => {
            least(|t| solid.distance(p.lerp(q, t))) < radius
        }
        (Core::Segment(p, q, r), Core::Segment(u, v, s)) => {
            least(|t| least(|w| p.lerp(q, t).distance(u.lerp(v, w)))) < r + s
        }
    }
}

/// Centre and radius of a ball around a solid, m.
fn bounds(shape: &Shape) -> (DVec3, f64) {
    match *shape {
        Shape::Box { center, half_extents, .. } => (center, half_extents.length()),
        Shape::Capsule { a, b, radius } => ((a + b) * 0.5, 0.5 * a.distance(b) + radius),
        Shape::Sphere { center, radius } => (center, radius),
    }
}

/// A solid as a core and a radius around it.
enum Core {
    Box(Solid),
    Segment(DVec3, DVec3, f64),
}

/// A box in space.
struct Solid {
    center: DVec3,
    half: DVec3,
    rotation: DQuat,
}

fn core(shape: &Shape) -> Core {
    match *shape {
        Shape::Box { center, half_extents, rotation } => Core::Box(Solid { center, half: half_extents, rotation }),
        Shape::Capsule { a, b, radius } => Core::Segment(a, b, radius),
        Shape::Sphere { center, radius } => Core::Segment(center, center, radius),
    }
}

impl Solid {
    /// Distance of a point from the box, m; zero inside.
    fn distance(&self, point: DVec3) -> f64 {
        let local = self.rotation.conjugate() * (point - self.center);
        (local.abs() - self.half).max(DVec3::ZERO).length()
    }
    /// Half of the box's extent along a direction, times the direction's length.
    fn reach(&self, direction: DVec3) -> f64 {
        (self.rotation.conjugate() * direction).abs().dot(self.half)
    }
}

/// Least value of a convex function on [0, 1], by ternary search. The distance to a convex set is convex along a line.
fn least(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if f(low + third) < f(high - third) { high -= third } else { low += third }
    }
    f(low).min(f(high)).min(f(0.5 * (low + high)))
}

/// The separating axis theorem: two boxes are apart exactly when one of their six face normals or nine cross products of
/// edges separates them (Gottschalk, Lin, Manocha 1996, "OBBTree").
fn boxes_meet(a: &Solid, b: &Solid) -> bool {
    let (ra, rb) = (DMat3::from_quat(a.rotation), DMat3::from_quat(b.rotation));
    let mut axes = Vec::with_capacity(15);
    for i in 0..3 {
        axes.extend([ra.col(i), rb.col(i)]);
        axes.extend((0..3).map(|j| ra.col(i).cross(rb.col(j))));
    }
    let between = b.center - a.center;
    // Boxes that only touch do not overlap; a parallel pair of edges gives a zero axis, which says nothing.
    !axes
        .iter()
        .filter(|axis| axis.length_squared() > 1e-12)
        .any(|&axis| between.dot(axis).abs() > a.reach(axis) + b.reach(axis) - 1e-12)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Overlap changes exactly where the two surfaces touch, for every pairing of solids.
    #[test]
    fn overlap_ends_where_the_surfaces_touch() {
        let unit = Shape::Box { center: DVec3::ZERO, half_extents: DVec3::splat(0.5), rotation: DQuat::IDENTITY };
        let turned = Shape::Box {
            center: DVec3::ZERO,
            half_extents: DVec3::splat(0.5),
            rotation: DQuat::from_rotation_z(core::f64::consts::FRAC_PI_4),
        };
        let capsule = Shape::Capsule { a: DVec3::ZERO, b: DVec3::Y, radius: 0.2 };
        let ball = Shape::Sphere { center: DVec3::ZERO, radius: 0.3 };
        let half_diagonal = 0.5f64.sqrt();
        for (a, b, touch) in [
            (unit, unit, 1.0),
            (unit, turned, 0.5 + half_diagonal),
            (unit, capsule, 0.7),
            (turned, ball, half_diagonal + 0.3),
            (capsule, capsule, 0.4),
            (capsule, ball, 0.5),
            (ball, ball, 0.6),
        ] {
            for (shift, expected) in [(touch - 1e-6, true), (touch + 1e-6, false)] {
                let moved = b.shifted(DVec3::X * shift);
                assert_eq!(overlap(&a, &moved), expected, "{a:?} and {moved:?}");
                assert_eq!(overlap(&moved, &a), expected, "{moved:?} and {a:?}");
            }
        }
    }
}
