//! A course in every lane: obstacles of the lane's own over solids that all lanes share.

mod ground;
mod lane_solid;

use crate::asset::CourseInstance;
use crate::asset::course::{SolidInstance, SolidShape};
use crate::contact::terrain::STEP_UP;
use crate::contact::{
    AnchorMotion, Geometry, HeightField, HeightFieldError, Solid, SupportHit, Surface, SurfaceHit, Terrain, World,
};
use crate::math::{Real, Vec3};
use glam::DVec3;
use ground::LaneGround;
use lane_solid::{Bounds, LaneSolid};
use std::sync::Arc;

/// Solids whose bounds are looked at together, and blocks of them.
const BLOCK: usize = 8;

/// Why a course was not put into a lane.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CourseLaneError {
    /// Lanes share the kinds of their solids and the size of their ground.
    #[error("lane {lane}: {what} is {found}; valid: {valid}, as in the other lanes (instances of one course)")]
    Different {
        /// The lane.
        lane: usize,
        /// What differs.
        what: &'static str,
        /// As it is in the instance.
        found: String,
        /// As it is in the other lanes.
        valid: String,
    },
    /// There is no such lane.
    #[error("lane {lane}; valid: 0 to {last}")]
    NoLane {
        /// The lane.
        lane: usize,
        /// The last one.
        last: usize,
    },
}

/// A terrain of shared solids and of a course in each lane.
///
/// All lanes have the same kinds of solids in the same order, each with numbers of its own; an instance is put into a lane
/// without allocation. Where a solid that moves is follows from the lane's time alone, so a snapshot needs the time.
///
/// Only what may be near a point is asked: solids lie in blocks of eight with common bounds, and blocks in regions of eight.
/// Without a course it is the shared world.
#[derive(Clone, Debug)]
pub struct CourseTerrain<R: Real> {
    world: Arc<World>,
    ground: LaneGround<R>,
    solids: Vec<LaneSolid<R>>,
    /// Bounds of eight solids each.
    blocks: Vec<Bounds<R>>,
    /// Bounds of eight blocks each.
    regions: Vec<Bounds<R>>,
    /// Which solids move in any lane, ascending.
    moving: Vec<usize>,
    /// By lane, s.
    times: Vec<f64>,
}

impl<R: Real> CourseTerrain<R> {
    /// The shared world alone.
    pub fn empty(world: Arc<World>) -> Self {
        Self::new(world, &CourseInstance::default())
    }

    /// The same course in every lane, at time zero. `world` is what all lanes share; a course with ground of its own wants an
    /// empty one.
    pub fn new(world: Arc<World>, instance: &CourseInstance) -> Self {
        let mut terrain = Self {
            world,
            ground: LaneGround::new(instance),
            solids: instance.solids.iter().map(LaneSolid::new).collect(),
            blocks: vec![Bounds::nothing(); instance.solids.len().div_ceil(BLOCK)],
            regions: vec![Bounds::nothing(); instance.solids.len().div_ceil(BLOCK * BLOCK)],
            moving: Vec::with_capacity(instance.solids.len()),
            times: vec![0.0; R::LANES],
        };
        for lane in 0..R::LANES {
            terrain.put(lane, instance);
        }
        terrain.find_moving();
        terrain
    }

    /// Puts a course into a lane, at time zero; refuses one of other kinds of solids than the lanes have.
    pub fn set_lane(&mut self, lane: usize, instance: &CourseInstance) -> Result<(), CourseLaneError> {
        if lane >= R::LANES {
            return Err(CourseLaneError::NoLane { lane, last: R::LANES - 1 });
        }
        let different =
            |what, found: String, valid: String| Err(CourseLaneError::Different { lane, what, found, valid });
        if instance.solids.len() != self.solids.len() {
            let (found, valid) = (instance.solids.len().to_string(), self.solids.len().to_string());
            return different("number of solids", found, valid);
        }
        if let Some(k) = (0..self.solids.len()).find(|&k| !self.solids[k].is_like(&instance.solids[k])) {
            let found = format!("{:?}", instance.solids[k].shape).chars().take(5).collect();
            return different("kind of a solid", found, format!("that of solid {}", k + 1));
        }
        if let Some((what, found, valid)) = self.ground.difference(instance) {
            return different(what, found, valid);
        }
        self.put(lane, instance);
        self.find_moving();
        Ok(())
    }

