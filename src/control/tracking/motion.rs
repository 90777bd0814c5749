//! A clip prepared for tracking: what the body should be like at every tick of the controller.

mod gaits;

use crate::asset::clip::{ClipError, MotionClip};
use crate::control::tracking::Warp;
use crate::control::tracking::mirror::{image, image_of_rotation, image_of_turn};
use crate::control::{Reference, ReferenceTick};
use crate::dynamics::{LinkConstants, LinkKinematics, State, momentum, totals, update_positions, update_velocities};
use crate::math::Vec3;
use crate::model::{CharacterModel, ModelPose, ModelVelocity, PointRole};
use glam::{DQuat, DVec3};

pub use gaits::GaitLevel;

/// Over how long the ends of a cycle are blended, s.
const SEAM: f64 = 0.2;
/// Height above the ground up to which a foot of a motion stands, m.
pub const STANDS: f64 = 0.03;
/// Half of the time over which the direction of travel is taken, s.
const TRAVEL_SPAN: f64 = 0.4;

/// What the body should be like at one tick, in the clip's own world.
#[derive(Clone, Debug)]
pub struct TrackedTick {
    /// The pose.
    pub pose: ModelPose,
    /// How fast it changes.
    pub velocity: ModelVelocity,
    /// Centre of mass, m.
    pub com: DVec3,
    /// Its velocity, m/s.
    pub com_velocity: DVec3,
    /// Origins of the end links (see [`TrackedMotion::ends`]) relative to the root, m.
    pub ends: Vec<DVec3>,
    /// Horizontal direction of travel, unit; along it the commanded speed is added.
    pub travel: DVec3,
    /// Where in the motion the tick is: [`TrackedMotion::PHASES`] hat functions, of which two neighbours are not zero.
    pub phase: [f64; TrackedMotion::PHASES],
    /// Height of the ground under the last foothold, m.
    pub support: f64,
    /// A foot is on that ground: its lowest point is within [`STANDS`] of it.
    pub stands: bool,
}

/// One turn of a cyclic motion over the ground: `p -> turn * p + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleShift {
    /// Cosine and sine of the turn about the vertical.
    pub turn: (f64, f64),
    /// Shift in the ground plane, m.
    pub shift: DVec3,
}

/// A motion prepared for tracking.
#[derive(Clone, Debug)]
pub struct TrackedMotion {
    ticks: Vec<TrackedTick>,
    cycle: Option<CycleShift>,
    tick_rate: f64,
    mean_speed: f64,
    ends: Vec<usize>,
    warps: Vec<Warp>,
    levels: Vec<GaitLevel>,
    /// Of a gait: the tick in the first half of its cycle at which both feet are nearest to the ground.
    both_down: usize,
}

impl TrackedMotion {
    /// Number of hat functions that tell the phase.
    pub const PHASES: usize = 10;

    /// Prepares a motion that ends: its last pose is held for `hold` seconds at the last velocity of the centre of mass.
    pub fn once(clip: &MotionClip, model: &CharacterModel, tick_rate: f64, hold: f64) -> Result<Self, ClipError> {
        let reference = Reference::new(&clip.to_model(model)?, tick_rate, None);
        let mut ticks = reference.ticks;
        let mut last = ticks[ticks.len() - 1].clone();
        let glide = ticks[ticks.len().saturating_sub(3)].velocity.root_linear * DVec3::new(1.0, 0.0, 1.0);
        for _ in 0..(hold * tick_rate).round() as usize {
            last.pose.root_position += glide / tick_rate;
            last.velocity = ModelVelocity { root_linear: glide, ..ModelVelocity::zero(model) };
            ticks.push(last.clone());
        }
        Ok(Self::prepare(model, ticks, tick_rate, None))
    }

    /// Prepares one cycle of a motion that repeats: the last pose counts as the first of the next cycle, moved along the
    /// ground and turned about the vertical (kept straight if `straight`). The cycle's time is rounded to whole ticks.
    pub fn cyclic(
        clip: &MotionClip,
        model: &CharacterModel,
        tick_rate: f64,
        straight: bool,
    ) -> Result<Self, ClipError> {
        let count = (clip.duration() * tick_rate).round().max(1.0);
        let clip = clip.time_scaled(count / tick_rate / clip.duration().max(1e-3))?;
        let clip = if straight { clip.repeated_straight(3, SEAM)? } else { clip.repeated(3, SEAM)? };
        let reference = Reference::new(&clip.to_model(model)?, tick_rate, None);
        let n = count as usize;
        let ticks = reference.ticks[n..=2 * n].to_vec();
        let (from, to) = (&ticks[0].pose, &ticks[n].pose);
        let turn = if straight {
            DQuat::IDENTITY
        } else {
            crate::asset::turn::twist(to.root_rotation * from.root_rotation.conjugate(), DVec3::Y)
        };
        let mut shift = to.root_position - turn * from.root_position;
        shift.y = 0.0;
        let ahead = turn * DVec3::X;
        let cycle = CycleShift { turn: (ahead.x, -ahead.z), shift };
        Ok(Self::prepare(model, ticks, tick_rate, Some(cycle)))
    }

