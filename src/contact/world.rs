//! Solids that all characters share.

use crate::contact::geometry::near_top_edge;
use crate::contact::terrain::STEP_UP;
use crate::contact::{AnchorMotion, Geometry, Material, SupportHit, Surface, SurfaceHit, Terrain};
use crate::math::{Mat3, Real, Vec3};
use glam::{DMat3, DQuat, DVec3};

/// One solid of the world.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Its shape.
    pub geometry: Geometry,
    /// Its surface.
    pub surface: Surface,
    /// The edges of its top can be held on to, if it is a box.
    pub edge: bool,
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
        let still = DVec3::ZERO;
        Self { geometry, surface, edge: false, linear_velocity: still, angular_velocity: still, pivot: still }
    }

    /// Origin (world frame, m) and axes of its frame: the middle of its shape and, of a box, its axes; of a strip or a height
    /// field those of the world.
    pub fn frame(&self) -> (DVec3, DQuat) {
        match &self.geometry {
            Geometry::Plane { point, .. } => (*point, DQuat::IDENTITY),
            Geometry::Box { center, rotation, .. } => (*center, *rotation),
            Geometry::Sphere { center, .. } | Geometry::Rail { center, .. } => (*center, DQuat::IDENTITY),
            Geometry::Strip { .. } | Geometry::HeightField(_) => (DVec3::ZERO, DQuat::IDENTITY),
        }
    }

    /// The place `place` (its own frame, m) as it is now.
    pub fn anchor(&self, place: DVec3) -> AnchorMotion {
        let (origin, axes) = self.frame();
        let place = origin + axes * place;
        AnchorMotion { place, velocity: self.velocity(Vec3::<f64>::splat(place)).lane(0) }
    }

    /// Its surface, as seen from `point` (world frame, m).
    #[inline]
    fn query<R: Real>(&self, point: Vec3<R>) -> SurfaceHit<R> {
        let hit = self.geometry.signed_distance(point);
        let none = R::zero().lt(R::zero());
        let everywhere = |is: bool| if is { !none } else { none };
        SurfaceHit {
            distance: hit.distance,
            normal: hit.normal,
            velocity: self.velocity(point),
            friction: R::splat(self.surface.friction),
            carves: everywhere(self.surface.material.carves),
            grippable: everywhere(self.surface.material.grippable) | self.at_edge(point),
        }
    }

    /// Whether a point is at an edge of its top that can be held on to.
    #[inline]
    fn at_edge<R: Real>(&self, point: Vec3<R>) -> R::Mask {
        match self.geometry {
            Geometry::Box { center, half_extents, rotation } if self.edge => {
                let to_world = Mat3::splat(DMat3::from_quat(rotation));
                near_top_edge(point - Vec3::splat(center), Vec3::splat(half_extents), &to_world)
            }
            _ => R::zero().lt(R::zero()),
        }
    }

    /// Velocity of its matter at `point`, m/s.
    #[inline]
    fn velocity<R: Real>(&self, point: Vec3<R>) -> Vec3<R> {
        if self.angular_velocity == DVec3::ZERO {
            return Vec3::splat(self.linear_velocity);
        }
        let arm = point - Vec3::splat(self.pivot);
        Vec3::splat(self.linear_velocity) + Vec3::splat(self.angular_velocity).cross(arm)
    }

    /// Its top in the vertical line through `point`, where it counts as a support of the point.
    #[inline]
    fn height<R: Real>(&self, point: Vec3<R>) -> SupportHit<R> {
        let column = self.geometry.column(point);
        let found = column.meets & column.bottom.lt(point.y + R::splat(STEP_UP));
        SupportHit {
            height: R::select(found, column.top, R::splat(SupportHit::<R>::BOTTOMLESS)),
            normal: column.normal,
            velocity: self.velocity(Vec3::new(point.x, column.top, point.z)),
            found,
        }
    }

    /// A plane that tilts about the axis `axis` (unit, horizontal) through `pivot`: by the angle `angle` (rad) at
    /// present, changing at `rate` (rad/s).
    pub fn tilted_plane(pivot: DVec3, axis: DVec3, angle: f64, rate: f64, surface: Surface) -> Self {
        Self {
            geometry: Geometry::Plane { point: pivot, normal: DQuat::from_axis_angle(axis, angle) * DVec3::Y },
            surface,
            edge: false,
            linear_velocity: DVec3::ZERO,
            angular_velocity: axis * rate,
            pivot,
        }
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
        let mut best = SurfaceHit::nothing();
        for solid in &self.solids {
            // A lane in which it is too far off stays out, whatever its neighbours need.
            let may = solid.geometry.at_least(point).lt(best.distance);
            if R::any(may) {
                let hit = solid.query(point);
                best = best.replaced(may & hit.distance.lt(best.distance), &hit);
            }
        }
        best
    }

    fn anchor(&self, _lane: usize, solid: usize, place: DVec3) -> Option<AnchorMotion> {
        self.solids.get(solid).map(|solid| solid.anchor(place))
    }

    fn material(&self, _lane: usize, point: DVec3) -> Material {
        let away = |solid: &Solid| solid.geometry.signed_distance(Vec3::<f64>::splat(point)).distance;
        let nearest = self.solids.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        nearest.map_or(Material::GROUND, |solid| solid.surface.material)
    }

    #[inline]
    fn clearance(&self, point: Vec3<R>) -> R {
        if let [solid] = self.solids.as_slice() {
            return solid.geometry.clearance(point);
        }
        self.solids.iter().fold(R::splat(1e9), |nearest, solid| {
            let may = solid.geometry.at_least(point).lt(nearest);
            if !R::any(may) {
                return nearest;
            }
            R::select(may, solid.geometry.clearance(point).min(nearest), nearest)
        })
    }

    #[inline]
    fn height(&self, point: Vec3<R>) -> SupportHit<R> {
        if let [solid] = self.solids.as_slice() {
            return solid.height(point);
        }
        self.solids.iter().fold(SupportHit::nothing(), |best, solid| best.higher(&solid.height(point)))
    }
}
