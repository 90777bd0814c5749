//! The articulated-body recursion, leaves to root, with implicit servo terms.
//!
//! Featherstone 2008, "Rigid Body Dynamics Algorithms", Section 7.3, written with world axes, each link's joint as
//! reference point, and classical accelerations. For link i, with J, H, M the blocks of its articulated inertia, (n, f)
//! its articulated bias, tau the explicit joint torque, e the implicit gain, and (alpha, a) the acceleration of the
//! parent that arrives at the joint:
//!
//! ```text
//! ball:   D = J + e 1,  K = D^-1 H,  E = e D^-1
//! hinge:  s the axis, U = J s, V = H^T s, D = s.U + e,  K = s V^T / D,  E = 1 - s U^T / D
//! link acceleration       alpha_i = D^-1 (tau - n) + E alpha - K a
//! passed to the parent    Ja = e 1 - e^2 D^-1, Ha = e K, Ma = M - H^T K               (ball)
//!                         Ja = J - U U^T/D, Ha = H - U V^T/D, Ma = M - V V^T/D        (hinge)
//!                         na = tau - E^T (tau - n) [ball], n + U u/D [hinge],  fa = f + K^T (tau - n)
//! ```
//!
//! A joint without gains (e = 0) passes on a force only.

use crate::dynamics::{LinkConstants, LinkKinematics, ServoOutput};
use crate::math::{Force, Inertia, Mat3, Mobility, Motion, Real, Sym3, Vec3};

/// What the recursion leaves at each link.
#[derive(Clone, Copy, Debug, Default)]
pub struct ArticulatedLink<R> {
    /// Articulated inertia about the link origin.
    pub inertia: Inertia<R>,
    /// Articulated bias wrench about the link origin.
    pub bias: Force<R>,
    /// Mobility of the joint: D^-1 (ball), s s^T / D (hinge).
    pub joint_mobility: Sym3<R>,
    /// K: what an arriving linear acceleration takes from the link's angular acceleration, 1/m.
    pub k: Mat3<R>,
    /// E: the part of the parent's angular acceleration that the joint passes on.
    pub e: Mat3<R>,
    /// tau - n: joint torque less the moment of the articulated bias, N m, world axes.
    pub drive: Vec3<R>,
    /// Velocity-product acceleration across the joint: angular part, and linear part at the joint.
    pub drift: Motion<R>,
}

impl<R: Real> ArticulatedLink<R> {
    /// The wrench that reaches the parent's origin from a wrench on this link (its transpose carries motion down).
    #[inline(always)]
    pub fn pass_up(&self, from_parent: Vec3<R>, w: &Force<R>) -> Force<R> {
        let force = w.force - self.k.tr_mul_vec(w.moment);
        Force { moment: self.e.tr_mul_vec(w.moment) + from_parent.cross(force), force }
    }
    /// The acceleration of this link (in a freely falling frame) from its parent's, and the angular acceleration that
    /// the joint adds; world axes.
    #[inline(always)]
    pub fn accelerate(&self, from_parent: Vec3<R>, parent: &Motion<R>) -> (Motion<R>, Vec3<R>) {
        let arriving =
            Motion { angular: parent.angular + self.drift.angular, linear: parent.at(from_parent) + self.drift.linear };
        let angular = self.joint_mobility.mul_vec(self.drive) + self.e.mul_vec(arriving.angular)
            - self.k.mul_vec(arriving.linear);
        (Motion { angular, linear: arriving.linear }, angular - arriving.angular)
    }
    /// The motion of this link that a motion of its parent brings.
    #[inline(always)]
    pub fn pass_down(&self, from_parent: Vec3<R>, m: &Motion<R>) -> Motion<R> {
        let linear = m.at(from_parent);
        Motion { angular: self.e.mul_vec(m.angular) - self.k.mul_vec(linear), linear }
    }
}

