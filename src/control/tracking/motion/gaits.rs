//! One gait at several speeds: cycles of the same steps, slow and fast, and everything between them.
//!
//! A motion that was made at one speed slides over the ground at another. A gait has a cycle for each of several speeds, all
//! cut into the same number of ticks, so that the same tick is the same instant of the step. At a **pace** `v` between the speeds
//! `v_i` and `v_j` of two neighbours, with `w = (v - v_i) / (v_j - v_i)`, pose and stride length are those between both,
//! `q = mix(q_i, q_j, w)` and `L = (1 - w) v_i T_i + w v_j T_j`, and the phase goes on by `v / L` cycles a second: so feet stand still at any
//! pace. `v / L` is the phase rate beta, the stride the amplitude alpha, of Park, Yu, Lee 2018, Section 5.2. The first cycle may be one of standing.

use super::{CycleShift, TrackedMotion, TrackedTick, phase_hats};
use crate::asset::clip::{ClipError, MotionClip};
use crate::model::{CharacterModel, Foot};
use glam::{DQuat, DVec3};

/// One speed of a gait.
#[derive(Clone, Debug)]
pub struct GaitLevel {
    /// One cycle. Roots and centres of mass count from where they would be at constant speed.
    pub(in crate::control::tracking) ticks: Vec<TrackedTick>,
    /// Mean speed, m/s.
    pub speed: f64,
    /// Length of the cycle, s.
    pub seconds: f64,
}

impl GaitLevel {
    /// Stride, m.
    fn stride(&self) -> f64 {
        self.speed * self.seconds
    }
}

/// Ticks of a cycle.
const TICKS: usize = 32;
/// Speed of a step on the spot at most, m/s.
const ON_THE_SPOT: f64 = 0.3;
/// Strides shorter than this do not say how fast the phase goes, m.
const NO_STRIDE: f64 = 1e-3;

/// The tick in the first half of a cycle at which the higher one of the feet is lowest.
fn both_down(level: &GaitLevel, model: &CharacterModel) -> usize {
    let mut places = Vec::with_capacity(model.links.len());
    let mut height = |tick: &TrackedTick| {
        tick.pose.link_transforms(model, &mut places);
        let lowest = |foot: &Foot| {
            let heights = model.foot_points(foot).map(|p| {
                let point = &model.contact_points[p];
                let place = &places[point.link];
                (place.position + place.rotation * point.position).y - point.radius
            });
            heights.fold(f64::INFINITY, f64::min)
        };
        model.feet().iter().map(lowest).fold(f64::NEG_INFINITY, f64::max)
    };
    let heights: Vec<f64> = level.ticks[..TICKS / 2].iter().map(&mut height).collect();
    (0..heights.len()).min_by(|a, b| heights[*a].total_cmp(&heights[*b])).unwrap_or(0)
}

impl TrackedMotion {
    /// Prepares a gait from one cycle for each of its speeds, ascending; the last pose of each counts as the first of the next cycle. Each goes
    /// straight ahead.
    pub fn gait(cycles: &[MotionClip], model: &CharacterModel, tick_rate: f64) -> Result<Self, ClipError> {
        let mut levels = Vec::with_capacity(cycles.len());
        let mut middle = None;
        for (k, clip) in cycles.iter().enumerate() {
            let seconds = clip.duration();
            let cycle = Self::cyclic(clip, model, TICKS as f64 / seconds.max(1e-3), true)?;
            let shift = cycle.cycle().map_or(DVec3::ZERO, |c| c.shift);
            let mut ticks = cycle.ticks.clone();
            let travel = shift.try_normalize().filter(|_| shift.length() > NO_STRIDE).unwrap_or(DVec3::NEG_Z);
            for (n, tick) in ticks.iter_mut().enumerate() {
                let gone = shift * (n as f64 / TICKS as f64);
                tick.pose.root_position -= gone;
                tick.com -= gone;
                tick.travel = travel;
            }
            // Over the origin at the start, so that all levels are in one place.
            let start = ticks[0].pose.root_position * DVec3::new(1.0, 0.0, 1.0);
            for tick in &mut ticks {
                tick.pose.root_position -= start;
                tick.com -= start;
            }
            levels.push(GaitLevel { ticks, speed: shift.length() / seconds, seconds });
            if k == cycles.len() / 2 {
                middle = Some(cycle);
            }
        }
        let Some(middle) = middle else { return Err(ClipError::NoPoses { clip: "gait".into() }) };
        let level = &levels[cycles.len() / 2];
        let still = CycleShift { turn: (1.0, 0.0), shift: DVec3::ZERO };
        let (ticks, mean_speed) = (level.ticks.clone(), level.speed);
        let both_down = levels.get(1).map_or(0, |level| both_down(level, model));
        Ok(Self { ticks, cycle: Some(still), tick_rate, mean_speed, levels, both_down, ..middle })
    }

