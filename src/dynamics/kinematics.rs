//! Forward kinematics: where every link is and how it moves.

use crate::dynamics::{LinkConstants, State};
use crate::math::{Mat3, Motion, Real, Sym3, Vec3};

/// Position and velocity of a link, world axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinkKinematics<R> {
    /// Link axes to world axes.
    pub rotation: Mat3<R>,
    /// Link origin relative to the root's origin, m.
    pub origin: Vec3<R>,
    /// Link origin relative to the parent's origin, m.
    pub from_parent: Vec3<R>,
    /// Centre of mass relative to the link origin, m.
    pub com: Vec3<R>,
    /// Rotational inertia about the centre of mass, kg m^2.
    pub inertia_com: Sym3<R>,
    /// Angular velocity of the link against its parent, rad/s.
    pub joint_velocity: Vec3<R>,
    /// Twist at the link origin, rad/s and m/s.
    pub velocity: Motion<R>,
}

/// Positions: rotations, origins, centres of mass and inertias of every link.
#[inline]
pub fn update_positions<R: Real>(constants: &[LinkConstants<R>], state: &State<R>, links: &mut [LinkKinematics<R>]) {
    for at in 0..constants.len() {
        let i = constants[at].breadth_first;
        let c = &constants[i];
        let (rotation, origin, from_parent) = if i == 0 {
            (state.root_rotation.to_mat3(), Vec3::zero(), Vec3::zero())
        } else {
            let parent = &links[c.parent];
            let d = parent.rotation.mul_vec(c.offset);
            (parent.rotation.mul_mat(&state.joints[i].rotation.to_mat3()), parent.origin + d, d)
        };
        let link = &mut links[i];
        link.rotation = rotation;
        link.origin = origin;
        link.from_parent = from_parent;
        link.com = rotation.mul_vec(c.com);
        link.inertia_com = c.inertia.in_world(&rotation);
    }
}

/// Velocities: joint velocities in world axes and the twist of every link, at positions that are up to date.
#[inline]
pub fn update_velocities<R: Real>(constants: &[LinkConstants<R>], state: &State<R>, links: &mut [LinkKinematics<R>]) {
    for (link, joint) in links.iter_mut().zip(&state.joints).skip(1) {
        link.joint_velocity = link.rotation.mul_vec(joint.velocity);
    }
    update_twists(constants, state.root_velocity, links);
}

/// Twist of every link from the root's twist and joint velocities that are up to date.
#[inline]
pub fn update_twists<R: Real>(constants: &[LinkConstants<R>], root: Motion<R>, links: &mut [LinkKinematics<R>]) {
    links[0].velocity = root;
    for i in 1..constants.len() {
        let parent = links[constants[i].parent].velocity;
        let link = &mut links[i];
        link.velocity = Motion { angular: parent.angular + link.joint_velocity, linear: parent.at(link.from_parent) };
    }
}
