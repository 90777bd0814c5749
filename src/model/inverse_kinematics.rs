//! Inverse kinematics: the pose whose landmarks lie nearest to given positions.
//!
//! Unknowns `x`: place and rotation of the root, a rotation vector `r_j` for each joint, one scale `s` (source units in a
//! metre) and a factor `f` on the length of each link, the same left and right. Minimised is
//!
//! ```text
//! sum_i rho(w_i |s P_i(x) - y_i| / (s sigma))     landmarks P_i of the character, positions y_i
//!   + sum_j |r_j / spread_j|^2                    joints are straight unless a landmark says otherwise
//!   + sum_j |excess of r_j over its range|^2 / limit^2
//!   + (log f / length spread)^2 + (log (s / s_0) / scale spread)^2
//! ```
//!
//! with the `rho` of Huber 1964, "Robust Estimation of a Location Parameter", so that one stray landmark does not bend the
//! rest, by the method of Levenberg 1944 and Marquardt 1963, "An Algorithm for Least-Squares Estimation of Nonlinear
//! Parameters". A joint's rotation changes with its rotation vector by the right Jacobian of SO(3),
//! `R(r + d) = R(r) exp(J(r) d)`, `J = 1 - (1 - cos a) / a^2 [r] + (a - sin a) / a^3 [r]^2`, `a = |r|` (Chirikjian 2011,
//! "Stochastic Models, Information Theory, and Lie Groups", volume 2).

use super::body_landmarks::{BodyLandmark, BodyLandmarks};
use super::{CharacterModel, JointKind, ModelPose};
use crate::math::Cholesky;
use glam::{DMat3, DQuat, DVec3};

/// A position that a landmark should be at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LandmarkTarget {
    /// Where, source units.
    pub position: DVec3,
    /// Weight beyond that of the landmark, such as its visibility.
    pub weight: f64,
}

/// What is known of the size of the body before a pose is solved.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySize {
    /// Source units in a metre of the character.
    pub scale: f64,
    /// Standard deviation of the logarithm of the scale.
    pub scale_spread: f64,
    /// Length of each link as a factor on the character's, by link.
    pub lengths: Vec<f64>,
    /// Standard deviation of the logarithm of a length.
    pub length_spread: f64,
}

/// A solved pose.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseFit {
    /// Place of the root, source axes, metres of the character.
    pub root_position: DVec3,
    /// Rotation of the root.
    pub root_rotation: DQuat,
    /// Rotation vector of each joint by link, rad; entry 0 unused.
    pub joints: Vec<DVec3>,
    /// Source units in a metre of the character.
    pub scale: f64,
    /// Length of each link as a factor on the character's, by link.
    pub lengths: Vec<f64>,
    /// The sum that was minimised.
    pub cost: f64,
    /// Distance of each landmark from its position, metres of the character; `None` where there was no position.
    pub distances: Vec<Option<f64>>,
}

impl PoseFit {
    /// The pose.
    pub fn pose(&self) -> ModelPose {
        ModelPose {
            root_position: self.root_position,
            root_rotation: self.root_rotation,
            joints: self.joints.iter().map(|r| DQuat::from_scaled_axis(*r)).collect(),
        }
    }

    /// Root of the mean square distance of the landmarks, m.
    pub fn rms(&self) -> f64 {
        let (sum, count) = self.distances.iter().flatten().fold((0.0, 0), |(s, n), d| (s + d * d, n + 1));
        (sum / f64::from(count.max(1))).sqrt()
    }
}

/// Standard deviation of a landmark, m: noise of the source and what differs between people and characters.
const LANDMARK_SPREAD: f64 = 0.02;
/// Distance from which a landmark counts linearly, in standard deviations.
const HUBER: f64 = 4.0;
/// Standard deviation of the excess of a joint over its range, rad.
const LIMIT_SPREAD: f64 = 0.03;
/// Most steps from one start.
const MAX_STEPS: usize = 80;
/// A step that lowers the sum by less than this part of it is the last.
const ENOUGH: f64 = 1e-6;
/// Largest change of a joint in a step, rad.
const LARGEST_TURN: f64 = 0.7;

/// The unknowns in metres of the character; positions are relative to the centre of the problem.
#[derive(Clone, Debug)]
struct Unknowns {
    root_position: DVec3,
    root_rotation: DQuat,
    joints: Vec<DVec3>,
    log_scale: f64,
    log_lengths: Vec<f64>,
}

