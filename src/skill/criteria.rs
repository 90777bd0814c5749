//! When a trial counts: conditions on what the skater did, each measured on samples of the simulation alone.

use crate::model::Side;
use crate::skill::performance::{FootSample, PerformanceSample, side_index};
use serde::{Deserialize, Serialize};

/// Time that a trial has to settle from its disturbed start before its blades are looked at, s.
pub const SETTLE: f64 = 0.3;
/// A blade whose lower end is higher than this has left the ice, m (where the knife edge ends, too).
pub const LIFT: f64 = 0.005;
/// Speed below which no direction of travel is asked for, m/s.
const SLOW: f64 = 0.3;
/// Shortest time on one foot that makes a stroke, s.
const SHORTEST_STROKE: f64 = 0.1;
/// Shortest time without ice that makes a flight, s.
pub const SHORTEST_FLIGHT: f64 = 0.1;

/// Forwards or backwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Way {
    /// The toe first.
    Forward,
    /// The heel first.
    Backward,
}

/// One condition of a skill.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Criterion {
    /// So many times on one foot, legs taking turns.
    Strokes {
        /// Times.
        count: usize,
    },
    /// The mean speed over the last `seconds` is at least this, m/s.
    KeptSpeed {
        /// Speed, m/s.
        at_least: f64,
        /// Time, s.
        seconds: f64,
    },
    /// The right foot passes to the left of the left one (seen by the skater) so many times.
    Crossings {
        /// Times.
        count: usize,
    },
    /// The direction of travel turns by so many full turns in all, to one side.
    Circles {
        /// Turns.
        turns: f64,
    },
    /// The pelvis faces the way of travel, or away from it, throughout.
    Travels {
        /// Which.
        way: Way,
    },
    /// One foot never leaves the ice, the other never touches it.
    OneFoot {
        /// The standing foot.
        foot: Side,
    },
    /// The standing blade turns half round (to within 60 degrees), from travelling one way to the other.
    Turns {
        /// The standing foot.
        foot: Side,
        /// The way it travels in the end.
        to: Way,
    },
    /// The last `seconds` are spent on one foot, travelling one way.
    Glides {
        /// The foot.
        foot: Side,
        /// The way.
        way: Way,
        /// Time, s.
        seconds: f64,
    },
    /// The body stays near its reference throughout: the root within a distance and an angle of it, and the joints by their mean over
    /// the whole trial.
    Follows {
        /// Largest distance of the root, m.
        root: f64,
        /// Largest angle of the root, degrees.
        #[serde(default = "one_radian")]
        turn: f64,
        /// Mean angle of the joints, degrees.
        joints: f64,
    },
    /// The root gets to at least `ahead` from where it began (along -Z of the motion's world, m), and never further to a side than
    /// `aside` (m): across an obstacle, between walls.
    Crosses {
        /// Way ahead, m.
        ahead: f64,
        /// To the side at most, m.
        aside: f64,
    },
    /// The way faced in the end is within so many degrees of that in the beginning.
    KeepsHeading {
        /// Degrees.
        within: f64,
    },
    /// A flight in which the centre of mass rises by at least `rise` (m) above where it left the ground, and both feet are at some moment
    /// at least `clear` (m) above the ground.
    Leaps {
        /// m.
        rise: f64,
        /// m.
        clear: f64,
    },
    /// Over the last `seconds` both feet are on the ground and the centre of mass is never faster than `below` (m/s).
    ComesToRest {
        /// Time, s.
        seconds: f64,
        /// Speed, m/s.
        below: f64,
    },
    /// A jump.
    Jumps {
        /// The foot that leaves the ice last.
        from: Side,
        /// The way it travels before.
        way: Way,
        /// It leaves on its inside edge (leans towards the midline).
        inside: bool,
        /// Shortest time with both blades off the ice, s.
        air_time: f64,
        /// Least rotation about the vertical in that time, turns.
        turns: f64,
        /// The foot that lands.
        to: Side,
    },
}

/// What a trial lacked.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortfall {
    /// The condition.
    pub condition: &'static str,
    /// What was found instead.
    pub found: String,
}

