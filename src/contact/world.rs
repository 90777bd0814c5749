//! The world as the characters feel it: a signed distance with a normal, a surface velocity and a surface kind.

use crate::contact::{ContactCandidate, Geometry};
use crate::math::{Real, Sym3, Vec3};
use glam::{DQuat, DVec3};

/// What a surface is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Ice: blades act as knife edges.
    Ice,
    /// Ordinary ground.
    Ground,
    /// A wall or an obstacle.
    Wall,
}

/// Kind and friction of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// What it is made of.
    pub kind: SurfaceKind,
    /// Coulomb coefficient.
    pub friction: f64,
}

impl Surface {
    /// Ice with the friction of the skating paper, 0.02.
    pub const ICE: Self = Self { kind: SurfaceKind::Ice, friction: 0.02 };
    /// Ground with friction 0.8.
    pub const GROUND: Self = Self { kind: SurfaceKind::Ground, friction: 0.8 };
}

/// One solid of the world.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Its shape.
    pub geometry: Geometry,
    /// Its surface.
    pub surface: Surface,
    /// Velocity of the solid at `pivot`, world axes, m/s: what stands on it is carried.
    pub linear_velocity: DVec3,
    /// Angular velocity, world axes, rad/s.
    pub angular_velocity: DVec3,
    /// Point that moves with `linear_velocity`, world frame, m.
    pub pivot: DVec3,
}

impl Solid {
    /// A solid at rest.
    pub fn fixed(geometry: Geometry, surface: Surface) -> Self {
        Self { geometry, surface, linear_velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO, pivot: DVec3::ZERO }
    }

    /// Its surface, as seen from `point` (world frame, m).
    #[inline]
    fn query<R: Real>(&self, point: Vec3<R>) -> SurfaceHit<R> {
        let hit = self.geometry.signed_distance(point);
        let velocity = if self.angular_velocity == DVec3::ZERO {
            Vec3::splat(self.linear_velocity)
        } else {
            let arm = point - Vec3::splat(self.pivot);
            Vec3::splat(self.linear_velocity) + Vec3::splat(self.angular_velocity).cross(arm)
        };
        let none = R::zero().lt(R::zero());
        SurfaceHit {
            distance: hit.distance,
            normal: hit.normal,
            velocity,
            friction: R::splat(self.surface.friction),
            ice: if self.surface.kind == SurfaceKind::Ice { !none } else { none },
        }
    }

    /// A plane that tilts about the axis `axis` (unit, horizontal) through `pivot`: by the angle `angle` (rad) at
    /// present, changing at `rate` (rad/s).
    pub fn tilted_plane(pivot: DVec3, axis: DVec3, angle: f64, rate: f64, surface: Surface) -> Self {
        Self {
            geometry: Geometry::Plane { point: pivot, normal: DQuat::from_axis_angle(axis, angle) * DVec3::Y },
            surface,
            linear_velocity: DVec3::ZERO,
            angular_velocity: axis * rate,
            pivot,
        }
    }
}

/// The answer of a [`Terrain`] for one point.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHit<R: Real> {
    /// Signed distance, m; negative inside.
    pub distance: R,
    /// Outward unit normal.
    pub normal: Vec3<R>,
    /// Velocity of the surface there, world axes, m/s.
    pub velocity: Vec3<R>,
    /// Coulomb coefficient.
    pub friction: R,
    /// True where the surface is ice.
    pub ice: R::Mask,
}

/// Anything that a character can touch.
pub trait Terrain<R: Real> {
    /// The surface nearest to `point` (world frame, m).
    fn query(&self, point: Vec3<R>) -> SurfaceHit<R>;

    /// A lower bound of the distance from `point` to anything, m: nothing within this distance of the point is inside a
    /// surface. The links that it clears are not asked further. To be overridden where `query` may overstate.
    #[inline]
    fn clearance(&self, point: Vec3<R>) -> R {
        self.query(point).distance
    }

    /// `query` on behalf of contact point `index` of the character. A terrain of several things overrides it to remember
    /// which of them the point is on.
    #[inline]
    fn query_contact(&self, index: usize, point: Vec3<R>) -> SurfaceHit<R> {
        let _ = index;
        self.query(point)
    }

