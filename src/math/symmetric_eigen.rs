//! Eigenvalues and eigenvectors of a symmetric matrix.
//!
//! Householder's reduction to a tridiagonal matrix, then the QL algorithm with implicit shifts (Golub, Van Loan 2013,
//! "Matrix Computations", Sections 8.3.1 and 8.3.3; Bowdler, Martin, Reinsch, Wilkinson 1968, "The QR and QL Algorithms for
//! Symmetric Matrices"). Eigenvectors are kept as rows, so that every inner loop runs along memory.

/// Most shifts for one eigenvalue; two or three are usual.
const MOST_SHIFTS: usize = 60;

/// `matrix = sum over k of values[k] * vectors[k] * vectors[k]^T`.
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetricEigen {
    /// Eigenvalues, in no order.
    pub values: Vec<f64>,
    /// Unit eigenvectors one after the other: entry `k * n + i` is component `i` of the one that belongs to value `k`.
    pub vectors: Vec<f64>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four partial sums, so that additions need not wait for each other.
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Length of the vector `(x, y)`, without the platform's own `hypot`.
fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

fn add_scaled(to: &mut [f64], factor: f64, from: &[f64]) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += factor * f;
    }
}

/// Decomposes a symmetric matrix of `n` rows, row by row; only numbers on and below the diagonal are read. `None` where
/// an entry is not finite, or in the (never seen) case that the shifts do not converge.
pub fn symmetric_eigen(matrix: &[f64], n: usize) -> Option<SymmetricEigen> {
    if matrix.len() != n * n || !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let mut a = matrix.to_vec();
    for i in 0..n {
        for j in 0..i {
            a[j * n + i] = a[i * n + j];
        }
    }
    let (mut diagonal, mut beside, reflectors) = tridiagonal(&mut a, n);
    let mut vectors = product_of_reflectors(&reflectors, n);
    implicit_ql(&mut diagonal, &mut beside, &mut vectors, n)?;
    Some(SymmetricEigen { values: diagonal, vectors })
}

/// Q^T A Q = T: the diagonal of T, what is beside it (entry `i` between rows `i - 1` and `i`), and the Householder vectors of
/// Q, each of length `sqrt(2)` or zero: the one with index `k` has zeros in its first `k + 1` components.
fn tridiagonal(a: &mut [f64], n: usize) -> (Vec<f64>, Vec<f64>, Vec<Vec<f64>>) {
    let mut beside = vec![0.0; n];
    let mut reflectors = Vec::with_capacity(n.saturating_sub(2));
    let mut p = vec![0.0; n];
    for k in 0..n.saturating_sub(2) {
        // The reflection takes column k below the diagonal to a multiple of the first axis.
        let mut v = vec![0.0; n];
        v[k + 1..].copy_from_slice(&a[k * n + k + 1..(k + 1) * n]);
        let whole = dot(&v, &v).sqrt();
        let alpha = if v[k + 1] > 0.0 { -whole } else { whole };
        v[k + 1] -= alpha;
        let norm = dot(&v, &v);
        beside[k + 1] = alpha;
        if norm > 0.0 {
            let scale = (2.0 / norm).sqrt();
            v.iter_mut().for_each(|x| *x *= scale);
            // A - v w^T - w v^T with w = p - (p . v / 2) v, p = A v.
            let active = k + 1..n;
            for i in active.clone() {
                p[i] = dot(&a[i * n + k + 1..(i + 1) * n], &v[k + 1..]);
            }
            let half = 0.5 * dot(&p[k + 1..], &v[k + 1..]);
            add_scaled(&mut p[k + 1..], -half, &v[k + 1..]);
            for i in active {
                let row = &mut a[i * n + k + 1..(i + 1) * n];
                let (vi, wi) = (v[i], p[i]);
                for ((x, w), v) in row.iter_mut().zip(&p[k + 1..]).zip(&v[k + 1..]) {
                    *x -= vi * w + wi * v;
                }
            }
        }
        reflectors.push(v);
    }
    if n >= 2 {
        beside[n - 1] = a[(n - 1) * n + n - 2];
    }
    ((0..n).map(|i| a[i * n + i]).collect(), beside, reflectors)
}

/// The transpose of Q = H_0 H_1 ..., row by row, with H = 1 - v v^T.
fn product_of_reflectors(reflectors: &[Vec<f64>], n: usize) -> Vec<f64> {
    let mut q = vec![0.0; n * n];
    for i in 0..n {
        q[i * n + i] = 1.0;
    }
    // From the last: each reflector then meets rows that are still zero left of it.
    for (k, v) in reflectors.iter().enumerate().rev() {
        for row in q.chunks_exact_mut(n).skip(k + 1) {
            let factor = dot(&row[k + 1..], &v[k + 1..]);
            add_scaled(&mut row[k + 1..], -factor, &v[k + 1..]);
        }
    }
    q
}

