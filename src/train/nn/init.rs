//! Orthogonal matrices for the first weights.

use crate::math::RandomStream;

/// A random rows x columns matrix, row-major, whose rows (or columns, if those are fewer) are orthonormal: Gram-Schmidt on normal numbers.
pub(super) fn orthogonal(rows: usize, columns: usize, random: &mut RandomStream) -> Vec<f64> {
    let (count, length) = (rows.min(columns), rows.max(columns));
    let mut vectors: Vec<Vec<f64>> = Vec::with_capacity(count);
    while vectors.len() < count {
        let mut vector: Vec<f64> = (0..length).map(|_| random.normal()).collect();
        // Twice is enough (Giraud, Langou, Rozloznik 2005).
        for _ in 0..2 {
            for other in &vectors {
                let along = dot(&vector, other);
                vector.iter_mut().zip(other).for_each(|(value, other)| *value -= along * other);
            }
        }
        let norm = dot(&vector, &vector).sqrt();
        if norm > 1e-6 {
            vectors.push(vector.into_iter().map(|value| value / norm).collect());
        }
    }
    (0..rows * columns)
        .map(|at| {
            let (row, column) = (at / columns, at % columns);
            if rows <= columns { vectors[row][column] } else { vectors[column][row] }
        })
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
