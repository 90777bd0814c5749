//! A field of heights over a horizontal grid: rough ground.

use crate::contact::GeometryHit;
use crate::math::{Real, Vec3};
use glam::DVec3;

/// Heights at the nodes of a square grid, interpolated bilinearly; flat at the border height beyond the grid. All of it may be tilted.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    origin: DVec3,
    spacing: f64,
    columns: usize,
    rows: usize,
    heights: Vec<f64>,
    /// By how much it rises along -z besides, from z = 0 on, m per m.
    slope: f64,
    /// Cosine of an angle that no slope of the field exceeds.
    steepest: f64,
}

/// Why a height field was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HeightFieldError {
    /// The grid is too small or its number of heights does not fit.
    #[error("height field of {columns} x {rows} nodes has {found} heights; it needs at least 2 x 2 nodes and {} heights", columns * rows)]
    Size {
        /// Nodes along x.
        columns: usize,
        /// Nodes along z.
        rows: usize,
        /// Heights given.
        found: usize,
    },
    /// A number is not usable.
    #[error("height field: {field} is {value}; {valid}")]
    Value {
        /// Which number.
        field: &'static str,
        /// What it is.
        value: f64,
        /// What would be valid.
        valid: &'static str,
    },
}

impl HeightField {
    /// A field whose node (column i, row j) lies at `origin + (i * spacing, heights[j * columns + i], j * spacing)`, m.
    pub fn new(
        origin: DVec3,
        spacing: f64,
        columns: usize,
        rows: usize,
        heights: Vec<f64>,
    ) -> Result<Self, HeightFieldError> {
        if columns < 2 || rows < 2 || columns.checked_mul(rows) != Some(heights.len()) {
            return Err(HeightFieldError::Size { columns, rows, found: heights.len() });
        }
        if !(spacing.is_finite() && spacing > 0.0) {
            return Err(HeightFieldError::Value { field: "spacing", value: spacing, valid: "a positive length in m" });
        }
        let bad = heights.iter().chain(&origin.to_array()).copied().find(|h| !h.is_finite());
        if let Some(value) = bad {
            return Err(HeightFieldError::Value { field: "height", value, valid: "a finite length in m" });
        }
        Ok(Self { origin, spacing, columns, rows, heights, slope: 0.0, steepest: 1.0 }.tilted(0.0))
    }

    /// The same field, rising by `slope` (m per m) along -z besides: by nothing at z = 0.
    pub fn tilted(mut self, slope: f64) -> Self {
        // Bilinear slopes lie between those of the cells' edges.
        let (mut along_x, mut along_z) = (0.0_f64, 0.0_f64);
        let (heights, columns, spacing) = (&self.heights, self.columns, self.spacing);
        for (k, height) in heights.iter().enumerate() {
            if (k + 1) % columns != 0 {
                along_x = along_x.max((heights[k + 1] - height).abs() / spacing);
            }
            if k + columns < heights.len() {
                along_z = along_z.max((heights[k + columns] - height).abs() / spacing);
            }
        }
        along_z += slope.abs();
        self.steepest = 1.0 / (1.0 + along_x * along_x + along_z * along_z).sqrt();
        self.slope = slope;
        self
    }

    /// Height and its slopes along x and z at one place.
    fn sample(&self, x: f64, z: f64) -> (f64, f64, f64) {
        let place = |v: f64, count: usize| {
            let v = (v / self.spacing).clamp(0.0, (count - 1) as f64);
            let cell = (v as usize).min(count - 2);
            (cell, v - cell as f64)
        };
        let (u, v) = (x - self.origin.x, z - self.origin.z);
        let ((i, s), (j, t)) = (place(u, self.columns), place(v, self.rows));
        let h = |i: usize, j: usize| self.heights[j * self.columns + i];
        let (a, b, c, d) = (h(i, j), h(i + 1, j), h(i, j + 1), h(i + 1, j + 1));
        let height = self.origin.y + (a * (1.0 - s) + b * s) * (1.0 - t) + (c * (1.0 - s) + d * s) * t;
        let inside = |v: f64, count: usize| v >= 0.0 && v <= (count - 1) as f64 * self.spacing;
        let slope_x = ((b - a) * (1.0 - t) + (d - c) * t) / self.spacing;
        let slope_z = ((c - a) * (1.0 - s) + (d - b) * s) / self.spacing;
        let slope_x = if inside(u, self.columns) { slope_x } else { 0.0 };
        let slope_z = if inside(v, self.rows) { slope_z } else { 0.0 };
        (height - self.slope * z, slope_x, slope_z - self.slope)
    }

    /// Distance along the local normal: exact on a slope, of first order elsewhere. Non-finite points are far away.
    pub fn signed_distance<R: Real>(&self, point: Vec3<R>) -> GeometryHit<R> {
        let mut distance = R::zero();
        let mut normal = Vec3::zero();
        for lane in 0..R::LANES {
            let p = point.lane(lane);
            if !p.is_finite() {
                distance.set_lane(lane, 1e9);
                normal.set_lane(lane, DVec3::Y);
                continue;
            }
            let (height, slope_x, slope_z) = self.sample(p.x, p.z);
            let n = DVec3::new(-slope_x, 1.0, -slope_z).normalize();
            distance.set_lane(lane, (p.y - height) * n.y);
            normal.set_lane(lane, n);
        }
        GeometryHit { distance, normal }
    }

    /// A lower bound of the distance to the field: no part of it is steeper than its steepest slope. The distance along
    /// the local normal is none: above a level cell it knows nothing of the ramp beside it.
    pub fn clearance<R: Real>(&self, point: Vec3<R>) -> R {
        R::from_lanes(|lane| {
            let p = point.lane(lane);
            if p.is_finite() { (p.y - self.height(p.x, p.z)) * self.steepest } else { 1e9 }
        })
    }

    /// Height (m) and outward unit normal of the ground in the vertical line through `point`, lane by lane. Of a point that is
    /// not finite, that at the field's origin.
    pub fn surface<R: Real>(&self, point: Vec3<R>) -> (R, Vec3<R>) {
        let (mut height, mut normal) = (R::zero(), Vec3::zero());
        for lane in 0..R::LANES {
            let p = point.lane(lane);
            let p = if p.is_finite() { p } else { self.origin };
            let (y, slope_x, slope_z) = self.sample(p.x, p.z);
            height.set_lane(lane, y);
            normal.set_lane(lane, DVec3::new(-slope_x, 1.0, -slope_z).normalize());
        }
        (height, normal)
    }

    /// Height of the ground at a place, m.
    pub fn height(&self, x: f64, z: f64) -> f64 {
        self.sample(x, z).0
    }
}
