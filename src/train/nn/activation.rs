//! The functions between layers, over lanes.

use pulp::Simd;
use serde::{Deserialize, Serialize};

/// The function that a hidden layer applies to each of its sums, within 3e-7 of the exact value, absolutely and relatively (4e-7 where the
/// processor has no fused multiply-add).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Activation {
    /// tanh x.
    Tanh,
    /// x for x > 0, e^x - 1 below (Clevert, Unterthiner, Hochreiter 2015, with alpha = 1).
    Elu,
}

impl Activation {
    /// The function itself.
    #[inline(always)]
    pub(super) fn value<S: Simd>(self, simd: S, x: S::f32s) -> S::f32s {
        match self {
            Self::Tanh => tanh(simd, x),
            Self::Elu => elu(simd, x),
        }
    }

    /// The derivative, from the function's own value y: 1 - y^2 for tanh; 1 above zero and y + 1 below for ELU.
    #[inline(always)]
    pub(super) fn slope<S: Simd>(self, simd: S, y: S::f32s) -> S::f32s {
        let one = simd.splat_f32s(1.0);
        match self {
            Self::Tanh => simd.negate_mul_add_e_f32s(y, y, one),
            Self::Elu => simd.add_f32s(simd.min_f32s(y, simd.splat_f32s(0.0)), one),
        }
    }
}

/// Beyond this the result is that of this bound, 6e-8 short of 1.
const TANH_BOUND: f32 = 8.0;

/// tanh x = x P(x^2) / Q(x^2): coefficients of P and Q from the constant term on. A minimax fit of the relative error
/// (6.5e-9 before rounding) over |x| <= 8, made for this crate.
const TANH_P: [f32; 5] = [1.0, 0.13444553, 0.003571665, 2.1895763e-5, 1.5231963e-8];
const TANH_Q: [f32; 5] = [1.0, 0.46777883, 0.026164696, 0.0003411401, 8.5230744e-7];

/// tanh, odd to the bit, exact at 0.
#[inline(always)]
fn tanh<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    // The variable comes last: of a comparison with not-a-number, x86 returns the second operand.
    let x = simd.max_f32s(simd.splat_f32s(-TANH_BOUND), simd.min_f32s(simd.splat_f32s(TANH_BOUND), x));
    let u = simd.mul_f32s(x, x);
    simd.div_f32s(simd.mul_f32s(x, polynomial(simd, &TANH_P, u)), polynomial(simd, &TANH_Q, u))
}

/// ELU by e^x - 1 = 2 t / (1 - t) with t = tanh(x / 2), which loses nothing near zero.
#[inline(always)]
fn elu<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let zero = simd.splat_f32s(0.0);
    let t = tanh(simd, simd.mul_f32s(simd.splat_f32s(0.5), simd.min_f32s(zero, x)));
    let below = simd.div_f32s(simd.add_f32s(t, t), simd.sub_f32s(simd.splat_f32s(1.0), t));
    simd.select_f32s(simd.greater_than_f32s(x, zero), x, below)
}

/// Horner's scheme.
#[inline(always)]
fn polynomial<S: Simd>(simd: S, coefficients: &[f32; 5], u: S::f32s) -> S::f32s {
    let mut sum = simd.splat_f32s(coefficients[4]);
    for k in [3, 2, 1, 0] {
        sum = simd.mul_add_e_f32s(sum, u, simd.splat_f32s(coefficients[k]));
    }
    sum
}
