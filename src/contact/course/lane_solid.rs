//! A solid of a course, with other numbers in every lane.

use crate::asset::course::{MotionInstance, SolidInstance, SolidShape};
use crate::contact::geometry::{box_distance, near_top_edge, rail_distance, rail_point};
use crate::contact::{AnchorMotion, Column, GeometryHit, SupportHit, SurfaceHit};
use crate::math::{Mat3, Real, Vec3};
use glam::{DMat3, DVec3};

/// A box along the world's axes round something.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds<R: Real> {
    center: Vec3<R>,
    half: Vec3<R>,
}

impl<R: Real> Bounds<R> {
    /// Round nothing: far away from everything.
    pub fn nothing() -> Self {
        Self { center: Vec3::splat(DVec3::splat(1e9)), half: Vec3::zero() }
    }

    /// Round several others.
    pub fn around<'a>(mut others: impl Iterator<Item = &'a Self>) -> Self {
        let Some(first) = others.next() else { return Self::nothing() };
        let (mut low, mut high) = (first.center - first.half, first.center + first.half);
        for bounds in others {
            let (a, b) = (bounds.center - bounds.half, bounds.center + bounds.half);
            low = Vec3::new(low.x.min(a.x), low.y.min(a.y), low.z.min(a.z));
            high = Vec3::new(high.x.max(b.x), high.y.max(b.y), high.z.max(b.z));
        }
        let half = R::splat(0.5);
        // Rounding may not make it smaller than what it holds.
        let slack = Vec3::splat(DVec3::splat(1e-4));
        Self { center: (low + high) * half, half: (high - low) * half + slack }
    }

    /// A lower bound of the distance to what is inside, m.
    #[inline(always)]
    pub fn gap(&self, point: Vec3<R>) -> R {
        let d = point - self.center;
        (d.x.abs() - self.half.x).max(d.y.abs() - self.half.y).max(d.z.abs() - self.half.z)
    }

    /// Where a vertical line meets it at or below `reached` (m).
    #[inline(always)]
    pub fn under(&self, point: Vec3<R>, reached: R) -> R::Mask {
        let (x, z) = ((point.x - self.center.x).abs(), (point.z - self.center.z).abs());
        x.lt(self.half.x) & z.lt(self.half.z) & (self.center.y - self.half.y).lt(reached)
    }
}

/// The shape over lanes.
#[derive(Clone, Copy, Debug)]
enum LaneShape<R: Real> {
    Block { half: Vec3<R>, to_world: Mat3<R> },
    Rail { along: Vec3<R>, half_length: R, radius: R },
}

/// A solid over lanes.
#[derive(Clone, Debug)]
pub(super) struct LaneSolid<R: Real> {
    pub bounds: Bounds<R>,
    shape: LaneShape<R>,
    center: Vec3<R>,
    velocity: Vec3<R>,
    friction: R,
    /// One where it is so, else zero.
    carves: R,
    grippable: R,
    edge: R,
    /// By lane: its centre before it moves, and how it moves.
    rest: Vec<(DVec3, Option<MotionInstance>)>,
}

impl<R: Real> LaneSolid<R> {
    /// Of the kind of `own`, with no numbers yet.
    pub fn new(own: &SolidInstance) -> Self {
        let (zero, nowhere) = (R::zero(), Vec3::zero());
        let shape = match own.shape {
            SolidShape::Block { .. } => LaneShape::Block { half: nowhere, to_world: Mat3::identity() },
            SolidShape::Rail { .. } => LaneShape::Rail { along: nowhere, half_length: zero, radius: zero },
        };
        Self {
            bounds: Bounds::nothing(),
            shape,
            center: nowhere,
            velocity: nowhere,
            friction: zero,
            carves: zero,
            grippable: zero,
            edge: zero,
            rest: vec![(DVec3::ZERO, None); R::LANES],
        }
    }

    /// Whether it is of the same kind.
    pub fn is_like(&self, own: &SolidInstance) -> bool {
        matches!(
            (&self.shape, &own.shape),
            (LaneShape::Block { .. }, SolidShape::Block { .. }) | (LaneShape::Rail { .. }, SolidShape::Rail { .. })
        )
    }