    /// Writes an instance that fits into a lane, at time zero.
    fn put(&mut self, lane: usize, instance: &CourseInstance) {
        self.ground.set_lane(lane, instance);
        for (solid, own) in self.solids.iter_mut().zip(&instance.solids) {
            solid.set_lane(lane, own);
        }
        self.set_time(lane, 0.0);
    }

    fn find_moving(&mut self) {
        self.moving.clear();
        self.moving.extend((0..self.solids.len()).filter(|&k| self.solids[k].moves()));
    }

    /// Time of a lane, s.
    pub fn time(&self, lane: usize) -> f64 {
        self.times[lane]
    }

    /// Sets the time of a lane (s), and moves what moves there.
    pub fn set_time(&mut self, lane: usize, time: f64) {
        self.times[lane] = time;
        for solid in &mut self.solids {
            solid.place(lane, time);
        }
        self.bound();
    }

    /// All lanes go on by `h` (s).
    pub fn advance(&mut self, h: f64) {
        self.times.iter_mut().for_each(|t| *t += h);
        for &k in &self.moving {
            for (lane, time) in self.times.iter().enumerate() {
                self.solids[k].place(lane, *time);
            }
        }
        if !self.moving.is_empty() {
            self.bound();
        }
    }

    /// True if a solid moves in any lane.
    pub fn moves(&self) -> bool {
        !self.moving.is_empty()
    }

    /// Bounds of blocks and regions, from those of the solids.
    fn bound(&mut self) {
        for (bounds, solids) in self.blocks.iter_mut().zip(self.solids.chunks(BLOCK)) {
            *bounds = Bounds::around(solids.iter().map(|s| &s.bounds));
        }
        for (bounds, blocks) in self.regions.iter_mut().zip(self.blocks.chunks(BLOCK)) {
            *bounds = Bounds::around(blocks.iter());
        }
    }

    /// Shows a state to solid after solid, past all whose bounds are not worth a look.
    #[inline(always)]
    fn each<S>(
        &self,
        state: &mut S,
        worth: impl Fn(&S, &Bounds<R>) -> bool,
        mut look: impl FnMut(&mut S, &LaneSolid<R>),
    ) {
        let regions = self.blocks.chunks(BLOCK).zip(self.solids.chunks(BLOCK * BLOCK));
        for (region, (blocks, solids)) in self.regions.iter().zip(regions) {
            // Few solids need no region.
            if self.regions.len() > 1 && !worth(state, region) {
                continue;
            }
            for (block, solids) in blocks.iter().zip(solids.chunks(BLOCK)) {
                if worth(state, block) {
                    solids.iter().for_each(|solid| look(state, solid));
                }
            }
        }
    }
}

impl<R: Real> Terrain<R> for CourseTerrain<R> {
    #[inline]
    fn query(&self, point: Vec3<R>) -> SurfaceHit<R> {
        let mut best = if self.world.solids.is_empty() { SurfaceHit::nothing() } else { self.world.query(point) };
        if let Some(hit) = self.ground.query(point) {
            best = best.replaced(hit.distance.lt(best.distance), &hit);
        }
        let worth = |best: &SurfaceHit<R>, bounds: &Bounds<R>| R::any(bounds.gap(point).lt(best.distance));
        self.each(&mut best, worth, |best, solid| {
            // A lane that its bounds rule out stays out, whatever its neighbours need.
            let may = solid.bounds.gap(point).lt(best.distance);
            if R::any(may) {
                let hit = solid.query(point);
                *best = best.replaced(may & hit.distance.lt(best.distance), &hit);
            }
        });
        best
    }

