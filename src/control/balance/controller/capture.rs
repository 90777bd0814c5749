//! A step when standing no longer helps.
//!
//! The capture point (Pratt, Carff, Drakunov, Goswami 2006, "Capture Point: A Step toward Humanoid Push Recovery") is where a linear pendulum that is
//! placed there comes to rest: `xi = c + c' / omega`, `omega^2 = g / z`. While it lies outside of what stands, no pressure under the feet brings the body to
//! rest. Then a foot is lifted and put where the capture point will be when it comes down: about the pressure `p` under the other foot it goes away as
//! `xi(t) = p + (xi - p) exp(omega t)`.

use super::super::hull::Hull;
use super::super::momentum::Whole;
use super::Balance;
use crate::asset::{Side, StateError, StateReader, StateWriter};
use crate::control::foot::SegmentSet;
use glam::{DQuat, DVec2, DVec3};

/// How far outside of what stands the capture point may lie before a step is taken, m.
const OUTSIDE: f64 = 0.015;
/// How long a foot is in the air in a step ahead or back, and in one to the side, s.
const SWING: (f64, f64) = (0.19, 0.13);
/// It may come down this much later before it counts as down, s.
const LATE: f64 = 0.15;
/// How high it is lifted, m.
const LIFT: f64 = 0.03;
/// How far beyond the capture point it is put, m.
const BEYOND: f64 = 0.05;
/// Least distance to the side between the middles of the feet, m; legs do not cross.
const APART: f64 = 0.12;
/// Farthest step from the standing foot, m.
const FARTHEST: f64 = 0.9;
/// After a step the other foot waits for so long, s.
const PAUSE: f64 = 0.05;
/// After so long without a step the count of steps begins anew, s.
const CALM: f64 = 2.0;

/// Seen from above, as [`Hull`] has it.
fn above(p: DVec3) -> DVec2 {
    DVec2::new(p.x, -p.z)
}

/// A foot in the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Swing {
    /// The foot.
    pub foot: usize,
    /// Where its ankle was, and where it shall come down, world frame, m.
    pub from: DVec3,
    pub to: DVec3,
    /// From the ankle to the middle of the sole, seen from above, m.
    pub sole: DVec2,
    /// How long it shall be in the air, s.
    pub seconds: f64,
    /// Since it was lifted, s.
    pub time: f64,
}

impl Swing {
    /// Place, velocity and acceleration of the ankle on its way: level with the least jerk (Flash, Hogan 1985), up and down along a parabola.
    pub fn at(&self) -> (DVec3, DVec3, DVec3) {
        let seconds = self.seconds;
        let s = (self.time / seconds).min(1.0);
        let way = self.to - self.from;
        let place = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
        let rate = 30.0 * s * s * (1.0 - s) * (1.0 - s) / seconds;
        let change = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (seconds * seconds);
        let moving = if s < 1.0 { 1.0 } else { 0.0 };
        let up = DVec3::Y * LIFT;
        (
            self.from + way * place + up * (4.0 * s * (1.0 - s)),
            way * rate + up * (4.0 * (1.0 - 2.0 * s) / seconds * moving),
            way * change - up * (8.0 / (seconds * seconds) * moving),
        )
    }
}

/// Steps that are taken to catch a fall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Capture {
    /// The foot in the air.
    pub swing: Option<Swing>,
    /// Steps taken since it last stood calmly.
    pub steps: usize,
    /// Since the last step, s.
    pub since: f64,
    /// How far outside of what stands the capture point was at the last decision, m; zero inside.
    pub outside: f64,
}

impl Balance {
    /// Number of steps taken to catch the present fall.
    pub fn steps_taken(&self) -> usize {
        self.capture.steps
    }

    /// How far outside of what stands the capture point was at the last decision, m; zero inside, and while the landing of the start lasts.
    pub fn outside(&self) -> f64 {
        self.capture.outside
    }

    /// Looks whether a step is due, moves the one under way, ends it.
    pub(super) fn step_where_due(&mut self, whole: &Whole, seconds: f64) {
        let ground = self.ground_height();
        let omega = (whole.gravity.length() / (whole.com.y - ground).max(0.2)).sqrt();
        let capture_point = above(whole.com) + above(whole.velocity) / omega;
        let hull = self.hull(|k| self.stance.feet[k].touch);
        let outside = hull.nearest(capture_point, 0.0).map_or(0.0, |edge| edge.distance(capture_point));
        self.capture.outside = if self.fresh > 0.0 { 0.0 } else { outside };
        if self.settings.steps == 0 || self.next.is_some() || self.footings.len() != 2 {
            return;
        }
        self.capture.since += seconds;
        if let Some(mut swing) = self.capture.swing {
            swing.time += seconds;
            let footing = &self.footings[swing.foot];
            let standing = footing.anatomy.standing();
            let down =
                standing.iter().any(|k| footing.gaps[k] < self.settings.contact) && swing.time > 0.5 * swing.seconds;
            if down || swing.time > swing.seconds + LATE {
                self.stance.feet[swing.foot].touch = standing;
                self.footings[swing.foot].coming = standing;
                self.capture.swing = None;
                self.capture.since = 0.0;
                self.guide = (whole.com, whole.velocity);
                return;
            }
            if swing.time < 0.7 * swing.seconds {
                swing.to = self.landing(&swing, capture_point, omega).0;
            }
            self.capture.swing = Some(swing);
            return;
        }
        if self.capture.since > CALM {
            self.capture.steps = 0;
        }
        let on_whole_soles =
            self.footings.iter().zip(&self.stance.feet).all(|(f, s)| s.touch == f.anatomy.standing() && s.rise == 0.0);
        let ready = on_whole_soles && self.fresh <= 0.0 && self.capture.since > PAUSE;
        if !(ready && outside > OUTSIDE && self.capture.steps < self.settings.steps as usize) {
            return;
        }
        let fall = capture_point - hull.middle().unwrap_or(capture_point);
        let aside = (fall.dot(above(self.heading * DVec3::X)) / fall.length().max(1e-9)).abs();
        let seconds = SWING.0 + (SWING.1 - SWING.0) * aside;
        // The foot whose landing is nearest to where it would have to be; of two as good, the one that carries less.
        let candidates = [0, 1].map(|foot| {
            let from = self.footings[foot].anchors[0].place;
            let sole = self.sole_of(foot).middle().unwrap_or(above(from)) - above(from);
            let swing = Swing { foot, from, to: from, sole, seconds, time: 0.0 };
            let (to, missed) = self.landing(&swing, capture_point, omega);
            let loaded = self.sole_of(foot).middle().map_or(0.0, |m| m.distance(capture_point));
            (Swing { to, ..swing }, missed - 0.2 * loaded)
        });
        let [a, b] = candidates;
        let (swing, _) = if a.1 <= b.1 { a } else { b };
        self.stance.feet[swing.foot].touch = SegmentSet::NONE;
        self.capture = Capture { swing: Some(swing), steps: self.capture.steps + 1, since: 0.0, outside };
    }

