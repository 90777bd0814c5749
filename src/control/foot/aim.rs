//! The smallest rotation that brings a vector's end to a height.
//!
//! Park, Yu, Lee 2018, equations 1 and 2, for any plane: the vector `v` from the pivot turns in the plane that it spans with the
//! normal `n`, about `n x v`, until `n . v` is the wanted height. Both the angle before (their phi_b) and after (phi_a) lie in that
//! plane, so the turned vector is written down without an angle:
//!
//! ```text
//! v' = c n + sqrt(|v|^2 - c^2) e,     e = (v - (v . n) n) / |v - (v . n) n|
//! ```
//!
//! `c` is the argument of their arccosine times `|v|`; out of its range it is clamped, and what is missing is told.

use glam::{DQuat, DVec3};

/// What [`least`] found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    /// The rotation, world axes.
    pub rotation: DQuat,
    /// How much farther along the normal the end would have to go, m; zero where the height is within reach.
    pub missing: f64,
    /// The vector was parallel to the normal, so the axis is not determined: the one given instead was taken.
    pub parallel: bool,
}

/// Sine of the angle between two directions below which they count as parallel.
const PARALLEL: f64 = 1e-6;

/// The smallest rotation that turns `v` so that `n . v` is `height`; `forward` (unit, perpendicular to `n`) is the way to turn where
/// `v` is parallel to `n`.
pub(super) fn least(v: DVec3, n: DVec3, height: f64, forward: DVec3) -> Aim {
    let length = v.length();
    let reachable = height.clamp(-length, length);
    let missing = height - reachable;
    let flat = v - n * v.dot(n);
    let across = flat.length();
    let parallel = across <= PARALLEL * length;
    let way = if parallel { forward } else { flat / across };
    let turned = n * reachable + way * (length * length - reachable * reachable).max(0.0).sqrt();
    Aim { rotation: arc(v, turned), missing, parallel }
}

/// The smallest rotation from one direction to another (their equation 5); no rotation where either has no length. Half a turn goes
/// about any axis across.
pub(super) fn arc(from: DVec3, to: DVec3) -> DQuat {
    let (Some(a), Some(b)) = (from.try_normalize(), to.try_normalize()) else { return DQuat::IDENTITY };
    let w = 1.0 + a.dot(b);
    if w < 1e-12 {
        let axis = a.any_orthonormal_vector();
        return DQuat::from_xyzw(axis.x, axis.y, axis.z, 0.0);
    }
    let v = a.cross(b);
    DQuat::from_xyzw(v.x, v.y, v.z, w).normalize()
}

/// The rotation that takes `up` to `n` and `along` to `t`; each pair perpendicular unit vectors. It is the product of their equation
/// 4, R(s, t) R(n_s, n), which no other rotation equals in both directions.
pub(super) fn frame(up: DVec3, along: DVec3, n: DVec3, t: DVec3) -> DQuat {
    let axes = |y: DVec3, z: DVec3| DQuat::from_mat3(&glam::DMat3::from_cols(y.cross(z), y, z));
    (axes(n, t) * axes(up, along).conjugate()).normalize()
}

/// A unit vector along the part of `v` that is perpendicular to the unit vector `n`; `None` where there is none.
pub(super) fn level(v: DVec3, n: DVec3) -> Option<DVec3> {
    let flat = v - n * v.dot(n);
    (flat.length() > PARALLEL * v.length()).then(|| flat.normalize())
}
