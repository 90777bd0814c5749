//! Matrix products over register tiles.

/// Columns of a tile: two vectors of eight.
const WIDTH: usize = 16;
/// Rows of a tile: with two vectors each, twelve sums stay in registers.
const HEIGHT: usize = 6;

/// `c += a b` with `a` (m x k), `b` (k x n), `c` (m x n), all row by row.
pub(super) fn add_product(a: &[f32], b: &[f32], c: &mut [f32], m: usize, k: usize, n: usize) {
    for top in (0..m).step_by(HEIGHT) {
        let height = HEIGHT.min(m - top);
        let rows = &a[top * k..(top + height) * k];
        for left in (0..n).step_by(WIDTH) {
            let width = WIDTH.min(n - left);
            if height == HEIGHT && width == WIDTH {
                let sums = tile(core::array::from_fn(|y| &rows[y * k..(y + 1) * k]), &b[left..], n);
                for (y, sums) in sums.iter().enumerate() {
                    let at = (top + y) * n + left;
                    for (c, sum) in c[at..at + WIDTH].iter_mut().zip(sums) {
                        *c += sum;
                    }
                }
            } else {
                for (y, row) in rows.chunks_exact(k).enumerate() {
                    let at = (top + y) * n + left;
                    edge(row, &b[left..], n, &mut c[at..at + width]);
                }
            }
        }
    }
}

/// The sums of one tile: rows of `a` against columns `0..WIDTH` of `b`, whose rows lie `n` apart.
#[inline(always)]
fn tile(a: [&[f32]; HEIGHT], b: &[f32], n: usize) -> [[f32; WIDTH]; HEIGHT] {
    let mut sums = [[0.0_f32; WIDTH]; HEIGHT];
    for (i, row) in b.chunks(n).take(a[0].len()).enumerate() {
        let row: &[f32; WIDTH] = match row.first_chunk() {
            Some(row) => row,
            None => break,
        };
        for (sums, a) in sums.iter_mut().zip(&a) {
            let x = a[i];
            for (sum, b) in sums.iter_mut().zip(row) {
                *sum = multiply_add(x, *b, *sum);
            }
        }
    }
    sums
}

/// One row of `c` at the right or lower border.
fn edge(a: &[f32], b: &[f32], n: usize, c: &mut [f32]) {
    for (x, row) in a.iter().zip(b.chunks(n)) {
        for (c, b) in c.iter_mut().zip(row) {
            *c = multiply_add(*x, *b, *c);
        }
    }
}

/// Fused where that is one instruction.
#[inline(always)]
fn multiply_add(a: f32, b: f32, c: f32) -> f32 {
    if cfg!(target_feature = "fma") { a.mul_add(b, c) } else { a * b + c }
}

/// `out` becomes the transpose of `a` (rows x columns).
pub(super) fn transpose(a: &[f32], rows: usize, columns: usize, out: &mut Vec<f32>) {
    const BLOCK: usize = 16;
    out.resize(rows * columns, 0.0);
    for top in (0..rows).step_by(BLOCK) {
        for left in (0..columns).step_by(BLOCK) {
            for r in top..(top + BLOCK).min(rows) {
                for c in left..(left + BLOCK).min(columns) {
                    out[c * rows + r] = a[r * columns + c];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn like_the_definition_at_every_border() {
        for (m, k, n) in [(1, 1, 1), (6, 5, 16), (7, 3, 17), (13, 40, 51), (64, 240, 128), (5, 2, 15)] {
            let a: Vec<f32> = (0..m * k).map(|x| ((x * 37 % 19) as f32 - 9.0) / 7.0).collect();
            let b: Vec<f32> = (0..k * n).map(|x| ((x * 53 % 23) as f32 - 11.0) / 9.0).collect();
            let mut c = vec![0.5; m * n];
            add_product(&a, &b, &mut c, m, k, n);
            let mut t = Vec::new();
            transpose(&b, k, n, &mut t);
            for y in 0..m {
                for x in 0..n {
                    let sum: f32 = (0..k).map(|i| a[y * k + i] * t[x * k + i]).sum::<f32>() + 0.5;
                    assert!((sum - c[y * n + x]).abs() < 1e-3, "{m} {k} {n}: {sum} {}", c[y * n + x]);
                }
            }
        }
    }
}
