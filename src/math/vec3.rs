//! Three-vectors over lanes.

use crate::math::Real;
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};
use glam::DVec3;

/// A vector with one component triple per lane.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vec3<R> {
    /// First component.
    pub x: R,
    /// Second component.
    pub y: R,
    /// Third component.
    pub z: R,
}

impl<R: Real> Vec3<R> {
    /// A vector from its components.
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::new(R::zero(), R::zero(), R::zero())
    }
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: DVec3) -> Self {
        Self::new(R::splat(v.x), R::splat(v.y), R::splat(v.z))
    }
    /// The vector of lane `index`.
    #[inline]
    pub fn lane(self, index: usize) -> DVec3 {
        DVec3::new(self.x.lane(index), self.y.lane(index), self.z.lane(index))
    }
    /// Replaces the vector of lane `index`.
    #[inline]
    pub fn set_lane(&mut self, index: usize, v: DVec3) {
        self.x.set_lane(index, v.x);
        self.y.set_lane(index, v.y);
        self.z.set_lane(index, v.z);
    }
    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> R {
        self.z.mul_add(b.z, self.y.mul_add(b.y, self.x * b.x))
    }
    /// Vector product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Self::new(
            self.z.neg_mul_add(b.y, self.y * b.z),
            self.x.neg_mul_add(b.z, self.z * b.x),
            self.y.neg_mul_add(b.x, self.x * b.y),
        )
    }
    /// `self . b + c`.
    #[inline(always)]
    pub fn dot_add(self, b: Self, c: R) -> R {
        self.z.mul_add(b.z, self.y.mul_add(b.y, self.x.mul_add(b.x, c)))
    }
    /// `self x b + c`.
    #[inline(always)]
    pub fn cross_add(self, b: Self, c: Self) -> Self {
        Self::new(
            self.z.neg_mul_add(b.y, self.y.mul_add(b.z, c.x)),
            self.x.neg_mul_add(b.z, self.z.mul_add(b.x, c.y)),
            self.y.neg_mul_add(b.x, self.x.mul_add(b.y, c.z)),
        )
    }
    /// `b - self * s`.
    #[inline(always)]
    pub fn neg_mul_add(self, s: R, b: Self) -> Self {
        Self::new(self.x.neg_mul_add(s, b.x), self.y.neg_mul_add(s, b.y), self.z.neg_mul_add(s, b.z))
    }
    /// `self * s + b`.
    #[inline(always)]
    pub fn mul_add(self, s: R, b: Self) -> Self {
        Self::new(self.x.mul_add(s, b.x), self.y.mul_add(s, b.y), self.z.mul_add(s, b.z))
    }
    /// Component by component product.
    #[inline(always)]
    pub fn component_mul(self, b: Self) -> Self {
        Self::new(self.x * b.x, self.y * b.y, self.z * b.z)
    }
    /// Squared length.
    #[inline(always)]
    pub fn length_squared(self) -> R {
        self.dot(self)
    }
    /// Length.
    #[inline(always)]
    pub fn length(self) -> R {
        self.dot(self).sqrt()
    }
    /// `if_true` where the mask holds, else `if_false`.
    #[inline(always)]
    pub fn select(mask: R::Mask, if_true: Self, if_false: Self) -> Self {
        Self::new(
            R::select(mask, if_true.x, if_false.x),
            R::select(mask, if_true.y, if_false.y),
            R::select(mask, if_true.z, if_false.z),
        )
    }
    /// `self` where the mask holds, else zero.
    #[inline(always)]
    pub fn masked(self, mask: R::Mask) -> Self {
        Self::select(mask, self, Self::zero())
    }
}

impl<R: Real> Add for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self::new(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}
impl<R: Real> Sub for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self::new(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}
impl<R: Real> AddAssign for Vec3<R> {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}
impl<R: Real> SubAssign for Vec3<R> {
    #[inline(always)]
    fn sub_assign(&mut self, b: Self) {
        *self = *self - b;
    }
}
impl<R: Real> Neg for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}
impl<R: Real> Mul<R> for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: R) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
}
