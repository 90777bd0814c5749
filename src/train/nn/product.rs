//! The three matrix products of a dense layer, over register tiles.
//!
//! With X the layer's input (rows x inputs), W its weights (outputs x inputs), b its bias, Y = f(X W^T + b) and D the derivative of the
//! loss with respect to X W^T + b:
//!
//! - forward: Y = f(X W^T + b) (`product` with `Activate`);
//! - back through the layer: D' = (D W) * f'(X), the D of the layer before (`product` with `Differentiate`);
//! - weights: dW = D^T X, db = column sums of D (`add_outer_product`, `add_column_sums`).
//!
//! Each element is summed in one fixed order by fused multiply-add, whatever the vector width: AVX2 and AVX-512 give the same bits.
//! Without fused multiply-add (WASM, old processors) products are rounded before they are added.

use pulp::Simd;

use super::activation::Activation;
use super::strips::{Strip, Strips, WIDTH};

/// What a tile starts from and what happens to it before it is stored.
pub(super) trait Finish {
    /// The first value of the sums in vector `vector` of panel `panel`.
    fn start<S: Simd>(&self, simd: S, panel: usize, vector: usize) -> S::f32s;
    /// The value to store, from the sum.
    fn finish<S: Simd>(&self, simd: S, sum: S::f32s, panel: usize, row: usize, vector: usize) -> S::f32s;
}

/// f(sum + bias); no function where `activation` is none.
pub(super) struct Activate<'a> {
    pub bias: &'a [Strip],
    pub activation: Option<Activation>,
}

impl Finish for Activate<'_> {
    #[inline(always)]
    fn start<S: Simd>(&self, _: S, panel: usize, vector: usize) -> S::f32s {
        vectors::<S>(&self.bias[panel])[vector]
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, sum: S::f32s, _: usize, _: usize, _: usize) -> S::f32s {
        match self.activation {
            Some(activation) => activation.value(simd, sum),
            None => sum,
        }
    }
}

/// sum * f'(values).
pub(super) struct Differentiate<'a> {
    pub values: &'a Strips,
    pub activation: Activation,
}

impl Finish for Differentiate<'_> {
    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, _: usize) -> S::f32s {
        simd.splat_f32s(0.0)
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, sum: S::f32s, panel: usize, row: usize, vector: usize) -> S::f32s {
        let value = vectors::<S>(&self.values.panel_tiles(panel)[row])[vector];
        simd.mul_f32s(sum, self.activation.slope(simd, value))
    }
}

/// out = finish(a b): `a` is rows x depth, `b` depth x columns; `out` must have the shape rows x columns.
#[inline(always)]
pub(super) fn product<S: Simd>(simd: S, a: &Strips, b: &Strips, finish: &impl Finish, out: &mut Strips) {
    if S::REGISTER_COUNT >= 32 {
        product_tiled::<S, 8, 2>(simd, a, b, finish, out);
    } else {
        product_tiled::<S, 4, 2>(simd, a, b, finish, out);
    }
}

/// The product by tiles of M rows and N vectors, all of whose sums stay in registers.
// Loops over constant ranges are unrolled early; with iterators the compiler keeps the sums in memory, at half the speed.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
fn product_tiled<S: Simd, const M: usize, const N: usize>(
    simd: S,
    a: &Strips,
    b: &Strips,
    finish: &impl Finish,
    out: &mut Strips,
) {
    for panel in 0..out.panels() {
        let b = b.panel(panel);
        for (tile, target) in out.panel_tiles_mut(panel).as_chunks_mut::<M>().0.iter_mut().enumerate() {
            for part in 0..WIDTH / (S::F32_LANES * N) {
                let mut sums = [[simd.splat_f32s(0.0); N]; M];
                for v in 0..N {
                    let start = finish.start(simd, panel, part * N + v);
                    for row in &mut sums {
                        row[v] = start;
                    }
                }
                for (a_panel, b) in b.chunks(WIDTH).enumerate() {
                    let a = &a.panel_tiles(a_panel).as_chunks::<M>().0[tile];
                    for (k, b) in (0..WIDTH).zip(b) {
                        let b = vectors::<S>(b);
                        for i in 0..M {
                            let factor = simd.splat_f32s(a[i].0[k]);
                            for v in 0..N {
                                sums[i][v] = simd.mul_add_e_f32s(factor, b[part * N + v], sums[i][v]);
                            }
                        }
                    }
                }
                for i in 0..M {
                    for v in 0..N {
                        let vector = part * N + v;
                        vectors_mut::<S>(&mut target[i])[vector] =
                            finish.finish(simd, sums[i][v], panel, tile * M + i, vector);
                    }
                }
            }
        }
    }
}

