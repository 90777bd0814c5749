//! Clips made from a clip: another rate, another speed, repeated, mirrored, moved.

use super::clip::{ClipError, MAX_POSES, MotionClip, Pose};
use super::turn::{slerp, twist, unit};
use glam::{DQuat, DVec3};

impl MotionClip {
    fn with_poses(&self, frame_rate: f64, poses: Vec<Pose>) -> Self {
        Self { name: self.name.clone(), frame_rate, joints: self.joints.clone(), poses }
    }

    fn check_option(
        &self,
        option: &'static str,
        found: f64,
        valid: bool,
        expected: &'static str,
    ) -> Result<(), ClipError> {
        if valid { Ok(()) } else { Err(ClipError::Option { clip: self.name.clone(), option, found, expected }) }
    }

    /// The clip with about `rate` poses per second. First and last pose and the duration stay, so the rate is rounded
    /// to a whole number of intervals.
    pub fn resample(&self, rate: f64) -> Result<Self, ClipError> {
        self.check_option("rate", rate, (1e-3..=1e5).contains(&rate), "0.001 to 100000 /s")?;
        let duration = self.duration();
        let intervals = (duration * rate).round();
        if intervals >= MAX_POSES as f64 {
            return Err(ClipError::TooLarge { what: "poses", found: intervals as usize, limit: MAX_POSES });
        }
        if duration <= 0.0 {
            return Ok(self.with_poses(rate, self.poses.clone()));
        }
        let intervals = intervals.max(1.0);
        let count = intervals as usize + 1;
        let poses = (0..count).map(|k| self.sample(duration * (k as f64 / intervals))).collect();
        Ok(self.with_poses(intervals / duration, poses))
    }

    /// The part of the clip from `from` to `to` (s), with the clip's frame rate as nearly as the length allows.
    pub fn cut(&self, from: f64, to: f64) -> Result<Self, ClipError> {
        let duration = self.duration();
        self.check_option("start", from, (0.0..=duration).contains(&from), "a time within the clip")?;
        self.check_option("end", to, from < to && to <= duration + 1e-6, "a time after the start, within the clip")?;
        let intervals = ((to - from) * self.frame_rate).round().max(1.0);
        let poses = (0..=intervals as usize).map(|k| self.sample(from + (to - from) * (k as f64 / intervals)));
        Ok(self.with_poses(intervals / (to - from), poses.collect()))
    }

    /// The clip `factor` times as long: 2 is half the speed.
    pub fn time_scaled(&self, factor: f64) -> Result<Self, ClipError> {
        self.check_option("time factor", factor, (1e-3..=1e3).contains(&factor), "0.001 to 1000")?;
        let clip = self.with_poses(self.frame_rate / factor, self.poses.clone());
        clip.validate()?;
        Ok(clip)
    }

    /// Clips one after the other in a clip of this name, each from where it is itself, and from when to when each lasts, s. Their times are rounded to
    /// whole frames of `frame_rate` (poses per second); the joints are those of the first, which all must have.
    pub fn joined(name: &str, clips: &[Self], frame_rate: f64) -> Result<(Self, Vec<(f64, f64)>), ClipError> {
        let Some(first) = clips.first() else { return Err(ClipError::NoPoses { clip: name.to_owned() }) };
        let (mut poses, mut parts) = (Vec::new(), Vec::new());
        for clip in clips {
            clip.check_option("frame rate", frame_rate, (1e-3..=1e5).contains(&frame_rate), "0.001 to 100000 /s")?;
            let places = first.joints.iter().map(|joint| {
                let place = clip.joints.iter().position(|j| j == joint);
                place.ok_or_else(|| ClipError::OtherJoints { clip: clip.name.clone(), joint: joint.clone() })
            });
            let places = places.collect::<Result<Vec<_>, _>>()?;
            let intervals = (clip.duration() * frame_rate).round().max(1.0);
            if poses.len() as f64 + intervals >= MAX_POSES as f64 {
                let found = poses.len() + intervals as usize;
                return Err(ClipError::TooLarge { what: "poses", found, limit: MAX_POSES });
            }
            let from = poses.len() as f64 / frame_rate;
            parts.push((from, from + intervals / frame_rate));
            for k in 0..=intervals as usize {
                let mut pose = clip.sample(clip.duration() * (k as f64 / intervals));
                pose.joints = places.iter().map(|p| pose.joints[*p]).collect();
                poses.push(pose);
            }
        }
        let clip = Self { name: name.to_owned(), frame_rate, joints: first.joints.clone(), poses };
        clip.validate()?;
        Ok((clip, parts))
    }

    /// The clip played `cycles` times, each cycle starting where the last one ended: the last pose counts as the first
    /// of the next cycle, moved along the ground and turned about the vertical.
    ///
    /// Where the last pose differs from the first one (besides place and heading), the difference is spread over the
    /// last `blend` seconds of every cycle; with 0 it stays as a jump at the seam.
    pub fn repeated(&self, cycles: usize, blend: f64) -> Result<Self, ClipError> {
        let turn = match (self.poses.first(), self.poses.last()) {
            (Some(first), Some(last)) => twist(last.root_rotation * first.root_rotation.conjugate(), DVec3::Y),
            _ => DQuat::IDENTITY,
        };
        self.repeated_with(cycles, blend, turn)
    }

    /// As [`MotionClip::repeated`], but every cycle keeps the heading of the first: for cycles that go straight on while
    /// their last pose happens to look a little to one side, which would add up to a curve. The sideways look is
    /// blended away like the rest of the difference.
    pub fn repeated_straight(&self, cycles: usize, blend: f64) -> Result<Self, ClipError> {
        self.repeated_with(cycles, blend, DQuat::IDENTITY)
    }