    /// The speeds of a gait, ascending; empty for other motions.
    pub fn levels(&self) -> &[GaitLevel] {
        &self.levels
    }

    /// The pace nearest to a speed (m/s) that the gait has.
    pub fn pace(&self, speed: f64) -> f64 {
        match self.levels() {
            [] => speed,
            levels => speed.clamp(levels[0].speed, levels[levels.len() - 1].speed),
        }
    }

    /// Most ticks that one decision can go on by, rounded up: 1 but for a gait.
    pub fn most_ticks(&self) -> usize {
        let fastest = self.levels().iter().map(|l| TICKS as f64 / (l.seconds * self.tick_rate())).fold(1.0, f64::max);
        fastest.ceil() as usize
    }

    /// Mean length of a tick, s.
    pub fn tick_seconds(&self) -> f64 {
        match self.levels() {
            [] => 1.0 / self.tick_rate(),
            levels => levels[levels.len() / 2].seconds / TICKS as f64,
        }
    }

    /// The two levels around a pace (m/s), how far it is from the first to the second, and the cycles per second.
    fn around(&self, pace: f64) -> (&GaitLevel, &GaitLevel, f64, f64) {
        let levels = self.levels();
        let j = levels.partition_point(|l| l.speed <= pace).clamp(1, levels.len().max(2) - 1).min(levels.len() - 1);
        let (a, b) = (&levels[j.saturating_sub(1)], &levels[j]);
        let span = b.speed - a.speed;
        let w = if span > 0.0 { ((pace - a.speed) / span).clamp(0.0, 1.0) } else { 0.0 };
        let stride = a.stride() + (b.stride() - a.stride()) * w;
        let cadence = if stride > NO_STRIDE { pace / stride } else { 1.0 / b.seconds };
        (a, b, w, cadence)
    }

    /// Ticks by which the phase goes on in a decision at a pace (m/s).
    pub(in crate::control::tracking) fn phase_step(&self, pace: f64) -> f64 {
        self.around(pace).3 * TICKS as f64 / self.tick_rate()
    }

    /// The phase (ticks) and the pace (m/s) a decision later, where the pace may change by up to `most` towards the one that is `wanted` (m/s). Who stops ends the
    /// step and waits there: between standing and the slowest steps the phase rests where both feet are down, so steps begin where steps end.
    pub(in crate::control::tracking) fn after(&self, phase: f64, pace: f64, wanted: f64, most: f64) -> (f64, f64) {
        let next = phase + self.phase_step(pace);
        let towards = |wanted: f64| pace + (wanted - pace).clamp(-most, most);
        if self.levels().first().is_none_or(|l| l.speed > NO_STRIDE) {
            return (next, towards(wanted));
        }
        let (step, down) = (TICKS as f64 / 2.0, self.both_down as f64);
        let rest = ((phase - down) / step).ceil() * step + down;
        let least = self.step_on_the_spot().unwrap_or(0.0);
        // Nothing goes more slowly than the slowest steps.
        let wanted = if wanted >= least {
            wanted
        } else if wanted < 0.5 * least {
            0.0
        } else {
            least
        };
        let (stands, stops) = (pace < least || pace <= 0.0, wanted < least && pace <= least);
        let next = if stands || stops { next.min(rest) } else { next };
        // Only there it goes over from the one to the other.
        let here = rest - phase < 1e-9;
        let wanted = if here || least == 0.0 {
            wanted
        } else if stands {
            pace
        } else {
            wanted.max(least)
        };
        (next, towards(wanted))
    }