/// Turns two rows: `(a, b)` to `(c a - s b, s a + c b)`.
fn turn_rows(a: &mut [f64], b: &mut [f64], c: f64, s: f64) {
    for (x, y) in a.iter_mut().zip(b) {
        let (p, q) = (*x, *y);
        *x = c * p - s * q;
        *y = s * p + c * q;
    }
}

/// Brings the tridiagonal matrix to diagonal form and turns the rows of `vectors` along.
fn implicit_ql(d: &mut [f64], beside: &mut [f64], vectors: &mut [f64], n: usize) -> Option<()> {
    // Entry i is now between rows i and i + 1.
    beside.rotate_left(usize::from(n > 0));
    let e = beside;
    for l in 0..n {
        for shift in 0.. {
            // The first place from l on where the matrix falls apart.
            let small = |m: usize| e[m].abs() <= f64::EPSILON * (d[m].abs() + d[m + 1].abs());
            let m = (l..n - 1).find(|&m| small(m)).unwrap_or(n - 1);
            if m == l {
                break;
            }
            if shift == MOST_SHIFTS {
                return None;
            }
            // Wilkinson's shift.
            let half = (d[l + 1] - d[l]) / (2.0 * e[l]);
            let root = length(half, 1.0);
            let mut g = d[m] - d[l] + e[l] / (half + root.copysign(half));
            let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
            let mut complete = true;
            for i in (l..m).rev() {
                let (f, b) = (s * e[i], c * e[i]);
                let r = length(f, g);
                e[i + 1] = r;
                if r == 0.0 {
                    d[i + 1] -= p;
                    e[m] = 0.0;
                    complete = false;
                    break;
                }
                (s, c) = (f / r, g / r);
                let q = d[i + 1] - p;
                let t = (d[i] - q) * s + 2.0 * c * b;
                p = s * t;
                d[i + 1] = q + p;
                g = c * t - b;
                let (upper, lower) = vectors.split_at_mut((i + 1) * n);
                turn_rows(&mut upper[i * n..], &mut lower[..n], c, s);
            }
            if complete {
                d[l] -= p;
                e[l] = g;
                e[m] = 0.0;
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::RandomStream;

    fn random_symmetric(n: usize, seed: u64) -> Vec<f64> {
        let mut random = RandomStream::new(seed, n as u64);
        let mut a = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let x = random.normal();
                (a[i * n + j], a[j * n + i]) = (x, x);
            }
        }
        a
    }

    fn check(a: &[f64], n: usize) {
        let eigen = symmetric_eigen(a, n).unwrap();
        let scale = a.iter().fold(1e-300_f64, |m, x| m.max(x.abs()));
        for k in 0..n {
            let v = &eigen.vectors[k * n..(k + 1) * n];
            for i in 0..n {
                let product: f64 = (0..n).map(|j| a[i * n + j] * v[j]).sum();
                let residual = product - eigen.values[k] * v[i];
                assert!(residual.abs() < 1e-12 * scale * n as f64, "n {n}, vector {k}: {residual:e}");
            }
            for m in 0..n {
                let expected = if m == k { 1.0 } else { 0.0 };
                let found = dot(v, &eigen.vectors[m * n..(m + 1) * n]);
                assert!((found - expected).abs() < 1e-12 * n as f64, "vectors {k}, {m}: {found}");
            }
        }
    }

    #[test]
    fn vectors_are_orthonormal_and_the_matrix_scales_each_by_its_value() {
        for n in [1, 2, 3, 4, 7, 30, 61] {
            check(&random_symmetric(n, 5), n);
        }
    }

    #[test]
    fn equal_eigenvalues_and_matrices_that_fall_apart_are_no_trouble() {
        // Identity, zero, and two blocks that know nothing of each other.
        let mut identity = vec![0.0; 25];
        (0..5).for_each(|i| identity[i * 6] = 1.0);
        check(&identity, 5);
        check(&[0.0; 16], 4);
        let mut blocks = vec![0.0; 36];
        let block = random_symmetric(3, 9);
        for i in 0..3 {
            for j in 0..3 {
                blocks[i * 6 + j] = block[i * 3 + j];
                blocks[(i + 3) * 6 + j + 3] = block[i * 3 + j];
            }
        }
        check(&blocks, 6);
        // Sixteen orders of magnitude between the largest and the smallest.
        let mut wide = vec![0.0; 9];
        (wide[0], wide[4], wide[8], wide[3], wide[1]) = (1.0, 1e-8, 1e-16, 1e-5, 1e-5);
        check(&wide, 3);
    }

    #[test]
    fn what_is_no_number_is_refused() {
        assert_eq!(symmetric_eigen(&[f64::NAN], 1), None);
        assert_eq!(symmetric_eigen(&[1.0, 2.0], 2), None);
        assert!(symmetric_eigen(&[], 0).is_some());
    }
}
