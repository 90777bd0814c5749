//! Inverse dynamics: the recursive Newton-Euler algorithm.

use crate::dynamics::{LinkConstants, LinkKinematics};
use crate::math::{Force, Motion, Real, Sym3, Vec3};

/// Work space of [`inverse_dynamics_into`]: one entry for each link.
#[derive(Clone, Debug)]
pub struct InverseDynamics<R> {
    accelerations: Vec<Motion<R>>,
    wrenches: Vec<Force<R>>,
    torques: Vec<Vec3<R>>,
}

impl<R: Real> InverseDynamics<R> {
    /// Room for a character of so many links.
    pub fn new(links: usize) -> Self {
        Self {
            accelerations: vec![Motion::zero(); links],
            wrenches: vec![Force::zero(); links],
            torques: vec![Vec3::zero(); links],
        }
    }
    /// The wrench that the root needs from outside (about its origin, world axes).
    pub fn root(&self) -> Force<R> {
        self.wrenches.first().copied().unwrap_or(Force::zero())
    }
    /// Joint torques, child axes, N m; along the axis for a hinge, entry 0 unused.
    pub fn torques(&self) -> &[Vec3<R>] {
        &self.torques
    }
    /// Acceleration of each link at its origin, world axes, in a freely falling frame.
    pub fn accelerations(&self) -> &[Motion<R>] {
        &self.accelerations
    }
}

/// The wrench on the root (about its origin, world axes) and the joint torques (child axes; along the axis for a
/// hinge, entry 0 unused) that give the root the acceleration `root` (world axes) and the joints the accelerations
/// `joints` (child axes) under `gravity`.
///
/// Luh, Walker, Paul 1980, in the form of Featherstone 2008, Section 5.3, with classical accelerations. Torques include what armatures
/// need; links feel nothing of those.
pub fn inverse_dynamics<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    root: Motion<R>,
    joints: &[Vec3<R>],
    gravity: Vec3<R>,
) -> (Force<R>, Vec<Vec3<R>>) {
    let mut work = InverseDynamics::new(constants.len());
    inverse_dynamics_into(constants, kinematics, root, joints, gravity, &[], &mut work);
    (work.root(), work.torques)
}

/// The same in the caller's room, under wrenches from outside: `external` holds one for each link, about its origin (world axes), or
/// is empty. Allocates nothing.
pub fn inverse_dynamics_into<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    root: Motion<R>,
    joints: &[Vec3<R>],
    gravity: Vec3<R>,
    external: &[Force<R>],
    work: &mut InverseDynamics<R>,
) {
    let n = constants.len();
    let InverseDynamics { accelerations, wrenches, torques } = work;
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
        if let Some(given) = external.get(i) {
            wrenches[i] = wrenches[i] - *given;
        }
    }
    for i in (1..n).rev() {
        let k = &kinematics[i];
        let local = joints[i].mul_add(constants[i].armature, k.rotation.tr_mul_vec(wrenches[i].moment));
        torques[i] = match constants[i].hinge {
            Some(axis) => axis * axis.dot(local),
            None => local,
        };
        let passed = wrenches[i].shifted(k.from_parent);
        wrenches[constants[i].parent] += passed;
    }
}
