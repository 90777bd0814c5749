//! Self-collision: links that are not neighbours push each other apart.
//!
//! Each link is represented by one capsule. A pair that overlaps is pushed apart by a spring and a damper along the line
//! of the closest points, an equal and opposite force at one and the same point, so momentum is untouched.

use crate::dynamics::LinkKinematics;
use crate::math::{Force, Real, Vec3};
use crate::model::{CharacterModel, Shape};
use glam::DVec3;

/// A link's stand-in for self-collision, link frame, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionCapsule {
    /// One end of the segment.
    pub a: DVec3,
    /// The other end.
    pub b: DVec3,
    /// Radius.
    pub radius: f64,
}

/// Tuning of self-collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfCollisionSettings {
    /// Spring of a pair, N/m. 20 kN/m stops a 3 kg leg at 2 m/s within 2.5 cm.
    pub stiffness: f64,
    /// Damper of a pair, N s/m, only while approaching.
    pub damping: f64,
    /// Overlap from which on the force no longer grows, m.
    pub depth_limit: f64,
}

impl Default for SelfCollisionSettings {
    fn default() -> Self {
        Self { stiffness: 20_000.0, damping: 60.0, depth_limit: 0.03 }
    }
}

impl CollisionCapsule {
    /// The capsule along the longest extent of the link's largest shape; `None` for a link without shapes.
    pub fn of(shapes: &[Shape]) -> Option<Self> {
        let volume = |s: &Shape| match s {
            Shape::Box { half_extents, .. } => half_extents.x * half_extents.y * half_extents.z,
            Shape::Capsule { a, b, radius } => radius * radius * (a.distance(*b) + radius),
            Shape::Sphere { radius, .. } => radius * radius * radius,
        };
        let shape = shapes.iter().max_by(|a, b| volume(a).total_cmp(&volume(b)))?;
        Some(match *shape {
            Shape::Capsule { a, b, radius } => Self { a, b, radius },
            Shape::Sphere { center, radius } => Self { a: center, b: center, radius },
            Shape::Box { center, half_extents, rotation } => {
                let e = half_extents.to_array();
                let long = (0..3).max_by(|&i, &j| e[i].total_cmp(&e[j])).unwrap_or(0);
                let others = [e[(long + 1) % 3], e[(long + 2) % 3]];
                let radius = 0.5 * (others[0] + others[1]);
                let mut half = [0.0; 3];
                half[long] = (e[long] - radius).max(0.0);
                let half = rotation * DVec3::from_array(half);
                Self { a: center - half, b: center + half, radius }
            }
        })
    }

    /// The capsules of all links.
    pub fn all(model: &CharacterModel) -> Vec<Option<Self>> {
        model.links.iter().map(|l| Self::of(&l.shapes)).collect()
    }
}

/// Closest points of two segments given by start and direction: the parameters on both, in [0, 1].
///
/// Ericson 2005, "Real-Time Collision Detection", Section 5.1.9, without branches.
#[inline(always)]
fn closest<R: Real>(p: Vec3<R>, d1: Vec3<R>, q: Vec3<R>, d2: Vec3<R>) -> (R, R) {
    let (zero, one, tiny) = (R::zero(), R::one(), R::splat(1e-9));
    let r = p - q;
    let (a, e) = (d1.length_squared().max(tiny), d2.length_squared().max(tiny));
    let (b, c, f) = (d1.dot(d2), d1.dot(r), d2.dot(r));
    // Parallel segments (denominator near zero) start from the first end.
    let denominator = a * e - b * b;
    let parallel = denominator.lt(tiny * a * e);
    let s = R::select(parallel, zero, (b * f - c * e) / denominator.max(tiny)).clamp(zero, one);
    let t = ((b * s + f) / e).clamp(zero, one);
    let s = ((b * t - c) / a).clamp(zero, one);
    (s, t)
}

/// Two links that may meet.
#[derive(Clone, Copy, Debug)]
struct Pair {
    i: usize,
    j: usize,
    /// Square of the distance of their middles from which on they cannot touch, m^2.
    reach: f64,
}

/// The links of a model that may meet, and work space for the search.
#[derive(Clone, Debug)]
pub struct SelfCollision<R: Real> {
    /// Links without a shape have one of no size; no pair names them.
    capsules: Vec<CollisionCapsule>,
    pairs: Vec<Pair>,
    /// Middles of the capsules, relative to the root, world axes, m.
    middles: Vec<Vec3<R>>,
}

