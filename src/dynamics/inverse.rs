//! Inverse dynamics: the recursive Newton-Euler algorithm.

use crate::dynamics::{LinkConstants, LinkKinematics};
use crate::math::{Force, Motion, Real, Sym3, Vec3};

/// The wrench on the root (about its origin, world axes) and the joint torques (child axes; along the axis for a
/// hinge, entry 0 unused) that give the root the acceleration `root` (world axes) and the joints the accelerations
/// `joints` (child axes) under `gravity`.
///
/// Luh, Walker, Paul 1980, in the form of Featherstone 2008, Section 5.3, with classical accelerations.
pub fn inverse_dynamics<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    root: Motion<R>,
    joints: &[Vec3<R>],
    gravity: Vec3<R>,
) -> (Force<R>, Vec<Vec3<R>>) {
    let n = constants.len();
    let mut accelerations = vec![Motion::zero(); n];
    let mut wrenches = vec![Force::zero(); n];
    accelerations[0] = Motion { angular: root.angular, linear: root.linear - gravity };
    for i in 0..n {
        let (c, k) = (&constants[i], &kinematics[i]);
        if i > 0 {
            let parent = accelerations[c.parent];
            let omega = kinematics[c.parent].velocity.angular;
            accelerations[i] = Motion {
                angular: parent.angular + omega.cross(k.joint_velocity) + k.rotation.mul_vec(joints[i]),
                linear: parent.at(k.from_parent) + omega.cross(omega.cross(k.from_parent)),
            };
        }
        let a = accelerations[i];
        let omega = k.velocity.angular;
        let first_moment = k.com * c.mass;
        let inertia = k.inertia_com + Sym3::parallel_axis(c.mass, k.com);
        wrenches[i] = Force {
            moment: inertia.mul_vec(a.angular) + first_moment.cross(a.linear) + omega.cross(inertia.mul_vec(omega)),
            force: a.linear * c.mass + a.angular.cross(first_moment) + omega.cross(omega.cross(first_moment)),
        };
    }
    let mut torques = vec![Vec3::zero(); n];
    for i in (1..n).rev() {
        let k = &kinematics[i];
        let local = k.rotation.tr_mul_vec(wrenches[i].moment);
        torques[i] = match constants[i].hinge {
            Some(axis) => axis * axis.dot(local),
            None => local,
        };
        let passed = wrenches[i].shifted(k.from_parent);
        wrenches[constants[i].parent] += passed;
    }
    (wrenches[0], torques)
}
