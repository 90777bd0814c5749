//! Accelerations of all degrees of freedom, from one linear system.
//!
//! Equation 6 of Park, Yu, Lee 2018: tracking, momentum and support are quadratic in the accelerations `a`. Momentum and support are rows
//! `C a = e` with a compliance each (the inverse of a weight; a constraint has a small one, which also keeps rows apart that depend on
//! each other, as those of several segments of one foot do), tracking has a weight for each degree of freedom:
//!
//! ```text
//! minimise (a - t)^T D (a - t) + (C a - e)^T S^-1 (C a - e)
//! (C D^-1 C^T + S) z = e - C t,      a = t + D^-1 C^T z
//! ```
//!
//! The system has as many unknowns as there are rows. C is kept by columns, of which each touches few supports.

use crate::math::{factorize, substitute};

/// The system with its room.
#[derive(Clone, Debug)]
pub(super) struct Accelerations {
    dof: usize,
    most: usize,
    rows: usize,
    /// C, column by column, `most` entries each.
    columns: Vec<f64>,
    /// e.
    pub wish: Vec<f64>,
    /// S.
    pub compliance: Vec<f64>,
    /// t, by degree of freedom.
    pub track: Vec<f64>,
    /// D.
    pub weights: Vec<f64>,
    matrix: Vec<f64>,
    multipliers: Vec<f64>,
    touched: Vec<usize>,
    /// The solution.
    pub solution: Vec<f64>,
}

impl Accelerations {
    pub(super) fn new(dof: usize, most: usize) -> Self {
        Self {
            dof,
            most,
            rows: 0,
            columns: vec![0.0; dof * most],
            wish: vec![0.0; most],
            compliance: vec![1.0; most],
            track: vec![0.0; dof],
            weights: vec![1.0; dof],
            matrix: vec![0.0; most * most],
            multipliers: vec![0.0; most],
            touched: Vec::with_capacity(most),
            solution: vec![0.0; dof],
        }
    }

    /// Begins a system of so many rows, all zero.
    pub(super) fn begin(&mut self, rows: usize) {
        self.rows = rows.min(self.most);
        self.columns.fill(0.0);
        self.wish.fill(0.0);
        self.compliance.fill(1.0);
    }

    /// Sets an entry of C.
    pub(super) fn set(&mut self, row: usize, dof: usize, value: f64) {
        if row < self.rows && dof < self.dof {
            self.columns[dof * self.most + row] = value;
        }
    }

    /// Solves it; false, and the tracking accelerations alone, where the system is not regular.
    pub(super) fn solve(&mut self) -> bool {
        let (n, most) = (self.rows, self.most);
        let matrix = &mut self.matrix[..n * n];
        matrix.fill(0.0);
        self.multipliers[..n].copy_from_slice(&self.wish[..n]);
        for k in 0..n {
            matrix[k * n + k] = self.compliance[k];
        }
        for dof in 0..self.dof {
            let column = &self.columns[dof * most..dof * most + n];
            self.touched.clear();
            self.touched.extend((0..n).filter(|&k| column[k] != 0.0));
            let mobility = 1.0 / self.weights[dof];
            for (at, &a) in self.touched.iter().enumerate() {
                let scaled = column[a] * mobility;
                for &b in &self.touched[..=at] {
                    matrix[a * n + b] += scaled * column[b];
                }
                self.multipliers[a] -= column[a] * self.track[dof];
            }
        }
        self.solution.copy_from_slice(&self.track);
        if !factorize(n, matrix) {
            return false;
        }
        substitute(n, matrix, &mut self.multipliers[..n]);
        for dof in 0..self.dof {
            let column = &self.columns[dof * most..dof * most + n];
            let sum: f64 = column.iter().zip(&self.multipliers).map(|(c, z)| c * z).sum();
            self.solution[dof] += sum / self.weights[dof];
        }
        true
    }
}