/// Where everything is for some unknowns.
struct Places {
    origin: Vec<DVec3>,
    rotation: Vec<DQuat>,
    length: Vec<f64>,
}

/// Normal equations `A d = -g`.
struct Equations {
    a: Vec<f64>,
    g: Vec<f64>,
}

/// Solves poses of one character from landmarks of one layout.
#[derive(Clone, Debug)]
pub struct PoseSolver<'a> {
    model: &'a CharacterModel,
    body: &'a BodyLandmarks,
    /// First unknown of each joint, by link.
    start: Vec<usize>,
    /// Number of the length of each link: partners share one.
    group: Vec<usize>,
    groups: usize,
    size: usize,
}

fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

/// The right Jacobian of SO(3).
fn right_jacobian(r: DVec3) -> DMat3 {
    let angle = r.length();
    let (b, c) = if angle < 1e-4 {
        (0.5, 1.0 / 6.0)
    } else {
        ((1.0 - angle.cos()) / (angle * angle), (angle - angle.sin()) / (angle * angle * angle))
    };
    let k = cross_matrix(r);
    DMat3::IDENTITY - k * b + k * k * c
}

impl<'a> PoseSolver<'a> {
    /// A solver for a character and its landmarks.
    pub fn new(model: &'a CharacterModel, body: &'a BodyLandmarks) -> Self {
        let mut start = Vec::with_capacity(model.links.len());
        let mut next = 6;
        let mut group = vec![0; model.links.len()];
        let mut groups = 0;
        for (i, link) in model.links.iter().enumerate() {
            start.push(next);
            next += if i == 0 { 0 } else { link.joint.dof() };
            if body.partner[i] < i {
                group[i] = group[body.partner[i]];
            } else {
                group[i] = groups;
                groups += 1;
            }
        }
        Self { model, body, start, group, groups, size: next + 1 + groups }
    }

    /// A size for a start: the character's proportions, and the scale by the distances between the given landmarks of hips
    /// and shoulders. `None` where these are all at one place.
    pub fn guess_size(&self, trunk: [usize; 4], targets: &[Option<LandmarkTarget>]) -> Option<BodySize> {
        let rest = self.model.rest_positions();
        let (mut source, mut own) = (0.0, 0.0);
        for (a, b) in [(0, 1), (2, 3), (0, 2), (1, 3), (0, 3), (1, 2)] {
            let (a, b) = (trunk[a], trunk[b]);
            if let (Some(p), Some(q), Some(s), Some(t)) =
                (self.body.points[a], self.body.points[b], targets[a], targets[b])
            {
                own += (rest[p.link] + p.position).distance(rest[q.link] + q.position);
                source += s.position.distance(t.position);
            }
        }
        let scale = source / own;
        (scale > 1e-9 && scale.is_finite()).then(|| BodySize {
            scale,
            scale_spread: 1.0,
            lengths: vec![1.0; self.model.links.len()],
            length_spread: 0.1,
        })
    }

    /// The pose nearest to the targets (one for each landmark of the layout), from starts of its own and, where given, from
    /// another pose. `trunk` are the landmarks of left hip, right hip, left shoulder, right shoulder, of which at least three
    /// must have targets.
    pub fn solve(
        &self,
        trunk: [usize; 4],
        targets: &[Option<LandmarkTarget>],
        size: &BodySize,
        start: Option<&PoseFit>,
    ) -> PoseFit {
        let center = self.center(targets);
        let local: Vec<Option<LandmarkTarget>> = targets
            .iter()
            .zip(&self.body.points)
            .map(|(t, p)| {
                let (t, _) = (t.as_ref()?, p.as_ref()?);
                Some(LandmarkTarget { position: (t.position - center) / size.scale, weight: t.weight })
            })
            .collect();
        let upright = self.upright(trunk, &local, size);
        let bent = |twisted: bool| self.bent_towards(&local, &upright, size, twisted);
        let mut starts = vec![bent(true), bent(false), upright.clone()];
        if let Some(fit) = start {
            let mut from = upright.clone();
            from.joints.clone_from(&fit.joints);
            from.root_rotation = fit.root_rotation;
            starts.push(from);
        }
        let mut best: Option<(f64, Unknowns)> = None;
        for start in starts {
            let (cost, found) = self.descend(start, &local, size);
            if best.as_ref().is_none_or(|(c, _)| cost < *c) {
                best = Some((cost, found));
            }
        }
        let (cost, x) = best.unwrap_or_else(|| (f64::INFINITY, self.upright(trunk, &local, size)));
        let places = self.places(&x);
        let factor = x.log_scale.exp();
        let distances = self.body.points.iter().zip(&local).map(|(p, t)| {
            let (p, t) = (p.as_ref()?, t.as_ref()?);
            Some(places.point(p).distance(t.position / factor))
        });
        let scale = size.scale * factor;
        PoseFit {
            root_position: x.root_position + center / scale,
            root_rotation: x.root_rotation.normalize(),
            scale,
            lengths: places.length.clone(),
            cost,
            distances: distances.collect(),
            joints: x.joints,
        }
    }

