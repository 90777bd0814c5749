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

use crate::dynamics::{LinkConstants, State};
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
    /// Extra torque on the child (and its opposite on the parent), child axes, N m; not limited.
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

/// The explicit part of the servo torque and the gain of its implicit part.
#[derive(Clone, Copy, Debug, Default)]
pub struct ServoOutput<R> {
    /// Torque on the child, child axes, N m, without the implicit term.
    pub torque: Vec3<R>,
    /// Implicit gain e, N m s^2/rad.
    pub implicit: R,
}

/// The servo of link `i` for a step of `h` seconds.
#[inline(always)]
pub fn servo<R: Real>(
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
    let torque = (error - w * h) * command.kp + (command.velocity - w) * command.kd;
    let implicit = h * h.mul_add(command.kp, command.kd);

    // The torque limit scales both parts: a saturated servo is a weaker servo in the same direction.
    let squared = torque.length_squared();
    let saturated = (constants.max_torque * constants.max_torque).lt(squared);
    let (mut torque, mut implicit) = if R::any(saturated) {
        let scale = R::select(saturated, constants.max_torque / squared.sqrt(), R::one());
        (torque * scale, implicit * scale)
    } else {
        (torque, implicit)
    };
    torque += command.torque;

    if let (Some((low, high)), Some(spring)) = (constants.limits, limit_spring) {
        let r = joint.rotation.to_rotation_vector();
        let beyond = |x: R, low: R, high: R| (x - high).max(R::zero()) + (x - low).min(R::zero());
        let excess = Vec3::new(beyond(r.x, low.x, high.x), beyond(r.y, low.y, high.y), beyond(r.z, low.z, high.z));
        let violated = R::zero().lt(excess.length_squared());
        if R::any(violated) {
            let (k, d) = (R::splat(spring.stiffness), R::splat(spring.damping));
            // Damping only where the limit is violated, component by component.
            let part = |x: R, w: R| R::select(R::zero().lt(x.abs()), w, R::zero());
            let moving = Vec3::new(part(excess.x, w.x), part(excess.y, w.y), part(excess.z, w.z));
            torque -= (excess + moving * h) * k + moving * d;
            implicit += (h * h.mul_add(k, d)).masked(violated);
        }
    }
    ServoOutput { torque, implicit }
}
