//! Finds the colliders near each athlete and steps it on them.

use crate::engine::arena::Worlds;
use crate::engine::avian::ground::CollidersAndSolids;
use crate::engine::avian::mover::Mover;
use crate::engine::avian::{AthleteSurface, ColliderGround};
use crate::engine::ground::OwnGround;
use crate::engine::{AthleteBody, AthleteSettings, AthleteTime, InArena};
use crate::skill::Director;
use avian3d::prelude::{
    AngularVelocity, Collider, ColliderAabb, ColliderDisabled, ColliderOf, CollisionLayers, ComputedAngularInertia,
    ComputedCenterOfMass, ComputedMass, ContactGraph, DefaultFriction, Friction, LinearVelocity, LockedAxes, Position,
    RigidBody, RigidBodyColliders, RigidBodyDisabled, Rotation, Sensor, SpatialQuery,
};
use bevy::ecs::system::SystemParam;
use bevy::math::{DMat3, DVec3};
use bevy::prelude::*;

/// Links are taken to move no faster than this against the root, m/s.
const LIMB_SPEED: f64 = 10.0;
/// How far beyond its own reach an athlete looks for colliders, m.
const MARGIN: f64 = 0.1;
/// A stack of bodies is followed down to this many.
const STACK: usize = 4;
/// A contact holds a body in a direction if its normal has at least this cosine to it.
const HOLDS: f32 = 0.7;

type NearCollider<'a> = (
    &'a Collider,
    &'a Position,
    &'a Rotation,
    &'a CollisionLayers,
    Option<&'a ColliderOf>,
    Option<&'a AthleteSurface>,
    Option<&'a Friction>,
);
type Solid = (Without<Sensor>, Without<ColliderDisabled>);
type NearBody<'a> = (
    &'a RigidBody,
    &'a Position,
    &'a Rotation,
    &'a LinearVelocity,
    &'a AngularVelocity,
    &'a ComputedMass,
    &'a ComputedAngularInertia,
    &'a ComputedCenterOfMass,
    Option<&'a LockedAxes>,
);

/// Avian's world, to be read.
#[derive(SystemParam)]
pub(super) struct AvianWorld<'w, 's> {
    near: SpatialQuery<'w, 's>,
    colliders: Query<'w, 's, NearCollider<'static>, Solid>,
    bodies: Query<'w, 's, NearBody<'static>, Without<RigidBodyDisabled>>,
    body_surfaces: Query<'w, 's, (Option<&'static AthleteSurface>, Option<&'static Friction>), With<RigidBody>>,
    body_colliders: Query<'w, 's, &'static RigidBodyColliders>,
    contacts: Res<'w, ContactGraph>,
    friction: Res<'w, DefaultFriction>,
}

/// Steps every athlete through the tick on the colliders near it, on all threads of the compute pool.
pub(super) fn step_on_colliders(
    time: Res<AthleteTime>,
    worlds: Worlds,
    avian: AvianWorld,
    mut athletes: Query<
        (Entity, &mut AthleteBody, &mut ColliderGround, &AthleteSettings, Option<&CollisionLayers>, Option<&InArena>),
        With<OwnGround>,
    >,
) {
    let dt = time.delta();
    athletes.par_iter_mut().for_each(|(entity, mut body, mut ground, settings, layers, arena)| {
        avian.gather(entity, &mut body, &mut ground, layers.copied().unwrap_or_default(), dt.as_secs_f64());
        let mut ground = CollidersAndSolids { colliders: &mut ground, solids: worlds.of(arena) };
        body.advance(dt, &mut ground, settings);
    });
}

/// The box that holds all contact points of a body, world frame, m.
fn reach_of(body: &mut AthleteBody) -> (DVec3, DVec3) {
    let model = body.model().clone();
    let simulator = body.simulator_mut();
    let root = simulator.state.root_position.lane(0);
    let links = simulator.kinematics();
    let (mut low, mut high) = (root, root);
    for point in &model.contact_points {
        let link = &links[point.link];
        let origin = root + link.origin.lane(0);
        let place = origin + link.rotation.lane(0) * point.position;
        low = low.min(origin).min(place - DVec3::splat(point.radius));
        high = high.max(origin).max(place + DVec3::splat(point.radius));
    }
    (low, high)
}

impl AvianWorld<'_, '_> {
    /// Fills the ground with what the athlete may reach within `dt` (s), in the order of entities.
    fn gather(
        &self,
        athlete: Entity,
        body: &mut AthleteBody,
        ground: &mut ColliderGround,
        layers: CollisionLayers,
        dt: f64,
    ) {
        let (low, high) = reach_of(body);
        let grow = DVec3::splat(MARGIN + (body.root_velocity().length() + LIMB_SPEED) * dt);
        // What its policies look at belongs to it.
        let sees = DVec3::splat(body.director().map_or(0.0, Director::sees_ground_within));
        let region = (low - grow - sees, high + grow + sees);
        ground.clear(region);
        ground.reserve_points(body.model().contact_points.len());
        if !(region.0.is_finite() && region.1.is_finite()) {
            return;
        }
        let mut found = std::mem::take(&mut ground.found);
        found.clear();
        let aabb = ColliderAabb { min: region.0.as_vec3(), max: region.1.as_vec3() };
        self.near.aabb_intersections_with_aabb_callback(aabb, |entity| {
            found.push(entity);
            true
        });
        found.sort_unstable();
        for &entity in &found {
            self.add_collider(athlete, entity, ground, layers);
        }
        ground.found = found;
        // The athlete's time is behind the tick's by what did not fill a step; so are the bodies now.
        ground.advance(-body.lag());
    }

