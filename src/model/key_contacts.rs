//! Contacts of key poses: which points of the body stay where while poses change, by inverse kinematics.
//!
//! Joint angles alone say nothing of the ground: a foot that should stand slides, a hand misses the box by a few centimetres.
//! A contact names points of the body and the poses between which each of them lies still. The points of one contact leave one
//! **print**: they lie to each other as on a body that stands straight, at the place and in the direction where the poses
//! have them on average, at the height of the ground there, or where the file says.
//!
//! For each frame the joints between the root and the points, and the height `y` of the root, are displaced as little as brings the points to their print:
//!
//! ```text
//! sum_i w_i(t) |p_i(q, y) - print_i|^2 / reach^2 + sum_j |log(q0_j^-1 q_j)|^2 + sum_j |excess of q_j over its range|^2 / limit^2 + (y - y0)^2 / rise^2
//! ```
//!
//! by damped Gauss-Newton steps (Wampler 1986, "Manipulator Inverse Kinematic Solutions Based on Vector Formulations and
//! Damped Least-Squares Methods"). `w_i` goes smoothly from 0 to 1 within [`EASE`] before the contact and back after it.

use super::{CharacterModel, JointKind, LinkTransform, ModelPose};
use crate::asset::clip_edit::other_side;
use crate::math::Cholesky;
use glam::{DQuat, DVec2, DVec3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How long before and after a contact its points are drawn to their print, s.
const EASE: f64 = 0.1;
/// Distance from the print that weighs as much as a joint that is off by a radian, m.
const REACH: f64 = 0.003;
/// Displacement of the root's height that weighs as much as a radian, m.
const RISE: f64 = 0.04;
/// Excess of a joint over its range that weighs as much as a radian, rad.
const LIMIT: f64 = 0.05;
/// Stiffness of a hinge across its axis.
const HINGE: f64 = 1e9;
/// Most steps for one frame.
const STEPS: usize = 60;

/// Points that lie still between poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyContact {
    /// Contact points of the character by name, and from which pose to which each lies still: numbers of poses, counted from 0
    /// in one repetition, halves between them allowed. A number beyond the last pose reaches into the mirror image or the next repetition.
    pub points: BTreeMap<String, (f64, f64)>,
    /// Where the middle of the points is, m: to the right of the path, height of the ground, and along the path from its beginning. By default where
    /// the poses have it on average, on what they stand on.
    #[serde(default)]
    pub at: Option<(f64, f64, f64)>,
}

/// One point of a print.
#[derive(Clone, Debug)]
struct Pin {
    point: usize,
    /// Between which times it lies still, s.
    seconds: (f64, f64),
    /// Where its centre lies, m.
    place: DVec3,
}

/// All points of all contacts of a motion.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pins {
    pins: Vec<Pin>,
}

/// When a motion's poses are, and what is repeated.
pub(crate) struct Schedule<'a> {
    /// Time of each pose of one repetition without its mirror image, and of its end, s.
    pub times: &'a [f64],
    pub mirrored: bool,
    pub repeat: usize,
    /// The motion goes on where it ends: contacts reach over its ends.
    pub cyclic: bool,
}

impl Schedule<'_> {
    fn length(&self) -> f64 {
        self.times[self.times.len() - 1]
    }
    /// The time of a number of a pose, s.
    fn time(&self, pose: f64) -> f64 {
        let count = (self.times.len() - 1) as f64;
        let (whole, rest) = ((pose / count).floor(), pose.rem_euclid(count));
        let k = (rest as usize).min(self.times.len() - 2);
        whole * self.length() + self.times[k] + (self.times[k + 1] - self.times[k]) * (rest - k as f64)
    }
}

impl KeyContact {
    /// What cannot be: the place, what was found, and what would be valid.
    pub(crate) fn fault(&self, model: &CharacterModel, poses: usize, once: bool) -> Option<(String, String, String)> {
        if self.points.is_empty() {
            return Some(("points".into(), "none".into(), "at least one".into()));
        }
        for (name, (from, to)) in &self.points {
            if !model.contact_points.iter().any(|p| p.name == *name) {
                let names: Vec<&str> = model.contact_points.iter().map(|p| p.name.as_str()).collect();
                return Some(("points".into(), format!("`{name}`"), format!("one of {}", names.join(", "))));
            }
            let most = if once { poses.saturating_sub(1) } else { 4 * poses } as f64;
            if !(*from >= 0.0 && from < to && *to <= most) {
                let valid = format!("two numbers of poses in order, 0 to {most}");
                return Some((format!("points, `{name}`"), format!("({from}, {to})"), valid));
            }
        }
        match self.at {
            Some((x, y, z)) if !once || ![x, y, z].iter().all(|v| (-1000.0..=1000.0).contains(v)) => {
                Some(("at".into(), format!("({x}, {y}, {z})"), "metres, in a motion that is shown once".into()))
            }
            _ => None,
        }
    }
}

