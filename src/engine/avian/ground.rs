//! The colliders near one athlete, as its ground.

use crate::contact::{
    AnchorMotion, ContactCandidate, Material, SupportHit, Surface, SurfaceHit, Terrain, World as Solids,
};
use crate::engine::avian::form::{FAR, Form};
use crate::engine::avian::mover::Mover;
use crate::engine::avian::{AthleteSurface, ColliderPush};
use crate::engine::ground::{Ground, OwnGround};
use crate::math::{Sym3, Vec3};
use crate::sim::Simulator;
use avian3d::parry::shape::{SharedShape, TypedShape};
use avian3d::prelude::Collider;
use bevy::math::{DMat3, DQuat, DVec3, Quat, Vec3 as Point};
use bevy::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// No collider.
const NONE: u32 = u32::MAX;
/// Where the bounding box is further away than this, its distance is good enough, m.
const NEAR: f64 = 0.5;
/// Compounds within compounds are followed to this depth.
const DEEPEST: usize = 4;

/// A simple shape near the athlete.
#[derive(Clone, Debug)]
struct NearShape {
    form: Form,
    surface: Surface,
    /// Frame of the shape: in the world, or in the frame of its moving body.
    origin: DVec3,
    rotation: DQuat,
    /// The frame in the world now, for shapes that move.
    now: Option<(DVec3, DQuat)>,
    /// Bounding box in its frame; `None` for one without an end.
    bounds: Option<(DVec3, DVec3)>,
    mover: Option<usize>,
}

impl NearShape {
    /// A point of the world in the shape's frame.
    fn local(&self, point: DVec3) -> DVec3 {
        let (origin, rotation) = self.now.unwrap_or((self.origin, self.rotation));
        rotation.inverse() * (point - origin)
    }
    /// A direction of the shape's frame in the world.
    fn to_world(&self, direction: DVec3) -> DVec3 {
        self.now.map_or(self.rotation, |(_, rotation)| rotation) * direction
    }
    /// Distance from a point in the shape's frame to its bounding box, m.
    fn to_bounds(&self, local: DVec3) -> f64 {
        self.bounds.map_or(0.0, |(low, high)| (local - local.clamp(low, high)).length())
    }
}

/// The colliders of Avian that are near an athlete, as they move and are pushed while a tick is stepped. The plugin adds it to every athlete.
///
/// It is a [`Terrain`], so it can be asked about without an app as well: [`ColliderGround::add`] puts colliders at rest in.
#[derive(Component, Debug, Default)]
#[require(OwnGround)]
pub struct ColliderGround {
    shapes: Vec<NearShape>,
    movers: Vec<Mover>,
    /// By contact point, the shape that was nearest when it was last asked about.
    touched: Vec<AtomicU32>,
    /// Entities found near, kept for their room.
    pub(super) found: Vec<Entity>,
    /// The neighbourhood it was filled for, world frame, m.
    region: (DVec3, DVec3),
}

impl ColliderGround {
    /// Removes all colliders. `region` is the box that will be asked about (world frame, m): of height fields, the part
    /// in it is looked at once.
    pub fn clear(&mut self, region: (DVec3, DVec3)) {
        self.shapes.clear();
        self.movers.clear();
        self.region = region;
    }

    /// Adds a collider at rest at a place of the world.
    pub fn add(&mut self, collider: &Collider, position: Point, rotation: Quat, surface: AthleteSurface) {
        let frame = (position.as_dvec3(), rotation.as_dquat().normalize());
        self.add_shape(collider.shape_scaled(), frame, None, surface.surface(), DEEPEST);
    }