    fn add_collider(&self, athlete: Entity, entity: Entity, ground: &mut ColliderGround, layers: CollisionLayers) {
        let Ok((collider, position, rotation, its_layers, of, surface, friction)) = self.colliders.get(entity) else {
            return;
        };
        let body = of.map(|of| of.body);
        if entity == athlete || body == Some(athlete) || !layers.interacts_with(*its_layers) {
            return;
        }
        let of_body = body.and_then(|b| self.body_surfaces.get(b).ok());
        let surface = surface.copied().unwrap_or_else(|| {
            let (body_surface, body_friction) = of_body.unwrap_or((None, None));
            body_surface
                .copied()
                .unwrap_or_else(|| AthleteSurface::of_friction(friction.or(body_friction).unwrap_or(&self.friction.0)))
        });
        let Some(mover) = body.and_then(|b| self.mover(b, ground)) else {
            ground.add(collider, position.0, rotation.0, surface);
            return;
        };
        let frame = (position.0.as_dvec3(), rotation.0.as_dquat().normalize());
        ground.add_moving(collider, frame, mover, surface.surface());
    }

    /// The number of a body that moves or can be moved; `None` for one that stays.
    fn mover(&self, entity: Entity, ground: &mut ColliderGround) -> Option<usize> {
        if let Some(known) = ground.mover(entity) {
            return Some(known);
        }
        let (kind, position, rotation, linear, angular, mass, inertia, center, locked) =
            self.bodies.get(entity).ok()?;
        let moves = linear.0 != Vec3::ZERO || angular.0 != Vec3::ZERO;
        if kind.is_static() || (kind.is_kinematic() && !moves) {
            return None;
        }
        let mut mover =
            Mover::new(entity, position.0.as_dvec3(), rotation.0.as_dquat().normalize(), center.0.as_dvec3());
        (mover.linear, mover.angular) = (linear.0.as_dvec3(), angular.0.as_dvec3());
        if kind.is_dynamic() {
            let locked = locked.copied().unwrap_or_default();
            let free = |locked: bool| if locked { 0.0 } else { 1.0 };
            let moves = DVec3::new(
                free(locked.is_translation_x_locked()),
                free(locked.is_translation_y_locked()),
                free(locked.is_translation_z_locked()),
            );
            let turns = DMat3::from_diagonal(DVec3::new(
                free(locked.is_rotation_x_locked()),
                free(locked.is_rotation_y_locked()),
                free(locked.is_rotation_z_locked()),
            ));
            let inverse = inertia.rotated(rotation.0).inverse_tensor();
            let columns = [inverse.col(0), inverse.col(1), inverse.col(2)].map(|c| c.as_dvec3());
            mover.inverse_mass = moves * f64::from(mass.inverse());
            mover.inverse_inertia = turns * DMat3::from_cols_array_2d(&columns.map(|c| c.to_array())) * turns;
            self.each_support(entity, STACK, None, &mut |direction| mover.add_support(direction.as_dvec3()));
        }
        Some(ground.add_mover(mover))
    }

    /// Calls `tell` with the directions from things that will not move to a body that touches them; with `along`, only
    /// those in about that direction. Returns true if there were any.
    fn each_support(&self, body: Entity, depth: usize, along: Option<Vec3>, tell: &mut dyn FnMut(Vec3)) -> bool {
        let Ok(colliders) = self.body_colliders.get(body) else { return false };
        let mut any = false;
        for collider in colliders {
            for pair in self.contacts.contact_pairs_with(collider).filter(|pair| pair.is_touching()) {
                let first = pair.collider1 == collider;
                let (other, other_collider) =
                    if first { (pair.body2, pair.collider2) } else { (pair.body1, pair.collider1) };
                if !self.colliders.contains(other_collider) {
                    continue;
                }
                let moves = other.is_some_and(|other| self.bodies.get(other).is_ok_and(|found| found.0.is_dynamic()));
                for manifold in pair.manifolds.iter().filter(|m| !m.points.is_empty()) {
                    let direction = if first { -manifold.normal } else { manifold.normal };
                    if along.is_some_and(|along| along.dot(direction) < HOLDS) {
                        continue;
                    }
                    let held = match other {
                        Some(other) if moves => {
                            depth > 1 && self.each_support(other, depth - 1, Some(direction), &mut |_| {})
                        }
                        _ => true,
                    };
                    if held {
                        tell(direction);
                        any = true;
                    }
                }
            }
        }
        any
    }
}