    /// How little is known of each component of each joint's rotation vector at a solved pose, if the landmarks for which
    /// `seen` holds had positions: its standard deviation over that of the prior, by link; 1 is nothing.
    pub fn uncertainty(&self, fit: &PoseFit, seen: impl Fn(usize) -> bool) -> Vec<DVec3> {
        let size = BodySize { scale: fit.scale, scale_spread: 0.1, lengths: fit.lengths.clone(), length_spread: 0.02 };
        // Ranges are no landmarks: what only a limit holds is not known.
        let joints = fit.joints.iter().zip(&self.model.links);
        let joints = joints.map(|(r, link)| link.limits.map_or(*r, |l| r.clamp(l.low, l.high)));
        let x = Unknowns {
            root_position: DVec3::ZERO,
            root_rotation: fit.root_rotation,
            joints: joints.collect(),
            log_scale: 0.0,
            log_lengths: self.log_lengths(&size),
        };
        let places = self.places(&x);
        let target = |(i, point): (usize, &Option<BodyLandmark>)| {
            let point = point.filter(|_| seen(i))?;
            Some(LandmarkTarget { position: places.point(&point), weight: 1.0 })
        };
        let targets: Vec<Option<LandmarkTarget>> = self.body.points.iter().enumerate().map(target).collect();
        let (_, equations) = self.equations(&x, &targets, &size);
        let mut out = vec![DVec3::ONE; self.model.links.len()];
        let Some(solver) = Cholesky::new(self.size, &equations.a) else { return out };
        let deviation: Vec<f64> = solver.inverse_diagonal().into_iter().map(f64::sqrt).collect();
        for (i, link) in self.model.links.iter().enumerate().skip(1) {
            let (at, spread) = (self.start[i], self.body.spread[i]);
            out[i] = match link.joint {
                JointKind::Hinge { axis } => DVec3::splat(deviation[at] / spread.dot(axis.abs())),
                _ => DVec3::new(deviation[at], deviation[at + 1], deviation[at + 2]) / spread,
            };
        }
        out
    }

    fn center(&self, targets: &[Option<LandmarkTarget>]) -> DVec3 {
        let (sum, count) = targets.iter().flatten().fold((DVec3::ZERO, 0.0), |(sum, n), t| (sum + t.position, n + 1.0));
        if count > 0.0 { sum / count } else { DVec3::ZERO }
    }

    fn log_lengths(&self, size: &BodySize) -> Vec<f64> {
        let mut out = vec![0.0; self.groups];
        for (i, length) in size.lengths.iter().enumerate() {
            out[self.group[i]] = length.max(1e-3).ln();
        }
        out
    }

