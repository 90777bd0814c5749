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

/// Vectors side by side in a tile.
const TILE_VECTORS: usize = 2;

/// out = finish(a b): `a` is rows x depth, `b` depth x columns; `out` must have the shape rows x columns.
#[inline(always)]
pub(super) fn product<S: Simd>(simd: S, a: &Strips, b: &Strips, finish: &impl Finish, out: &mut Strips) {
    for panel in 0..out.panels() {
        let b = b.panel(panel);
        let out = out.panel_tiles_mut(panel);
        // All rows for one part of the panel, so that this part of `b` stays in the first cache.
        for part in 0..parts::<S>() {
            // As many rows as the sums have registers for: 16 or 12 sums, two vectors of `b`, a factor.
            if S::REGISTER_COUNT >= 32 {
                product_rows::<S, 8>(simd, a, b, finish, (panel, part), out);
            } else {
                product_rows::<S, 6>(simd, a, b, finish, (panel, part), out);
            }
        }
    }
}

/// Parts of a strip that tiles cover.
#[inline(always)]
const fn parts<S: Simd>() -> usize {
    WIDTH / (S::F32_LANES * TILE_VECTORS)
}

/// One part of a panel, by tiles of M rows and, where M does not divide their number, of two.
#[inline(always)]
fn product_rows<S: Simd, const M: usize>(
    simd: S,
    a: &Strips,
    b: &[Strip],
    finish: &impl Finish,
    place: (usize, usize),
    out: &mut [Strip],
) {
    let (tiles, rest) = out.as_chunks_mut::<M>();
    let done = tiles.len() * M;
    for (tile, target) in tiles.iter_mut().enumerate() {
        product_tile(simd, a, b, finish, place, tile * M, target);
    }
    for (tile, target) in rest.as_chunks_mut::<2>().0.iter_mut().enumerate() {
        product_tile(simd, a, b, finish, place, done + tile * 2, target);
    }
}

/// A tile of M rows from `first` on: all of its sums stay in registers.
// Loops over constant ranges are unrolled early; with iterators the compiler keeps the sums in memory, at half the speed.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
fn product_tile<S: Simd, const M: usize>(
    simd: S,
    a: &Strips,
    b: &[Strip],
    finish: &impl Finish,
    (panel, part): (usize, usize),
    first: usize,
    target: &mut [Strip; M],
) {
    const N: usize = TILE_VECTORS;
    let mut sums = [[simd.splat_f32s(0.0); N]; M];
    for v in 0..N {
        let start = finish.start(simd, panel, part * N + v);
        for row in &mut sums {
            row[v] = start;
        }
    }
    for (a_panel, b) in b.chunks(WIDTH).enumerate() {
        let Some(a) = a.panel_tiles(a_panel)[first..].first_chunk::<M>() else { return };
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
            vectors_mut::<S>(&mut target[i])[vector] = finish.finish(simd, sums[i][v], panel, first + i, vector);
        }
    }
}

/// target += d^T x: `d` is rows x outputs, `x` rows x inputs, `target` outputs x inputs, row-major.
#[inline(always)]
pub(super) fn add_outer_product<S: Simd>(simd: S, d: &Strips, x: &Strips, target: &mut [f32]) {
    for panel in 0..x.panels() {
        for part in 0..parts::<S>() {
            for (d_panel, target) in target.chunks_mut(WIDTH * x.columns()).enumerate() {
                let place = (panel, part, d_panel);
                // The 32 outputs of a panel by tiles that divide them: with 6, and 2 left over, AVX2 is slower.
                if S::REGISTER_COUNT >= 32 {
                    outer_product_outputs::<S, 8>(simd, d, x, place, target);
                } else {
                    outer_product_outputs::<S, 4>(simd, d, x, place, target);
                }
            }
        }
    }
}

/// The outputs of one panel of `d`, by tiles of M of them and, in the end, of two.
#[inline(always)]
fn outer_product_outputs<S: Simd, const M: usize>(
    simd: S,
    d: &Strips,
    x: &Strips,
    place: (usize, usize, usize),
    target: &mut [f32],
) {
    let inputs = x.columns();
    let whole = WIDTH - WIDTH % M;
    let (tiles, rest) = target.split_at_mut(target.len().min(whole * inputs));
    for (tile, target) in tiles.chunks_mut(M * inputs).enumerate() {
        outer_product_tile::<S, M>(simd, d, x, place, tile * M, target);
    }
    for (tile, target) in rest.chunks_mut(2 * inputs).enumerate() {
        outer_product_tile::<S, 2>(simd, d, x, place, whole + tile * 2, target);
    }
}

/// A tile of M outputs from `first` on, counted in the panel of `d`; `target` may hold fewer.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
fn outer_product_tile<S: Simd, const M: usize>(
    simd: S,
    d: &Strips,
    x: &Strips,
    (panel, part, d_panel): (usize, usize, usize),
    first: usize,
    target: &mut [f32],
) {
    const N: usize = TILE_VECTORS;
    let mut sums = [[simd.splat_f32s(0.0); N]; M];
    for (d, x) in d.panel(d_panel).iter().zip(x.panel(panel)) {
        let Some(d) = d.0[first..].first_chunk::<M>() else { return };
        let x = vectors::<S>(x);
        for i in 0..M {
            let factor = simd.splat_f32s(d[i]);
            for v in 0..N {
                sums[i][v] = simd.mul_add_e_f32s(factor, x[part * N + v], sums[i][v]);
            }
        }
    }
    let (inputs, begin) = (x.columns(), panel * WIDTH);
    let used = WIDTH.min(inputs - begin);
    let mut strip = Strip::ZERO;
    let lanes = part * N * S::F32_LANES..used.min((part + 1) * N * S::F32_LANES);
    for (row, sums) in target.chunks_exact_mut(inputs).zip(&sums) {
        for v in 0..N {
            vectors_mut::<S>(&mut strip)[part * N + v] = sums[v];
        }
        let row = &mut row[begin..];
        for lane in lanes.clone() {
            row[lane] += strip.0[lane];
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
