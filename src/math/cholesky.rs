//! Dense symmetric positive definite systems of some dozens of unknowns.

/// The factor `L` of `A = L L^T` of a symmetric positive definite matrix (Golub, Van Loan 2013, "Matrix Computations",
/// algorithm 4.2.1).
#[derive(Clone, Debug)]
pub struct Cholesky {
    size: usize,
    /// The factor, row by row; what is above the diagonal is not read.
    factor: Vec<f64>,
}

impl Cholesky {
    /// The factor of a matrix of `size` rows, given row by row (`size * size` entries, of which the lower triangle is
    /// read). `None` where the matrix is not positive definite, holds a NaN, or has another size.
    pub fn new(size: usize, matrix: &[f64]) -> Option<Self> {
        if matrix.len() != size * size {
            return None;
        }
        let mut factor = matrix.to_vec();
        factorize(size, &mut factor).then_some(Self { size, factor })
    }

    /// Solves `A x = b`: `b` (`size` entries) becomes `x`.
    pub fn solve(&self, b: &mut [f64]) {
        substitute(self.size, &self.factor, b);
    }

    /// The diagonal of the inverse: the variances, where the matrix is an information matrix.
    pub fn inverse_diagonal(&self) -> Vec<f64> {
        let n = self.size;
        let mut diagonal = vec![0.0; n];
        let mut column = vec![0.0; n];
        for (i, out) in diagonal.iter_mut().enumerate() {
            column.fill(0.0);
            column[i] = 1.0;
            self.solve(&mut column);
            *out = column[i];
        }
        diagonal
    }
}

/// Turns the lower triangle of a symmetric matrix, given row by row (`size * size` entries), into its factor; the same as
/// [`Cholesky::new`], in the caller's own room. False where the matrix is not positive definite; it is then of no use.
pub fn factorize(size: usize, matrix: &mut [f64]) -> bool {
    for j in 0..size {
        let (above, rest) = matrix.split_at_mut(j * size);
        let row = &mut rest[..size];
        for k in 0..j {
            let other = &above[k * size..k * size + k + 1];
            let sum: f64 = other[..k].iter().zip(&row[..k]).map(|(a, b)| a * b).sum();
            row[k] = (row[k] - sum) / other[k];
        }
        let square = row[j] - row[..j].iter().map(|x| x * x).sum::<f64>();
        // A NaN is not above zero either.
        if !(square > 0.0 && square.is_finite()) {
            return false;
        }
        row[j] = square.sqrt();
    }
    true
}

/// Solves `A x = b` with the factor that [`factorize`] left: `b` (`size` entries) becomes `x`.
pub fn substitute(size: usize, factor: &[f64], b: &mut [f64]) {
    let (n, l) = (size, factor);
    for i in 0..n {
        let sum: f64 = l[i * n..i * n + i].iter().zip(&b[..i]).map(|(l, x)| l * x).sum();
        b[i] = (b[i] - sum) / l[i * n + i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| l[k * n + i] * b[k]).sum();
        b[i] = (b[i] - sum) / l[i * n + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::RandomStream;

    #[test]
    fn solves_and_inverts_and_refuses() {
        let mut random = RandomStream::new(11, 3);
        for n in [1, 2, 5, 30] {
            let b: Vec<f64> = (0..n * n).map(|_| random.normal()).collect();
            let entry = |i: usize, j: usize| {
                let product: f64 = (0..n).map(|k| b[i * n + k] * b[j * n + k]).sum();
                product + if i == j { 0.5 } else { 0.0 }
            };
            let matrix: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            let solver = Cholesky::new(n, &matrix).unwrap();
            let wanted: Vec<f64> = (0..n).map(|_| random.normal()).collect();
            let mut x: Vec<f64> = (0..n).map(|i| (0..n).map(|j| matrix[i * n + j] * wanted[j]).sum()).collect();
            solver.solve(&mut x);
            let worst = x.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-9, "{n}: {worst:.1e}");
            let diagonal = solver.inverse_diagonal();
            let mut unit = vec![0.0; n];
            unit[n - 1] = 1.0;
            solver.solve(&mut unit);
            assert!((diagonal[n - 1] - unit[n - 1]).abs() < 1e-12 && diagonal.iter().all(|d| *d > 0.0));
        }
        assert!(Cholesky::new(2, &[1.0, 2.0, 2.0, 1.0]).is_none(), "indefinite");
        assert!(Cholesky::new(1, &[f64::NAN]).is_none());
        assert!(Cholesky::new(2, &[1.0]).is_none());
    }
}
