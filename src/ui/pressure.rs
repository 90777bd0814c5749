//! Pressure under a sole from the forces at its points, and the way of its centre over the last seconds. Numbers alone, nothing is drawn here.
//!
//! A simulated sole touches at points, where pressure is not defined. The picture spreads each force over a disc, so it has the force and, to a
//! fraction of a cell, the centre that the sole has; how far it spreads is chosen, not measured.

use crate::ui::plate_view::{PlateFoot, PlateView};
use glam::DVec2;
use std::collections::VecDeque;

/// A foot that bears less has no centre of pressure worth a path, N.
const LEAST: f64 = 5.0;

/// Pressure on a grid over the plate: to the right, and ahead, as in the zero pose.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureGrid {
    /// Corner of the first cell: the smallest coordinates, m.
    pub low: DVec2,
    /// Edge of a cell, m.
    pub cell: f64,
    /// Cells to the right.
    pub columns: usize,
    /// Cells ahead.
    pub rows: usize,
    /// Pressure of each cell, Pa; cell (column i, row j) is number `j * columns + i`.
    pub values: Vec<f64>,
}

impl PressureGrid {
    /// How much farther than the radius of its point a force spreads, m.
    pub const SPREAD: f64 = 0.012;
    /// Most cells of a grid.
    const MOST: usize = 1 << 16;

    /// The pressure under the points of a foot, in cells of the edge `cell` (m); `None` without points, or where the cells would be too many.
    ///
    /// A force `F` at a point is spread over the disc of the radius `R` = its radius + [`PressureGrid::SPREAD`] as `(1 - d^2 / R^2)^2`, scaled so that the
    /// cells bear `F` to rounding. Forces that press nowhere are left out.
    pub fn of(foot: &PlateFoot, cell: f64) -> Option<Self> {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in &foot.points {
            let reach = point.radius + Self::SPREAD + cell;
            low = low.min(point.place - reach);
            high = high.max(point.place + reach);
        }
        let size = ((high - low) / cell).ceil();
        if foot.points.is_empty() || !(size.is_finite() && size.x * size.y <= Self::MOST as f64) {
            return None;
        }
        let (columns, rows) = (size.x as usize, size.y as usize);
        let mut grid = Self { low, cell, columns, rows, values: vec![0.0; columns * rows] };
        for point in foot.points.iter().filter(|point| point.force > 0.0) {
            grid.spread(point.place, point.radius + Self::SPREAD, point.force);
        }
        Some(grid)
    }

    /// Middle of a cell, m.
    pub fn middle(&self, column: usize, row: usize) -> DVec2 {
        self.low + (DVec2::new(column as f64, row as f64) + 0.5) * self.cell
    }

    /// The force that all cells bear, N.
    pub fn force(&self) -> f64 {
        self.values.iter().sum::<f64>() * self.cell * self.cell
    }

    /// Largest pressure, Pa.
    pub fn peak(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }

    /// Centre of pressure, m; `None` without any.
    pub fn center(&self) -> Option<DVec2> {
        let (mut moment, mut sum) = (DVec2::ZERO, 0.0);
        for (k, value) in self.values.iter().enumerate() {
            moment += self.middle(k % self.columns, k / self.columns) * *value;
            sum += value;
        }
        (sum > 0.0).then(|| moment / sum)
    }

    fn spread(&mut self, place: DVec2, radius: f64, force: f64) {
        let shape = |d2: f64| (1.0 - d2 / (radius * radius)).max(0.0).powi(2);
        let index = |x: f64, count: usize| (x / self.cell).max(0.0).min(count as f64 - 1.0) as usize;
        let (from, to) = (place - radius - self.low, place + radius - self.low);
        let columns = index(from.x, self.columns)..=index(to.x, self.columns);
        let rows = index(from.y, self.rows)..=index(to.y, self.rows);
        let cells = |j: usize| columns.clone().map(move |i| (i, j));
        let weight: f64 =
            rows.clone().flat_map(cells).map(|(i, j)| shape(self.middle(i, j).distance_squared(place))).sum();
        if weight <= 0.0 {
            return;
        }
        let scale = force / (weight * self.cell * self.cell);
        for (i, j) in rows.flat_map(cells).collect::<Vec<_>>() {
            self.values[j * self.columns + i] += scale * shape(self.middle(i, j).distance_squared(place));
        }
    }
}

