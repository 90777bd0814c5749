//! Velocities of points and their derivatives by the generalised velocity.

use crate::dynamics::{LinkConstants, LinkKinematics};
use crate::math::{Real, Vec3};
use glam::DVec3;

/// Velocity of the point at `position` (link frame, m) of link `link`, world axes, m/s.
pub fn point_velocity<R: Real>(kinematics: &[LinkKinematics<R>], link: usize, position: Vec3<R>) -> Vec3<R> {
    let k = &kinematics[link];
    k.velocity.at(k.rotation.mul_vec(position))
}

/// The Jacobian of that velocity, lane 0: one column (world axes) for each degree of freedom, in the order of the
/// module's conventions.
pub fn point_jacobian<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    link: usize,
    position: Vec3<R>,
) -> Vec<DVec3> {
    let point = kinematics[link].origin + kinematics[link].rotation.mul_vec(position);
    let mut on_path = vec![false; constants.len()];
    let mut at = link;
    loop {
        on_path[at] = true;
        if at == 0 {
            break;
        }
        at = constants[at].parent;
    }
    let mut columns = vec![DVec3::X, DVec3::Y, DVec3::Z];
    for (i, c) in constants.iter().enumerate() {
        let arm = (point - kinematics[i].origin).lane(0);
        let r = kinematics[i].rotation.lane(0);
        let axes: Vec<DVec3> = match c.hinge {
            Some(axis) => vec![axis.lane(0)],
            None => vec![DVec3::X, DVec3::Y, DVec3::Z],
        };
        columns.extend(axes.into_iter().map(|a| if on_path[i] { (r * a).cross(arm) } else { DVec3::ZERO }));
    }
    columns
}