    fn prepare(
        model: &CharacterModel,
        reference: Vec<ReferenceTick>,
        tick_rate: f64,
        cycle: Option<CycleShift>,
    ) -> Self {
        let ends = model.end_links();
        let constants = LinkConstants::<f64>::of(model);
        let mut state = State::<f64>::at_rest(model);
        let mut links = vec![LinkKinematics::default(); model.links.len()];
        let mass = model.mass();
        let count = reference.len();
        let span = (count - 1).max(1) as f64;
        let mut ticks: Vec<TrackedTick> = reference
            .into_iter()
            .enumerate()
            .map(|(k, tick)| {
                let (p, v) = (tick.pose, tick.velocity);
                state.set_pose(0, p.root_position, p.root_rotation, &p.joints);
                state.set_velocity(0, v.root_linear, v.root_angular, &v.joints);
                update_positions(&constants, &state, &mut links);
                update_velocities(&constants, &state, &mut links);
                let com = totals(&constants, &links, mass).com;
                let moving = momentum(&constants, &links, com).linear.lane(0) / mass;
                TrackedTick {
                    com: p.root_position + com.lane(0),
                    com_velocity: moving,
                    ends: ends.iter().map(|&i| links[i].origin.lane(0)).collect(),
                    travel: DVec3::ZERO,
                    phase: phase_hats(k as f64 / span, cycle.is_some()),
                    support: 0.0,
                    stands: lowest_foot(model, &links) + p.root_position.y < STANDS,
                    pose: p,
                    velocity: v,
                }
            })
            .collect();

        // The direction of travel: from the centre of mass some time before to some time after.
        let reach = ((TRAVEL_SPAN * tick_rate).round() as isize).max(1);
        let last = count as isize - 1;
        let place = |k: isize| -> DVec3 {
            match &cycle {
                Some(c) if k > last => c.apply(ticks[((k - last) as usize).min(count - 1)].com),
                Some(c) if k < 0 => c.inverse().apply(ticks[((k + last).max(0)) as usize].com),
                _ => ticks[k.clamp(0, last) as usize].com,
            }
        };
        let mut before = DVec3::NEG_Z;
        let directions: Vec<DVec3> = (0..count as isize)
            .map(|k| {
                let way = (place(k + reach) - place(k - reach)) * DVec3::new(1.0, 0.0, 1.0);
                before = way.try_normalize().filter(|_| way.length() > 0.05).unwrap_or(before);
                before
            })
            .collect();
        for (tick, travel) in ticks.iter_mut().zip(directions) {
            tick.travel = travel;
        }
        let mean_speed = ticks.iter().map(|t| t.com_velocity.dot(t.travel)).sum::<f64>() / count as f64;
        Self { ticks, cycle, tick_rate, mean_speed, ends, warps: Vec::new(), levels: Vec::new(), both_down: 0 }
    }

    /// The mirror image, its left and right exchanged; `links` has for each link the one on the other side (see
    /// [`mirror_links`](super::mirror_links)).
    pub fn mirrored(&self, links: &[usize]) -> Self {
        let swapped = |list: &[DQuat]| links.iter().map(|&i| image_of_rotation(list[i])).collect();
        let end_of = |end: &usize| self.ends.iter().position(|e| *e == links[*end]);
        let ends: Vec<usize> = self.ends.iter().enumerate().map(|(k, end)| end_of(end).unwrap_or(k)).collect();
        let ticks = |ticks: &[TrackedTick]| {
            ticks
                .iter()
                .map(|t| TrackedTick {
                    pose: ModelPose {
                        root_position: image(t.pose.root_position),
                        root_rotation: image_of_rotation(t.pose.root_rotation),
                        joints: swapped(&t.pose.joints),
                    },
                    velocity: ModelVelocity {
                        root_linear: image(t.velocity.root_linear),
                        root_angular: image_of_turn(t.velocity.root_angular),
                        joints: links.iter().map(|&i| image_of_turn(t.velocity.joints[i])).collect(),
                    },
                    com: image(t.com),
                    com_velocity: image(t.com_velocity),
                    ends: ends.iter().map(|&k| image(t.ends[k])).collect(),
                    travel: image(t.travel),
                    phase: t.phase,
                    support: t.support,
                    stands: t.stands,
                })
                .collect::<Vec<_>>()
        };
        let cycle = |c: &CycleShift| CycleShift { turn: (c.turn.0, -c.turn.1), shift: image(c.shift) };
        Self {
            ticks: ticks(&self.ticks),
            levels: self.levels.iter().map(|l| GaitLevel { ticks: ticks(&l.ticks), ..*l }).collect(),
            cycle: self.cycle.as_ref().map(cycle),
            ends: self.ends.clone(),
            warps: self.warps.iter().map(Warp::mirrored).collect(),
            ..*self
        }
    }