/// Both centres of pressure at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PathSample {
    /// Simulated time, s.
    time: f64,
    /// Left and right, on the plate, m; `None` while the foot bears nothing.
    centers: [Option<DVec2>; 2],
}

/// A place of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPlace {
    /// Where it was, on the plate, m.
    pub place: DVec2,
    /// How old that is as a part of what is kept: 0 is now, 1 about to be forgotten.
    pub age: f64,
}

/// The way of the centres of pressure over the last seconds, in the frames of the feet. Holds at most [`PressurePath::CAPACITY`] moments.
#[derive(Clone, Debug)]
pub struct PressurePath {
    samples: VecDeque<PathSample>,
    seconds: f64,
}

impl Default for PressurePath {
    fn default() -> Self {
        Self::new(4.0)
    }
}

impl PressurePath {
    /// Most moments that are kept, whatever their times.
    pub const CAPACITY: usize = 2048;

    /// Keeps the last `seconds` of simulated time (0.1 to 60 s).
    pub fn new(seconds: f64) -> Self {
        let seconds = if seconds.is_finite() { seconds.clamp(0.1, 60.0) } else { 4.0 };
        Self { samples: VecDeque::new(), seconds }
    }

    /// Adds what the feet bear at a time (s). A time before the last one (the athlete was put back) starts anew; the same time again is left out.
    pub fn push(&mut self, time: f64, view: &PlateView) {
        match self.samples.back() {
            Some(last) if time == last.time => return,
            Some(last) if time < last.time => self.samples.clear(),
            _ => {}
        }
        while self.samples.len() >= Self::CAPACITY
            || self.samples.front().is_some_and(|first| time - first.time > self.seconds)
        {
            self.samples.pop_front();
        }
        let center = |foot: &PlateFoot| foot.center_of_pressure().filter(|_| foot.force() >= LEAST);
        self.samples.push_back(PathSample { time, centers: view.feet.each_ref().map(center) });
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// How far back it reaches at most, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The way under a foot (0 left, 1 right), oldest first, in one piece for each time that it stood.
    pub fn runs(&self, foot: usize) -> Vec<Vec<PathPlace>> {
        let now = self.samples.back().map_or(0.0, |last| last.time);
        let mut runs: Vec<Vec<PathPlace>> = Vec::new();
        let mut standing = false;
        for sample in &self.samples {
            let center = sample.centers.get(foot).copied().flatten();
            if let Some(place) = center {
                if !standing {
                    runs.push(Vec::new());
                }
                let age = (now - sample.time) / self.seconds;
                if let Some(run) = runs.last_mut() {
                    run.push(PathPlace { place, age });
                }
            }
            standing = center.is_some();
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::RandomStream;
    use crate::ui::plate_view::PlatePoint;

    fn point(x: f64, y: f64, force: f64) -> PlatePoint {
        PlatePoint { name: String::new(), place: DVec2::new(x, y), radius: 0.01, force, segment: None }
    }

    fn foot(points: Vec<PlatePoint>) -> PlateFoot {
        PlateFoot { points, ..PlateFoot::default() }
    }

    #[test]
    fn the_picture_bears_the_forces_and_has_their_centre() {
        let mut random = RandomStream::new(20, 7);
        for _ in 0..50 {
            let mut draw = |low, high| random.range(low, high);
            let points = (0..16).map(|_| point(draw(-0.05, 0.05), draw(-0.1, 0.1), draw(-20.0, 80.0))).collect();
            let foot = foot(points);
            let pressing = PlateFoot {
                points: foot.points.iter().filter(|p| p.force > 0.0).cloned().collect(),
                ..PlateFoot::default()
            };
            let grid = PressureGrid::of(&foot, 0.004).unwrap();
            assert!((grid.force() - pressing.force()).abs() < 1e-9 * pressing.force(), "{}", grid.force());
            let apart = grid.center().unwrap().distance(pressing.center_of_pressure().unwrap());
            assert!(apart < 0.1 * grid.cell, "{apart} m");
            assert!(grid.values.iter().all(|p| *p >= 0.0));
        }
    }

    #[test]
    fn finer_cells_come_to_the_pressure_of_the_disc() {
        // The integral of (1 - d^2 / R^2)^2 over the disc is pi R^2 / 3.
        let radius = 0.01 + PressureGrid::SPREAD;
        let peak = 3.0 * 100.0 / (core::f64::consts::PI * radius * radius);
        let off = |cell: f64| {
            (PressureGrid::of(&foot(vec![point(0.0, 0.0, 100.0)]), cell).unwrap().peak() / peak - 1.0).abs()
        };
        println!("off by {:.4} at 4 mm, {:.5} at 0.5 mm", off(0.004), off(0.0005));
        assert!(off(0.0005) < 0.002 && off(0.004) < 0.1);
    }

    #[test]
    fn nothing_to_stand_on_and_too_many_cells_have_no_picture() {
        assert_eq!(PressureGrid::of(&PlateFoot::default(), 0.004), None);
        let two = foot(vec![point(0.0, 0.0, 1.0), point(100.0, 100.0, 1.0)]);
        assert_eq!(PressureGrid::of(&two, 0.004), None);
        assert_eq!(PressureGrid::of(&two, 0.0), None);
        let still = PressureGrid::of(&foot(vec![point(0.0, 0.0, 0.0)]), 0.004).unwrap();
        assert_eq!((still.force(), still.peak(), still.center()), (0.0, 0.0, None));
    }

    fn view(left: Option<f64>, right: Option<f64>) -> PlateView {
        let stands = |x: Option<f64>| foot(x.map(|x| point(x, 0.0, 200.0)).into_iter().collect());
        PlateView { feet: [stands(left), stands(right)], ..PlateView::default() }
    }

    #[test]
    fn a_path_has_a_piece_for_each_time_that_the_foot_stood() {
        let mut path = PressurePath::new(10.0);
        for k in 0..30 {
            let stood = !(10..20).contains(&k);
            path.push(f64::from(k) * 0.1, &view(stood.then_some(f64::from(k)), Some(0.0)));
        }
        let runs = path.runs(0);
        assert_eq!(runs.iter().map(Vec::len).collect::<Vec<_>>(), [10, 10]);
        assert_eq!(runs[1][9], PathPlace { place: DVec2::new(29.0, 0.0), age: 0.0 });
        assert!((runs[0][0].age - 0.29).abs() < 1e-12, "{:?}", runs[0][0]);
        assert_eq!(path.runs(1).len(), 1);
        assert!(path.runs(2).is_empty(), "there is no third foot");
    }

    #[test]
    fn a_path_forgets_what_is_old_and_begins_anew_when_time_goes_back() {
        let mut path = PressurePath::new(1.0);
        for k in 0..10_000 {
            path.push(f64::from(k) * 1e-4, &view(Some(0.0), None));
        }
        assert!(path.runs(0)[0].len() <= PressurePath::CAPACITY);
        path.push(5.0, &view(Some(1.0), None));
        assert_eq!(path.runs(0)[0].len(), 1, "all before is older than a second");
        path.push(5.0, &view(Some(2.0), None));
        assert_eq!(path.runs(0)[0].len(), 1, "time stands still");
        path.push(0.5, &view(Some(3.0), None));
        assert_eq!(path.runs(0), vec![vec![PathPlace { place: DVec2::new(3.0, 0.0), age: 0.0 }]]);
    }
}
