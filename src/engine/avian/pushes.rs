//! The athletes' pushes, handed to Avian.

use crate::engine::avian::ColliderGround;
use avian3d::prelude::{Forces, WriteRigidBodyForces};
use bevy::prelude::*;

/// Gives the pushes of the tick to the bodies, athlete by athlete in the order of their entities.
pub(super) fn hand_over_pushes(
    grounds: Query<(Entity, &ColliderGround)>,
    mut bodies: Query<Forces>,
    mut order: Local<Vec<Entity>>,
) {
    order.clear();
    order.extend(grounds.iter().map(|(entity, _)| entity));
    order.sort_unstable();
    for (_, ground) in order.iter().filter_map(|entity| grounds.get(*entity).ok()) {
        for push in ground.pushes() {
            if let Ok(mut body) = bodies.get_mut(push.body) {
                body.apply_linear_impulse(push.impulse.as_vec3());
                body.apply_angular_impulse(push.moment.as_vec3());
            }
        }
    }
}
