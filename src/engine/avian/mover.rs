//! A rigid body of Avian as it moves while a tick of the athlete is stepped.

use bevy::ecs::entity::Entity;
use bevy::math::{DMat3, DQuat, DVec3};

/// How many directions are kept in which a body leans on something.
const SUPPORTS: usize = 3;
/// Supports whose directions have a larger cosine are one.
const SAME_SUPPORT: f64 = 0.95;
/// A push with a normal that has a smaller cosine to a support's direction lifts the body off it.
const LIFTS: f64 = -0.3;
/// A push with a normal that has a larger one presses the body onto it.
const PRESSES: f64 = 0.5;

/// A kinematic or dynamic body between two steps of Avian: it goes on with its velocity, which the athlete's pushes change
/// if it is dynamic. Gravity, joints and its other contacts act in Avian's own step, once per tick.
#[derive(Clone, Debug)]
pub(super) struct Mover {
    pub entity: Entity,
    /// Centre of mass and rotation now, world frame, m.
    pub center: DVec3,
    pub rotation: DQuat,
    /// Centre of mass in the body's frame, m.
    pub local_center: DVec3,
    /// Velocity of the centre of mass, m/s, and angular velocity, rad/s; world axes.
    pub linear: DVec3,
    pub angular: DVec3,
    /// Inverse mass along the world's axes, 1/kg; zero for kinematic bodies and locked axes.
    pub inverse_mass: DVec3,
    /// Inverse inertia about the centre of mass, world axes, at the start of the tick, 1/(kg m^2).
    pub inverse_inertia: DMat3,
    /// Centre of mass for Avian, where the pushes of this tick are handed over, m.
    pub handed_center: DVec3,
    /// Pushes of this tick: impulse, N s, and its moment about `handed_center`, N m s.
    pub impulse: DVec3,
    pub moment: DVec3,
    supports: [DVec3; SUPPORTS],
    support_count: usize,
}

impl Mover {
    /// A body at a place with a velocity; immovable until it is given a mass.
    pub fn new(entity: Entity, position: DVec3, rotation: DQuat, local_center: DVec3) -> Self {
        let center = position + rotation * local_center;
        Self {
            entity,
            center,
            rotation,
            local_center,
            linear: DVec3::ZERO,
            angular: DVec3::ZERO,
            inverse_mass: DVec3::ZERO,
            inverse_inertia: DMat3::ZERO,
            handed_center: center,
            impulse: DVec3::ZERO,
            moment: DVec3::ZERO,
            supports: [DVec3::ZERO; SUPPORTS],
            support_count: 0,
        }
    }

    /// True if pushes move it.
    pub fn is_dynamic(&self) -> bool {
        self.inverse_mass != DVec3::ZERO || self.inverse_inertia != DMat3::ZERO
    }

    /// The body leans on something that will not move: `direction` (unit) is from there to the body.
    pub fn add_support(&mut self, direction: DVec3) {
        let known = &self.supports[..self.support_count];
        if self.support_count < SUPPORTS && known.iter().all(|s| s.dot(direction) < SAME_SUPPORT) {
            self.supports[self.support_count] = direction;
            self.support_count += 1;
        }
    }

    /// Place of a point of the body's frame, m.
    pub fn point(&self, local: DVec3) -> DVec3 {
        self.center + self.rotation * (local - self.local_center)
    }

    /// Velocity of the body's matter at a point of the world, m/s.
    pub fn velocity_at(&self, point: DVec3) -> DVec3 {
        self.linear + self.angular.cross(point - self.center)
    }

    /// Moves on by `dt` (s, may be negative).
    pub fn advance(&mut self, dt: f64) {
        self.center += self.linear * dt;
        if self.angular != DVec3::ZERO {
            // A step turns by so little that first order and a new normalisation are exact to rounding of single precision.
            let w = self.angular * (0.5 * dt);
            self.rotation = (self.rotation + DQuat::from_xyzw(w.x, w.y, w.z, 0.0) * self.rotation).normalize();
        }
    }

