//! Velocities of points and their derivatives by the generalised velocity.

use crate::dynamics::generalized::joint_axes;
use crate::dynamics::{LinkConstants, LinkKinematics};
use crate::math::{Real, Vec3};
use glam::DVec3;

/// Velocity of the point at `position` (link frame, m) of link `link`, world axes, m/s.
pub fn point_velocity<R: Real>(kinematics: &[LinkKinematics<R>], link: usize, position: Vec3<R>) -> Vec3<R> {
    let k = &kinematics[link];
    k.velocity.at(k.rotation.mul_vec(position))
}

/// The Jacobian J of that velocity: one column (world axes) for each degree of freedom, in the order of the module's
/// conventions, written to `columns` ([`degrees_of_freedom`](crate::dynamics::degrees_of_freedom) entries; further ones stay).
/// Nothing is allocated.
pub fn point_jacobian<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    link: usize,
    position: Vec3<R>,
    columns: &mut [Vec3<R>],
) {
    let point = kinematics[link].origin + kinematics[link].rotation.mul_vec(position);
    let mut columns = columns.iter_mut();
    let mut write = |column: Vec3<R>| {
        if let Some(place) = columns.next() {
            *place = column;
        }
    };
    [DVec3::X, DVec3::Y, DVec3::Z].into_iter().for_each(|axis| write(Vec3::splat(axis)));
    for (i, c) in constants.iter().enumerate() {
        let moves = is_above(constants, i, link);
        let k = &kinematics[i];
        let (axes, count) = joint_axes(c);
        for axis in &axes[..count] {
            write(if moves { k.rotation.mul_vec(*axis).cross(point - k.origin) } else { Vec3::zero() });
        }
    }
}

/// The rate of the Jacobian times the generalised velocity: the acceleration (world axes, m/s^2) that the point at `position` (link
/// frame, m) of link `link` has while no generalised velocity changes. With `a` the generalised acceleration the point's own is
/// `J a` and this.
///
/// Summed from the link up to the root (Featherstone 2008, Section 2.10, written with classical accelerations):
///
/// ```text
/// J' v = w x (w x r) + sum over links k above and including it of  w_p x (w_p x d_k) + (w_p x u_k) x (p - o_k)
/// ```
///
/// r from the link's origin to the point p; o_k the origin of link k, d_k from its parent's; w and w_p angular velocities of the link
/// and of k's parent, u_k that of k against its parent.
pub fn point_jacobian_rate<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    link: usize,
    position: Vec3<R>,
) -> Vec3<R> {
    let k = &kinematics[link];
    let arm = k.rotation.mul_vec(position);
    let point = k.origin + arm;
    let omega = k.velocity.angular;
    let mut rate = omega.cross(omega.cross(arm));
    let mut at = link;
    while at != 0 {
        let (k, parent) = (&kinematics[at], constants[at].parent);
        let omega = kinematics[parent].velocity.angular;
        rate += omega.cross(omega.cross(k.from_parent)) + omega.cross(k.joint_velocity).cross(point - k.origin);
        at = parent;
    }
    rate
}

/// True if link `i` is `link` or carries it.
fn is_above<R>(constants: &[LinkConstants<R>], i: usize, link: usize) -> bool {
    // A parent comes before its children.
    let mut at = link;
    while at > i {
        at = constants[at].parent;
    }
    at == i
}