/// Articulated inertias and biases of all links; returns the inverse of the root's, the mobility of the whole body at the root.
///
/// `servos` are in child axes; `external` holds wrenches on links about their origins (world axes), or is empty.
#[inline]
pub fn articulated_inertias<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    servos: &[ServoOutput<R>],
    external: &[Force<R>],
    links: &mut [ArticulatedLink<R>],
) -> Mobility<R> {
    // Rigid-body terms: inertia about the joint, gyroscopic and centrifugal bias.
    for (i, (c, k)) in constants.iter().zip(kinematics).enumerate() {
        let first_moment = k.com * c.mass;
        let angular = k.inertia_com + Sym3::parallel_axis(c.mass, k.com);
        let omega = k.velocity.angular;
        let link = &mut links[i];
        link.bias =
            Force { moment: omega.cross(angular.mul_vec(omega)), force: omega.cross(omega.cross(first_moment)) };
        if !external.is_empty() {
            link.bias = link.bias - external[i];
        }
        link.inertia = Inertia { angular, coupling: Mat3::skew(first_moment), linear: Sym3::diagonal(c.mass) };
    }

    for i in (1..constants.len()).rev() {
        let c = &constants[i];
        let k = &kinematics[i];
        let servo = &servos[i];
        let d = k.from_parent;
        let parent_omega = kinematics[c.parent].velocity.angular;
        let drift =
            Motion { angular: parent_omega.cross(k.joint_velocity), linear: parent_omega.cross(parent_omega.cross(d)) };

        // What the joint lets through.
        let link = &mut links[i];
        let Inertia { angular: j, coupling: h, linear: m } = link.inertia;
        let tau = k.rotation.mul_vec(servo.torque);
        let u = tau - link.bias.moment;
        let e = servo.implicit;
        let (ja, ha, ma, na, fa);
        if let Some(axis) = c.hinge {
            let s = k.rotation.mul_vec(axis);
            let (ju, hu) = (j.mul_vec(s), h.tr_mul_vec(s));
            let inverse = (s.dot(ju) + e).recip();
            let si = s * inverse;
            link.joint_mobility =
                Sym3 { xx: si.x * s.x, yy: si.y * s.y, zz: si.z * s.z, xy: si.x * s.y, xz: si.x * s.z, yz: si.y * s.z };
            link.k = Mat3::from_columns(si * hu.x, si * hu.y, si * hu.z);
            link.e = Mat3::identity() - Mat3::from_columns(si * ju.x, si * ju.y, si * ju.z);
            let (jui, hui) = (ju * inverse, hu * inverse);
            let outer = |a: Vec3<R>, b: Vec3<R>| Mat3::from_columns(a * b.x, a * b.y, a * b.z);
            ja = j - Sym3::from_upper(&outer(jui, ju));
            ha = h - outer(jui, hu);
            ma = m - Sym3::from_upper(&outer(hui, hu));
            let su = s.dot(u);
            na = link.bias.moment + jui * su;
            fa = link.bias.force + hui * su;
        } else {
            let inverse = j.add_diagonal(e).inverse();
            link.joint_mobility = inverse;
            link.k = inverse.mul_mat(&h);
            let scaled = inverse * e;
            link.e = scaled.to_mat3();
            ja = Sym3::diagonal(e) - scaled * e;
            ha = link.k.scale(e);
            ma = m - Sym3::tr_product_upper(&h, &link.k);
            na = tau - scaled.mul_vec(u);
            fa = link.bias.force + link.k.tr_mul_vec(u);
        }
        link.drive = u;
        link.drift = drift;

        // Velocity-product terms, then the shift to the parent's origin.
        let na = na + ja.mul_vec(drift.angular) + ha.mul_vec(drift.linear);
        let fa = fa + ha.tr_mul_vec(drift.angular) + ma.mul_vec(drift.linear);
        let shifted = Force { moment: na + d.cross(fa), force: fa };
        // With a = a_parent - d x alpha:  H' = Ha + [d] Ma,  J' = Ja - Ha [d] + [d] H'^T.
        let coupling = ha + Mat3::cross_columns(d, &ma.to_mat3());
        let minus_ha_d = Mat3::from_columns(ha.z * d.y - ha.y * d.z, ha.x * d.z - ha.z * d.x, ha.y * d.x - ha.x * d.y);
        let d_ht = Mat3::cross_columns(d, &coupling.transpose());
        let angular = ja + Sym3::from_upper(&minus_ha_d) + Sym3::from_upper(&d_ht);

        let parent = &mut links[c.parent];
        parent.inertia.angular += angular;
        parent.inertia.coupling = parent.inertia.coupling + coupling;
        parent.inertia.linear += ma;
        parent.bias += shifted;
    }
    links[0].inertia.inverse()
}
