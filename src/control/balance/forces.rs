//! Forces inside friction cones that come nearest to a wished wrench.
//!
//! Each point pushes along the four edges of a pyramid inside its friction cone, by factors that are not negative:
//!
//! ```text
//! minimise  1/2 (G x - w)^T Q (G x - w) + eps/2 |x|^2   over x >= 0
//! ```
//!
//! G has a column for each edge: the force, and its moment about the middle of the support. The optimum is `x = max(0, G^T y) / eps`
//! with the six multipliers `y = Q (w - G x)`, so that the programme is one of six unknowns however many points there are: `y` is the
//! minimum of a convex, piecewise quadratic function, found by Newton steps with a line search (the dual of a strictly convex
//! quadratic programme; Mangasarian 2006, "Absolute value equation solution via concave minimization", has the kind of step). Sums in a fixed
//! order, no random choice: the same bits everywhere.

use crate::math::{factorize, substitute};
use glam::DVec3;

/// Edges of a point's pyramid.
const EDGES: usize = 4;
/// Unit of length for moments, m: about half a foot, so that moments and forces are of like size.
pub(super) const LEVER: f64 = 0.1;
/// eps: weight of the factors, which spreads a wrench over the points, 1/N^2 of a force's weight.
const SPREAD: f64 = 1e-5;
/// Most Newton steps.
const STEPS: usize = 40;

/// A point that carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupportPoint {
    /// Link index.
    pub link: usize,
    /// Index of the contact point.
    pub index: usize,
    /// Where it touches, relative to the root's origin, world axes, m.
    pub place: DVec3,
    /// Unit normal of the ground there.
    pub normal: DVec3,
    /// How readily it carries, above 0 to 1: little for a point that is about to leave the ground or to reach it.
    pub share: f64,
}

/// What is missing counts so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceWeights {
    /// Of a newton along the ground.
    pub force: f64,
    /// Of a newton upwards.
    pub upward: f64,
    /// Of a newton metre about the middle of the support.
    pub moment: f64,
}

/// The programme with its room. Allocates only when more points come than it has room for.
#[derive(Clone, Debug)]
pub struct ConeForces {
    points: Vec<SupportPoint>,
    /// Edge directions, four a point.
    edges: Vec<DVec3>,
    /// Force and scaled moment of each edge.
    columns: Vec<[f64; 6]>,
    factors: Vec<f64>,
    multipliers: [f64; 6],
    middle: DVec3,
    steps: usize,
}

impl ConeForces {
    /// Room for so many points.
    pub fn new(points: usize) -> Self {
        Self {
            points: Vec::with_capacity(points),
            edges: Vec::with_capacity(EDGES * points),
            columns: Vec::with_capacity(EDGES * points),
            factors: Vec::with_capacity(EDGES * points),
            multipliers: [0.0; 6],
            middle: DVec3::ZERO,
            steps: 0,
        }
    }

    /// The points.
    pub fn points(&self) -> &[SupportPoint] {
        &self.points
    }
    /// What moments are counted about, relative to the root's origin, m.
    pub fn middle(&self) -> DVec3 {
        self.middle
    }
    /// Newton steps of the last solution.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Forgets all points.
    pub fn clear(&mut self) {
        self.points.clear();
        self.edges.clear();
        self.columns.clear();
        self.factors.clear();
    }
    /// Adds a point.
    pub fn push(&mut self, point: SupportPoint) {
        self.points.push(point);
    }

    /// Makes the edges: friction `friction`; moments are counted about `middle` (relative to the root's origin, world axes, m), levers
    /// shortened by the part `margin`, so that the centre of pressure keeps away from the edge of the support.
    pub fn build(&mut self, friction: f64, margin: f64, middle: DVec3) {
        self.edges.clear();
        self.columns.clear();
        self.factors.clear();
        self.middle = middle;
        for p in &self.points {
            let aside = if p.normal.z.abs() < 0.9 { DVec3::Z } else { DVec3::X };
            let u = (aside - p.normal * aside.dot(p.normal)).normalize();
            let v = p.normal.cross(u);
            let arm = (p.place - self.middle) * (1.0 - margin);
            for across in [u, v, -u, -v] {
                // A pyramid inside the cone: its edges lie on it.
                let edge = (p.normal + across * friction) * p.share;
                let moment = arm.cross(edge) / LEVER;
                self.edges.push(edge);
                self.columns.push([edge.x, edge.y, edge.z, moment.x, moment.y, moment.z]);
                self.factors.push(0.0);
            }
        }
    }

