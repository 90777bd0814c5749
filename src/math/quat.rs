//! Unit quaternions over lanes. No trigonometric function: polynomials only, so that every lane type and every
//! platform gives the same bits.

use crate::math::{Mat3, Real, Vec3};
use core::ops::Mul;
use glam::DQuat;

/// A rotation, `w + x i + y j + z k`, with one quaternion per lane.
#[derive(Clone, Copy, Debug)]
pub struct Quat<R> {
    /// Vector part: `sin(angle / 2)` times the axis.
    pub v: Vec3<R>,
    /// Scalar part: `cos(angle / 2)`.
    pub w: R,
}

impl<R: Real> Default for Quat<R> {
    fn default() -> Self {
        Self::identity()
    }
}

/// `acos(w) / sqrt(1 - w^2)` for `w` in [0, 1]: a polynomial in `2 w - 1`, from the Chebyshev expansion cut at degree 10.
///
/// Times twice the vector part of a unit quaternion with `w >= 0` this is the rotation vector. The largest error is
/// below 3e-9 (the nearest singularity is at `w = -1`, so the Chebyshev coefficients fall by 6 each).
#[inline(always)]
pub fn half_angle_over_sine<R: Real>(w: R) -> R {
    const C: [f64; 11] = [
        1.209199575780444,
        -0.26360016626530397,
        0.06973321884367324,
        -0.01983665343841151,
        0.005861320559752052,
        -0.0017756410692077703,
        0.0005460639278850627,
        -0.00016329768374555415,
        5.0666721266322e-05,
        -2.240253093255419e-05,
        7.317167595870132e-06,
    ];
    let t = w + w - R::one();
    let mut sum = R::splat(C[10]);
    for k in (0..10).rev() {
        sum = sum.mul_add(t, R::splat(C[k]));
    }
    sum
}

impl<R: Real> Quat<R> {
    /// No rotation.
    #[inline(always)]
    pub fn identity() -> Self {
        Self { v: Vec3::zero(), w: R::one() }
    }
    /// The same rotation in every lane.
    #[inline(always)]
    pub fn splat(q: DQuat) -> Self {
        Self { v: Vec3::new(R::splat(q.x), R::splat(q.y), R::splat(q.z)), w: R::splat(q.w) }
    }
    /// The rotation of lane `index`.
    #[inline]
    pub fn lane(self, index: usize) -> DQuat {
        DQuat::from_xyzw(self.v.x.lane(index), self.v.y.lane(index), self.v.z.lane(index), self.w.lane(index))
    }
    /// Replaces the rotation of lane `index`.
    #[inline]
    pub fn set_lane(&mut self, index: usize, q: DQuat) {
        self.v.set_lane(index, q.xyz());
        self.w.set_lane(index, q.w);
    }
    /// The inverse of a unit quaternion.
    #[inline(always)]
    pub fn conjugate(self) -> Self {
        Self { v: -self.v, w: self.w }
    }
    // A method, not the operator: a product of rotations should not look like one of numbers.
    #[allow(clippy::should_implement_trait)]
    /// The rotation matrix of a unit quaternion.
    #[inline(always)]
    pub fn to_mat3(self) -> Mat3<R> {
        let (x2, y2, z2) = (self.v.x + self.v.x, self.v.y + self.v.y, self.v.z + self.v.z);
        let (xx, yy, zz) = (self.v.x * x2, self.v.y * y2, self.v.z * z2);
        let (xy, xz, yz) = (self.v.x * y2, self.v.x * z2, self.v.y * z2);
        let (wx, wy, wz) = (self.w * x2, self.w * y2, self.w * z2);
        let one = R::one();
        Mat3::from_columns(
            Vec3::new(one - (yy + zz), xy + wz, xz - wy),
            Vec3::new(xy - wz, one - (xx + zz), yz + wx),
            Vec3::new(xz + wy, yz - wx, one - (xx + yy)),
        )
    }
    /// The rotation vector (axis times angle, angle in [0, pi]), rad. Sign of the quaternion does not matter; at
    /// exactly half a turn either axis may come out.
    #[inline(always)]
    pub fn to_rotation_vector(self) -> Vec3<R> {
        let w = self.w.abs().min(R::one());
        let s = half_angle_over_sine(w);
        let s = s + s;
        self.v * R::select(self.w.lt(R::zero()), -s, s)
    }
    /// The rotation by the vector `r` (rad, any frame): Taylor series of the half angle to the fifth order, then
    /// normalised. Exact to 1e-9 for the angles of one step (below 0.2 rad).
    #[inline(always)]
    pub fn from_small_rotation_vector(r: Vec3<R>) -> Self {
        let a = r.length_squared();
        let s = a.mul_add(a.mul_add(R::splat(1.0 / 3840.0), R::splat(-1.0 / 48.0)), R::splat(0.5));
        let w = a.mul_add(a.mul_add(R::splat(1.0 / 384.0), R::splat(-0.125)), R::one());
        Self { v: r * s, w }
    }
    /// One Newton step towards unit length: exact to the square of the deviation.
    #[inline(always)]
    pub fn renormalized(self) -> Self {
        let n = self.w.mul_add(self.w, self.v.length_squared());
        let s = n.mul_add(R::splat(-0.5), R::splat(1.5));
        Self { v: self.v * s, w: self.w * s }
    }
    /// Rotates a vector.
    #[inline(always)]
    pub fn rotate(self, a: Vec3<R>) -> Vec3<R> {
        let t = self.v.cross(a);
        let t = t + t;
        a + t * self.w + self.v.cross(t)
    }
    /// `if_true` where the mask holds, else `if_false`.
    #[inline(always)]
    pub fn select(mask: R::Mask, if_true: Self, if_false: Self) -> Self {
        Self { v: Vec3::select(mask, if_true.v, if_false.v), w: R::select(mask, if_true.w, if_false.w) }
    }
}

impl<R: Real> Mul for Quat<R> {
    type Output = Self;
    /// Hamilton product: rotate by `b`, then by `self`.
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        let c = self.v.cross(b.v);
        Self { v: self.v.mul_add(b.w, b.v.mul_add(self.w, c)), w: self.w * b.w - self.v.dot(b.v) }
    }
}
