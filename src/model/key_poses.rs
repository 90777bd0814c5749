//! Key poses written by hand: a pose every few tenths of a second, by joint name, in degrees.
//!
//! Angles are the components of each joint's rotation vector in the character frame (X to the right, Y up, Z backwards; the
//! character faces -Z). For a skater or runner standing upright: `+x` bends the hip, shoulder and elbow forwards and
//! lifts the toes, `-x` bends the knee and the trunk forwards, `+y` turns to the left, `+z` tilts to the left (a hanging
//! arm or leg goes to the right).
//!
//! Poses become a clip by monotone cubic curves through the angles. The body travels along -Z at the file's speed; its
//! height is such that the lowest contact point is on the ground, or given.
//!
//! With a curvature the root travels on a circle, and the heading turns with it: the pose's own root rotation and lateral
//! place count from the heading. A negative speed travels backwards, facing the way it came from.
//!
//! Contacts name points that lie still between poses ([`KeyContact`]): the joints that lead to them give way, so that a standing foot does
//! not slide and a hand is where the obstacle is.
//!
//! With `mass_on_path` it is the centre of mass that travels, however the body turns above it; between take-off and
//! landing, where poses are airborne, it also follows the parabola of free fall.

use crate::asset::clip::{ClipError, MotionClip, Pose};
use crate::asset::clip_edit::other_side;
use crate::asset::read_file::read_text;
use crate::model::key_contacts::{KeyContact, Pins, Schedule};
use crate::model::mass_path::{Flight, center_of_mass, turned};
use crate::model::{CharacterModel, ModelPose, OptimizeRecord, Window};
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Key poses, as saved in a `*.keyposes.ron` file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyPoses {
    /// Name of the motion.
    pub name: String,
    /// Character whose links are named.
    pub character: String,
    /// Speed along -Z, m/s; negative travels backwards along +Z, facing -Z.
    pub speed: f64,
    /// Turn of the heading for each metre travelled, 1/m: positive turns to the left, counter-clockwise seen from above,
    /// forwards and backwards. So the centre of the circle is to the left of the direction of travel: forwards on the
    /// athlete's left, backwards on its right. The heading starts along -Z. In the air the path is straight.
    #[serde(default)]
    pub curvature: f64,
    /// Change of the speed, m/s^2: a coasting skater slows down.
    #[serde(default)]
    pub acceleration: f64,
    /// If true, the centre of mass travels on the path instead of the root.
    #[serde(default)]
    pub mass_on_path: bool,
    /// Seconds from each pose to the next; the last one leads to the first of the next repetition.
    pub seconds: Vec<f64>,
    /// The poses.
    pub poses: Vec<KeyPose>,
    /// Points that lie still between poses: joints give way.
    #[serde(default)]
    pub contacts: Vec<KeyContact>,
    /// If true, each repetition is followed by its mirror image.
    #[serde(default)]
    pub mirrored: bool,
    /// How often the poses are repeated (a mirror image counts with its original).
    #[serde(default = "one")]
    pub repeat: usize,
    /// Poses per second of the clip.
    #[serde(default = "thirty")]
    pub frame_rate: f64,
    /// Parts of one repetition (without its mirror image) and what is asked of the simulated motion there; none where
    /// the poses are all there is.
    #[serde(default)]
    pub windows: Vec<Window>,
    /// How the windows are optimised.
    #[serde(default)]
    pub optimize: OptimizeRecord,
}

/// Longest motion, repetitions included, s.
const MAX_SECONDS: f64 = 3600.0;

fn one() -> usize {
    1
}
fn thirty() -> f64 {
    30.0
}

