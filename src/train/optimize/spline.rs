//! A cubic B-spline over the ticks of a control, with knots that follow the windows.

/// Basis functions that do not vanish at a place.
pub(super) const ORDER: usize = 4;

/// Knots at the ends of windows and between them. Control point `j` belongs to the basis function whose support begins at
/// knot `j`: it changes nothing before that, so windows before it stay as they are. The three basis functions that begin
/// ahead of the motion are left out: offsets start from zero, with zero slope and curvature.
#[derive(Clone, Debug)]
pub(super) struct KnotGrid {
    /// Knots, in ticks.
    knots: Vec<f64>,
    /// Index of the knot at the start of each window, and of the last one.
    starts: Vec<usize>,
}

impl KnotGrid {
    /// For windows that end at these ticks, the first one beginning at tick 0, with knots no further apart than
    /// `spacing` ticks.
    pub fn new(ends: &[usize], spacing: f64) -> Self {
        let mut knots = vec![0.0];
        let mut starts = vec![0];
        let mut from = 0.0;
        for &end in ends {
            let length = end as f64 - from;
            let count = (length / spacing - 1e-9).ceil().max(1.0) as usize;
            knots.extend((1..=count).map(|k| from + length * k as f64 / count as f64));
            starts.push(knots.len() - 1);
            from = end as f64;
        }
        Self { knots, starts }
    }

    /// Control points that begin in windows `first..last`.
    pub fn points(&self, first: usize, last: usize) -> core::ops::Range<usize> {
        let at = |w: usize| self.starts[w.min(self.starts.len() - 1)];
        at(first)..at(last)
    }

    /// Number of control points.
    pub fn count(&self) -> usize {
        self.knots.len() - 1
    }

    /// The knot with index `k`; beyond both ends at the distance of the last two.
    fn knot(&self, k: isize) -> f64 {
        let last = self.knots.len() as isize - 1;
        if k < 0 {
            self.knots[0] + k as f64 * (self.knots[1] - self.knots[0])
        } else if k > last {
            let (a, b) = (self.knots[last as usize - 1], self.knots[last as usize]);
            b + (k - last) as f64 * (b - a)
        } else {
            self.knots[k as usize]
        }
    }

    /// Control points and their weights at the place `u` (ticks): the recursion of Cox and de Boor (de Boor 1978, "A
    /// Practical Guide to Splines"), as a triangle. Points ahead of the motion have no index.
    pub fn basis(&self, u: f64) -> [(Option<usize>, f64); ORDER] {
        let interval = self.knots.partition_point(|k| *k <= u).clamp(1, self.knots.len() - 1) - 1;
        let m = interval as isize;
        let mut weights = [1.0, 0.0, 0.0, 0.0];
        for degree in 1..ORDER {
            let mut carried = 0.0;
            for (r, weight) in weights[..degree].iter_mut().enumerate() {
                let left = self.knot(m + 1 + r as isize - degree as isize);
                let right = self.knot(m + 1 + r as isize);
                let part = *weight / (right - left);
                *weight = carried + (right - u) * part;
                carried = (u - left) * part;
            }
            weights[degree] = carried;
        }
        core::array::from_fn(|k| (usize::try_from(m - 3 + k as isize).ok(), weights[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(grid: &KnotGrid, points: &[f64], u: f64) -> f64 {
        grid.basis(u).iter().map(|(j, w)| j.map_or(0.0, |j| points[j] * w)).sum()
    }

    fn grid() -> KnotGrid {
        KnotGrid::new(&[40, 65, 110], 14.0)
    }

    #[test]
    fn weights_are_not_negative_and_add_up_to_one() {
        let grid = grid();
        assert_eq!(grid.count(), 3 + 2 + 4);
        assert_eq!((grid.points(0, 1), grid.points(1, 3), grid.points(2, 9)), (0..3, 3..9, 5..9));
        for tick in 0..=220 {
            let basis = grid.basis(0.5 * f64::from(tick));
            assert!(basis.iter().all(|(_, w)| *w >= 0.0));
            assert!((basis.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_point_changes_nothing_before_its_knot() {
        let grid = grid();
        for window in 0..3 {
            let points: Vec<f64> = (0..grid.count()).map(|j| f64::from(j >= grid.points(window, 3).start)).collect();
            let start = [0.0, 40.0, 65.0][window];
            for k in 0..100 {
                assert_eq!(value(&grid, &points, start * f64::from(k) / 100.0), 0.0);
            }
            assert!(value(&grid, &points, start + 1.0) > 0.0);
        }
    }

    #[test]
    fn slope_and_curvature_are_continuous_across_uneven_knots() {
        let grid = grid();
        let points: Vec<f64> = (0..grid.count()).map(|j| ((j * 7 + 3) % 5) as f64 - 2.0).collect();
        let h = 1e-3;
        for knot in [40.0 / 3.0, 40.0, 52.5, 65.0, 76.25] {
            // Second differences just before and just after the knot; a jump of curvature would show at once.
            let second = |u: f64| {
                (value(&grid, &points, u + h) - 2.0 * value(&grid, &points, u) + value(&grid, &points, u - h)) / (h * h)
            };
            let (before, after) = (second(knot - 2.0 * h), second(knot + 2.0 * h));
            assert!((before - after).abs() < 1e-4, "at {knot}: {before}, {after}");
        }
    }
}
