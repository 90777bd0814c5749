//! From key poses to a clip: curves through the angles, the way over the ground, flights and contacts.

use super::{KeyPose, KeyPoseError, KeyPoses};
use crate::asset::clip::{MotionClip, Pose};
use crate::model::key_contacts::{Pins, Schedule};
use crate::model::mass_path::{Flight, center_of_mass, turned};
use crate::model::{CharacterModel, ModelPose};
use glam::{DQuat, DVec3};

/// One row of curves: lateral place, height and turn, root rotation, support, then the joints; degrees and metres.
type Row = Vec<DVec3>;

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

impl KeyPoses {
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
    use crate::model::{OptimizeRecord, preset};

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