/// One pose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyPose {
    /// Place of the root, or with `mass_on_path` of the centre of mass, beside the path, m: to the right of the heading.
    #[serde(default)]
    pub lateral: f64,
    /// Height of the root, m; by default the lowest contact point is on the support. Given in every pose or in none.
    #[serde(default)]
    pub height: Option<f64>,
    /// Height of what the pose stands on, m: the top of a box, of a stair. Heights are those of the poses between.
    #[serde(default)]
    pub support: f64,
    /// Turn about the vertical from the heading, degrees, to the left; beyond 360 it counts whole turns. Comes before
    /// `root`.
    #[serde(default)]
    pub turn: f64,
    /// In the air: from the pose before it to the next one that is not, the centre of mass falls freely. Needs
    /// `mass_on_path`, no `height`, and poses on the ground before and after.
    #[serde(default)]
    pub airborne: bool,
    /// Rotation vector of the root from the heading and the turn, degrees.
    #[serde(default)]
    pub root: (f64, f64, f64),
    /// Rotation vectors of the joints, degrees; joints that are not named are straight.
    #[serde(default)]
    pub joints: BTreeMap<String, (f64, f64, f64)>,
}

/// Why key poses were refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum KeyPoseError {
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The text is not a key pose file.
    #[error("{}: not a key pose file: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Where and why.
        message: String,
    },
    /// A value cannot be used.
    #[error("key poses {name}: {place}: {found}; {valid}")]
    Value {
        /// Name of the motion.
        name: String,
        /// Pose and field.
        place: String,
        /// What was found.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// The clip does not fit the character.
    #[error(transparent)]
    Clip(#[from] ClipError),
}

/// Slope at a point with the steps `before` and `after`: their harmonic mean, zero where the motion turns round, so
/// that a joint never swings beyond its poses. Fritsch, Butland 1984, "A Method for Constructing Local Monotone
/// Piecewise Cubic Interpolants".
fn slope(before: f64, after: f64) -> f64 {
    if before * after > 0.0 { 2.0 * before * after / (before + after) } else { 0.0 }
}

/// Curve between `b` and `c` with neighbours `a` and `d`, `s` in [0, 1], component by component.
fn curve(a: DVec3, b: DVec3, c: DVec3, d: DVec3, s: f64) -> DVec3 {
    let slopes = |x: DVec3, y: DVec3| DVec3::new(slope(x.x, y.x), slope(x.y, y.y), slope(x.z, y.z));
    let (m0, m1) = (slopes(b - a, c - b), slopes(c - b, d - c));
    let (s2, s3) = (s * s, s * s * s);
    b * (2.0 * s3 - 3.0 * s2 + 1.0) + m0 * (s3 - 2.0 * s2 + s) + c * (3.0 * s2 - 2.0 * s3) + m1 * (s3 - s2)
}

impl KeyPose {
    /// The pose seen in a mirror that swaps left and right.
    pub fn mirrored(&self) -> Self {
        let flip = |(x, y, z): (f64, f64, f64)| (x, -y, -z);
        Self {
            lateral: -self.lateral,
            turn: -self.turn,
            root: flip(self.root),
            joints: self.joints.iter().map(|(name, v)| (other_side(name), flip(*v))).collect(),
            ..self.clone()
        }
    }
}

/// Largest file, bytes.
const MAX_KEY_POSE_BYTES: u64 = 4 << 20;

/// One row of curves: lateral place, height and turn, root rotation, support, then the joints; degrees and metres.
type Row = Vec<DVec3>;

impl KeyPoses {
    /// Reads a file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, KeyPoseError> {
        let path = path.as_ref();
        let text = read_text(path, MAX_KEY_POSE_BYTES)
            .map_err(|e| KeyPoseError::Io { path: path.to_path_buf(), source: e.into() })?;
        Self::from_ron(&text, path)
    }

    /// Reads text; `path` is for messages.
    pub fn from_ron(text: &str, path: impl AsRef<Path>) -> Result<Self, KeyPoseError> {
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        options
            .from_str(text)
            .map_err(|e| KeyPoseError::Syntax { path: path.as_ref().to_path_buf(), message: e.to_string() })
    }

    fn check(&self, model: &CharacterModel) -> Result<(), KeyPoseError> {
        let bad = |place: String, found: String, valid: &str| {
            Err(KeyPoseError::Value { name: self.name.clone(), place, found, valid: valid.to_owned() })
        };
        if self.poses.is_empty() || self.poses.len() > 1000 {
            return bad("poses".into(), format!("{} poses", self.poses.len()), "1 to 1000");
        }
        if self.seconds.len() != self.poses.len() {
            return bad("seconds".into(), format!("{} times", self.seconds.len()), "one for each pose");
        }
        if let Some((i, s)) = self.seconds.iter().enumerate().find(|(_, s)| !(0.01..=10.0).contains(*s)) {
            return bad(format!("seconds of pose {i}"), s.to_string(), "0.01 to 10 s");
        }
        if !(1..=1000).contains(&self.repeat) {
            return bad("repeat".into(), self.repeat.to_string(), "1 to 1000");
        }
        if !(1.0..=240.0).contains(&self.frame_rate) {
            return bad("frame_rate".into(), self.frame_rate.to_string(), "1 to 240 poses per second");
        }
        let sides = if self.mirrored { 2.0 } else { 1.0 };
        let total = self.seconds.iter().sum::<f64>() * self.repeat as f64 * sides;
        if total > MAX_SECONDS {
            return bad("repeat".into(), format!("{total} s in all"), "at most 3600 s in all");
        }
        if !(-30.0..=30.0).contains(&self.speed) {
            return bad("speed".into(), self.speed.to_string(), "-30 to 30 m/s");
        }
        if !(-30.0..=30.0).contains(&self.acceleration) {
            return bad("acceleration".into(), self.acceleration.to_string(), "-30 to 30 m/s^2");
        }
        if !(-5.0..=5.0).contains(&self.curvature) {
            return bad("curvature".into(), self.curvature.to_string(), "-5 to 5 1/m");
        }
        if self.mirrored && self.curvature != 0.0 {
            return bad(
                "curvature".into(),
                self.curvature.to_string(),
                "0 where `mirrored`: a mirror image turns back",
            );
        }
        for (i, pose) in self.poses.iter().enumerate() {
            let place = |what: &str| format!("pose {i}, {what}");
            if !(-10.0..=10.0).contains(&pose.lateral) {
                return bad(place("lateral"), pose.lateral.to_string(), "-10 to 10 m");
            }
            match pose.height {
                Some(height) if !(0.0..=10.0).contains(&height) => {
                    return bad(place("height"), height.to_string(), "0 to 10 m");
                }
                None if self.poses.iter().any(|p| p.height.is_some()) => {
                    return bad(place("height"), "none".into(), "a height in every pose, or in none");
                }
                _ => {}
            }
            if !(-100.0..=100.0).contains(&pose.support) {
                return bad(place("support"), pose.support.to_string(), "-100 to 100 m");
            }
            if !(-10_000.0..=10_000.0).contains(&pose.turn) {
                return bad(place("turn"), pose.turn.to_string(), "at most 10000 degrees");
            }
            let inner = i > 0 && i + 1 < self.poses.len();
            if pose.airborne && !(self.mass_on_path && pose.height.is_none() && inner) {
                let valid = "only with `mass_on_path`, without `height`, and not in the first or last pose";
                return bad(place("airborne"), "true".into(), valid);
            }
            let root = std::iter::once(("root", &pose.root));
            for (name, angle) in root.chain(pose.joints.iter().map(|(n, a)| (n.as_str(), a))) {
                let v = DVec3::new(angle.0, angle.1, angle.2);
                if !(v.is_finite() && v.length() <= 360.0) {
                    return bad(place(name), v.to_string(), "a rotation vector of at most 360 degrees");
                }
                if name != "root" && model.link_index(name).is_none_or(|l| l == 0) {
                    let links: Vec<&str> = model.links.iter().skip(1).map(|l| l.name.as_str()).collect();
                    return bad(place(name), "no such joint".into(), &format!("one of {}", links.join(", ")));
                }
            }
        }
        for (i, contact) in self.contacts.iter().enumerate() {
            let once = !self.mirrored && self.repeat == 1;
            if let Some((field, found, valid)) = contact.fault(model, self.poses.len(), once) {
                return bad(format!("contact {i}, {field}"), found, &valid);
            }
        }
        self.check_windows()
    }

    fn check_windows(&self) -> Result<(), KeyPoseError> {
        let bad = |place: String, found: String, valid: &str| {
            Err(KeyPoseError::Value { name: self.name.clone(), place, found, valid: valid.to_owned() })
        };
        if let Some((field, found, valid)) = self.optimize.fault() {
            return bad(format!("optimize, {field}"), found, valid);
        }
        for (i, window) in self.windows.iter().enumerate() {
            if !(0.05..=5.0).contains(&window.seconds) {
                return bad(format!("window {i}, seconds"), window.seconds.to_string(), "0.05 to 5 s");
            }
            for objective in &window.objectives {
                if let Some((found, valid)) = objective.fault() {
                    return bad(format!("window {i}, {}", objective.label()), found, valid);
                }
            }
        }
        let (poses, windows) = (self.seconds.iter().sum::<f64>(), self.windows.iter().map(|w| w.seconds).sum::<f64>());
        if !self.windows.is_empty() && (poses - windows).abs() > 1e-3 {
            return bad("windows".into(), format!("{windows:.3} s in all"), &format!("{poses:.3} s, as the poses"));
        }
        Ok(())
    }

    /// Place on the path and heading (rad about +Y) at the time `t`, s: a circle, or the line -Z. In the air, between the
    /// times (s) of each pair in `air`, it goes straight on.
    fn path(&self, t: f64, air: &[(f64, f64)]) -> (DVec3, f64) {
        let along = |t: f64| (self.speed + 0.5 * self.acceleration * t) * t;
        let (mut place, mut heading, mut from) = (DVec3::ZERO, 0.0, 0.0_f64);
        let parts = air.iter().flat_map(|&(start, end)| [(start, self.curvature), (end, 0.0)]);
        for (end, curvature) in parts.chain([(f64::INFINITY, self.curvature)]) {
            let to = end.min(t);
            let length = along(to) - along(from);
            // The chord of an arc lies half way between the headings of its ends.
            let half = 0.5 * curvature * length * self.speed.signum();
            let chord = if half.abs() < 1e-9 { length } else { length * half.sin() / half };
            place += DVec3::new(-(heading + half).sin(), 0.0, -(heading + half).cos()) * chord;
            heading += 2.0 * half;
            from = to;
            if end >= t {
                break;
            }
        }
        (place, heading)
    }

    /// The clip of these poses for a character; contacts lie on what the poses stand on.
    pub fn to_clip(&self, model: &CharacterModel) -> Result<MotionClip, KeyPoseError> {
        self.clip_with(model, |_, support| support)
    }

    /// The clip of these poses for a character on ground whose height (m) below a point is given: contacts lie on it.
    pub fn to_clip_on(
        &self,
        model: &CharacterModel,
        ground: impl Fn(DVec3) -> f64,
    ) -> Result<MotionClip, KeyPoseError> {
        self.clip_with(model, |point, _| ground(point))
    }

    /// `ground` is told a point and what the poses stand on there, m.
    fn clip_with(
        &self,
        model: &CharacterModel,
        ground: impl Fn(DVec3, f64) -> f64,
    ) -> Result<MotionClip, KeyPoseError> {
        self.check(model)?;
        let names: Vec<String> = model.links.iter().skip(1).map(|l| l.name.clone()).collect();
        let vector = |a: &(f64, f64, f64)| DVec3::new(a.0, a.1, a.2);
        let row = |pose: &KeyPose| -> Row {
            // A height of NaN stands for "on the ground" until the pose is known.
            let place = DVec3::new(pose.lateral, pose.height.unwrap_or(f64::NAN), pose.turn);
            let mut row = vec![place, vector(&pose.root), DVec3::X * pose.support];
            row.extend(names.iter().map(|name| pose.joints.get(name).map_or(DVec3::ZERO, vector)));
            row
        };
        let mut rows = Vec::new();
        let mut airborne = Vec::new();
        let mut times = vec![0.0];
        for _ in 0..self.repeat {
            for flip in [false, true] {
                if flip && !self.mirrored {
                    continue;
                }
                for (pose, seconds) in self.poses.iter().zip(&self.seconds) {
                    rows.push(if flip { row(&pose.mirrored()) } else { row(pose) });
                    airborne.push(pose.airborne);
                    times.push(times[times.len() - 1] + seconds);
                }
            }
        }
        // A motion that repeats ends in its first pose; another one holds its last.
        let cyclic = self.mirrored || self.repeat > 1;
        let end = if cyclic { rows[0].clone() } else { rows[rows.len() - 1].clone() };
        rows.push(end);

        let duration = times[times.len() - 1];
        // Rounding of the sum of times must not cost the last frame.
        let frames = (duration * self.frame_rate + 1e-6).floor() as usize + 1;
        let mut clip = MotionClip {
            name: self.name.clone(),
            frame_rate: self.frame_rate,
            joints: names,
            poses: Vec::with_capacity(frames),
        };
        let mut air = Vec::new();
        for k in (1..airborne.len()).filter(|&k| airborne[k] && !airborne[k - 1]) {
            let end = (k..airborne.len()).find(|&e| !airborne[e]).unwrap_or(k);
            air.push((times[k - 1], times[end]));
        }
        let around = |t: f64| {
            let since = if cyclic && !(0.0..=duration).contains(&t) { t.rem_euclid(duration) } else { t };
            let k = times.partition_point(|x| *x <= since).clamp(1, times.len() - 1) - 1;
            let s = ((since - times[k]) / (times[k + 1] - times[k])).clamp(0.0, 1.0);
            let row = |k: isize| {
                let last = rows.len() as isize - 1;
                let k = if cyclic { k.rem_euclid(last) } else { k.clamp(0, last) };
                &rows[k as usize]
            };
            let k = k as isize;
            ([row(k - 1), row(k), row(k + 1), row(k + 2)], s)
        };
        let support_at = |t: f64| {
            let ([a, b, c, d], s) = around(t);
            curve(a[2], b[2], c[2], d[2], s).x
        };
        let pose_at = |t: f64| {
            let ([a, b, c, d], s) = around(t);
            let at = |i: usize| curve(a[i], b[i], c[i], d[i], s);
            let turn = |i: usize| {
                let v = at(i);
                DQuat::from_scaled_axis(v * (core::f64::consts::PI / 180.0))
            };
            let place = at(0);
            let (path, heading) = self.path(t, &air);
            let heading = DQuat::from_rotation_y(heading);
            let mut pose = Pose {
                root_position: path + heading * DVec3::new(place.x, 0.0, 0.0),
                root_rotation: heading * turned(place.z) * turn(1),
                joints: (3..b.len()).map(turn).collect(),
            };
            pose.root_position.y = if place.y.is_nan() {
                let mut places = Vec::new();
                let mut whole = ModelPose::zero(model);
                whole.root_rotation = pose.root_rotation;
                whole.joints[1..].copy_from_slice(&pose.joints);
                whole.link_transforms(model, &mut places);
                let lowest = model.contact_points.iter().map(|p| {
                    let link = &places[p.link];
                    (link.position + link.rotation * p.position).y - p.radius
                });
                at(2).x - lowest.fold(f64::INFINITY, f64::min)
            } else {
                place.y
            };
            if self.mass_on_path {
                let aside = center_of_mass(model, &pose) - pose.root_position;
                pose.root_position -= DVec3::new(aside.x, 0.0, aside.z);
            }
            pose
        };
        let height = |t| center_of_mass(model, &pose_at(t)).y;
        let flight = |&seconds: &(f64, f64)| Flight { seconds, heights: (height(seconds.0), height(seconds.1)) };
        let flights: Vec<Flight> = air.iter().map(flight).collect();
        let free = |t: f64| {
            let mut pose = pose_at(t);
            if let Some(height) = flights.iter().find_map(|f| f.height(t)) {
                pose.root_position.y += height - center_of_mass(model, &pose).y;
            }
            pose
        };
        let whole = |pose: &Pose| {
            let mut whole = ModelPose { root_position: pose.root_position, ..ModelPose::zero(model) };
            whole.root_rotation = pose.root_rotation;
            whole.joints[1..].copy_from_slice(&pose.joints);
            whole
        };
        let once = &times[..=self.poses.len()];
        let schedule = Schedule { times: once, mirrored: self.mirrored, repeat: self.repeat, cyclic };
        let figure = |t| (whole(&free(t)), support_at(t));
        let pins = Pins::new(&self.contacts, model, &schedule, figure, ground);
        for frame in 0..frames {
            let t = frame as f64 / self.frame_rate;
            let mut pose = free(t);
            if !self.contacts.is_empty() {
                let mut held = whole(&pose);
                pins.apply(model, t, &mut held);
                pose.root_position = held.root_position;
                pose.joints.copy_from_slice(&held.joints[1..]);
            }
            clip.poses.push(pose);
        }
        clip.validate()?;
        Ok(clip)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::preset;

    fn circling(speed: f64, curvature: f64, lateral: f64) -> MotionClip {
        let pose = KeyPose { lateral, root: (-10.0, 20.0, 5.0), ..KeyPose::default() };
        let poses = KeyPoses {
            name: "circle".into(),
            character: "skater".into(),
            speed,
            acceleration: 0.0,
            curvature,
            mass_on_path: false,
            seconds: vec![0.5, 0.5],
            poses: vec![pose.clone(), pose],
            mirrored: false,
            repeat: 4,
            frame_rate: 30.0,
            windows: vec![],
            contacts: vec![],
            optimize: OptimizeRecord::default(),
        };
        poses.to_clip(&preset("skater").unwrap()).unwrap()
    }

    #[test]
    fn a_curved_path_is_a_circle_around_its_centre() {
        // Forwards the centre is on the left, backwards on the right; counter-clockwise both times. A place to the right
        // of the heading is outside in the first case and inside in the second.
        for (speed, centre, radius) in [(3.0, -4.0, 4.1), (-3.0, 4.0, 3.9)] {
            let clip = circling(speed, 0.25, 0.1);
            let centre = DVec3::new(centre, 0.0, 0.0);
            let flat = |p: &Pose| DVec3::new(p.root_position.x, 0.0, p.root_position.z) - centre;
            for pair in clip.poses.windows(2) {
                let (a, b) = (flat(&pair[0]), flat(&pair[1]));
                assert!((a.length() - radius).abs() < 1e-9, "{speed}: {} m", a.length());
                let angle = a.cross(b).y.atan2(a.dot(b));
                assert!((angle - 3.0 * 0.25 / 30.0).abs() < 1e-9, "{speed}: turns by {angle}");
                // The body turns with the path.
                let turn = pair[1].root_rotation * pair[0].root_rotation.conjugate();
                assert!((turn.to_scaled_axis() - DVec3::Y * angle).length() < 1e-9);
                // It faces along the path, or against it.
                let own = DQuat::from_scaled_axis(DVec3::new(-10.0, 20.0, 5.0) * (core::f64::consts::PI / 180.0));
                let facing = pair[0].root_rotation * own.conjugate() * DVec3::NEG_Z;
                assert!((facing * speed.signum() - DVec3::Y.cross(a.normalize())).length() < 1e-9, "{facing}");
            }
        }
    }

    #[test]
    fn a_slight_curvature_tends_to_the_straight_path() {
        let (straight, bent) = (circling(2.0, 0.0, 0.1), circling(2.0, 1e-7, 0.1));
        for (a, b) in straight.poses.iter().zip(&bent.poses) {
            assert!((a.root_position - b.root_position).length() < 1e-5);
            assert!((a.root_position.x - 0.1).abs() < 1e-12);
        }
        assert!((straight.poses[straight.poses.len() - 1].root_position.z + 8.0).abs() < 1e-9);
    }

    #[test]
    fn a_curvature_that_cannot_be_is_refused() {
        let text = |extra: &str| {
            format!("(name: \"c\", character: \"skater\", speed: 3, {extra}, seconds: [0.5], poses: [()])")
        };
        for (extra, good) in [
            ("curvature: 0.3", true),
            ("curvature: 0.3, mirrored: true", false),
            ("curvature: 7", false),
            ("curvature: NaN", false),
        ] {
            let poses = KeyPoses::from_ron(&text(extra), "c.keyposes.ron").unwrap();
            let clip = poses.to_clip(&preset("skater").unwrap());
            assert_eq!(clip.is_ok(), good, "{extra}");
            if let Err(error) = clip {
                assert!(error.to_string().contains("curvature"), "{error}");
            }
        }
    }

    /// A jump with two turns and swinging arms; in the air from 0.3 to 0.75 s.
    const JUMP: &str = r#"(
        name: "jump", character: "skater", speed: 2, mass_on_path: true, frame_rate: 120,
        seconds: [0.3, 0.15, 0.15, 0.15, 0.3],
        poses: [
            (joints: {"thigh_left": (60, 0, 0), "shin_left": (-90, 0, 0)}),
            (turn: 90, joints: {"bicep_left": (0, 0, -90)}),
            (turn: 330, airborne: true, lateral: 0.05, joints: {"bicep_left": (60, 0, 0)}),
            (turn: 570, airborne: true, lateral: 0.1, joints: {"thigh_right": (30, 0, 0)}),
            (turn: 810, lateral: 0.15),
        ],
    )"#;

    #[test]
    fn in_the_air_the_centre_of_mass_falls_freely_and_the_root_turns_on() {
        let model = preset("skater").unwrap();
        let clip = KeyPoses::from_ron(JUMP, "jump").unwrap().to_clip(&model).unwrap();
        let mass: Vec<DVec3> = clip.poses.iter().map(|p| center_of_mass(&model, p)).collect();
        let step = 1.0 / 120.0;
        for (k, m) in mass.iter().enumerate() {
            assert!((m.z + 2.0 * k as f64 * step).abs() < 1e-9, "frame {k}: {}", m.z);
        }
        for k in 37..89 {
            let acceleration = (mass[k + 1] - 2.0 * mass[k] + mass[k - 1]).y / (step * step);
            assert!((acceleration + 9.81).abs() < 1e-6, "frame {k}: {acceleration} m/s^2");
        }
        let mut turned = 0.0;
        for pair in clip.poses.windows(2) {
            let by = (pair[1].root_rotation * pair[0].root_rotation.conjugate()).to_scaled_axis();
            assert!(by.x.abs() + by.z.abs() < 1e-9);
            turned += by.y;
        }
        assert!((turned.to_degrees() - 810.0).abs() < 1e-6, "{} degrees", turned.to_degrees());
    }

    #[test]
    fn in_the_air_a_curved_path_is_straight() {
        let model = preset("skater").unwrap();
        let mut text = JUMP.replacen("speed: 2,", "speed: -2, curvature: 0.3,", 1);
        for lateral in ["0.05", "0.15", "0.1"] {
            text = text.replacen(&format!("lateral: {lateral}"), "lateral: 0", 1);
        }
        let clip = KeyPoses::from_ron(&text, "jump").unwrap().to_clip(&model).unwrap();
        let mass: Vec<DVec3> = clip.poses.iter().map(|p| center_of_mass(&model, p)).collect();
        for (k, m) in mass.windows(3).enumerate() {
            let (before, after) = (m[1] - m[0], m[2] - m[1]);
            let (before, after) = (DVec3::new(before.x, 0.0, before.z), DVec3::new(after.x, 0.0, after.z));
            let turn = before.cross(after).y.atan2(before.dot(after));
            // 0.6 rad/s on the ice, none between 0.3 and 0.75 s; frames at both ends have a part of it.
            let expected = if (37..89).contains(&(k + 1)) { 0.0 } else { 0.005 };
            let at_an_end = [36, 89, 90].contains(&(k + 1));
            assert!(at_an_end || (turn - expected).abs() < 1e-9, "frame {}: {turn}", k + 1);
            assert!((after.length() - 2.0 / 120.0).abs() < 1e-6, "frame {}: {after}", k + 1);
        }
    }

    #[test]
    fn flights_that_have_no_ground_are_refused() {
        let model = preset("skater").unwrap();
        for (from, to) in [
            ("mass_on_path: true, ", ""),
            ("(turn: 810", "(airborne: true, turn: 810"),
            ("airborne: true, lateral: 0.05", "airborne: true, height: 1"),
            ("turn: 330", "turn: 1e6"),
        ] {
            let text = JUMP.replacen(from, to, 1);
            assert_ne!(text, JUMP);
            let error = KeyPoses::from_ron(&text, "jump").unwrap().to_clip(&model).unwrap_err();
            assert!(matches!(error, KeyPoseError::Value { .. }), "{error}");
        }
    }
}