    fn repeated_with(&self, cycles: usize, blend: f64, turn: DQuat) -> Result<Self, ClipError> {
        self.check_option("number of cycles", cycles as f64, cycles > 0, "at least 1")?;
        self.check_option("seam blending", blend, blend >= 0.0 && blend.is_finite(), "0 s or more")?;
        let (Some(first), Some(last)) = (self.poses.first(), self.poses.last()) else {
            return Err(ClipError::NoPoses { clip: self.name.clone() });
        };
        let intervals = self.poses.len() - 1;
        let count = intervals.saturating_mul(cycles).saturating_add(1);
        if count > MAX_POSES {
            return Err(ClipError::TooLarge { what: "poses", found: count, limit: MAX_POSES });
        }
        if intervals == 0 {
            return Ok(self.clone());
        }

        // One cycle on the ground: p -> turn * p + shift.
        let mut shift = last.root_position - turn * first.root_position;
        shift.y = 0.0;

        // The seam closed: what the last pose lacks to be the first of the next cycle.
        let mut cycle = self.poses.clone();
        if blend > 0.0 {
            let root_gap = unit((turn * first.root_rotation) * last.root_rotation.conjugate());
            let height_gap = first.root_position.y - last.root_position.y;
            let span = blend.min(self.duration());
            for (k, pose) in cycle.iter_mut().enumerate() {
                let left = self.duration() - k as f64 / self.frame_rate;
                let x = (1.0 - left / span).clamp(0.0, 1.0);
                if x == 0.0 {
                    continue;
                }
                let weight = x * x * (3.0 - 2.0 * x);
                pose.root_position.y += weight * height_gap;
                pose.root_rotation = unit(slerp(DQuat::IDENTITY, root_gap, weight) * pose.root_rotation);
                for ((q, a), b) in pose.joints.iter_mut().zip(&last.joints).zip(&first.joints) {
                    *q = unit(*q * slerp(DQuat::IDENTITY, a.conjugate() * *b, weight));
                }
            }
        }

        let mut poses = Vec::with_capacity(count);
        let (mut heading, mut place) = (DQuat::IDENTITY, DVec3::ZERO);
        for index in 0..cycles {
            let used = if index + 1 == cycles { intervals + 1 } else { intervals };
            if index == 0 {
                poses.extend_from_slice(&cycle[..used]);
            }
            for pose in cycle[..used].iter().filter(|_| index > 0) {
                poses.push(Pose {
                    root_position: heading * pose.root_position + place,
                    root_rotation: unit(heading * pose.root_rotation),
                    joints: pose.joints.clone(),
                });
            }
            place += heading * shift;
            heading = unit(heading * turn);
        }
        Ok(self.with_poses(self.frame_rate, poses))
    }

    /// The clip with left and right exchanged (mirrored in the plane x = 0). Sides are read from the joint names:
    /// `left` and `right` anywhere in them (also `Left`, `LEFT`), or an ending `_l`, `.l`, `_L`, `.L` and its partner.
    pub fn mirrored(&self) -> Result<Self, ClipError> {
        let mut partners = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            let partner = other_side(joint);
            let Some(index) = self.joints.iter().position(|j| *j == partner) else {
                return Err(ClipError::NoPartner { clip: self.name.clone(), joint: joint.clone(), partner });
            };
            partners.push(index);
        }
        let mirror = |q: DQuat| DQuat::from_xyzw(q.x, -q.y, -q.z, q.w);
        let poses = self.poses.iter().map(|pose| Pose {
            root_position: pose.root_position * DVec3::new(-1.0, 1.0, 1.0),
            root_rotation: mirror(pose.root_rotation),
            joints: partners.iter().map(|&j| mirror(pose.joints.get(j).copied().unwrap_or(DQuat::IDENTITY))).collect(),
        });
        Ok(self.with_poses(self.frame_rate, poses.collect()))
    }

    /// The clip moved along the ground and turned about the vertical, so that it starts above the origin, facing -Z.
    /// Heights stay.
    pub fn moved_to_origin(&self) -> Self {
        let Some(first) = self.poses.first() else { return self.clone() };
        let turn = twist(first.root_rotation, DVec3::Y).conjugate();
        let start = DVec3::new(first.root_position.x, 0.0, first.root_position.z);
        let poses = self.poses.iter().map(|pose| Pose {
            root_position: turn * (pose.root_position - start),
            root_rotation: unit(turn * pose.root_rotation),
            joints: pose.joints.clone(),
        });
        self.with_poses(self.frame_rate, poses.collect())
    }

    /// The clip raised by `height`, m.
    pub fn raised(&self, height: f64) -> Self {
        let mut clip = self.clone();
        for pose in &mut clip.poses {
            pose.root_position.y += height;
        }
        clip
    }
}

/// The name of the joint on the other side; the name itself where it names no side.
pub(crate) fn other_side(name: &str) -> String {
    for (left, right) in [("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT")] {
        if name.contains(left) {
            return name.replacen(left, right, 1);
        }
        if name.contains(right) {
            return name.replacen(right, left, 1);
        }
    }
    for (left, right) in [("_l", "_r"), (".l", ".r"), ("_L", "_R"), (".L", ".R")] {
        if let Some(stem) = name.strip_suffix(left) {
            return format!("{stem}{right}");
        }
        if let Some(stem) = name.strip_suffix(right) {
            return format!("{stem}{left}");
        }
    }
    name.to_owned()
}
