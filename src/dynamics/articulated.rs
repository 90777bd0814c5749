//! The articulated-body recursion, leaves to root, with implicit servo terms.
//!
//! Featherstone 2008, "Rigid Body Dynamics Algorithms", Section 7.3, written with world axes, each link's joint as
//! reference point, and classical accelerations. All accelerations are counted from those of the **coasting** body: the
//! root falls freely and no joint rate changes. So the velocity products enter once, as the rigid wrench that each link
//! needs to coast, and the recursion itself is that of a body at rest.
//!
//! For link i, with J, H, M the blocks of its articulated inertia, (n, f) its articulated bias, tau the explicit joint
//! torque, e the implicit gain and the joint's armature (both act against the joint's own acceleration), and (alpha, a) the acceleration of the parent that arrives at the joint:
//!
//! ```text
//! joint mobility          Phi = D^-1, D = J + e 1  (ball);   Phi = s s^T / D, D = s^T J s + e, s the axis  (hinge)
//! what arrives            K = Phi H,  E = 1 - Phi J          (for a ball E = e Phi)
//! link acceleration       alpha_i = w + E alpha - K a,  w = Phi (tau - n)
//! passed to the parent    Ja = e 1 - e^2 Phi,  Ha = e K,  Ma = M - H^T K,  na = tau - e w,  fa = f + K^T (tau - n)   (ball)
//!                         Ja = J - J Phi J,    Ha = E^T H, Ma = M - H^T K, na = n + J w,   fa = f + H^T w            (hinge)
//! ```
//!
//! A joint with neither (e = 0) passes on a force only.
//!
//! A ball joint beyond its range has other gains about some axes: `e 1 + L` takes the place of `e 1`, L symmetric. Then
//!
//! ```text
//! D = J + e 1 + L,  E = e Phi + Phi L,  Ja = e 1 - e^2 Phi + L - e (Phi L + L Phi) - L Phi L,  Ha = e K + L K,  na = tau - e w - L w
//! ```
//!
//! L is zero in lanes that are within their range, and every term with it is added to what stands there without, so their bits
//! do not depend on their neighbours'.

use crate::dynamics::{LinkConstants, LinkKinematics, ServoOutput};
use crate::math::{Force, Inertia, Mat3, Mobility, Motion, Real, Sym3, Vec3};

/// E: the part of the parent's angular acceleration that a joint passes on.
#[derive(Clone, Copy, Debug)]
pub enum Transmission<R> {
    /// Ball joint with this implicit gain e: `E = e Phi`.
    Ball(R),
    /// Ball joint that is beyond its range in some lane, with the gains e and L (world axes): `E = e Phi + Phi L`.
    Beyond(R, Sym3<R>),
    /// Hinge: any matrix.
    Hinge(Mat3<R>),
}

/// What the recursion leaves at each link.
#[derive(Clone, Copy, Debug)]
pub struct ArticulatedLink<R> {
    /// What the children pass on, about the link origin; work space of the recursion (the root's is complete).
    inertia: Inertia<R>,
    /// Articulated bias wrench about the link origin.
    pub bias: Force<R>,
    /// Acceleration of the coasting body at the link origin, in a freely falling frame.
    pub coasting: Motion<R>,
    /// Phi: mobility of the joint.
    pub joint_mobility: Sym3<R>,
    /// K: what an arriving linear acceleration takes from the link's angular acceleration, 1/m.
    pub k: Mat3<R>,
    /// E.
    pub transmission: Transmission<R>,
    /// w: the link's angular acceleration if nothing arrives, rad/s^2, world axes.
    pub drive: Vec3<R>,
}

impl<R: Real> Default for ArticulatedLink<R> {
    fn default() -> Self {
        Self {
            inertia: Inertia::default(),
            bias: Force::default(),
            coasting: Motion::default(),
            joint_mobility: Sym3::default(),
            k: Mat3::default(),
            transmission: Transmission::Ball(R::zero()),
            drive: Vec3::default(),
        }
    }
}

