//! What happened over the last seconds: a ring of samples.

use crate::engine::{AthleteBody, LinkPoses};
use crate::model::CharacterModel;
use glam::DVec3;
use std::collections::VecDeque;

/// Points nearer to the middle of the body than this belong to no side, m.
const MIDDLE: f64 = 1e-3;

/// An athlete at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Simulated time since the start, s.
    pub time: f64,
    /// Horizontal speed of the root, m/s.
    pub speed: f64,
    /// Height of the centre of mass, world frame, m.
    pub mass_height: f64,
    /// Angle from the vertical to the line from the centre of pressure to the centre of mass, rad: towards the athlete's
    /// right, and forwards. NaN in the air.
    pub lean: [f64; 2],
    /// Vertical contact force on the left and on the right side of the body, N.
    pub force: [f64; 2],
    /// Wall time of one step of one athlete, microseconds; NaN where it was not measured.
    pub step_micros: f64,
}

impl Sample {
    /// Reads a body and its links at the last fixed tick; `step_micros` is measured elsewhere. `None` before the body has
    /// been placed.
    pub fn of(body: &AthleteBody, poses: &LinkPoses, step_micros: f64) -> Option<Self> {
        let (sim, model) = (body.simulator(), body.model());
        if poses.current.len() != model.links.len() {
            return None;
        }
        let mut moment = DVec3::ZERO;
        for (link, place) in model.links.iter().zip(&poses.current) {
            moment += (place.position + place.rotation * link.com) * link.mass;
        }
        let mass = moment / model.mass();
        let (mut force, mut pressure, mut whole) = ([0.0; 2], DVec3::ZERO, 0.0);
        for (k, point) in model.contact_points.iter().enumerate() {
            let up = sim.contact_force(k, 0).y;
            if up <= 0.0 {
                continue;
            }
            let link = &poses.current[point.link];
            pressure += (link.position + link.rotation * point.position) * up;
            whole += up;
            if let Some(side) = side_of(model, k) {
                force[side] += up;
            }
        }
        let lean = if whole > 1.0 {
            // The root's own right and ahead, level.
            let ahead = (poses.current[0].rotation * DVec3::NEG_Z).with_y(0.0).normalize_or(DVec3::NEG_Z);
            let right = ahead.cross(DVec3::Y);
            let arm = mass - pressure / whole;
            [arm.dot(right).atan2(arm.y), arm.dot(ahead).atan2(arm.y)]
        } else {
            [f64::NAN; 2]
        };
        Some(Self {
            time: body.time(),
            speed: body.root_velocity().with_y(0.0).length(),
            mass_height: mass.y,
            lean,
            force,
            step_micros,
        })
    }
}

/// The side of the body (0 left, 1 right) on which a contact point lies in the zero pose.
pub(super) fn side_of(model: &CharacterModel, point: usize) -> Option<usize> {
    let point = &model.contact_points[point];
    let mut x = point.position.x;
    let mut link = Some(point.link);
    while let Some(i) = link {
        x += model.links[i].offset.x;
        link = model.links[i].parent;
    }
    if x.abs() < MIDDLE { None } else { Some(usize::from(x > 0.0)) }
}

/// Samples of the last seconds, oldest first. Holds at most [`History::CAPACITY`] of them.
#[derive(Clone, Debug)]
pub struct History {
    samples: VecDeque<Sample>,
    seconds: f64,
}

impl Default for History {
    fn default() -> Self {
        Self::new(10.0)
    }
}

impl History {
    /// Most samples that are kept, whatever their times.
    pub const CAPACITY: usize = 4096;

    /// Keeps the last `seconds` of simulated time (0.1 to 600 s).
    pub fn new(seconds: f64) -> Self {
        let seconds = if seconds.is_finite() { seconds.clamp(0.1, 600.0) } else { 10.0 };
        Self { samples: VecDeque::new(), seconds }
    }

    /// Adds a sample. One that is older than the last (the athlete was put back) starts anew; one of the same time (the
    /// athlete stands still in time) is left out.
    pub fn push(&mut self, sample: Sample) {
        if let Some(last) = self.samples.back() {
            if sample.time == last.time {
                return;
            }
            if sample.time < last.time {
                self.samples.clear();
            }
        }
        while self.samples.len() >= Self::CAPACITY
            || self.samples.front().is_some_and(|first| sample.time - first.time > self.seconds)
        {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// The samples, oldest first.
    pub fn samples(&self) -> impl ExactSizeIterator<Item = &Sample> {
        self.samples.iter()
    }

    /// How far back it reaches at most, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time: f64) -> Sample {
        Sample { time, ..Sample::default() }
    }

    #[test]
    fn it_keeps_the_last_seconds_and_no_more_than_its_capacity() {
        let mut history = History::new(2.0);
        for k in 0..1000 {
            history.push(at(f64::from(k) * 0.01));
        }
        assert!(history.samples().all(|s| s.time >= 9.99 - 2.0 - 1e-9));
        assert_eq!(history.samples().len(), 201);
        for k in 0..10 * History::CAPACITY {
            history.push(at(10.0 + k as f64 * 1e-6));
        }
        assert!(history.samples().len() <= History::CAPACITY);
    }

    #[test]
    fn going_back_in_time_starts_anew_and_standing_still_adds_nothing() {
        let mut history = History::new(5.0);
        for time in [0.0, 1.0, 1.0, 1.0, 2.0] {
            history.push(at(time));
        }
        assert_eq!(history.samples().len(), 3);
        history.push(at(0.5));
        assert_eq!(history.samples().map(|s| s.time).collect::<Vec<_>>(), [0.5]);
    }

    #[test]
    fn blades_have_sides() {
        let model = crate::model::preset("skater").unwrap();
        for blade in &model.blades {
            let side = usize::from(blade.name == "right");
            assert_eq!(side_of(&model, blade.toe), Some(side), "{}", blade.name);
        }
    }
}
