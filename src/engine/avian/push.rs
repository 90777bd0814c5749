//! What an athlete did to a body of Avian's.

use bevy::math::DVec3;
use bevy::prelude::*;

/// What an athlete did to a dynamic body in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct ColliderPush {
    /// The rigid body.
    pub body: Entity,
    /// Impulse on the body, world axes, N s; the athlete got its opposite.
    pub impulse: DVec3,
    /// Moment of the impulses about `center`, world axes, N m s.
    pub moment: DVec3,
    /// Centre of mass of the body at the start of the tick, world frame, m.
    pub center: DVec3,
}