impl Pins {
    /// The prints of all contacts of a motion whose poses (before anything is pinned), and what they stand on (m), are given by `pose_at`.
    /// `ground` is the height of what is below a point, which is told what the poses stand on, m.
    pub(crate) fn new(
        contacts: &[KeyContact],
        model: &CharacterModel,
        schedule: &Schedule,
        pose_at: impl Fn(f64) -> (ModelPose, f64),
        ground: impl Fn(DVec3, f64) -> f64,
    ) -> Self {
        let mut pins = Vec::new();
        let halves = if schedule.mirrored { 2 } else { 1 };
        let turns = (schedule.repeat * halves) as isize;
        // A contact that began before the motion, or goes on after it, counts where it repeats.
        let (first, last) = if schedule.cyclic { (-2, turns + 1) } else { (0, turns) };
        for contact in contacts {
            for turn in first..last {
                let flip = schedule.mirrored && turn.rem_euclid(2) == 1;
                let name = |name: &String| if flip { other_side(name) } else { name.clone() };
                let points: Vec<(usize, (f64, f64))> = contact
                    .points
                    .iter()
                    .filter_map(|(point, (from, to))| {
                        let index = model.contact_points.iter().position(|p| p.name == name(point))?;
                        let offset = turn as f64 * schedule.length();
                        Some((index, (offset + schedule.time(*from), offset + schedule.time(*to))))
                    })
                    .collect();
                pins.extend(print(&points, contact.at, model, &pose_at, &ground));
            }
        }
        Self { pins }
    }

    /// Displaces the joints of a pose at the time `t` (s).
    pub(crate) fn apply(&self, model: &CharacterModel, t: f64, pose: &mut ModelPose) {
        let active: Vec<(&Pin, f64)> =
            self.pins.iter().map(|pin| (pin, pin.weight(t))).filter(|(_, weight)| *weight > 0.0).collect();
        if !active.is_empty() {
            reach(model, &active, pose);
        }
    }
}

impl Pin {
    fn weight(&self, t: f64) -> f64 {
        let away = (self.seconds.0 - t).max(t - self.seconds.1).max(0.0) / EASE;
        let s = (1.0 - away).max(0.0);
        s * s * (3.0 - 2.0 * s)
    }
}

/// Where the points of one contact lie.
fn print(
    points: &[(usize, (f64, f64))],
    at: Option<(f64, f64, f64)>,
    model: &CharacterModel,
    pose_at: &impl Fn(f64) -> (ModelPose, f64),
    ground: &impl Fn(DVec3, f64) -> f64,
) -> Vec<Pin> {
    const SAMPLES: usize = 24;
    let rest = model.rest_positions();
    let flat = |v: DVec3| DVec2::new(v.x, v.z);
    let mut places = Vec::new();
    let mut support = 0.0;
    // Of every point its mean place while it lies still, and how it lies in the body at rest.
    let means: Vec<DVec2> = points
        .iter()
        .map(|(point, (from, to))| {
            let sum: DVec2 = (0..SAMPLES)
                .map(|k| {
                    let (pose, below) = pose_at(from + (to - from) * (k as f64 + 0.5) / SAMPLES as f64);
                    pose.link_transforms(model, &mut places);
                    support += below / (SAMPLES * points.len()) as f64;
                    flat(center(model, *point, &places))
                })
                .sum();
            sum / SAMPLES as f64
        })
        .collect();
    let at_rest: Vec<DVec2> = points
        .iter()
        .map(|(point, _)| {
            let p = &model.contact_points[*point];
            flat(rest[p.link] + p.position)
        })
        .collect();
    let count = points.len() as f64;
    let (middle, rest_middle) = (means.iter().sum::<DVec2>() / count, at_rest.iter().sum::<DVec2>() / count);
    // The turn that fits best in the plane (Procrustes), none for a single point.
    let (mut dot, mut cross) = (0.0, 0.0);
    for (mean, rest) in means.iter().zip(&at_rest) {
        let (a, b) = (*rest - rest_middle, *mean - middle);
        (dot, cross) = (dot + a.dot(b), cross + a.perp_dot(b));
    }
    let turn = if dot.hypot(cross) > 1e-9 { DVec2::new(dot, cross).normalize() } else { DVec2::X };
    let (place, given) = match at {
        Some((x, y, z)) => (DVec2::new(x, -z), Some(y)),
        None => (middle, None),
    };
    points
        .iter()
        .zip(&at_rest)
        .map(|((point, seconds), rest)| {
            let p = place + turn.rotate(*rest - rest_middle);
            let radius = model.contact_points[*point].radius;
            // Above everything that could be below it.
            let height = given.unwrap_or_else(|| ground(DVec3::new(p.x, 1e3, p.y), support));
            Pin { point: *point, seconds: *seconds, place: DVec3::new(p.x, height + radius, p.y) }
        })
        .collect()
}

