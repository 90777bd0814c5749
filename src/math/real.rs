//! The number type of the core: one trait, one or many characters per value.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

/// A real number, or a row of them with one character in each lane.
///
/// The dynamics is written once over this trait. What differs between lanes is expressed by masks and
/// [`Real::select`], never by a branch, so lane `k` of a wide type computes the same bits as the scalar type would.
///
/// There are two families:
/// - **play** (`f64`, `f32`, [`F64x4`](crate::math::F64x4), [`F32x8`](crate::math::F32x8)): [`Real::mul_add`] rounds
///   twice. The same bits on every machine.
/// - **training** ([`F64Fused`](crate::math::F64Fused), [`F64x4Fused`](crate::math::F64x4Fused),
///   [`F32x8Fused`](crate::math::F32x8Fused)): [`Real::mul_add`] is one instruction where the target has it. Fastest,
///   but the last bits depend on the machine.
pub trait Real:
    Copy
    + Debug
    + Default
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// One truth value per lane.
    type Mask: Copy
        + Debug
        + Send
        + Sync
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + Not<Output = Self::Mask>;

    /// Number of characters in one value.
    const LANES: usize;
    /// Short name for reports, such as `4 x f64`.
    const NAME: &'static str;
    /// Unit round-off of one lane.
    const EPSILON: f64;

    /// The same value in every lane.
    fn splat(value: f64) -> Self;
    /// The value of lane `index`; panics if `index >= LANES`.
    fn lane(self, index: usize) -> f64;
    /// Replaces the value of lane `index`; panics if `index >= LANES`.
    fn set_lane(&mut self, index: usize, value: f64);
    /// `self * b + c`, fused in the training family.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `c - self * b`, fused in the training family.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// Square root; NaN for negative lanes.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// `self < other ? self : other` in each lane.
    fn min(self, other: Self) -> Self;
    /// `self > other ? self : other` in each lane.
    fn max(self, other: Self) -> Self;
    /// True where `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `if_true` where the mask holds, else `if_false`.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;
    /// True if the mask holds in any lane.
    fn any(mask: Self::Mask) -> bool;
    /// Truth value of lane `index` of a mask.
    fn mask_lane(mask: Self::Mask, index: usize) -> bool;

    /// Zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    /// One in every lane.
    #[inline(always)]
    fn one() -> Self {
        Self::splat(1.0)
    }
    /// `1 / self`.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::one() / self
    }
    /// `low` where smaller, `high` where larger, else `self`.
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
    /// `self` where the mask holds, else zero.
    #[inline(always)]
    fn masked(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, Self::zero())
    }
    /// A value built lane by lane.
    #[inline]
    fn from_lanes(mut lane: impl FnMut(usize) -> f64) -> Self {
        let mut value = Self::zero();
        for index in 0..Self::LANES {
            value.set_lane(index, lane(index));
        }
        value
    }
}

macro_rules! scalar_real {
    ($scalar:ty, $name:literal) => {
        impl Real for $scalar {
            type Mask = bool;
            const LANES: usize = 1;
            const NAME: &'static str = $name;
            const EPSILON: f64 = <$scalar>::EPSILON as f64;

            #[inline(always)]
            fn splat(value: f64) -> Self {
                value as $scalar
            }
            #[inline(always)]
            fn lane(self, _index: usize) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn set_lane(&mut self, _index: usize, value: f64) {
                *self = value as $scalar;
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                self * b + c
            }
            #[inline(always)]
            fn neg_mul_add(self, b: Self, c: Self) -> Self {
                c - self * b
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$scalar>::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$scalar>::abs(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
                if mask { if_true } else { if_false }
            }
            #[inline(always)]
            fn any(mask: bool) -> bool {
                mask
            }
            #[inline(always)]
            fn mask_lane(mask: bool, _index: usize) -> bool {
                mask
            }
        }
    };
}

scalar_real!(f64, "f64");
scalar_real!(f32, "f32");