    /// The place `place` (from its centre, its own axes, m) as it is now in a lane.
    pub fn anchor(&self, lane: usize, place: DVec3) -> AnchorMotion {
        let turned = match &self.shape {
            LaneShape::Block { to_world, .. } => to_world.lane(lane) * place,
            LaneShape::Rail { .. } => place,
        };
        AnchorMotion { place: self.center.lane(lane) + turned, velocity: self.velocity.lane(lane) }
    }

    /// Writes the numbers of a lane; its place follows with the time.
    pub fn set_lane(&mut self, lane: usize, own: &SolidInstance) {
        let reach = match (&mut self.shape, own.shape) {
            (LaneShape::Block { half, to_world }, SolidShape::Block { half: size, rotation }) => {
                half.set_lane(lane, size);
                let m = DMat3::from_quat(rotation);
                set_matrix(to_world, lane, m);
                m.x_axis.abs() * size.x + m.y_axis.abs() * size.y + m.z_axis.abs() * size.z
            }
            (LaneShape::Rail { along, half_length, radius }, SolidShape::Rail { half, radius: size }) => {
                let length = half.length();
                along.set_lane(lane, if length > 0.0 { half / length } else { DVec3::X });
                half_length.set_lane(lane, length);
                radius.set_lane(lane, size);
                half.abs() + size
            }
            // Kinds are compared before.
            _ => return,
        };
        self.bounds.half.set_lane(lane, reach + 1e-4);
        self.friction.set_lane(lane, own.friction);
        let number = |is: bool| f64::from(u8::from(is));
        self.carves.set_lane(lane, number(own.material.carves));
        self.grippable.set_lane(lane, number(own.material.grippable));
        self.edge.set_lane(lane, number(own.edge));
        self.rest[lane] = (own.center, own.motion);
    }

    /// Puts it where it is at a time (s).
    pub fn place(&mut self, lane: usize, time: f64) {
        let (center, motion) = self.rest[lane];
        let (way, velocity) = motion.map_or((DVec3::ZERO, DVec3::ZERO), |m| m.at(time));
        self.center.set_lane(lane, center + way);
        self.bounds.center.set_lane(lane, center + way);
        self.velocity.set_lane(lane, velocity);
    }

    /// Whether it moves in any lane.
    pub fn moves(&self) -> bool {
        self.rest.iter().any(|(_, motion)| motion.is_some())
    }

    #[inline]
    fn geometry_hit(&self, point: Vec3<R>) -> GeometryHit<R> {
        match &self.shape {
            LaneShape::Block { half, to_world } => box_distance(point - self.center, *half, to_world),
            LaneShape::Rail { along, half_length, radius } => {
                rail_distance(point, self.center, *along, *half_length, *radius)
            }
        }
    }

    /// Signed distance, m.
    #[inline]
    pub fn distance(&self, point: Vec3<R>) -> R {
        self.geometry_hit(point).distance
    }

    #[inline]
    pub fn query(&self, point: Vec3<R>) -> SurfaceHit<R> {
        let hit = self.geometry_hit(point);
        let half = R::splat(0.5);
        let mut grippable = half.lt(self.grippable);
        let edge = half.lt(self.edge);
        if let (LaneShape::Block { half, to_world }, true) = (&self.shape, R::any(edge)) {
            grippable = grippable | (edge & near_top_edge(point - self.center, *half, to_world));
        }
        SurfaceHit {
            distance: hit.distance,
            normal: hit.normal,
            velocity: self.velocity,
            friction: self.friction,
            carves: half.lt(self.carves),
            grippable,
        }
    }

    /// Its top in the vertical line through `point`, where it begins below `reached` (m).
    #[inline]
    pub fn height(&self, point: Vec3<R>, reached: R) -> SupportHit<R> {
        let column = match &self.shape {
            LaneShape::Block { half, to_world } => Column::block(point, self.center, *half, to_world),
            LaneShape::Rail { along, half_length, radius } => {
                Column::swept_ball(point, rail_point(point, self.center, *along, *half_length), *radius)
            }
        };
        let found = column.meets & column.bottom.lt(reached);
        let height = R::select(found, column.top, R::splat(SupportHit::<R>::BOTTOMLESS));
        SupportHit { height, normal: column.normal, velocity: self.velocity, found }
    }
}

/// Replaces the matrix of a lane.
fn set_matrix<R: Real>(matrix: &mut Mat3<R>, lane: usize, m: DMat3) {
    matrix.x.set_lane(lane, m.x_axis);
    matrix.y.set_lane(lane, m.y_axis);
    matrix.z.set_lane(lane, m.z_axis);
}