impl<R: Real> ArticulatedLink<R> {
    /// `E v + c`.
    #[inline(always)]
    fn transmit(&self, v: Vec3<R>, c: Vec3<R>) -> Vec3<R> {
        match &self.transmission {
            Transmission::Ball(e) => self.joint_mobility.mul_vec_add(v * *e, c),
            Transmission::Beyond(e, l) => self.joint_mobility.mul_vec_add(v * *e + l.mul_vec(v), c),
            Transmission::Hinge(m) => m.mul_vec_add(v, c),
        }
    }
    /// E as a matrix.
    #[inline(always)]
    pub fn transmission_matrix(&self) -> Mat3<R> {
        match &self.transmission {
            Transmission::Ball(e) => self.joint_mobility.scale(*e).to_mat3(),
            Transmission::Beyond(e, l) => {
                self.joint_mobility.scale(*e).to_mat3() + self.joint_mobility.mul_mat(&l.to_mat3())
            }
            Transmission::Hinge(m) => *m,
        }
    }
    /// [`ArticulatedLink::pass_down`] as a matrix.
    #[inline(always)]
    pub fn pass_down_matrix(&self, from_parent: Vec3<R>) -> Mobility<R> {
        // The parent's motion arrives as (omega, v - d x omega).
        let shift = Mat3::skew(-from_parent);
        Mobility {
            aa: self.transmission_matrix().add_mul_skew(&self.k, from_parent),
            al: Mat3::zero() - self.k,
            la: shift,
            ll: Mat3::identity(),
        }
    }
    /// The wrench that reaches the parent's origin from a wrench on this link (its transpose carries motion down).
    #[inline(always)]
    pub fn pass_up(&self, from_parent: Vec3<R>, w: &Force<R>) -> Force<R> {
        let force = w.force - self.k.tr_mul_vec(w.moment);
        let arm = from_parent.cross(force);
        let moment = match &self.transmission {
            Transmission::Ball(e) => self.joint_mobility.mul_vec_add(w.moment * *e, arm),
            Transmission::Beyond(e, l) => {
                self.joint_mobility.mul_vec_add(w.moment * *e, arm) + l.mul_vec(self.joint_mobility.mul_vec(w.moment))
            }
            Transmission::Hinge(m) => m.tr_mul_vec_add(w.moment, arm),
        };
        Force { moment, force }
    }
    /// The acceleration of this link from its parent's, and the angular acceleration that the joint adds; world axes,
    /// both counted from the coasting body.
    #[inline(always)]
    pub fn accelerate(&self, from_parent: Vec3<R>, parent: &Motion<R>) -> (Motion<R>, Vec3<R>) {
        let linear = parent.at(from_parent);
        let angular = self.transmit(parent.angular, self.k.mul_vec_sub_from(linear, self.drive));
        (Motion { angular, linear }, angular - parent.angular)
    }
    /// The motion of this link that a motion of its parent brings.
    #[inline(always)]
    pub fn pass_down(&self, from_parent: Vec3<R>, m: &Motion<R>) -> Motion<R> {
        let linear = m.at(from_parent);
        Motion { angular: self.transmit(m.angular, -self.k.mul_vec(linear)), linear }
    }
    /// The inertia of a rigid link about its origin, and what its children passed on.
    #[inline(always)]
    fn total_inertia(&self, c: &LinkConstants<R>, k: &LinkKinematics<R>) -> Inertia<R> {
        let first_moment = k.com * c.mass;
        let angular = k.inertia_com.add_parallel_axis(c.mass, k.com);
        if c.is_leaf {
            return Inertia { angular, coupling: Mat3::skew(first_moment), linear: Sym3::diagonal(c.mass) };
        }
        Inertia {
            angular: self.inertia.angular + angular,
            coupling: self.inertia.coupling.add_skew(first_moment),
            linear: self.inertia.linear.add_diagonal(c.mass),
        }
    }
}