    /// All joints straight, the trunk where hips and shoulders are.
    fn upright(&self, trunk: [usize; 4], targets: &[Option<LandmarkTarget>], size: &BodySize) -> Unknowns {
        let mut x = Unknowns {
            root_position: DVec3::ZERO,
            root_rotation: DQuat::IDENTITY,
            joints: vec![DVec3::ZERO; self.model.links.len()],
            log_scale: 0.0,
            log_lengths: self.log_lengths(size),
        };
        let rest = self.places(&x);
        let pair = |a: usize, b: usize| (self.pair(targets, &rest, trunk[a]), self.pair(targets, &rest, trunk[b]));
        let (hips, shoulders) = (pair(0, 1), pair(2, 3));
        let middle = |pair: (Option<(DVec3, DVec3)>, Option<(DVec3, DVec3)>)| match pair {
            (Some(a), Some(b)) => Some(((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0)),
            (a, b) => a.or(b),
        };
        let across = |pair: (Option<(DVec3, DVec3)>, Option<(DVec3, DVec3)>)| match pair {
            (Some(a), Some(b)) => (b.0 - a.0, b.1 - a.1),
            _ => (DVec3::ZERO, DVec3::ZERO),
        };
        if let (Some(low), Some(high)) = (middle(hips), middle(shoulders)) {
            let frame = |up: DVec3, right: DVec3| {
                let up = up.try_normalize().unwrap_or(DVec3::Y);
                let right = (right - up * right.dot(up)).try_normalize().unwrap_or_else(|| up.any_orthonormal_vector());
                DQuat::from_mat3(&DMat3::from_cols(right, up, right.cross(up)))
            };
            let own = frame(high.0 - low.0, across(hips).0 + across(shoulders).0);
            let source = frame(high.1 - low.1, across(hips).1 + across(shoulders).1);
            x.root_rotation = (source * own.conjugate()).normalize();
            x.root_position = low.1 - x.root_rotation * low.0;
        }
        x
    }

    /// A landmark's place at rest and its target.
    fn pair(&self, targets: &[Option<LandmarkTarget>], places: &Places, index: usize) -> Option<(DVec3, DVec3)> {
        Some((places.point(self.body.points[index].as_ref()?), targets[index]?.position))
    }

    /// From the trunk outwards, each joint swung so that the next landmarks lie in their direction; with `twisted` also
    /// turned about that direction so that the joint after it, if it bends about x above all, can bend the way it does.
    fn bent_towards(
        &self,
        targets: &[Option<LandmarkTarget>],
        from: &Unknowns,
        size: &BodySize,
        twisted: bool,
    ) -> Unknowns {
        let mut x = from.clone();
        for (j, link) in self.model.links.iter().enumerate().skip(1) {
            let places = self.places(&x);
            let (mut own, mut source) = (DVec3::ZERO, DVec3::ZERO);
            for (point, target) in self.body.points.iter().zip(targets) {
                let (Some(point), Some(target)) = (point, target) else { continue };
                let near = if point.link == j {
                    point.position.length() > 0.02
                } else {
                    self.model.links[point.link].parent == Some(j) && point.position.length() < 0.05
                };
                if near {
                    own += places.point(point) - places.origin[j];
                    source += target.position - places.origin[j];
                }
            }
            let (Some(own), Some(source)) = (own.try_normalize(), source.try_normalize()) else { continue };
            let parent = places.rotation[link.parent.unwrap_or(0)];
            let swing = parent.conjugate() * DQuat::from_rotation_arc(own, source) * parent;
            let turn = if twisted { self.twist_for_bend(targets, &places, j, swing) } else { DQuat::IDENTITY };
            let mut r = (swing * turn).to_scaled_axis();
            if let JointKind::Hinge { axis } = link.joint {
                r = axis * r.dot(axis);
            }
            x.joints[j] = link.limits.map_or(r, |limits| r.clamp(limits.low, limits.high));
        }
        x.log_lengths = self.log_lengths(size);
        x
    }

    /// The turn of link `j` about the way to its only child that lets the child bend about x towards its landmarks.
    fn twist_for_bend(&self, targets: &[Option<LandmarkTarget>], places: &Places, j: usize, swing: DQuat) -> DQuat {
        let mut children = (0..self.model.links.len()).filter(|&c| self.model.links[c].parent == Some(j));
        let (Some(child), None) = (children.next(), children.next()) else { return DQuat::IDENTITY };
        let (link, spread) = (&self.model.links[child], self.body.spread[child]);
        let (Some(limits), true) = (link.limits, spread.x > 2.0 * spread.z) else { return DQuat::IDENTITY };
        // Where the child lies when it is straight, where it should lie, and where bending takes it, link frame.
        let rotation = places.rotation[self.model.links[j].parent.unwrap_or(0)] * swing;
        let joint = places.origin[j] + rotation * (link.offset * places.length[j]);
        let (mut own, mut source) = (DVec3::ZERO, DVec3::ZERO);
        for (point, target) in self.body.points.iter().zip(targets) {
            let (Some(point), Some(target)) = (point, target) else { continue };
            let below = self.model.links[point.link].parent == Some(child);
            let arm = if below { self.model.links[point.link].offset } else { point.position };
            if (point.link == child || below) && arm.length() > 0.02 {
                own += arm;
                source += rotation.conjugate() * (target.position - joint);
            }
        }
        let (Some(own), Some(source)) = (own.try_normalize(), source.try_normalize()) else { return DQuat::IDENTITY };
        let bent = DVec3::X.cross(own) * (limits.low.x + limits.high.x).signum();
        let aside = source - own * source.dot(own);
        if aside.length() < 0.2 {
            return DQuat::IDENTITY;
        }
        DQuat::from_axis_angle(own, bent.cross(aside).dot(own).atan2(bent.dot(aside)))
    }

    fn places(&self, x: &Unknowns) -> Places {
        let n = self.model.links.len();
        let mut out = Places {
            origin: Vec::with_capacity(n),
            rotation: Vec::with_capacity(n),
            length: self.group.iter().map(|&g| x.log_lengths[g].exp()).collect(),
        };
        for (i, link) in self.model.links.iter().enumerate() {
            let (origin, rotation) = match link.parent {
                None => (x.root_position, x.root_rotation),
                Some(p) => (
                    out.origin[p] + out.rotation[p] * (link.offset * out.length[p]),
                    out.rotation[p] * DQuat::from_scaled_axis(x.joints[i]),
                ),
            };
            out.origin.push(origin);
            out.rotation.push(rotation);
        }
        out
    }

    /// Levenberg-Marquardt steps from one start: the sum reached, and where.
    fn descend(&self, mut x: Unknowns, targets: &[Option<LandmarkTarget>], size: &BodySize) -> (f64, Unknowns) {
        let (mut cost, mut equations) = self.equations(&x, targets, size);
        let mut damping = 1e-3;
        for _ in 0..MAX_STEPS {
            let mut matrix = equations.a.clone();
            for i in 0..self.size {
                matrix[i * self.size + i] *= 1.0 + damping;
            }
            let mut step: Vec<f64> = equations.g.iter().map(|g| -g).collect();
            let Some(solver) = Cholesky::new(self.size, &matrix) else { break };
            solver.solve(&mut step);
            let tried = self.moved(&x, &step);
            let (tried_cost, tried_equations) = self.equations(&tried, targets, size);
            if tried_cost < cost {
                let gain = cost - tried_cost;
                (x, cost, equations) = (tried, tried_cost, tried_equations);
                damping = (damping * 0.3).max(1e-7);
                if gain < ENOUGH * (1.0 + cost) {
                    break;
                }
            } else {
                damping *= 5.0;
                if damping > 1e8 {
                    break;
                }
            }
        }
        (cost, x)
    }

    fn moved(&self, x: &Unknowns, step: &[f64]) -> Unknowns {
        let mut out = x.clone();
        let vector = |at: usize| DVec3::new(step[at], step[at + 1], step[at + 2]);
        out.root_position += vector(0);
        let turn = vector(3).clamp_length_max(LARGEST_TURN);
        out.root_rotation = (DQuat::from_scaled_axis(turn) * x.root_rotation).normalize();
        for (i, link) in self.model.links.iter().enumerate().skip(1) {
            let change = match link.joint {
                JointKind::Hinge { axis } => axis * step[self.start[i]],
                _ => vector(self.start[i]),
            };
            out.joints[i] += change.clamp_length_max(LARGEST_TURN);
        }
        let scale = self.size - 1 - self.groups;
        out.log_scale += step[scale].clamp(-0.5, 0.5);
        for (length, change) in out.log_lengths.iter_mut().zip(&step[scale + 1..]) {
            *length += change.clamp(-0.2, 0.2);
        }
        out
    }

    /// The sum to be minimised and its normal equations.
    fn equations(&self, x: &Unknowns, targets: &[Option<LandmarkTarget>], size: &BodySize) -> (f64, Equations) {
        let n = self.size;
        let scale_at = n - 1 - self.groups;
        let mut out = Equations { a: vec![0.0; n * n], g: vec![0.0; n] };
        let places = self.places(x);
        let factor = x.log_scale.exp();
        let mut cost = 0.0;

        // Landmarks. The spread is one in metres of the source's own size, so the scale cannot shrink errors away.
        let world: Vec<DMat3> = places.rotation.iter().map(|q| DMat3::from_quat(*q)).collect();
        let turned: Vec<DMat3> = world.iter().zip(&x.joints).map(|(m, r)| *m * right_jacobian(*r)).collect();
        let mut columns: Vec<(usize, DVec3)> = Vec::with_capacity(64);
        for (point, target) in self.body.points.iter().zip(targets) {
            let (Some(point), Some(target)) = (point, target) else { continue };
            let at = places.point(point);
            let mut weight = (point.weight * target.weight).sqrt() / LANDMARK_SPREAD;
            let error = at * factor - target.position;
            let size = weight * error.length();
            if size > HUBER {
                cost += HUBER * (2.0 * size - HUBER);
                weight *= (HUBER / size).sqrt();
            } else {
                cost += size * size;
            }
            self.columns(point, at, &places, &turned, scale_at, &mut columns);
            for (_, column) in &mut columns {
                *column *= factor * weight;
            }
            let error = error * weight;
            for &(i, ci) in &columns {
                out.g[i] += ci.dot(error);
                for &(k, ck) in columns.iter().filter(|(k, _)| *k <= i) {
                    out.a[i * n + k] += ci.dot(ck);
                }
            }
        }

        // What is known without landmarks: one row each.
        let mut row = |i: usize, residual: f64, slope: f64| {
            cost += residual * residual;
            out.g[i] += residual * slope;
            out.a[i * n + i] += slope * slope;
        };
        for (j, link) in self.model.links.iter().enumerate().skip(1) {
            let (r, spread) = (x.joints[j], self.body.spread[j]);
            let excess = |r: DVec3| link.limits.map_or(DVec3::ZERO, |l| r - r.clamp(l.low, l.high));
            if let JointKind::Hinge { axis } = link.joint {
                let spread = spread.dot(axis.abs());
                row(self.start[j], r.dot(axis) / spread, 1.0 / spread);
                let over = excess(r).dot(axis);
                row(self.start[j], over / LIMIT_SPREAD, if over == 0.0 { 0.0 } else { 1.0 / LIMIT_SPREAD });
                continue;
            }
            let over = excess(r);
            for k in 0..3 {
                row(self.start[j] + k, r[k] / spread[k], 1.0 / spread[k]);
                if over[k] != 0.0 {
                    row(self.start[j] + k, over[k] / LIMIT_SPREAD, 1.0 / LIMIT_SPREAD);
                }
            }
        }
        row(scale_at, x.log_scale / size.scale_spread, 1.0 / size.scale_spread);
        for (g, (length, known)) in x.log_lengths.iter().zip(self.log_lengths(size)).enumerate() {
            row(scale_at + 1 + g, (length - known) / size.length_spread, 1.0 / size.length_spread);
        }
        // Nothing holds the root where no landmark does; a trace of stiffness keeps the equations solvable.
        for i in 0..6 {
            row(i, 0.0, 1e-3);
        }
        (cost, out)
    }

    /// How a landmark at `at` moves with each unknown, before the scale: pairs of unknown and column.
    fn columns(
        &self,
        point: &BodyLandmark,
        at: DVec3,
        places: &Places,
        turned: &[DMat3],
        scale_at: usize,
        columns: &mut Vec<(usize, DVec3)>,
    ) {
        columns.clear();
        let length_at = |link: usize| scale_at + 1 + self.group[link];
        let lengths = |columns: &mut Vec<(usize, DVec3)>, link: usize, arm: DVec3| {
            let index = length_at(link);
            match columns.iter_mut().find(|(i, _)| *i == index) {
                Some((_, column)) => *column += arm,
                None => columns.push((index, arm)),
            }
        };
        lengths(columns, point.link, at - places.origin[point.link]);
        let mut j = point.link;
        while let Some(parent) = self.model.links[j].parent {
            let arm = at - places.origin[j];
            match self.model.links[j].joint {
                JointKind::Hinge { axis } => columns.push((self.start[j], (turned[j] * axis).cross(arm))),
                _ => {
                    for k in 0..3 {
                        columns.push((self.start[j] + k, turned[j].col(k).cross(arm)));
                    }
                }
            }
            lengths(columns, parent, places.origin[j] - places.origin[parent]);
            j = parent;
        }
        let arm = at - places.origin[0];
        for (k, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            columns.push((k, axis));
            columns.push((3 + k, axis.cross(arm)));
        }
        columns.push((scale_at, at));
    }
}

impl Places {
    /// Where a landmark is.
    fn point(&self, point: &BodyLandmark) -> DVec3 {
        self.origin[point.link] + self.rotation[point.link] * (point.position * self.length[point.link])
    }
}