    /// The pushes of the last tick on dynamic bodies.
    pub fn pushes(&self) -> impl Iterator<Item = ColliderPush> + '_ {
        let pushed = self.movers.iter().filter(|m| m.is_dynamic() && m.impulse != DVec3::ZERO);
        pushed.map(|m| ColliderPush { body: m.entity, impulse: m.impulse, moment: m.moment, center: m.handed_center })
    }

    /// Room for the contact points of a character.
    pub(super) fn reserve_points(&mut self, count: usize) {
        self.touched.resize_with(count, || AtomicU32::new(NONE));
    }

    /// The number of a moving body that is known already.
    pub(super) fn mover(&self, entity: Entity) -> Option<usize> {
        self.movers.iter().position(|m| m.entity == entity)
    }

    /// Adds a moving body and returns its number.
    pub(super) fn add_mover(&mut self, mover: Mover) -> usize {
        self.movers.push(mover);
        self.movers.len() - 1
    }

    /// Adds a collider that belongs to a moving body, at its place in the world.
    pub(super) fn add_moving(&mut self, collider: &Collider, at: (DVec3, DQuat), mover: usize, surface: Surface) {
        self.add_shape(collider.shape_scaled(), at, Some(mover), surface, DEEPEST);
    }

    /// All moving bodies go on by `dt` (s), and their shapes with them.
    pub(super) fn advance(&mut self, dt: f64) {
        self.movers.iter_mut().for_each(|m| m.advance(dt));
        for shape in &mut self.shapes {
            if let Some(mover) = shape.mover.map(|m| &self.movers[m]) {
                shape.now = Some((mover.point(shape.origin), mover.rotation * shape.rotation));
            }
        }
    }

    fn add_shape(
        &mut self,
        shape: &SharedShape,
        at: (DVec3, DQuat),
        mover: Option<usize>,
        surface: Surface,
        deeper: usize,
    ) {
        let (position, rotation) = at;
        if let (TypedShape::Compound(compound), 1..) = (shape.as_typed_shape(), deeper) {
            for (pose, part) in compound.shapes() {
                let frame = (
                    position + rotation * pose.translation.as_dvec3(),
                    (rotation * pose.rotation.as_dquat()).normalize(),
                );
                self.add_shape(part, frame, mover, surface, deeper - 1);
            }
            return;
        }
        let box_of = shape.compute_local_aabb();
        let (low, high) = (box_of.mins.as_dvec3(), box_of.maxs.as_dvec3());
        let bounds = (low.is_finite() && high.is_finite() && (high - low).max_element() < 1e8).then_some((low, high));
        let (near_low, near_high) = seen_from(self.region, position, rotation);
        let form = Form::of(shape, near_low, near_high);
        // In the frame of the body that carries it.
        let (mut origin, mut frame, mut now) = (position, rotation, None);
        if let Some(body) = mover.map(|m| &self.movers[m]) {
            let back = body.rotation.inverse();
            origin = body.local_center + back * (position - body.center);
            frame = (back * rotation).normalize();
            now = Some((position, rotation));
        }
        self.shapes.push(NearShape { form, surface, origin, rotation: frame, now, bounds, mover });
    }

    /// The nearest shape: its number, distance and outward normal, world axes.
    fn nearest(&self, point: DVec3) -> Option<(usize, f64, DVec3)> {
        let mut best: Option<(usize, f64, DVec3)> = None;
        for (index, shape) in self.shapes.iter().enumerate() {
            let local = shape.local(point);
            let nearest = best.map_or(FAR, |(_, distance, _)| distance);
            // A point inside of something is still looked up in what it may be inside of as well.
            if shape.to_bounds(local) > nearest.max(0.0) {
                continue;
            }
            let (distance, normal) = shape.form.distance(local);
            if distance < nearest {
                best = Some((index, distance, shape.to_world(normal)));
            }
        }
        best
    }

    /// Velocity of a shape's matter at a point, m/s.
    fn velocity(&self, shape: usize, point: DVec3) -> DVec3 {
        self.shapes[shape].mover.map_or(DVec3::ZERO, |m| self.movers[m].velocity_at(point))
    }

    /// The shape and the dynamic body under a contact point, as last asked about.
    fn body_under(&self, contact_point: usize) -> Option<usize> {
        let shape = self.touched.get(contact_point)?.load(Ordering::Relaxed);
        let mover = self.shapes.get(shape as usize)?.mover?;
        self.movers[mover].is_dynamic().then_some(mover)
    }

    fn hit(&self, point: Vec3<f64>) -> (u32, SurfaceHit<f64>) {
        let at = point.lane(0);
        let Some((index, distance, normal)) = self.nearest(at).filter(|_| at.is_finite()) else {
            let nothing = SurfaceHit { distance: FAR, ..SurfaceHit::nothing() };
            return (NONE, nothing);
        };
        let surface = self.shapes[index].surface;
        // The surface's own point: what turns carries it there.
        let velocity = self.velocity(index, at - normal * distance);
        let hit = SurfaceHit {
            distance,
            normal: Vec3::splat(normal),
            velocity: Vec3::splat(velocity),
            friction: surface.friction,
            carves: surface.material.carves,
            grippable: surface.material.grippable,
        };
        (index as u32, hit)
    }
}

