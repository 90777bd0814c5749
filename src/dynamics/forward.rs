//! Accelerations from root to leaves, and the integration of one step.

use crate::dynamics::{ArticulatedLink, JointState, LinkConstants, LinkKinematics, State};
use crate::math::{Mobility, Motion, Quat, Real, Vec3};

/// Accelerations of every link: angular and of the link origin, world axes, in a freely falling frame and counted from
/// the coasting body (see [`articulated_inertias`](crate::dynamics::articulated_inertias)); and of every joint (child
/// axes), written to `joint_accelerations`. Returns the acceleration of the root, gravity included.
///
/// `gravity` is the acceleration of free fall, world axes, m/s^2.
#[inline]
pub fn forward_accelerations<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    articulated: &[ArticulatedLink<R>],
    root_mobility: &Mobility<R>,
    gravity: Vec3<R>,
    accelerations: &mut [Motion<R>],
    joint_accelerations: &mut [Vec3<R>],
) -> Motion<R> {
    // The root of the coasting body falls freely, so gravity needs no force.
    let root = -root_mobility.mul_force(&articulated[0].bias);
    accelerations[0] = root;
    for at in 1..constants.len() {
        let i = constants[at].breadth_first;
        let k = &kinematics[i];
        let (acceleration, relative) = articulated[i].accelerate(k.from_parent, &accelerations[constants[i].parent]);
        accelerations[i] = acceleration;
        joint_accelerations[i] = k.rotation.tr_mul_vec(relative);
    }
    Motion { angular: root.angular, linear: root.linear + gravity }
}

/// Semi-implicit Euler: new velocities, then new positions with them. `h` in seconds.
#[inline]
pub fn integrate<R: Real>(root_acceleration: &Motion<R>, joint_accelerations: &[Vec3<R>], h: R, state: &mut State<R>) {
    state.root_velocity = root_acceleration.mul_add(h, &state.root_velocity);
    state.root_position = state.root_velocity.linear.mul_add(h, state.root_position);
    let turn = Quat::from_small_rotation_vector(state.root_velocity.angular * h);
    state.root_rotation = (turn * state.root_rotation).renormalized();
    for (joint, a) in state.joints.iter_mut().zip(joint_accelerations).skip(1) {
        let velocity = a.mul_add(h, joint.velocity);
        let turn = Quat::from_small_rotation_vector(velocity * h);
        *joint = JointState { rotation: (joint.rotation * turn).renormalized(), velocity };
    }
}

/// Contact-free forward dynamics with given joint torques (child axes, N m): for comparison and tests. Returns the
/// root's acceleration (angular, linear; world axes) and the joints' (child axes).
pub fn contact_free_accelerations<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    torques: &[Vec3<R>],
    gravity: Vec3<R>,
) -> (Motion<R>, Vec<Vec3<R>>) {
    let servos: Vec<_> = torques
        .iter()
        .map(|t| crate::dynamics::ServoOutput { torque: *t, implicit: R::zero(), beyond: None })
        .collect();
    let mut articulated = vec![ArticulatedLink::default(); constants.len()];
    let mobility = crate::dynamics::articulated_inertias(constants, kinematics, &servos, &[], &mut articulated);
    let mut accelerations = vec![Motion::zero(); constants.len()];
    let mut joints = vec![Vec3::zero(); constants.len()];
    let root =
        forward_accelerations(constants, kinematics, &articulated, &mobility, gravity, &mut accelerations, &mut joints);
    (root, joints)
}