/// A time without ice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// Index of the first sample in the air.
    pub from: usize,
    /// Index of the sample that touches again; the number of samples if none does.
    pub to: usize,
    /// Length, s.
    pub seconds: f64,
    /// Rotation of the root about the vertical, turns, positive to the left (counter-clockwise from above).
    pub turns: f64,
    /// Rise of the root above where it left the ice, m.
    pub height: f64,
}

fn one_radian() -> f64 {
    57.3
}

fn angle_between(a: glam::DVec3, b: glam::DVec3) -> f64 {
    // Positive to the left, seen from above.
    a.cross(b).y.atan2(a.dot(b))
}

/// Rotation of the root about the vertical over some samples, rad, positive to the left.
pub fn yaw_over(samples: &[PerformanceSample]) -> f64 {
    samples.windows(2).map(|w| angle_between(w[0].facing(), w[1].facing())).sum()
}

/// Flights of at least [`SHORTEST_FLIGHT`].
pub fn flights(samples: &[PerformanceSample]) -> Vec<Flight> {
    let mut found = Vec::new();
    let mut k = 0;
    while k < samples.len() {
        if !samples[k].airborne() {
            k += 1;
            continue;
        }
        let from = k;
        while k < samples.len() && samples[k].airborne() {
            k += 1;
        }
        let last = &samples[k.min(samples.len() - 1)];
        let seconds = last.time - samples[from].time;
        if seconds >= SHORTEST_FLIGHT {
            let part = &samples[from..(k + 1).min(samples.len())];
            let ground = samples[from.saturating_sub(1)].root_position.y;
            let height = part.iter().map(|s| s.root_position.y - ground).fold(0.0, f64::max);
            let turns = yaw_over(part) / core::f64::consts::TAU;
            found.push(Flight { from, to: k, seconds, turns, height });
        }
    }
    found
}

/// How far the centre of mass rises in a flight, and the height of the lower foot where it is highest, m.
fn leap(samples: &[PerformanceSample], flight: &Flight) -> (f64, f64) {
    let in_air = &samples[flight.from.saturating_sub(1)..flight.to.min(samples.len())];
    let (mut up, mut rise, mut clear) = (0.0, 0.0_f64, 0.0_f64);
    for pair in in_air.windows(2) {
        up += 0.5 * (pair[0].com_velocity.y + pair[1].com_velocity.y) * (pair[1].time - pair[0].time);
        rise = rise.max(up);
        clear = clear.max(pair[1].feet.iter().map(FootSample::gap).fold(f64::INFINITY, f64::min));
    }
    (rise, clear)
}

/// Times on one foot of at least 0.1 s, one foot after the other: the same foot again counts on.
pub fn strokes(samples: &[PerformanceSample]) -> Vec<Side> {
    let mut found: Vec<Side> = Vec::new();
    let (mut side, mut since) = (None, 0.0);
    for sample in samples {
        let now = sample.standing();
        if now != side {
            (side, since) = (now, sample.time);
        }
        if let Some(foot) = side
            && sample.time - since >= SHORTEST_STROKE
            && found.last() != Some(&foot)
        {
            found.push(foot);
        }
    }
    found
}

/// How often the right foot passes to the left of the left one, seen by the skater.
pub fn crossings(samples: &[PerformanceSample]) -> usize {
    let (mut count, mut crossed) = (0, false);
    for sample in samples {
        let right = sample.facing().cross(glam::DVec3::Y);
        let apart = (sample.feet[1].middle() - sample.feet[0].middle()).dot(right);
        if !crossed && apart < -0.02 {
            (count, crossed) = (count + 1, true);
        } else if apart > 0.05 {
            crossed = false;
        }
    }
    count
}

/// How far a blade travels along itself against how far it travels in all, from -1 (straight backwards) to 1; `None` if
/// hardly at all.
fn way_along(samples: &[PerformanceSample], foot: Side) -> Option<f64> {
    let (mut along, mut all) = (0.0, 0.0);
    for sample in samples {
        along += sample.velocity().dot(sample.foot(foot).ahead());
        all += sample.speed();
    }
    (all > SLOW * samples.len() as f64).then(|| along / all)
}

fn goes(way: Way, along: f64) -> bool {
    match way {
        Way::Forward => along > 0.5,
        Way::Backward => along < -0.5,
    }
}

fn part(samples: &[PerformanceSample], from: f64, to: f64) -> &[PerformanceSample] {
    let first = samples.partition_point(|s| s.time < from);
    let last = samples.partition_point(|s| s.time <= to);
    &samples[first.min(last)..last]
}

