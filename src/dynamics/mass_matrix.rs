//! The joint-space mass matrix: the composite-rigid-body algorithm.

use crate::dynamics::{LinkConstants, LinkKinematics};
use crate::math::{Force, Inertia, Mat3, Motion, Real, Sym3, Vec3};

/// The generalised mass matrix of one character (lane 0), row by row, in the order of the module's conventions: root
/// linear (world axes), root angular (root axes), joints in link order (child axes; one row for a hinge).
///
/// Featherstone 2008, Section 6.2; armatures add to the diagonal.
pub fn mass_matrix<R: Real>(constants: &[LinkConstants<R>], kinematics: &[LinkKinematics<R>]) -> Vec<Vec<f64>> {
    let n = constants.len();
    // Composite inertia of each subtree about the link's own origin.
    let mut composite: Vec<Inertia<R>> = constants
        .iter()
        .zip(kinematics)
        .map(|(c, k)| Inertia {
            angular: k.inertia_com + Sym3::parallel_axis(c.mass, k.com),
            coupling: Mat3::skew(k.com * c.mass),
            linear: Sym3::diagonal(c.mass),
        })
        .collect();
    for i in (1..n).rev() {
        let d = kinematics[i].from_parent;
        let Inertia { angular, coupling, linear } = composite[i];
        let shifted = coupling + Mat3::cross_columns(d, &linear.to_mat3());
        let minus = Mat3::zero() - coupling.mul_mat(&Mat3::skew(d));
        let rest = Mat3::cross_columns(d, &shifted.transpose());
        let parent = &mut composite[constants[i].parent];
        parent.angular += angular + Sym3::from_upper(&minus) + Sym3::from_upper(&rest);
        parent.coupling = parent.coupling + shifted;
        parent.linear += linear;
    }

    // The motion of each degree of freedom at its link's origin.
    let unit = |k: usize| {
        let mut v = Vec3::zero();
        match k {
            0 => v.x = R::one(),
            1 => v.y = R::one(),
            _ => v.z = R::one(),
        }
        v
    };
    let mut columns: Vec<(usize, Motion<R>)> = Vec::new();
    for (i, c) in constants.iter().enumerate() {
        if i == 0 {
            columns.extend((0..3).map(|k| (0, Motion { angular: Vec3::zero(), linear: unit(k) })));
        }
        let axes: Vec<Vec3<R>> = match c.hinge {
            Some(axis) => vec![axis],
            None => (0..3).map(unit).collect(),
        };
        for axis in axes {
            let angular = kinematics[i].rotation.mul_vec(axis);
            columns.push((i, Motion { angular, linear: Vec3::zero() }));
        }
    }
    let dot = |f: &Force<R>, m: &Motion<R>| (f.moment.dot(m.angular) + f.force.dot(m.linear)).lane(0);
    let mut matrix = vec![vec![0.0; columns.len()]; columns.len()];
    for (a, &(link, motion)) in columns.iter().enumerate() {
        let mut wrench = composite[link].mul_motion(&motion);
        let mut at = link;
        loop {
            for (b, (other, m)) in columns.iter().enumerate() {
                if *other == at && b <= a {
                    let value = dot(&wrench, m);
                    matrix[a][b] = value;
                    matrix[b][a] = value;
                }
            }
            if at == 0 {
                break;
            }
            wrench = wrench.shifted(kinematics[at].from_parent);
            at = constants[at].parent;
        }
        if link > 0 {
            matrix[a][a] += constants[link].armature.lane(0);
        }
    }
    matrix
}
