//! Stable PD servos and joint limits.
//!
//! Tan, Liu, Turk 2011, "Stable Proportional-Derivative Controllers", equation 3: the torque is evaluated at the end of
//! the step. With the semi-implicit step `w' = w + h a`, `q' = q + h w'` that is
//!
//! ```text
//! tau = kp (error - h w) + kd (w_target - w) - e a,     e = h (kd + h kp)
//! ```
//!
//! where `error` is the rotation vector from the joint's rotation to its target (child axes), `w` the joint velocity
//! (child axes), `a` its unknown derivative. The term `-e a` goes into the articulated inertias.
//!
//! Beyond the range of the joint a spring and a damper act in the same way, each component of the rotation vector for
//! itself, with implicit gains on those components only.
//!
//! A passive spring acts on top of all that, by the same equation with a target at rest; no limit holds for it.
//!
//! The joint's torque limit holds for the sum of servo, extra torque and spring; the servo yields to the spring. Only a spring that is
//! stronger than the limit by itself keeps its strength: a joint thrown against its end stop is held by bone and ligament, and one
//! that could be turned through its range would come out on the other side. The limit is applied to what is known before the
//! step, the explicit and the implicit part by the same factor: a servo at its limit is a weaker servo, which is as stable as the
//! strong one. In a jolt the implicit damping may still go beyond the limit for a step: what it makes of it is known only when the step
//! is solved.

use crate::dynamics::{JointState, LinkConstants, State};
use crate::math::{Quat, Real, Vec3};

/// What a joint is told to do.
#[derive(Clone, Copy, Debug)]
pub struct JointCommand<R> {
    /// Target rotation, child axes to parent axes.
    pub rotation: Quat<R>,
    /// Target angular velocity, child axes, rad/s.
    pub velocity: Vec3<R>,
    /// Stiffness, N m/rad. Zero with `kd` zero leaves the joint loose.
    pub kp: R,
    /// Damping, N m s/rad.
    pub kd: R,
    /// Extra torque on the child (and its opposite on the parent), child axes, N m. It counts towards the joint's torque limit
    /// like the servo's own.
    pub torque: Vec3<R>,
}

/// Spring and damper that act once a joint is beyond its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitSpring {
    /// N m/rad. A 20 N m load on a limit opens it by 0.6 degrees.
    pub stiffness: f64,
    /// N m s/rad; acts implicitly on the whole relative motion while the joint is beyond its range.
    pub damping: f64,
}

impl Default for LimitSpring {
    fn default() -> Self {
        Self { stiffness: 2000.0, damping: 40.0 }
    }
}

/// The explicit part of a joint's torque and the gains of its implicit part.
#[derive(Clone, Copy, Debug, Default)]
pub struct ServoOutput<R> {
    /// Torque on the child, child axes, N m, without the implicit term.
    pub torque: Vec3<R>,
    /// Implicit gain e about every axis, N m s^2/rad.
    pub implicit: R,
    /// Implicit gains about each of the child's axes that come on top, N m s^2/rad: those of the limit spring of a ball joint.
    /// `None` where no lane is beyond its range, zero about axes within it.
    pub beyond: Option<Vec3<R>>,
}

impl<R: Real> ServoOutput<R> {
    /// The whole torque on the child once the joint's acceleration is known (child axes, N m and rad/s^2).
    #[inline(always)]
    pub fn torque_at(&self, acceleration: Vec3<R>) -> Vec3<R> {
        let torque = self.torque - acceleration * self.implicit;
        match self.beyond {
            None => torque,
            Some(gains) => torque - acceleration.component_mul(gains),
        }
    }
}

/// The torque of a joint's passive spring as it is now (child axes, N m): `k error - d w`; zero without one.
pub fn passive_torque<R: Real>(constants: &LinkConstants<R>, joint: &JointState<R>) -> Vec3<R> {
    let Some(spring) = &constants.spring else { return Vec3::zero() };
    let error = (joint.rotation.conjugate() * spring.rest).to_rotation_vector();
    let torque = error * spring.stiffness - joint.velocity * spring.damping;
    constants.hinge.map_or(torque, |axis| axis * axis.dot(torque))
}

