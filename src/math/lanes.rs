//! Lane types: several characters in one SIMD register, over the `wide` crate.

use crate::math::Real;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

macro_rules! forward_operators {
    ($name:ident) => {
        forward_operators!(@binary $name, Add, add);
        forward_operators!(@binary $name, Sub, sub);
        forward_operators!(@binary $name, Mul, mul);
        forward_operators!(@binary $name, Div, div);
        forward_operators!(@assign $name, AddAssign, add_assign, add);
        forward_operators!(@assign $name, SubAssign, sub_assign, sub);
        forward_operators!(@assign $name, MulAssign, mul_assign, mul);
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }
    };
    (@binary $name:ident, $operator:ident, $method:ident) => {
        impl $operator for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($operator::$method(self.0, other.0))
            }
        }
    };
    (@assign $name:ident, $operator:ident, $method:ident, $by:ident) => {
        impl $operator for $name {
            #[inline(always)]
            fn $method(&mut self, other: Self) {
                *self = Self(self.0.$by(other.0));
            }
        }
    };
}

macro_rules! lane_type {
    ($name:ident, $mask:ident, $wide:ty, $element:ty, $lanes:literal, $label:literal, $fused:literal, $doc:literal) => {
        #[doc = $doc]
        #[derive(Clone, Copy, Debug, Default)]
        #[repr(transparent)]
        pub struct $name($wide);

        forward_operators!($name);

        #[doc = concat!("One truth value per lane of [`", stringify!($name), "`].")]
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub struct $mask($wide);

        impl BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                Self(self.0 & other.0)
            }
        }
        impl BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }
        impl Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }

        impl Real for $name {
            type Mask = $mask;
            const LANES: usize = $lanes;
            const NAME: &'static str = $label;
            const EPSILON: f64 = <$element>::EPSILON as f64;

            #[inline(always)]
            fn splat(value: f64) -> Self {
                Self(<$wide>::splat(value as $element))
            }
            #[inline(always)]
            fn lane(self, index: usize) -> f64 {
                self.0.to_array()[index] as f64
            }
            #[inline(always)]
            fn set_lane(&mut self, index: usize, value: f64) {
                // In place: a vector that is loaded whole after one of its lanes was stored waits for the store.
                self.0.as_mut_array()[index] = value as $element;
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                if $fused { Self(self.0.mul_add(b.0, c.0)) } else { Self(self.0 * b.0 + c.0) }
            }
            #[inline(always)]
            fn neg_mul_add(self, b: Self, c: Self) -> Self {
                if $fused { Self(self.0.mul_neg_add(b.0, c.0)) } else { Self(c.0 - self.0 * b.0) }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.0.sqrt())
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0.abs())
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // One instruction, and it means what the other branch spells out, NaN and signed zeros included.
                if cfg!(target_arch = "x86_64") {
                    Self(self.0.fast_min(other.0))
                } else {
                    Self(self.0.simd_lt(other.0).select(self.0, other.0))
                }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if cfg!(target_arch = "x86_64") {
                    Self(self.0.fast_max(other.0))
                } else {
                    Self(other.0.simd_lt(self.0).select(self.0, other.0))
                }
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                $mask(self.0.simd_lt(other.0))
            }
            #[inline(always)]
            fn select(mask: $mask, if_true: Self, if_false: Self) -> Self {
                Self(mask.0.select(if_true.0, if_false.0))
            }
            #[inline(always)]
            fn any(mask: $mask) -> bool {
                mask.0.any()
            }
            #[inline(always)]
            fn mask_lane(mask: $mask, index: usize) -> bool {
                mask.0.to_bitmask() >> index & 1 == 1
            }
        }
    };
}

lane_type!(
    F64x4,
    F64x4Mask,
    wide::f64x4,
    f64,
    4,
    "4 x f64",
    false,
    "Four characters in `f64`, unfused: each lane has the bits of the scalar `f64`."
);
lane_type!(
    F64x4Fused,
    F64x4FusedMask,
    wide::f64x4,
    f64,
    4,
    "4 x f64 fused",
    true,
    "Four characters in `f64`, with fused multiply-add where the target has it."
);
lane_type!(
    F32x8,
    F32x8Mask,
    wide::f32x8,
    f32,
    8,
    "8 x f32",
    false,
    "Eight characters in `f32`, unfused: each lane has the bits of the scalar `f32`."
);
lane_type!(
    F32x8Fused,
    F32x8FusedMask,
    wide::f32x8,
    f32,
    8,
    "8 x f32 fused",
    true,
    "Eight characters in `f32`, with fused multiply-add where the target has it: the training configuration."
);

/// One character in `f64`, with fused multiply-add where the target has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(transparent)]
pub struct F64Fused(f64);

forward_operators!(F64Fused);

impl Real for F64Fused {
    type Mask = bool;
    const LANES: usize = 1;
    const NAME: &'static str = "f64 fused";
    const EPSILON: f64 = f64::EPSILON;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn lane(self, _index: usize) -> f64 {
        self.0
    }
    #[inline(always)]
    fn set_lane(&mut self, _index: usize, value: f64) {
        self.0 = value;
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // Without the instruction `f64::mul_add` is a library call, hundreds of times slower.
        if cfg!(target_feature = "fma") { Self(self.0.mul_add(b.0, c.0)) } else { Self(self.0 * b.0 + c.0) }
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        if cfg!(target_feature = "fma") { Self((-self.0).mul_add(b.0, c.0)) } else { Self(c.0 - self.0 * b.0) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self.0 < other.0 { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self.0 > other.0 { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self.0 < other.0
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
