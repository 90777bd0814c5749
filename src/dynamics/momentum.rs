//! Momentum, energy, and the correction that makes momentum exact.

use crate::dynamics::{LinkConstants, LinkKinematics, State};
use crate::math::{Motion, Real, Sym3, Vec3};

/// Total momentum of a character.
#[derive(Clone, Copy, Debug, Default)]
pub struct Momentum<R> {
    /// Linear momentum, world axes, kg m/s.
    pub linear: Vec3<R>,
    /// Angular momentum about the centre of mass, world axes, kg m^2/s.
    pub angular: Vec3<R>,
}

/// Mass distribution of the whole body.
#[derive(Clone, Copy, Debug, Default)]
pub struct Totals<R> {
    /// Centre of mass relative to the root's origin, world axes, m.
    pub com: Vec3<R>,
    /// Composite rotational inertia about the centre of mass, world axes, kg m^2.
    pub inertia: Sym3<R>,
}

/// Centre of mass and composite inertia of the whole body.
#[inline]
pub fn totals<R: Real>(constants: &[LinkConstants<R>], kinematics: &[LinkKinematics<R>], mass: R) -> Totals<R> {
    let mut first_moment = Vec3::zero();
    let mut inertia = Sym3::zero();
    for (c, k) in constants.iter().zip(kinematics) {
        let r = k.origin + k.com;
        first_moment = r.mul_add(c.mass, first_moment);
        inertia += k.inertia_com.add_parallel_axis(c.mass, r);
    }
    let com = first_moment * mass.recip();
    Totals { com, inertia: inertia - Sym3::parallel_axis(mass, com) }
}

/// Linear momentum and angular momentum about the centre of mass `com` (relative to the root's origin).
#[inline]
pub fn momentum<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    com: Vec3<R>,
) -> Momentum<R> {
    let (mut linear, mut angular) = (Vec3::zero(), Vec3::zero());
    for (c, k) in constants.iter().zip(kinematics) {
        let p = k.velocity.at(k.com) * c.mass;
        linear += p;
        // One addition per link hangs on the link before.
        angular += (k.origin + k.com - com).cross_add(p, k.inertia_com.mul_vec(k.velocity.angular));
    }
    Momentum { linear, angular }
}

/// Kinetic and potential energy, J, that of armatures included and that of springs left out; the potential is zero at y = 0 for a gravity along -y.
pub fn energy<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    root_position: Vec3<R>,
    gravity: Vec3<R>,
) -> (R, R) {
    let half = R::splat(0.5);
    let (mut kinetic, mut potential) = (R::zero(), R::zero());
    for (c, k) in constants.iter().zip(kinematics) {
        let omega = k.velocity.angular;
        let v = k.velocity.at(k.com);
        kinetic += half * (c.mass * v.length_squared() + omega.dot(k.inertia_com.mul_vec(omega)));
        kinetic += half * c.armature * k.joint_velocity.length_squared();
        potential -= c.mass * gravity.dot(root_position + k.origin + k.com);
    }
    (kinetic, potential)
}

/// Moves and spins the whole body rigidly so that its momentum is `target` and its centre of mass is at `com_target`
/// (world frame, m).
///
/// A semi-implicit step in generalised coordinates reads the new joint velocities at the new configuration, where they
/// no longer carry the momentum that the forces gave. Both errors are of second order in the step; without the
/// correction a tucking skater gains or loses turns. With it, momentum changes by the listed forces to rounding.
/// `kinematics` must hold the new positions and the uncorrected velocities; the velocities have to be updated again.
/// Returns the mass distribution at the new configuration.
#[inline]
pub fn correct_root<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    mass: R,
    target: &Momentum<R>,
    com_target: Vec3<R>,
    state: &mut State<R>,
) -> Totals<R> {
    let body = totals(constants, kinematics, mass);
    let now = momentum(constants, kinematics, body.com);
    let spin = body.inertia.inverse().mul_vec(target.angular - now.angular);
    let push = (target.linear - now.linear) * mass.recip();
    state.root_velocity += Motion { angular: spin, linear: push - spin.cross(body.com) };
    state.root_position = com_target - body.com;
    body
}
