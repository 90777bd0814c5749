//! Where one motion can be left for another: by foot, edge, phase and speed.

use crate::control::tracking::{Heading, TrackedMotion, TrackedTick};
use crate::math::{Quat, Vec3};
use glam::{DQuat, DVec3};

/// How far into a motion that does not repeat it may be entered, s.
pub const ENTRY: f64 = 0.3;

/// A transition from one motion to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// Tick at which the first motion is left.
    pub leave: usize,
    /// Tick at which the second is entered.
    pub enter: usize,
    /// How far apart the two are; 0 is the same, 1 is a great difference.
    pub distance: f64,
}

/// How far the body would have to change in no time, going from one tick to another: 0 for none.
///
/// The sum of: mean squared angle between the joints (0.5 rad counts one), squared distance of hands, head and feet
/// relative to the root (0.3 m), squared difference of the up directions (0.3), of the directions of travel relative to the
/// pelvis (0.5) and of the heights of the root above what carries it (0.1 m). Where the feet are says which of them stands, and how the shank
/// leans says on which edge.
pub fn tick_distance(a: &TrackedTick, b: &TrackedTick) -> f64 {
    let heading = |t: &TrackedTick| Heading::of(Quat::<f64>::splat(t.pose.root_rotation));
    let (ha, hb) = (heading(a), heading(b));
    let local = |h: Heading<f64>, v: DVec3| h.to_local(Vec3::<f64>::splat(v)).lane(0);
    let square = |value: DVec3, scale: f64| value.length_squared() / (scale * scale);
    let angle = |p: DQuat, q: DQuat| {
        let w = p.dot(q).abs().min(1.0);
        4.0 * (1.0 - w * w)
    };
    let joints = a.pose.joints.iter().zip(&b.pose.joints).skip(1);
    let count = a.pose.joints.len().saturating_sub(1).max(1) as f64;
    let pose = joints.map(|(p, q)| angle(*p, *q)).sum::<f64>() / count / 0.25;
    let places = a.ends.iter().zip(&b.ends);
    let ends =
        places.map(|(p, q)| square(local(ha, *p) - local(hb, *q), 0.3)).sum::<f64>() / a.ends.len().max(1) as f64;
    let up = |t: &TrackedTick| t.pose.root_rotation * DVec3::Y;
    let tilt = square(local(ha, up(a)) - local(hb, up(b)), 0.3);
    let travel = square(local(ha, a.travel) - local(hb, b.travel), 0.5);
    let above = |t: &TrackedTick| t.pose.root_position.y - t.support;
    let height = square(DVec3::Y * (above(a) - above(b)), 0.1);
    pose + ends + tilt + travel + height
}

/// The best transition from one motion to another. A motion that ends is left at its end, or from tick `exit` on; one that repeats wherever it fits
/// best. `entry` is the last tick at which the second may be entered; of one that repeats, any.
pub fn best_transition(from: &TrackedMotion, exit: Option<usize>, to: &TrackedMotion, entry: usize) -> Transition {
    let exit = exit.unwrap_or(from.last()).min(from.last());
    let leave = if from.cycle().is_some() { 0..from.last() } else { exit..from.last() + 1 };
    let last = if to.cycle().is_some() { to.last().saturating_sub(1) } else { entry.min(to.last()) };
    let mut best = Transition { leave: leave.start, enter: 0, distance: f64::INFINITY };
    for a in leave {
        for b in 0..=last {
            let distance = tick_distance(from.tick(a), to.tick(b));
            if distance < best.distance {
                best = Transition { leave: a, enter: b, distance };
            }
        }
    }
    best
}
