//! The generalised velocity as a row of numbers, in the order of the module's conventions: root linear (world axes), root
//! angular (root axes), then each joint in link order (child axes; one number for a hinge).

use crate::dynamics::{LinkConstants, LinkKinematics, State};
use crate::math::{Motion, Real, Vec3};
use glam::DVec3;

/// Number of degrees of freedom: entries of a generalised velocity.
pub fn degrees_of_freedom<R>(constants: &[LinkConstants<R>]) -> usize {
    3 + constants.iter().map(|c| if c.hinge.is_some() { 1 } else { 3 }).sum::<usize>()
}

/// The axes about which link `i` turns against its parent (of the root: against the world), in its own axes; of three the first one
/// of a hinge, which has no others.
#[inline]
pub(crate) fn joint_axes<R: Real>(constants: &LinkConstants<R>) -> ([Vec3<R>; 3], usize) {
    match constants.hinge {
        Some(axis) => ([axis; 3], 1),
        None => ([DVec3::X, DVec3::Y, DVec3::Z].map(Vec3::splat), 3),
    }
}

/// Writes the generalised velocity of a state, `degrees_of_freedom` entries (m/s and rad/s), to `out`; kinematics of that state.
pub fn generalized_velocity<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    state: &State<R>,
    out: &mut [R],
) {
    let Motion { angular, linear } = state.root_velocity;
    let mut out = out.iter_mut();
    let mut write = |value: R| {
        if let Some(place) = out.next() {
            *place = value;
        }
    };
    [linear.x, linear.y, linear.z].into_iter().for_each(&mut write);
    for (i, c) in constants.iter().enumerate() {
        let own = if i == 0 { kinematics[0].rotation.tr_mul_vec(angular) } else { state.joints[i].velocity };
        let (axes, count) = joint_axes(c);
        axes[..count].iter().for_each(|axis| write(axis.dot(own)));
    }
}
