//! Spatial vectors and matrices, angular part first, world-aligned axes.
//!
//! A reference point belongs to every quantity here; the names of fields say which. See Featherstone 2008, "Rigid Body
//! Dynamics Algorithms", chapter 2; this crate uses the classical linear acceleration of the reference point rather
//! than the spatial one.

use crate::math::{Mat3, Real, Sym3, Vec3};
use core::ops::{Add, AddAssign, Neg, Sub};

/// A twist (angular velocity, linear velocity of the reference point) or its derivative or an increment of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion<R> {
    /// Angular part, rad/s (or rad/s^2), world axes.
    pub angular: Vec3<R>,
    /// Linear part at the reference point, m/s (or m/s^2), world axes.
    pub linear: Vec3<R>,
}

/// A wrench (moment about the reference point, force) or an impulse of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Force<R> {
    /// Moment about the reference point, N m (or N m s), world axes.
    pub moment: Vec3<R>,
    /// Force, N (or N s), world axes.
    pub force: Vec3<R>,
}

impl<R: Real> Motion<R> {
    /// The zero motion.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { angular: Vec3::zero(), linear: Vec3::zero() }
    }
    /// Velocity of the point at `r` from the reference point.
    #[inline(always)]
    pub fn at(&self, r: Vec3<R>) -> Vec3<R> {
        self.angular.cross_add(r, self.linear)
    }
    /// `self * s + b`.
    #[inline(always)]
    pub fn mul_add(&self, s: R, b: &Self) -> Self {
        Self { angular: self.angular.mul_add(s, b.angular), linear: self.linear.mul_add(s, b.linear) }
    }
}

impl<R: Real> Force<R> {
    /// No wrench.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { moment: Vec3::zero(), force: Vec3::zero() }
    }
    /// The wrench of a force `f` that acts at `r` from the reference point.
    #[inline(always)]
    pub fn at(r: Vec3<R>, f: Vec3<R>) -> Self {
        Self { moment: r.cross(f), force: f }
    }
    /// The same wrench about a point from which the present reference point is at `d`.
    #[inline(always)]
    pub fn shifted(&self, d: Vec3<R>) -> Self {
        Self { moment: d.cross_add(self.force, self.moment), force: self.force }
    }
}

macro_rules! componentwise {
    ($name:ident, $a:ident, $b:ident) => {
        impl<R: Real> Add for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn add(self, o: Self) -> Self {
                Self { $a: self.$a + o.$a, $b: self.$b + o.$b }
            }
        }
        impl<R: Real> Sub for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, o: Self) -> Self {
                Self { $a: self.$a - o.$a, $b: self.$b - o.$b }
            }
        }
        impl<R: Real> Neg for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self { $a: -self.$a, $b: -self.$b }
            }
        }
        impl<R: Real> AddAssign for $name<R> {
            #[inline(always)]
            fn add_assign(&mut self, o: Self) {
                *self = *self + o;
            }
        }
    };
}
componentwise!(Motion, angular, linear);
componentwise!(Force, moment, force);

/// A symmetric 6 x 6 inertia `[J H; H^T M]`: wrench = inertia times acceleration, both at the reference point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inertia<R> {
    /// Angular block J, kg m^2.
    pub angular: Sym3<R>,
    /// Coupling block H, kg m.
    pub coupling: Mat3<R>,
    /// Linear block M, kg.
    pub linear: Sym3<R>,
}

impl<R: Real> Add for Inertia<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { angular: self.angular + o.angular, coupling: self.coupling + o.coupling, linear: self.linear + o.linear }
    }
}

impl<R: Real> Inertia<R> {
    /// The wrench that gives this inertia the acceleration `a`.
    #[inline(always)]
    pub fn mul_motion(&self, a: &Motion<R>) -> Force<R> {
        Force {
            moment: self.angular.mul_vec(a.angular) + self.coupling.mul_vec(a.linear),
            force: self.coupling.tr_mul_vec(a.angular) + self.linear.mul_vec(a.linear),
        }
    }
    /// Inverse of a positive definite inertia, by the Schur complement of the linear block.
    #[inline(always)]
    pub fn inverse(&self) -> Mobility<R> {
        // S = J - H M^-1 H^T;  Phi_aa = S^-1, Phi_la = -M^-1 H^T S^-1, Phi_ll = M^-1 + M^-1 H^T S^-1 H M^-1.
        let m_inverse = self.linear.inverse();
        let y = m_inverse.mul_mat(&self.coupling.transpose());
        let schur = self.angular - Sym3::product_upper(&self.coupling, &y);
        let aa = schur.inverse();
        let aa_yt = aa.mul_mat(&y.transpose());
        Mobility {
            aa: aa.to_mat3(),
            al: Mat3::zero() - aa_yt,
            la: Mat3::zero() - aa_yt.transpose(),
            ll: (m_inverse + Sym3::product_upper(&y, &aa_yt)).to_mat3(),
        }
    }
}

/// A block of an inverse inertia: the acceleration of one link from a wrench on another (6 x 6, four 3 x 3 blocks).
#[derive(Clone, Copy, Debug, Default)]
pub struct Mobility<R> {
    /// Angular acceleration from moment, 1/(kg m^2).
    pub aa: Mat3<R>,
    /// Angular acceleration from force, 1/(kg m).
    pub al: Mat3<R>,
    /// Linear acceleration from moment, 1/(kg m).
    pub la: Mat3<R>,
    /// Linear acceleration from force, 1/kg.
    pub ll: Mat3<R>,
}

impl<R: Real> Mobility<R> {
    /// The motion that the wrench `f` brings.
    #[inline(always)]
    pub fn mul_force(&self, f: &Force<R>) -> Motion<R> {
        Motion {
            angular: self.al.mul_vec_add(f.force, self.aa.mul_vec(f.moment)),
            linear: self.ll.mul_vec_add(f.force, self.la.mul_vec(f.moment)),
        }
    }
    /// The motion of the other link from a wrench on this one.
    #[inline(always)]
    pub fn tr_mul_force(&self, f: &Force<R>) -> Motion<R> {
        Motion {
            angular: self.la.tr_mul_vec_add(f.force, self.aa.tr_mul_vec(f.moment)),
            linear: self.ll.tr_mul_vec_add(f.force, self.al.tr_mul_vec(f.moment)),
        }
    }
    /// Transposed block.
    #[inline(always)]
    pub fn transpose(&self) -> Self {
        Self { aa: self.aa.transpose(), al: self.la.transpose(), la: self.al.transpose(), ll: self.ll.transpose() }
    }
}