impl<R: Real> SelfCollision<R> {
    /// That of a model.
    pub fn of(model: &CharacterModel) -> Self {
        let capsules = CollisionCapsule::all(model);
        let pair = |&(i, j): &(usize, usize)| {
            let (ci, cj) = (capsules[i]?, capsules[j]?);
            let reach = 0.5 * (ci.a.distance(ci.b) + cj.a.distance(cj.b)) + ci.radius + cj.radius;
            Some(Pair { i, j, reach: reach * reach })
        };
        let nothing = CollisionCapsule { a: DVec3::ZERO, b: DVec3::ZERO, radius: 0.0 };
        Self {
            pairs: model.collision_pairs.iter().filter_map(pair).collect(),
            middles: vec![Vec3::zero(); capsules.len()],
            capsules: capsules.into_iter().map(|c| c.unwrap_or(nothing)).collect(),
        }
    }

    /// Adds the forces of all overlapping pairs to `wrenches` (about the link origins, world axes). Returns true if any
    /// pair overlaps in any lane.
    #[inline]
    pub fn add_forces(
        &mut self,
        kinematics: &[LinkKinematics<R>],
        settings: &SelfCollisionSettings,
        wrenches: &mut [Force<R>],
    ) -> bool {
        let zero = R::zero();
        let mut touched = false;
        for ((middle, link), capsule) in self.middles.iter_mut().zip(kinematics).zip(&self.capsules) {
            *middle = link.rotation.mul_vec(Vec3::splat((capsule.a + capsule.b) * 0.5)) + link.origin;
        }
        for &Pair { i, j, reach } in &self.pairs {
            // Bounding balls first.
            let (mid_i, mid_j) = (self.middles[i], self.middles[j]);
            if !R::any((mid_i - mid_j).length_squared().lt(R::splat(reach))) {
                continue;
            }
            let (ci, cj) = (&self.capsules[i], &self.capsules[j]);
            let (ki, kj) = (&kinematics[i], &kinematics[j]);
            let di = ki.rotation.mul_vec(Vec3::splat(ci.b - ci.a));
            let dj = kj.rotation.mul_vec(Vec3::splat(cj.b - cj.a));
            let half = R::splat(0.5);
            let (pi, pj) = (mid_i - di * half, mid_j - dj * half);
            let (s, t) = closest(pi, di, pj, dj);
            let (on_i, on_j) = (pi + di * s, pj + dj * t);
            let between = on_i - on_j;
            let distance = between.length();
            let depth = R::splat(ci.radius + cj.radius) - distance;
            // Crossing axes have no direction to part in.
            let overlapping = zero.lt(depth) & R::splat(1e-6).lt(distance);
            if !R::any(overlapping) {
                continue;
            }
            touched = true;
            let n = between * R::select(overlapping, distance, R::one()).recip();
            // The force acts half way into the overlap, at one point for both.
            let point = on_j + n * (R::splat(cj.radius) - depth * half);
            let velocity = ki.velocity.at(point - ki.origin) - kj.velocity.at(point - kj.origin);
            let closing = (-velocity.dot(n)).max(zero);
            let depth = depth.min(R::splat(settings.depth_limit));
            let push = R::splat(settings.stiffness) * depth + R::splat(settings.damping) * closing;
            let force = (n * push).masked(overlapping);
            wrenches[i] += Force::at(point - ki.origin, force);
            wrenches[j] += Force::at(point - kj.origin, -force);
        }
        touched
    }
}

/// How deep the capsules of links that are not neighbours are in each other, the deepest pair of a lane, m; 0 for none.
pub fn deepest_overlap<R: Real>(
    model: &CharacterModel,
    capsules: &[Option<CollisionCapsule>],
    kinematics: &[LinkKinematics<R>],
    lane: usize,
) -> f64 {
    let segment = |link: usize, c: &CollisionCapsule| {
        let (k, place) = (&kinematics[link], |p: DVec3| Vec3::<R>::splat(p));
        let (a, b) = (k.rotation.mul_vec(place(c.a)) + k.origin, k.rotation.mul_vec(place(c.b)) + k.origin);
        (Vec3::<f64>::splat(a.lane(lane)), Vec3::<f64>::splat((b - a).lane(lane)))
    };
    let depth = |&(i, j): &(usize, usize)| {
        let (ci, cj) = (capsules[i].as_ref()?, capsules[j].as_ref()?);
        let ((p, d), (q, e)) = (segment(i, ci), segment(j, cj));
        let (s, t) = closest(p, d, q, e);
        Some(ci.radius + cj.radius - (p + d * s - q - e * t).length())
    };
    model.collision_pairs.iter().filter_map(depth).fold(0.0, f64::max)
}