/// The wrench that each link needs to coast, less the wrenches on it from outside.
#[inline]
fn coasting_wrenches<R: Real>(
    constants: &[LinkConstants<R>],
    kinematics: &[LinkKinematics<R>],
    external: &[Force<R>],
    links: &mut [ArticulatedLink<R>],
) {
    for at in 0..constants.len() {
        let i = constants[at].breadth_first;
        let (c, k) = (&constants[i], &kinematics[i]);
        let coasting = if i == 0 {
            Motion::zero()
        } else {
            let parent = links[c.parent].coasting;
            let omega = kinematics[c.parent].velocity.angular;
            Motion {
                angular: omega.cross_add(k.joint_velocity, parent.angular),
                linear: omega.cross_add(omega.cross(k.from_parent), parent.at(k.from_parent)),
            }
        };
        let omega = k.velocity.angular;
        let force = omega.cross_add(omega.cross(k.com), coasting.at(k.com)) * c.mass;
        let moment = omega
            .cross_add(k.inertia_com.mul_vec(omega), k.com.cross_add(force, k.inertia_com.mul_vec(coasting.angular)));
        let bias = Force { moment, force };
        let link = &mut links[i];
        link.coasting = coasting;
        link.bias = if external.is_empty() { bias } else { bias - external[i] };
    }
}

/// Articulated inertias and biases of all links; returns the inverse of the root's, the mobility of the whole body at
/// the root.
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
    coasting_wrenches(constants, kinematics, external, links);
    for at in (1..constants.len()).rev() {
        let i = constants[at].breadth_first;
        let (c, k, servo) = (&constants[i], &kinematics[i], &servos[i]);
        let (before, rest) = links.split_at_mut(i);
        let (parent, link) = (&mut before[c.parent], &mut rest[0]);

        // What the joint lets through.
        let Inertia { angular: j, coupling: h, linear: m } = link.total_inertia(c, k);
        let tau = k.rotation.mul_vec(servo.torque);
        let u = tau - link.bias.moment;
        let e = servo.implicit + c.armature;
        let (ja, ha, na);
        if let Some(axis) = c.hinge {
            let s = k.rotation.mul_vec(axis);
            let js = j.mul_vec(s);
            let si = s * (s.dot(js) + e).recip();
            link.joint_mobility = Sym3::outer(si, s);
            link.k = Mat3::outer(si, h.tr_mul_vec(s));
            let transmission = Mat3::identity() - Mat3::outer(si, js);
            link.transmission = Transmission::Hinge(transmission);
            link.drive = si * s.dot(u);
            ja = j.sub_outer(js, js * (s.dot(js) + e).recip());
            ha = transmission.transpose().mul_mat(&h);
            na = j.mul_vec_add(link.drive, link.bias.moment);
        } else if let Some(gains) = servo.beyond {
            let l = Sym3::rotated_diagonal(gains, &k.rotation);
            let phi = (j.add_diagonal(e) + l).inverse();
            link.joint_mobility = phi;
            link.k = phi.mul_mat(&h);
            link.transmission = Transmission::Beyond(e, l);
            link.drive = phi.mul_vec(u);
            let phi_l = phi.mul_mat(&l.to_mat3());
            let both = Sym3::sum_with_transpose(&phi_l).scale(e) + Sym3::product_upper(&l.to_mat3(), &phi_l);
            ja = phi.scale(-(e * e)).add_diagonal(e) + (l - both);
            ha = link.k.scale(e) + l.mul_mat(&link.k);
            na = link.drive.neg_mul_add(e, tau) - l.mul_vec(link.drive);
        } else {
            let phi = j.add_diagonal(e).inverse();
            link.joint_mobility = phi;
            link.k = phi.mul_mat(&h);
            link.transmission = Transmission::Ball(e);
            link.drive = phi.mul_vec(u);
            ja = phi.scale(-(e * e)).add_diagonal(e);
            ha = link.k.scale(e);
            na = link.drive.neg_mul_add(e, tau);
        }
        // K^T u = H^T Phi u for both kinds.
        let ma = m.sub_tr_product(&h, &link.k);
        let fa = h.tr_mul_vec_add(link.drive, link.bias.force);

        // The shift to the parent's origin, d away. With a = a_parent - d x alpha:
        // H' = Ha + [d] Ma,  J' = Ja - Ha [d] + [d] H'^T.
        let d = k.from_parent;
        let coupling = ha.add_cross_columns(d, &ma);
        let angular = ja.add_skew_products(d, &ha, &coupling);
        parent.bias.moment += d.cross_add(fa, na);
        parent.bias.force += fa;
        // The first child to arrive, which is the last in order, finds nothing there yet.
        let passed = Inertia { angular, coupling, linear: ma };
        parent.inertia = if c.arrives_first { passed } else { parent.inertia + passed };
    }
    links[0].total_inertia(&constants[0], &kinematics[0]).inverse()
}