    /// What remains of a push through a contact with this outward normal after its supports have answered: the projection off their
    /// directions. A push that lifts the body off a support is not held by it.
    fn free(&self, normal: DVec3, push: DVec3) -> DVec3 {
        let mut held = [DVec3::ZERO; SUPPORTS];
        let mut count = 0;
        let mut push = push;
        for support in &self.supports[..self.support_count] {
            if normal.dot(*support) < LIFTS {
                continue;
            }
            // Square to those before.
            let off = held[..count].iter().fold(*support, |d, h| d - *h * h.dot(*support));
            if let Some(direction) = off.try_normalize() {
                held[count] = direction;
                count += 1;
                push -= direction * direction.dot(push);
            }
        }
        push
    }

    /// Angular velocity per moment of a push with this normal. What is pressed onto one support turns about its direction
    /// only, onto several not at all; else it turns freely. (On a floor it would turn less: the push is underrated rather than overrated.)
    fn turn(&self, normal: DVec3, moment: DVec3) -> DVec3 {
        let mut pressed = self.supports[..self.support_count].iter().filter(|s| normal.dot(**s) > PRESSES);
        match (pressed.next(), pressed.next()) {
            (None, _) => self.inverse_inertia * moment,
            (Some(axis), None) => *axis * (axis.dot(self.inverse_inertia * *axis) * axis.dot(moment)),
            _ => DVec3::ZERO,
        }
    }

    /// Velocity of its surface at `point` per impulse there, world axes, 1/kg, for a contact with the outward normal `normal`
    /// that is one of `sharers` on this body. Each of them is given its part of the mass (Tonge, Benevolenski, Voroshilov
    /// 2012, "Mass Splitting for Jitter-Free Parallel Rigid Body Simulation"): together they push the whole.
    pub fn surface_inverse_mass(&self, point: DVec3, normal: DVec3, sharers: f64) -> DMat3 {
        let arm = point - self.center;
        let column = |impulse: DVec3| {
            let impulse = self.free(normal, impulse);
            let velocity = self.inverse_mass * impulse + self.turn(normal, arm.cross(impulse)).cross(arm);
            self.free(normal, velocity) * sharers
        };
        DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
    }

    /// Takes an impulse (N s) at a point of the world through a contact with this outward normal.
    pub fn push(&mut self, point: DVec3, normal: DVec3, impulse: DVec3) {
        self.impulse += impulse;
        self.moment += (point - self.handed_center).cross(impulse);
        let free = self.free(normal, impulse);
        self.linear += self.inverse_mass * free;
        self.angular += self.turn(normal, (point - self.center).cross(free));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crate_of_5_kg() -> Mover {
        Mover {
            inverse_mass: DVec3::splat(0.2),
            inverse_inertia: DMat3::from_diagonal(DVec3::new(4.0, 5.0, 6.0)),
            ..Mover::new(Entity::PLACEHOLDER, DVec3::new(1.0, 0.25, 0.0), DQuat::IDENTITY, DVec3::ZERO)
        }
    }

    #[test]
    fn it_gives_way_as_pushes_then_move_it() {
        let (point, normal) = (DVec3::new(0.75, 0.4, 0.1), DVec3::NEG_X);
        let impulse = DVec3::new(1.0, -0.2, 0.3);
        for supports in [&[][..], &[DVec3::Y], &[DVec3::Y, DVec3::Z]] {
            let mut body = crate_of_5_kg();
            supports.iter().for_each(|s| body.add_support(*s));
            let give = body.surface_inverse_mass(point, normal, 1.0);
            assert!((give - give.transpose()).abs_diff_eq(DMat3::ZERO, 1e-12), "an inverse mass is symmetric");
            body.push(point, normal, impulse);
            let moved = body.free(normal, body.velocity_at(point));
            assert!((moved - give * impulse).length() < 1e-12, "{supports:?}: {moved}, {}", give * impulse);
            assert_eq!(body.impulse, impulse, "Avian gets all of it");
        }
    }

    #[test]
    fn what_it_leans_on_holds_it() {
        let mut body = crate_of_5_kg();
        body.add_support(DVec3::Y);
        body.push(DVec3::new(1.2, 0.5, 0.2), DVec3::Y, DVec3::new(0.0, -10.0, 0.0));
        assert_eq!((body.linear, body.angular), (DVec3::ZERO, DVec3::ZERO), "stood upon");
        body.push(DVec3::new(1.0, 0.0, 0.0), DVec3::NEG_Y, DVec3::new(0.0, 10.0, 0.0));
        assert_eq!(body.linear, DVec3::Y * 2.0, "lifted from below");
    }
}