    /// Finds the factors for a wished force (N) and moment about the middle (N m), and returns what they give.
    pub fn solve(&mut self, force: DVec3, moment: DVec3, weights: ForceWeights) -> (DVec3, DVec3) {
        if self.columns.is_empty() {
            self.multipliers = [0.0; 6];
            return (DVec3::ZERO, DVec3::ZERO);
        }
        let m = moment / LEVER;
        let wish = [force.x, force.y, force.z, m.x, m.y, m.z];
        let (f, u, t) = (weights.force, weights.upward, weights.moment * LEVER * LEVER);
        let compliance = [f, u, f, t, t, t].map(|weight| 1.0 / weight.max(1e-12));
        let small = 1e-9 * (1.0 + wish.iter().map(|x| x.abs()).fold(0.0, f64::max));
        let mut y = self.multipliers;
        if !y.iter().all(|x| x.is_finite()) {
            y = [0.0; 6];
        }
        let mut value = self.dual(&y, &compliance, &wish);
        self.steps = 0;
        for _ in 0..STEPS {
            let mut gradient = [0.0; 6];
            let mut hessian = [0.0; 36];
            for (k, g) in gradient.iter_mut().enumerate() {
                *g = compliance[k] * y[k] - wish[k];
                hessian[7 * k] = compliance[k];
            }
            for column in &self.columns {
                let s = dot(column, &y);
                if s > 0.0 {
                    for (a, (entry, g)) in column.iter().zip(&mut gradient).enumerate() {
                        *g += entry * (s / SPREAD);
                        for (b, other) in column[..=a].iter().enumerate() {
                            hessian[6 * a + b] += entry * other / SPREAD;
                        }
                    }
                }
            }
            if gradient.iter().all(|g| g.abs() < small) || !factorize(6, &mut hessian) {
                break;
            }
            self.steps += 1;
            let mut step = gradient.map(|g| -g);
            substitute(6, &hessian, &mut step);
            let slope = dot(&gradient, &step);
            let mut length = 1.0;
            let mut moved = false;
            for _ in 0..30 {
                let tried: [f64; 6] = std::array::from_fn(|k| y[k] + length * step[k]);
                let there = self.dual(&tried, &compliance, &wish);
                if there <= value + 1e-4 * length * slope {
                    (y, value, moved) = (tried, there, true);
                    break;
                }
                length *= 0.5;
            }
            if !moved {
                break;
            }
        }
        self.multipliers = y;
        let mut sum = [0.0; 6];
        for (factor, column) in self.factors.iter_mut().zip(&self.columns) {
            *factor = dot(column, &y).max(0.0) / SPREAD;
            for (total, entry) in sum.iter_mut().zip(column) {
                *total += *factor * entry;
            }
        }
        (DVec3::new(sum[0], sum[1], sum[2]), DVec3::new(sum[3], sum[4], sum[5]) * LEVER)
    }

    /// The six multipliers of the last solution.
    pub(super) fn multipliers(&self) -> &[f64; 6] {
        &self.multipliers
    }

    /// The factors that belong to these multipliers, for edges that are built.
    pub(super) fn restore(&mut self, multipliers: [f64; 6]) {
        self.multipliers = multipliers;
        for (factor, column) in self.factors.iter_mut().zip(&self.columns) {
            *factor = dot(column, &multipliers).max(0.0) / SPREAD;
        }
    }

    /// The dual function that `y` is the minimum of.
    fn dual(&self, y: &[f64; 6], compliance: &[f64; 6], wish: &[f64; 6]) -> f64 {
        let quadratic: f64 = (0..6).map(|k| 0.5 * compliance[k] * y[k] * y[k] - wish[k] * y[k]).sum();
        let cones: f64 = self.columns.iter().map(|c| dot(c, y).max(0.0)).map(|s| s * s).sum();
        quadratic + 0.5 * cones / SPREAD
    }

    /// Force at each point, world axes, N.
    pub fn forces(&self) -> impl Iterator<Item = (&SupportPoint, DVec3)> {
        let edges = self.edges.chunks_exact(EDGES).zip(self.factors.chunks_exact(EDGES));
        let sum = |(edges, factors): (&[DVec3], &[f64])| edges.iter().zip(factors).map(|(e, f)| *e * *f).sum::<DVec3>();
        self.points.iter().zip(edges.map(sum))
    }
}

fn dot(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
}