    #[inline]
    fn clearance(&self, point: Vec3<R>) -> R {
        /// Bounds that are further away are a good enough bound of the distance, m.
        const NEAR: f64 = 0.25;
        let mut nearest =
            if self.world.solids.is_empty() { R::splat(1e9) } else { Terrain::<R>::clearance(&*self.world, point) };
        nearest = self.ground.clearance(point).map_or(nearest, |own| own.min(nearest));
        let worth = |nearest: &R, bounds: &Bounds<R>| R::any(bounds.gap(point).lt(*nearest));
        self.each(&mut nearest, worth, |nearest, solid| {
            let gap = solid.bounds.gap(point);
            let close = gap.lt(R::splat(NEAR)) & gap.lt(*nearest);
            let own = if R::any(close) { R::select(close, solid.distance(point), gap) } else { gap };
            *nearest = nearest.min(own);
        });
        nearest
    }

    /// The solids of the shared world come first, then those of the course.
    fn anchor(&self, lane: usize, solid: usize, place: DVec3) -> Option<AnchorMotion> {
        match self.world.solids.get(solid) {
            Some(solid) => Some(solid.anchor(place)),
            None => Some(self.solids.get(solid - self.world.solids.len())?.anchor(lane, place)),
        }
    }

    #[inline]
    fn height(&self, point: Vec3<R>) -> SupportHit<R> {
        let mut best = if self.world.solids.is_empty() { SupportHit::nothing() } else { self.world.height(point) };
        if let Some(hit) = self.ground.height(point) {
            best = best.higher(&hit);
        }
        let reached = point.y + R::splat(STEP_UP);
        let worth = |_: &SupportHit<R>, bounds: &Bounds<R>| R::any(bounds.under(point, reached));
        self.each(&mut best, worth, |best, solid| *best = best.higher(&solid.height(point, reached)));
        best
    }
}

impl World {
    /// The solids of a course at a time (s), as they then move: its ground first, then what stands on it. For a world that
    /// is drawn, or in which nothing moves.
    pub fn course_solids(instance: &CourseInstance, time: f64) -> Result<Vec<Solid>, HeightFieldError> {
        let mut solids = Vec::new();
        if let Some((material, friction)) = instance.ground {
            let surface = Surface { material, friction };
            match &instance.bumps {
                Some(b) => {
                    let field = HeightField::new(b.origin, b.spacing, b.columns, b.rows, b.heights.clone())?
                        .tilted(instance.slope);
                    solids.push(Solid::fixed(Geometry::HeightField(Arc::new(field)), surface));
                }
                None if instance.gaps.is_empty() => {
                    let normal = DVec3::new(0.0, 1.0, instance.slope).normalize();
                    solids.push(Solid::fixed(Geometry::Plane { point: DVec3::ZERO, normal }, surface));
                }
                None => {
                    let brinks = instance.gaps.iter().map(|g| g.1);
                    let near = std::iter::once(f64::INFINITY).chain(brinks);
                    let far = instance.gaps.iter().map(|g| g.0).chain(std::iter::once(f64::NEG_INFINITY));
                    let strip = |(near, far)| Solid::fixed(Geometry::Strip { top: 0.0, near, far }, surface);
                    solids.extend(near.zip(far).map(strip));
                }
            }
        }
        solids.extend(instance.solids.iter().map(|solid| moved(solid, time)));
        Ok(solids)
    }

    /// A course alone, or on `base` where it has no ground of its own; at time 0.
    pub fn with_course(base: &World, instance: &CourseInstance) -> Result<World, HeightFieldError> {
        let mut world = if instance.ground.is_some() { World::empty() } else { base.clone() };
        world.solids.extend(Self::course_solids(instance, 0.0)?);
        Ok(world)
    }
}

/// A solid of a course at a time (s).
fn moved(own: &SolidInstance, time: f64) -> Solid {
    let (way, velocity) = own.motion.map_or((DVec3::ZERO, DVec3::ZERO), |m| m.at(time));
    let center = own.center + way;
    let geometry = match own.shape {
        SolidShape::Block { half, rotation } => Geometry::Box { center, half_extents: half, rotation },
        SolidShape::Rail { half, radius } => Geometry::Rail { center, half, radius },
    };
    let surface = Surface { material: own.material, friction: own.friction };
    Solid { linear_velocity: velocity, edge: own.edge, ..Solid::fixed(geometry, surface) }
}