    /// The same motion, warped to parameters of its skill.
    pub fn with_warps(mut self, warps: Vec<Warp>) -> Self {
        self.warps = warps;
        self
    }
    /// How parameters of the skill move it.
    pub fn warps(&self) -> &[Warp] {
        &self.warps
    }
    /// Says which ground each tick's foothold is on: `ground` gives the height (m) below a point of the clip's world. Between footholds
    /// the last one counts.
    pub fn stand_on(&mut self, model: &CharacterModel, ground: impl Fn(DVec3) -> f64) {
        let mut places = Vec::with_capacity(model.links.len());
        let mut support = 0.0;
        for tick in &mut self.ticks {
            tick.pose.link_transforms(model, &mut places);
            let gap = |p: usize| {
                let point = &model.contact_points[p];
                let place = places[point.link].position + places[point.link].rotation * point.position;
                let height = ground(place);
                (place.y - point.radius - height, height)
            };
            let lowest = model.points(PointRole::Foot).map(gap).reduce(|a, b| if b.0 < a.0 { b } else { a });
            tick.stands = lowest.is_some_and(|(gap, _)| gap < STANDS);
            if let Some((_, height)) = lowest.filter(|_| tick.stands) {
                support = height;
            }
            tick.support = support;
        }
    }

    /// Ticks per second.
    pub fn tick_rate(&self) -> f64 {
        self.tick_rate
    }
    /// Index of the last tick; in a cyclic motion it is the first of the next cycle.
    pub fn last(&self) -> usize {
        self.ticks.len() - 1
    }
    /// The tick with this index, clamped.
    pub fn tick(&self, index: usize) -> &TrackedTick {
        &self.ticks[index.min(self.last())]
    }
    /// How a cycle moves over the ground; `None` for a motion that ends.
    pub fn cycle(&self) -> Option<&CycleShift> {
        self.cycle.as_ref()
    }
    /// Length of the motion or of one cycle, s.
    pub fn duration(&self) -> f64 {
        self.last() as f64 / self.tick_rate
    }
    /// Mean speed of the centre of mass along the direction of travel, m/s.
    pub fn mean_speed(&self) -> f64 {
        self.mean_speed
    }
    /// The links without children, whose places are compared.
    pub fn ends(&self) -> &[usize] {
        &self.ends
    }
}

impl CycleShift {
    /// Where a point of one cycle is in the next, m.
    pub fn apply(&self, p: DVec3) -> DVec3 {
        let (c, s) = self.turn;
        DVec3::new(c * p.x + s * p.z, p.y, c * p.z - s * p.x) + self.shift
    }
    /// The way back.
    pub fn inverse(&self) -> Self {
        let (c, s) = self.turn;
        let back = Self { turn: (c, -s), shift: DVec3::ZERO };
        Self { shift: -back.apply(self.shift), ..back }
    }
}

/// Height of the lowest point of the feet above the root, m; infinite for a body without feet.
fn lowest_foot(model: &CharacterModel, links: &[LinkKinematics<f64>]) -> f64 {
    let bottom = |p: usize| {
        let point = &model.contact_points[p];
        let link = &links[point.link];
        (link.origin + link.rotation.mul_vec(Vec3::splat(point.position))).y - point.radius
    };
    model.points(PointRole::Foot).map(bottom).fold(f64::INFINITY, f64::min)
}

/// Hat functions around evenly spaced centres: on a ring for a motion that repeats, from start to end for one that ends.
/// Piecewise linear, so the same bits everywhere.
fn phase_hats(phase: f64, ring: bool) -> [f64; TrackedMotion::PHASES] {
    let n = TrackedMotion::PHASES as f64;
    core::array::from_fn(|k| {
        let (spacing, x) = if ring { (n, phase * n) } else { (n - 1.0, phase * (n - 1.0)) };
        let mut away = (x - k as f64).abs();
        if ring {
            away = away.min((spacing - away).abs());
        }
        (1.0 - away).max(0.0)
    })
}