impl Criterion {
    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Criterion::Strokes { .. } => "Strokes",
            Criterion::KeptSpeed { .. } => "KeptSpeed",
            Criterion::Crossings { .. } => "Crossings",
            Criterion::Circles { .. } => "Circles",
            Criterion::Travels { .. } => "Travels",
            Criterion::OneFoot { .. } => "OneFoot",
            Criterion::Turns { .. } => "Turns",
            Criterion::Glides { .. } => "Glides",
            Criterion::Follows { .. } => "Follows",
            Criterion::Crosses { .. } => "Crosses",
            Criterion::KeepsHeading { .. } => "KeepsHeading",
            Criterion::Leaps { .. } => "Leaps",
            Criterion::ComesToRest { .. } => "ComesToRest",
            Criterion::Jumps { .. } => "Jumps",
        }
    }

    /// Whether it is about feet.
    pub fn needs_feet(&self) -> bool {
        !matches!(
            self,
            Self::KeptSpeed { .. }
                | Self::Circles { .. }
                | Self::Travels { .. }
                | Self::Follows { .. }
                | Self::Crosses { .. }
                | Self::KeepsHeading { .. }
        )
    }

    /// Whether a whole trial meets it.
    pub fn check(&self, samples: &[PerformanceSample]) -> Result<(), Shortfall> {
        let fail = |found: String| Err(Shortfall { condition: self.name(), found });
        let Some(end) = samples.last().map(|s| s.time) else { return fail("no samples".into()) };
        let settled = part(samples, SETTLE, end);
        match *self {
            Criterion::Strokes { count } => {
                let made = strokes(samples).len();
                if made < count {
                    return fail(format!("{made} strokes"));
                }
            }
            Criterion::KeptSpeed { at_least, seconds } => {
                let last = part(samples, end - seconds, end);
                let mean = last.iter().map(|s| s.speed()).sum::<f64>() / last.len().max(1) as f64;
                if mean < at_least {
                    return fail(format!("{mean:.2} m/s"));
                }
            }
            Criterion::Crossings { count } => {
                let made = crossings(samples);
                if made < count {
                    return fail(format!("{made} crossings"));
                }
            }
            Criterion::Circles { turns } => {
                let moving: Vec<_> = samples.iter().map(|s| s.velocity()).filter(|v| v.length() > SLOW).collect();
                let turned: f64 = moving.windows(2).map(|w| angle_between(w[0], w[1])).sum();
                if turned.abs() < turns * core::f64::consts::TAU {
                    return fail(format!("{:.2} turns", turned / core::f64::consts::TAU));
                }
            }
            Criterion::Travels { way } => {
                let wrong = settled.iter().find(|s| {
                    let along = s.velocity().dot(s.facing());
                    s.speed() > SLOW && (if way == Way::Forward { along } else { -along }) < 0.0
                });
                if let Some(s) = wrong {
                    return fail(format!("the other way at {:.2} s", s.time));
                }
            }
            Criterion::OneFoot { foot } => {
                for s in settled {
                    if s.foot(foot).gap() > LIFT {
                        return Err(Shortfall {
                            condition: "standing foot down",
                            found: format!("off at {:.2} s", s.time),
                        });
                    }
                    if s.foot(foot.other()).pressed {
                        return Err(Shortfall { condition: "free foot up", found: format!("down at {:.2} s", s.time) });
                    }
                }
            }
            Criterion::Turns { foot, to } => {
                let turned: f64 =
                    samples.windows(2).map(|w| angle_between(w[0].foot(foot).ahead(), w[1].foot(foot).ahead())).sum();
                if (turned.abs().to_degrees() - 180.0).abs() > 60.0 {
                    return fail(format!("turned by {:.0} degrees", turned.to_degrees()));
                }
                let from = if to == Way::Forward { Way::Backward } else { Way::Forward };
                for (way, ends) in [(from, part(samples, 0.0, 0.3)), (to, part(samples, end - 0.5, end))] {
                    if way_along(ends, foot).is_some_and(|along| !goes(way, along)) {
                        return fail(format!("does not travel {way:?}"));
                    }
                }
            }
            Criterion::Glides { foot, way, seconds } => {
                let last = part(samples, end - seconds, end);
                if end < seconds || last.iter().any(|s| s.foot(foot.other()).pressed) {
                    return fail("the other foot is on the ice".into());
                }
                if last.iter().any(|s| s.foot(foot).gap() > LIFT) {
                    return fail("the foot is off the ice".into());
                }
                if way_along(last, foot).is_some_and(|along| !goes(way, along)) {
                    return fail(format!("does not travel {way:?}"));
                }
            }
            Criterion::Follows { root, turn, joints } => {
                let (mut sum, mut count) = (0.0, 0);
                for (time, error) in samples.iter().filter_map(|s| Some((s.time, s.error?))) {
                    if error.root > root {
                        return fail(format!("{:.2} m away at {time:.2} s", error.root));
                    }
                    if error.root_angle.to_degrees() > turn {
                        return fail(format!("turned by {:.0} degrees at {time:.2} s", error.root_angle.to_degrees()));
                    }
                    (sum, count) = (sum + error.joints.to_degrees(), count + 1);
                }
                let mean = sum / f64::from(count.max(1));
                if count == 0 || mean > joints {
                    return fail(format!("joints off by {mean:.1} degrees"));
                }
            }
            Criterion::Crosses { ahead, aside } => {
                let start = samples[0].root_position;
                if let Some(s) = samples.iter().find(|s| (s.root_position.x - start.x).abs() > aside) {
                    return fail(format!("beside the course at {:.2} s", s.time));
                }
                let way = start.z - samples[samples.len() - 1].root_position.z;
                if way < ahead {
                    return fail(format!("{way:.2} m ahead"));
                }
            }
            Criterion::KeepsHeading { within } => {
                let turned = angle_between(samples[0].facing(), samples[samples.len() - 1].facing()).to_degrees();
                if turned.abs() > within {
                    return fail(format!("turned by {turned:.0} degrees"));
                }
            }
            Criterion::Leaps { rise, clear } => {
                let best = flights(samples)
                    .iter()
                    .map(|f| leap(samples, f))
                    .fold((0.0_f64, 0.0_f64), |best, found| if found.0 > best.0 { found } else { best });
                if best.0 < rise || best.1 < clear {
                    return fail(format!("{:.2} m up, feet {:.2} m clear", best.0, best.1));
                }
            }
            Criterion::ComesToRest { seconds, below } => {
                let last = part(samples, end - seconds, end);
                let fastest = last.iter().map(|s| s.com_velocity.length()).fold(0.0, f64::max);
                if end < seconds || fastest > below {
                    return fail(format!("{fastest:.2} m/s"));
                }
                if let Some(s) = last.iter().find(|s| !(s.feet[0].pressed && s.feet[1].pressed)) {
                    return fail(format!("a foot is off the ground at {:.2} s", s.time));
                }
            }
            Criterion::Jumps { from, way, inside, air_time, turns, to } => {
                let all = flights(settled);
                let Some(flight) = all.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds)) else {
                    return fail("no flight".into());
                };
                if flight.seconds < air_time {
                    return fail(format!("{:.2} s in the air", flight.seconds));
                }
                if flight.turns.abs() < turns {
                    return fail(format!("{:.2} turns", flight.turns));
                }
                let before = &settled[..flight.from];
                if before.last().and_then(|s| s.standing()) != Some(from) {
                    return fail("takes off from the other foot, or from both".into());
                }
                // On its edge: the last quarter of a second in which the whole blade was down.
                let edge: Vec<f64> = before.iter().rev().filter_map(|s| s.foot(from).lean).take(30).collect();
                let lean = edge.iter().sum::<f64>() / edge.len().max(1) as f64;
                if edge.is_empty() || (lean > 0.0) != inside {
                    return fail(format!("leaves on the other edge ({:.0} degrees)", lean.to_degrees()));
                }
                let entry = part(samples, 0.0, SETTLE);
                if way_along(entry, from).is_some_and(|along| !goes(way, along)) {
                    return fail(format!("does not come {way:?}"));
                }
                let landing = settled.get(flight.to).map(|s| s.feet.map(|b| b.pressed));
                if landing.is_none_or(|feet| !feet[side_index(to)] || feet[side_index(to.other())]) {
                    return fail("lands on the other foot, or on both".into());
                }
            }
        }
        Ok(())
    }
}