    /// True if something in it may give way; then `give` is asked in every step with contact.
    #[inline]
    fn yields(&self) -> bool {
        false
    }

    /// How the surface under each candidate gives way: `out[k]` is the velocity there per impulse on it, world axes, 1/kg;
    /// zero where it does not move. `root` is what the candidates' places are relative to (world frame, m). Of a candidate
    /// only the source, the place and the normal (`directions[0]`) are known yet; grips are among them, and theirs is not used.
    #[inline]
    fn give(&self, root: Vec3<R>, candidates: &[ContactCandidate<R>], out: &mut [Sym3<R>]) {
        let _ = (root, candidates);
        out.fill(Sym3::zero());
    }
}

impl<R: Real, T: Terrain<R>> Terrain<R> for &T {
    #[inline]
    fn query(&self, point: Vec3<R>) -> SurfaceHit<R> {
        T::query(self, point)
    }
    #[inline]
    fn clearance(&self, point: Vec3<R>) -> R {
        T::clearance(self, point)
    }
    #[inline]
    fn query_contact(&self, index: usize, point: Vec3<R>) -> SurfaceHit<R> {
        T::query_contact(self, index, point)
    }
    #[inline]
    fn yields(&self) -> bool {
        T::yields(self)
    }
    #[inline]
    fn give(&self, root: Vec3<R>, candidates: &[ContactCandidate<R>], out: &mut [Sym3<R>]) {
        T::give(self, root, candidates, out);
    }
}

/// Solids, nearest first wins.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// The solids; none means empty space.
    pub solids: Vec<Solid>,
}

impl World {
    /// Level ice at y = 0.
    pub fn ice() -> Self {
        Self::plane(Surface::ICE)
    }
    /// Level ground at y = 0.
    pub fn ground() -> Self {
        Self::plane(Surface::GROUND)
    }
    /// A level plane at y = 0 with this surface.
    pub fn plane(surface: Surface) -> Self {
        Self { solids: vec![Solid::fixed(Geometry::Plane { point: DVec3::ZERO, normal: DVec3::Y }, surface)] }
    }
    /// Empty space.
    pub fn empty() -> Self {
        Self::default()
    }
    /// Steps in the -Z direction on level ground: `count` boxes from z = `start`, each `depth` deep, `width` wide, and
    /// `rise` higher than the one before, m.
    pub fn stairs(start: f64, count: usize, depth: f64, rise: f64, width: f64, surface: Surface) -> Self {
        let mut world = Self::plane(surface);
        for k in 0..count {
            let height = rise * (k + 1) as f64;
            let length = depth * (count - k) as f64;
            let far = start - depth * k as f64;
            world.solids.push(Solid::fixed(
                Geometry::Box {
                    center: DVec3::new(0.0, height * 0.5, far - length * 0.5),
                    half_extents: DVec3::new(width * 0.5, height * 0.5, length * 0.5),
                    rotation: DQuat::IDENTITY,
                },
                surface,
            ));
        }
        world
    }
}

impl<R: Real> Terrain<R> for World {
    #[inline]
    fn query(&self, point: Vec3<R>) -> SurfaceHit<R> {
        if let [solid] = self.solids.as_slice() {
            return solid.query(point);
        }
        let zero = R::zero();
        let mut best = SurfaceHit {
            distance: R::splat(1e9),
            normal: Vec3::splat(DVec3::Y),
            velocity: Vec3::zero(),
            friction: zero,
            ice: zero.lt(zero),
        };
        for solid in &self.solids {
            let hit = solid.query(point);
            let nearer = hit.distance.lt(best.distance);
            best.distance = R::select(nearer, hit.distance, best.distance);
            best.normal = Vec3::select(nearer, hit.normal, best.normal);
            best.friction = R::select(nearer, hit.friction, best.friction);
            best.velocity = Vec3::select(nearer, hit.velocity, best.velocity);
            best.ice = (best.ice & !nearer) | (hit.ice & nearer);
        }
        best
    }

    #[inline]
    fn clearance(&self, point: Vec3<R>) -> R {
        if let [solid] = self.solids.as_slice() {
            return solid.geometry.clearance(point);
        }
        let far = R::splat(1e9);
        self.solids.iter().fold(far, |nearest, solid| solid.geometry.clearance(point).min(nearest))
    }
}