/// A box of the world as seen from a frame: the box in that frame that holds it.
fn seen_from((low, high): (DVec3, DVec3), origin: DVec3, rotation: DQuat) -> (DVec3, DVec3) {
    let back = DMat3::from_quat(rotation.inverse());
    let (center, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let center = back * (center - origin);
    let half = back.x_axis.abs() * half.x + back.y_axis.abs() * half.y + back.z_axis.abs() * half.z;
    (center - half, center + half)
}

impl Terrain<f64> for ColliderGround {
    fn query(&self, point: Vec3<f64>) -> SurfaceHit<f64> {
        self.hit(point).1
    }

    fn clearance(&self, point: Vec3<f64>) -> f64 {
        let at = point.lane(0);
        let mut nearest = FAR;
        if at.is_finite() {
            for shape in &self.shapes {
                let local = shape.local(at);
                let bounds = shape.to_bounds(local);
                if bounds < nearest {
                    nearest = nearest.min(if bounds > NEAR { bounds } else { shape.form.clearance(local) });
                }
            }
        }
        nearest
    }

    fn query_contact(&self, index: usize, point: Vec3<f64>) -> SurfaceHit<f64> {
        let (shape, hit) = self.hit(point);
        if let Some(touched) = self.touched.get(index) {
            touched.store(shape, Ordering::Relaxed);
        }
        hit
    }

    fn material(&self, _lane: usize, point: DVec3) -> Material {
        let (shape, _) = self.hit(Vec3::splat(point));
        self.shapes.get(shape as usize).map_or(Material::GROUND, |shape| shape.surface.material)
    }

    fn is_compliant(&self) -> bool {
        self.movers.iter().any(Mover::is_dynamic)
    }

    fn surface_inverse_mass(&self, root: Vec3<f64>, candidates: &[ContactCandidate<f64>], out: &mut [Sym3<f64>]) {
        let body_of = |c: &ContactCandidate<f64>| if c.is_grip { None } else { self.body_under(c.source) };
        for (candidate, give) in candidates.iter().zip(out) {
            *give = Sym3::zero();
            if let Some(body) = body_of(candidate) {
                let sharers = candidates.iter().filter(|c| body_of(c) == Some(body)).count();
                let point = (root + candidate.place).lane(0);
                let normal = candidate.directions[0].lane(0);
                *give = Sym3::splat(self.movers[body].surface_inverse_mass(point, normal, sharers as f64));
            }
        }
    }
}

/// Colliders and the solids of [`AthleteWorld`](crate::engine::AthleteWorld) together; the nearest counts.
pub(super) struct CollidersAndSolids<'a> {
    pub colliders: &'a mut ColliderGround,
    pub solids: &'a Solids,
}

impl CollidersAndSolids<'_> {
    fn nearer_solid(&self, point: Vec3<f64>, distance: f64) -> Option<SurfaceHit<f64>> {
        if self.solids.solids.is_empty() {
            return None;
        }
        let hit = self.solids.query(point);
        (hit.distance < distance).then_some(hit)
    }
}

impl Terrain<f64> for CollidersAndSolids<'_> {
    fn query(&self, point: Vec3<f64>) -> SurfaceHit<f64> {
        let hit = self.colliders.query(point);
        self.nearer_solid(point, hit.distance).unwrap_or(hit)
    }

    fn clearance(&self, point: Vec3<f64>) -> f64 {
        self.colliders.clearance(point).min(Terrain::<f64>::clearance(self.solids, point))
    }

    fn query_contact(&self, index: usize, point: Vec3<f64>) -> SurfaceHit<f64> {
        let hit = self.colliders.query_contact(index, point);
        let Some(nearer) = self.nearer_solid(point, hit.distance) else { return hit };
        if let Some(touched) = self.colliders.touched.get(index) {
            touched.store(NONE, Ordering::Relaxed);
        }
        nearer
    }

    fn height(&self, point: Vec3<f64>) -> SupportHit<f64> {
        self.colliders.height(point).higher(&self.solids.height(point))
    }

    /// That of what is nearer: a solid or a collider.
    fn material(&self, lane: usize, point: DVec3) -> Material {
        let at = Vec3::splat(point);
        let collider = self.colliders.query(at).distance;
        match self.nearer_solid(at, collider) {
            Some(_) => Terrain::<f64>::material(self.solids, lane, point),
            None => self.colliders.material(lane, point),
        }
    }

    /// The solids of the world; colliders have no numbers.
    fn anchor(&self, lane: usize, solid: usize, place: DVec3) -> Option<AnchorMotion> {
        Terrain::<f64>::anchor(self.solids, lane, solid, place)
    }

    fn is_compliant(&self) -> bool {
        self.colliders.is_compliant()
    }

    fn surface_inverse_mass(&self, root: Vec3<f64>, candidates: &[ContactCandidate<f64>], out: &mut [Sym3<f64>]) {
        self.colliders.surface_inverse_mass(root, candidates, out);
    }
}

impl Ground for CollidersAndSolids<'_> {
    /// Gives the step's impulses to the bodies, and moves them on.
    fn stepped(&mut self, simulator: &Simulator<f64>) {
        let ground = &mut *self.colliders;
        if ground.movers.is_empty() {
            return;
        }
        let root = simulator.contact_root_position;
        for candidate in simulator.contact.candidates().iter().filter(|c| !c.is_grip) {
            let impulse = -candidate.impulse().lane(0);
            if let Some(body) = ground.body_under(candidate.source)
                && impulse.is_finite()
            {
                let point = (root + candidate.place).lane(0);
                ground.movers[body].push(point, candidate.directions[0].lane(0), impulse);
            }
        }
        ground.advance(simulator.step_seconds());
    }
}