    /// The speed of the slowest steps (m/s) of a gait that also stands, where they are steps on the spot.
    pub(in crate::control::tracking) fn step_on_the_spot(&self) -> Option<f64> {
        match self.levels() {
            [stand, step, ..] if stand.speed <= NO_STRIDE && step.speed <= ON_THE_SPOT => Some(step.speed),
            _ => None,
        }
    }

    /// The gait at a pace (m/s) and a phase (ticks, from 0 to [`TrackedMotion::last`]).
    pub(in crate::control::tracking) fn sample(&self, phase: f64, pace: f64, out: &mut TrackedTick) {
        let (a, b, w, cadence) = self.around(pace);
        let k = (phase as usize).min(TICKS - 1);
        let s = phase - k as f64;
        let corners = [
            (&a.ticks[k], (1.0 - w) * (1.0 - s), a),
            (&a.ticks[k + 1], (1.0 - w) * s, a),
            (&b.ticks[k], w * (1.0 - s), b),
            (&b.ticks[k + 1], w * s, b),
        ];
        let sum = |f: &dyn Fn(&TrackedTick) -> DVec3| corners.iter().map(|(t, part, _)| f(t) * *part).sum::<DVec3>();
        // Velocities against the mean one, of a cycle that takes another time.
        let rate = |f: &dyn Fn(&TrackedTick, &GaitLevel) -> DVec3| {
            corners.iter().map(|(t, part, l)| f(t, l) * (*part * l.seconds * cadence)).sum::<DVec3>()
        };
        let mix = |f: &dyn Fn(&TrackedTick) -> DQuat| {
            let first = f(corners[0].0);
            let sum = corners.iter().fold(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), |sum, (t, part, _)| {
                let q = f(t);
                sum + q * if q.dot(first) < 0.0 { -*part } else { *part }
            });
            let length = sum.length_squared().sqrt();
            sum * (1.0 / length)
        };
        out.travel = if a.speed > b.speed { a.ticks[k].travel } else { b.ticks[k].travel };
        let mean = out.travel * pace;
        out.pose.root_position = sum(&|t| t.pose.root_position);
        out.pose.root_rotation = mix(&|t| t.pose.root_rotation);
        out.velocity.root_linear = rate(&|t, l| t.velocity.root_linear - t.travel * l.speed) + mean;
        out.velocity.root_angular = rate(&|t, _| t.velocity.root_angular);
        for i in 1..out.pose.joints.len() {
            out.pose.joints[i] = mix(&|t| t.pose.joints[i]);
            out.velocity.joints[i] = rate(&|t, _| t.velocity.joints[i]);
        }
        out.com = sum(&|t| t.com);
        out.com_velocity = rate(&|t, l| t.com_velocity - t.travel * l.speed) + mean;
        for (i, end) in out.ends.iter_mut().enumerate() {
            *end = sum(&|t| t.ends[i]);
        }
        out.phase = phase_hats(phase / TICKS as f64, true);
        out.support = 0.0;
        let nearest = if w < 0.5 { a } else { b };
        out.stands = nearest.ticks[k].stands;
    }

    /// The reference at a tick: of a gait at a pace (m/s).
    pub(in crate::control::tracking) fn at_pace(&self, tick: usize, pace: f64) -> TrackedTick {
        let mut out = self.tick(tick).clone();
        if !self.levels().is_empty() {
            self.sample((tick % TICKS) as f64, pace, &mut out);
        }
        out
    }
}
