//! A simulated motion as a clip.

use crate::asset::clip::{ClipError, MAX_POSES, MotionClip, Pose};
use crate::math::Real;
use crate::model::CharacterModel;
use crate::sim::Simulator;

/// Part of a step by which an instant may be missed and still count as met: the clock sums rounded steps.
const SLACK: f64 = 0.01;

/// Keeps the poses that one lane of a simulation goes through, at even times.
///
/// The first pose is that of the first look, and times count from there. An instant on a step has the pose of that
/// step, bit for bit (where the stored rotation has unit length to rounding); one between two steps is interpolated:
/// positions linearly, rotations along the shorter arc.
#[derive(Clone, Debug)]
pub struct MotionRecorder {
    lane: usize,
    rate: f64,
    start: f64,
    /// Time and pose of the last look, where it was needed.
    before: Option<(f64, Pose)>,
    poses: Vec<Pose>,
}

impl MotionRecorder {
    /// Poses per second where nobody asks for another rate.
    pub const DEFAULT_RATE: f64 = 30.0;

    /// Will keep `rate` poses per second of lane `lane`, for a motion of up to `seconds` (s). Fails where the rate is not
    /// within 1 to 1000 poses per second or a clip cannot hold so many poses.
    pub fn new(lane: usize, rate: f64, seconds: f64) -> Result<Self, ClipError> {
        if !(1.0..=1000.0).contains(&rate) {
            let expected = "1 to 1000 poses per second";
            return Err(ClipError::Option { clip: "recorded".into(), option: "rate", found: rate, expected });
        }
        let found = (seconds * rate).max(0.0) as usize + 1;
        if found > MAX_POSES {
            return Err(ClipError::TooLarge { what: "poses", found, limit: MAX_POSES });
        }
        Ok(Self { lane, rate, start: 0.0, before: None, poses: Vec::with_capacity(found) })
    }

    /// To be called before the first step and after every step.
    pub fn look<R: Real>(&mut self, sim: &Simulator<R>) {
        let (time, h) = (sim.state.time, sim.step_seconds());
        if self.poses.is_empty() {
            self.start = time;
        }
        // Only looks around an instant matter: the one at or after it, and the one before that.
        if time + (1.0 + SLACK) * h < self.due() {
            return;
        }
        let pose = pose_of(sim, self.lane);
        while self.due() <= time + SLACK * h {
            let due = self.due();
            self.poses.push(match &self.before {
                Some((earlier, from)) if due < time - SLACK * h && time > *earlier => {
                    from.mix(&pose, ((due - earlier) / (time - earlier)).clamp(0.0, 1.0))
                }
                _ => pose.clone(),
            });
        }
        self.before = Some((time, pose));
    }

    /// Time of the next pose to keep, s.
    fn due(&self) -> f64 {
        self.start + self.poses.len() as f64 / self.rate
    }

    /// The poses so far as a clip of this name that moves every joint of the character. Fails where a pose is no pose,
    /// as of a simulation that left its range, or where nothing was looked at.
    pub fn into_clip(self, name: &str, model: &CharacterModel) -> Result<MotionClip, ClipError> {
        let joints = model.links.iter().skip(1).map(|link| link.name.clone()).collect();
        let clip = MotionClip { name: name.to_owned(), frame_rate: self.rate, joints, poses: self.poses };
        clip.validate()?;
        Ok(clip)
    }
}

/// The present pose of a lane.
fn pose_of<R: Real>(sim: &Simulator<R>, lane: usize) -> Pose {
    Pose {
        root_position: sim.state.root_position.lane(lane),
        root_rotation: sim.state.root_rotation.lane(lane),
        joints: sim.state.joints.iter().skip(1).map(|joint| joint.rotation.lane(lane)).collect(),
    }
}