/// target += d^T x: `d` is rows x outputs, `x` rows x inputs, `target` outputs x inputs, row-major.
#[inline(always)]
pub(super) fn add_outer_product<S: Simd>(simd: S, d: &Strips, x: &Strips, target: &mut [f32]) {
    if S::REGISTER_COUNT >= 32 {
        add_outer_product_tiled::<S, 8, 2>(simd, d, x, target);
    } else {
        add_outer_product_tiled::<S, 4, 2>(simd, d, x, target);
    }
}

/// By tiles of M outputs and N vectors of inputs, as `product_tiled`.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
fn add_outer_product_tiled<S: Simd, const M: usize, const N: usize>(
    simd: S,
    d: &Strips,
    x: &Strips,
    target: &mut [f32],
) {
    let inputs = x.columns();
    for panel in 0..x.panels() {
        let first = panel * WIDTH;
        let used = WIDTH.min(inputs - first);
        for (tile, target) in target.chunks_mut(M * inputs).enumerate() {
            let (d_panel, d_tile) = (tile * M / WIDTH, tile % (WIDTH / M));
            for part in 0..WIDTH / (S::F32_LANES * N) {
                let mut sums = [[simd.splat_f32s(0.0); N]; M];
                for (d, x) in d.panel(d_panel).iter().zip(x.panel(panel)) {
                    let d = &d.0.as_chunks::<M>().0[d_tile];
                    let x = vectors::<S>(x);
                    for i in 0..M {
                        let factor = simd.splat_f32s(d[i]);
                        for v in 0..N {
                            sums[i][v] = simd.mul_add_e_f32s(factor, x[part * N + v], sums[i][v]);
                        }
                    }
                }
                let mut strip = Strip::ZERO;
                let lanes = part * N * S::F32_LANES..used.min((part + 1) * N * S::F32_LANES);
                for (row, sums) in target.chunks_exact_mut(inputs).zip(&sums) {
                    for v in 0..N {
                        vectors_mut::<S>(&mut strip)[part * N + v] = sums[v];
                    }
                    let row = &mut row[first..];
                    for lane in lanes.clone() {
                        row[lane] += strip.0[lane];
                    }
                }
            }
        }
    }
}

/// target += the sums of d's columns.
#[inline(always)]
pub(super) fn add_column_sums<S: Simd>(simd: S, d: &Strips, target: &mut [f32]) {
    for (panel, target) in target.chunks_mut(WIDTH).enumerate() {
        let mut sums = Strip::ZERO;
        let total = vectors_mut::<S>(&mut sums);
        for strip in d.panel(panel) {
            for (sum, value) in total.iter_mut().zip(vectors::<S>(strip)) {
                *sum = simd.add_f32s(*sum, *value);
            }
        }
        for (target, sum) in target.iter_mut().zip(sums.0) {
            *target += sum;
        }
    }
}

/// A strip as the vectors of the instruction set.
#[inline(always)]
fn vectors<S: Simd>(strip: &Strip) -> &[S::f32s] {
    S::as_simd_f32s(&strip.0).0
}

#[inline(always)]
fn vectors_mut<S: Simd>(strip: &mut Strip) -> &mut [S::f32s] {
    S::as_mut_simd_f32s(&mut strip.0).0
}