    /// What a foot stands on, seen from above.
    fn sole_of(&self, foot: usize) -> Hull {
        let footing = &self.footings[foot];
        Hull::of(footing.touching_places(footing.anatomy.standing()).map(above))
    }

    /// Where the ankle of a swinging foot has to come down, and how far from where it should the sole would be, m.
    fn landing(&self, swing: &Swing, capture_point: DVec2, omega: f64) -> (DVec3, f64) {
        let other = self.sole_of(1 - swing.foot);
        let pressure = other.nearest(capture_point, self.settings.margin).unwrap_or(capture_point);
        let away = capture_point - pressure;
        let wanted =
            pressure + away * (omega * (swing.seconds - swing.time).max(0.0)).exp() + away.normalize_or_zero() * BEYOND;
        let stands = other.middle().unwrap_or(pressure);
        let right = above(self.heading * DVec3::X).normalize_or(DVec2::X);
        let side = if self.footings[swing.foot].anatomy.side == Some(Side::Left) { -1.0 } else { 1.0 };
        let mut way = wanted - stands;
        let aside = way.dot(right) * side;
        way += right * side * (APART - aside).max(0.0);
        way = way.clamp_length_max(FARTHEST);
        let sole = stands + way;
        let ankle = sole - swing.sole;
        let ground = self.footings[swing.foot].ground;
        let level = DVec3::new(ankle.x, ground.point.y, -ankle.y);
        // On the plane that is under the foot.
        let on = level - ground.normal * ground.height(level);
        (on + ground.normal * self.footings[swing.foot].flat_height(), sole.distance(wanted))
    }

    /// How a swinging foot's ankle shall accelerate, m/s^2, and where it shall point.
    pub(super) fn swing_wish(&self, swing: &Swing, place: DVec3, velocity: DVec3) -> (DVec3, DQuat) {
        let gain = self.settings.swing;
        let (p, v, a) = swing.at();
        let linear = gain * (p - place) + 2.0 * gain.sqrt() * (v - velocity) + a;
        (linear, self.footings[swing.foot].flat())
    }
}

impl Capture {
    pub(super) fn write_state(&self, out: &mut StateWriter) {
        out.count(self.steps);
        out.number(self.since);
        out.number(self.outside);
        out.option(self.swing.as_ref(), |out, swing| {
            out.count(swing.foot);
            out.vector(swing.from);
            out.vector(swing.to);
            out.vector(swing.sole.extend(0.0));
            out.number(swing.seconds);
            out.number(swing.time);
        });
    }

    pub(super) fn read_state(from: &mut StateReader, feet: usize) -> Result<Self, StateError> {
        let steps = from.below("steps taken", 1 << 16)?;
        let since = from.number("time since the last step")?;
        let outside = from.number("distance of the capture point")?;
        let swing = from.option("foot in the air", |from| {
            let foot = from.below("foot in the air", feet)?;
            let (start, to) = (from.vector("place of the ankle")?, from.vector("place of the landing")?);
            let sole = from.vector("middle of the sole")?.truncate();
            let seconds = from.number("length of the swing")?;
            Ok(Swing { foot, from: start, to, sole, seconds, time: from.number("time in the air")? })
        })?;
        Ok(Self { swing, steps, since, outside })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swing_begins_and_ends_at_rest_and_its_rates_are_those_of_its_places() {
        let (from, to, seconds) = (DVec3::new(0.1, 0.06, 0.0), DVec3::new(0.2, 0.08, -0.4), 0.2);
        let mut swing = Swing { foot: 0, from, to, sole: DVec2::ZERO, seconds, time: 0.0 };
        let at = |swing: &mut Swing, time: f64| {
            swing.time = time;
            swing.at()
        };
        assert!(at(&mut swing, 0.0).0.distance(swing.from) < 1e-12);
        assert!(at(&mut swing, seconds).0.distance(swing.to) < 1e-12);
        let h = 1e-5;
        for k in 1..20 {
            let time = seconds * f64::from(k) / 20.0;
            let (before, (_, v, a), after) = (at(&mut swing, time - h), at(&mut swing, time), at(&mut swing, time + h));
            assert!(((after.0 - before.0) / (2.0 * h)).distance(v) < 1e-6, "{time}");
            assert!(((after.1 - before.1) / (2.0 * h)).distance(a) < 1e-4, "{time}");
        }
    }
}