/// Centre of a contact point, m.
fn center(model: &CharacterModel, point: usize, places: &[LinkTransform]) -> DVec3 {
    let p = &model.contact_points[point];
    places[p.link].position + places[p.link].rotation * p.position
}

/// Gauss-Newton on the joints between the root and the points.
fn reach(model: &CharacterModel, pins: &[(&Pin, f64)], pose: &mut ModelPose) {
    let above = |mut link: usize| {
        let mut chain = Vec::new();
        while let Some(parent) = model.links[link].parent {
            if model.links[link].joint.dof() > 0 {
                chain.push(link);
            }
            link = parent;
        }
        chain
    };
    let chains: Vec<Vec<usize>> = pins.iter().map(|(pin, _)| above(model.contact_points[pin.point].link)).collect();
    let mut joints: Vec<usize> = chains.iter().flatten().copied().collect();
    joints.sort_unstable();
    joints.dedup();
    // The last unknown is the height of the root.
    let height = 3 * joints.len();
    let size = height + 1;
    let start = pose.joints.clone();
    let low = pose.root_position.y;
    let mut places = Vec::new();
    for _ in 0..STEPS {
        pose.link_transforms(model, &mut places);
        let (mut a, mut g) = (vec![0.0; size * size], vec![0.0; size]);
        for ((pin, weight), chain) in pins.iter().zip(&chains) {
            let here = center(model, pin.point, &places);
            let (error, w) = (here - pin.place, weight / (REACH * REACH));
            // A turn `omega` (world axes) of a joint moves the point by `omega x arm`.
            let arms: Vec<(usize, DVec3)> = chain
                .iter()
                .map(|link| (3 * joints.binary_search(link).unwrap_or_default(), here - places[*link].position))
                .collect();
            g[height] += error.y * w;
            a[height * size + height] += w;
            for (i, arm) in &arms {
                // e_y . (omega x arm) = omega . (arm x e_y)
                for (k, part) in arm.cross(DVec3::Y).to_array().into_iter().enumerate() {
                    a[height * size + i + k] += w * part;
                }
                let pull = arm.cross(error) * w;
                for (k, part) in pull.to_array().into_iter().enumerate() {
                    g[i + k] += part;
                }
                for (j, other) in &arms {
                    // (e_k x arm) . (e_l x other) = delta_kl arm . other - arm_l other_k
                    for k in 0..3 {
                        for l in 0..3 {
                            let both = if k == l { arm.dot(*other) } else { 0.0 } - arm[l] * other[k];
                            a[(i + k) * size + j + l] += w * both;
                        }
                    }
                }
            }
        }
        for (n, &link) in joints.iter().enumerate() {
            let rotation = places[link].rotation;
            let own = pose.joints[link];
            let away = (start[link].conjugate() * own).to_scaled_axis();
            let excess = model.links[link].limits.map_or(DVec3::ZERO, |l| {
                let r = own.to_scaled_axis();
                r - r.clamp(l.low, l.high)
            });
            let pull = rotation * (away + excess / (LIMIT * LIMIT));
            // Damped by as much again; a hinge turns about its axis alone.
            let stiff = 2.0 + if excess == DVec3::ZERO { 0.0 } else { 1.0 / (LIMIT * LIMIT) };
            let axis = match model.links[link].joint {
                JointKind::Hinge { axis } => Some(rotation * axis),
                _ => None,
            };
            for k in 0..3 {
                a[(3 * n + k) * size + 3 * n + k] += stiff;
                g[3 * n + k] += pull[k];
                for l in 0..3 {
                    let across = |axis: DVec3| HINGE * (f64::from(u8::from(k == l)) - axis[k] * axis[l]);
                    a[(3 * n + k) * size + 3 * n + l] += axis.map_or(0.0, across);
                }
            }
        }
        a[height * size + height] += 2.0 / (RISE * RISE);
        g[height] += (pose.root_position.y - low) / (RISE * RISE);
        let Some(solver) = Cholesky::new(size, &a) else { return };
        solver.solve(&mut g);
        pose.root_position.y -= g[height].clamp(-0.05, 0.05);
        let mut largest = g[height].abs();
        for (n, &link) in joints.iter().enumerate() {
            let turn = DVec3::new(-g[3 * n], -g[3 * n + 1], -g[3 * n + 2]).clamp_length_max(0.3);
            largest = largest.max(turn.length());
            let parent = model.links[link].parent.map_or(DQuat::IDENTITY, |p| places[p].rotation);
            let local = parent.conjugate() * DQuat::from_scaled_axis(turn) * parent;
            pose.joints[link] = (local * pose.joints[link]).normalize();
        }
        if largest < 1e-6 {
            return;
        }
    }
}