/// The servo of link `i` for a step of `h` seconds, and its passive spring.
#[inline(always)]
pub fn servo<R: Real>(
    constants: &LinkConstants<R>,
    state: &State<R>,
    i: usize,
    command: &JointCommand<R>,
    limit_spring: Option<LimitSpring>,
    h: R,
) -> ServoOutput<R> {
    let mut output = driven(constants, state, i, command, limit_spring, h);
    if let Some(spring) = &constants.spring {
        let joint = &state.joints[i];
        output.torque += passive_torque(constants, joint) - joint.velocity * (h * spring.stiffness);
        output.implicit += h * h.mul_add(spring.stiffness, spring.damping);
    }
    output
}

/// What a joint does that is told to: servo, extra torque and limit spring.
#[inline(always)]
fn driven<R: Real>(
    constants: &LinkConstants<R>,
    state: &State<R>,
    i: usize,
    command: &JointCommand<R>,
    limit_spring: Option<LimitSpring>,
    h: R,
) -> ServoOutput<R> {
    let joint = &state.joints[i];
    let error = (joint.rotation.conjugate() * command.rotation).to_rotation_vector();
    let w = joint.velocity;
    let mut torque = (error - w * h) * command.kp + (command.velocity - w) * command.kd + command.torque;
    if let Some(axis) = constants.hinge {
        // A hinge is driven about its axis alone.
        torque = axis * axis.dot(torque);
    }
    let mut implicit = h * h.mul_add(command.kp, command.kd);

    let most = constants.max_torque;
    let squared = torque.length_squared();
    let saturated = (most * most).lt(squared);
    if R::any(saturated) {
        let scale = R::select(saturated, most / squared.sqrt(), R::one());
        torque = torque * scale;
        implicit *= scale;
    }

    let (Some((low, high)), Some(spring)) = (constants.limits, limit_spring) else {
        return ServoOutput { torque, implicit, beyond: None };
    };
    let r = joint.rotation.to_rotation_vector();
    let beyond = |x: R, low: R, high: R| (x - high).max(R::zero()) + (x - low).min(R::zero());
    let excess = Vec3::new(beyond(r.x, low.x, high.x), beyond(r.y, low.y, high.y), beyond(r.z, low.z, high.z));
    let violated = R::zero().lt(excess.length_squared());
    if !R::any(violated) {
        return ServoOutput { torque, implicit, beyond: None };
    }

    let (k, d) = (R::splat(spring.stiffness), R::splat(spring.damping));
    // Only where the limit is violated, component by component.
    let part = |x: R, value: R| value.masked(R::zero().lt(x.abs()));
    let moving = Vec3::new(part(excess.x, w.x), part(excess.y, w.y), part(excess.z, w.z));
    let gain = h * h.mul_add(k, d);
    let gains = Vec3::new(part(excess.x, gain), part(excess.y, gain), part(excess.z, gain));
    let spring = -((excess + moving * h) * k + moving * d);
    // (A servo at its limit within the range is not over it by rounding.)
    let over = violated & (most * most).lt((torque + spring).length_squared());
    if R::any(over) {
        let servo_part = R::select(over, share(torque, spring, most.max(spring.length())), R::one());
        torque = torque * servo_part;
        implicit *= servo_part;
    }
    torque += spring;
    match constants.hinge {
        Some(axis) => {
            let about_axis = axis.dot(axis.component_mul(gains));
            ServoOutput { torque, implicit: implicit + about_axis, beyond: None }
        }
        None => ServoOutput { torque, implicit, beyond: Some(gains) },
    }
}

/// The part, 0 to 1, of a servo's torque that stays beside a limit spring's: the largest alpha with `|spring + alpha servo| <= most`,
/// the larger root of a quadratic. `most` is not below the spring's own torque.
#[inline]
fn share<R: Real>(servo: Vec3<R>, spring: Vec3<R>, most: R) -> R {
    let square = servo.length_squared().max(R::splat(1e-30));
    let along = servo.dot(spring);
    let inside = (most * most - spring.length_squared()).max(R::zero());
    let root = square.mul_add(inside, along * along).sqrt();
    ((root - along) / square).clamp(R::zero(), R::one())
}
