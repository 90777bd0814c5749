//! Following a motion with a policy: reference, phase and place of every lane, observations, targets and errors.
//!
//! After Peng, Abbeel, Levine, van de Panne 2018, "DeepMimic: Example-Guided Deep Reinforcement Learning of Physics-Based
//! Character Skills", with the residual actions of Yu, Park, Lee 2019, Section 6.2: a policy's action displaces the
//! reference pose that stable PD servos track. Training and games run this same code.
//!
//! The reference lives in a world of its own; an **anchor** (a place and a heading for each lane) puts it into the real
//! one. With a largest drift the anchor follows the character, so that a pushed skater goes on from where it is; without one the
//! reference keeps its place.

mod errors;
mod gait;
mod state;

use crate::contact::Terrain;
use crate::control::terms::{BodyFrame, ObservationLayout, ObservationTerm, View};
use crate::control::tracking::gathered::Gathered;
use crate::control::tracking::{AllLanes, Heading, SeenBody, Support, TrackedMotion, TrackedTick};
use crate::math::{Quat, Real, Vec3};
use crate::model::ModelPose;
use crate::sim::Simulator;
use std::sync::Arc;

pub use errors::TrackingTerms;

/// How a motion is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackerOptions {
    /// Offset of a joint's target for an action of one, rad.
    pub action_scale: f64,
    /// Part of a tick over which targets move to their new place, so that they do not jump; (0, 1].
    pub ramp: f64,
    /// How far the reference may be from the character before it is dragged along, m; `None` leaves it in place.
    pub max_reference_drift: Option<f64>,
    /// Sine of the angle by which the reference's heading may differ before it is dragged along.
    pub max_heading_drift: f64,
    /// How fast a gait goes over to another speed, m/s^2.
    pub acceleration: f64,
    /// Servo gains for all joints (kp N m/rad, kd N m s/rad) in place of the character's.
    pub gains: Option<(f64, f64)>,
}

impl Default for TrackerOptions {
    fn default() -> Self {
        Self {
            action_scale: 0.3,
            ramp: 0.5,
            max_reference_drift: None,
            max_heading_drift: 0.5,
            acceleration: 1.5,
            gains: None,
        }
    }
}

/// How fast the reference's height follows a foothold, m in a decision: a step up or down is taken over two or three of them.
const FOLLOW_HEIGHT: f64 = 0.05;
/// Where the part over the ground of the root's -Z axis (body or reference) is shorter than this, the reference's heading is left as it is.
const CERTAIN: f64 = 0.5;
/// Height above the root from which the ground ahead is looked for, m.
const SCAN_FROM: f64 = 0.5;

/// Reference, phase, place and targets of every lane.
#[derive(Clone, Debug)]
pub struct Tracker<R: Real> {
    motion: Arc<TrackedMotion>,
    options: TrackerOptions,
    ticks: Vec<usize>,
    /// Of a gait: how far each lane is between its tick and the next, and how fast it goes, m/s.
    fractions: Vec<f64>,
    paces: Vec<f64>,
    /// Where a gait is worked out.
    sampled: TrackedTick,
    /// Of a gait: how it leans, as the tangent of half the angle, positive to the right; and the last turn that was commanded, rad in a tick.
    lean: R,
    turning: R,
    anchor_heading: Heading<R>,
    anchor_place: Vec3<R>,
    speed: R,
    /// The ground under the last foothold.
    support: Support<R>,
    /// What is seen beside the body: the skill's parameters, and heights ahead.
    parameters: Vec<R>,
    /// The parameters of each lane as the skill file has them.
    values: Vec<Vec<f64>>,
    scan: Vec<R>,
    layout: Arc<ObservationLayout>,
    now: Gathered<R>,
    next: Gathered<R>,
    from: Vec<Quat<R>>,
    to: Vec<Quat<R>>,
    /// What the policy says of the gains, -1 to 1.
    alphas: Vec<R>,
}

impl<R: Real> Tracker<R> {
    /// A tracker with every lane at the motion's start, on level ground; its policy sees what `layout` says.
    pub fn new(motion: Arc<TrackedMotion>, options: TrackerOptions, layout: Arc<ObservationLayout>) -> Self {
        let now = Gathered::new(&motion);
        let links = now.joints.len();
        let scan = layout.terms.iter().map(ObservationTerm::heights_ahead).map(<[f64]>::len).sum();
        Self {
            options,
            support: Support::level(),
            parameters: vec![R::zero(); layout.parameters],
            values: vec![vec![0.0; layout.parameters]; R::LANES],
            scan: vec![R::zero(); scan],
            alphas: vec![R::zero(); layout.gains.links.len()],
            layout,
            ticks: vec![0; R::LANES],
            fractions: vec![0.0; R::LANES],
            paces: vec![motion.mean_speed(); R::LANES],
            sampled: motion.tick(0).clone(),
            lean: R::zero(),
            turning: R::zero(),
            anchor_heading: Heading::ahead(),
            anchor_place: Vec3::zero(),
            speed: R::splat(motion.mean_speed()),
            next: now.clone(),
            now,
            from: vec![Quat::identity(); links],
            to: vec![Quat::identity(); links],
            motion,
        }
    }

    /// The motion.
    pub fn motion(&self) -> &Arc<TrackedMotion> {
        &self.motion
    }
    /// How it is followed.
    pub fn options(&self) -> &TrackerOptions {
        &self.options
    }
    /// Tick of a lane.
    pub fn tick(&self, lane: usize) -> usize {
        self.ticks[lane]
    }
    /// True once a motion that ends is at its end.
    pub fn is_finished(&self, lane: usize) -> bool {
        self.motion.cycle().is_none() && self.ticks[lane] >= self.motion.last()
    }
    /// Commands a mean speed along the direction of travel, m/s.
    pub fn set_speed(&mut self, lane: usize, speed: f64) {
        self.speed.set_lane(lane, speed);
    }
    /// The ground under the last foothold of every lane.
    pub fn support(&self) -> &Support<R> {
        &self.support
    }
    /// Tells a lane what carries it: the height of the ground (world, m) and its level velocity (m/s).
    pub fn set_support(&mut self, lane: usize, height: f64, velocity: glam::DVec3) {
        self.support.height.set_lane(lane, height);
        self.support.velocity.set_lane(lane, glam::DVec3::new(velocity.x, 0.0, velocity.z));
    }
    /// Sets the skill's parameters of a lane: `values` as the skill file has them, `seen` from -1 to 1 over their ranges. The reference
    /// is warped to them.
    pub fn set_parameters(&mut self, lane: usize, values: &[f64], seen: &[f64]) {
        for (mine, value) in self.parameters.iter_mut().zip(seen) {
            mine.set_lane(lane, *value);
        }
        self.values[lane].clear();
        self.values[lane].extend_from_slice(values);
        self.enter(lane, self.ticks[lane]);
    }
    /// The skill's parameters of a lane, as the skill file has them.
    pub fn parameters(&self, lane: usize) -> &[f64] {
        &self.values[lane]
    }
    /// Looks at the ground: what carries each lane, and what is ahead. Call it before the decisions, once a tick.
    pub fn sense(&mut self, sim: &mut Simulator<R>, terrain: &impl Terrain<R>) {
        self.sense_support(sim, terrain);
        self.look_ahead(sim, terrain);
    }
    /// Looks at what carries each lane. Where body and reference both have a foothold, the reference's height goes along with the body's.
    pub fn sense_support(&mut self, sim: &mut Simulator<R>, terrain: &impl Terrain<R>) {
        let stands = self.support.update(sim, terrain) & R::splat(0.5).lt(self.now.stands);
        if R::any(stands) {
            let most = R::splat(FOLLOW_HEIGHT);
            let away = self.support.height - self.now.support - self.anchor_place.y;
            self.anchor_place.y += away.clamp(-most, most).masked(stands);
        }
    }
    /// Looks at how the ground below moves, before the first step of a lane that was put there.
    pub fn sense_start(&mut self, sim: &mut Simulator<R>, terrain: &impl Terrain<R>) {
        self.support.look_below(sim, terrain);
    }
    /// Looks at the heights ahead, where the policy sees some. Of use alone before the first decision, and for lanes that were put
    /// somewhere else.
    pub fn look_ahead(&mut self, sim: &Simulator<R>, terrain: &impl Terrain<R>) {
        if !self.scan.is_empty() {
            let root = sim.state.root_position;
            let ahead = Heading::of(sim.state.root_rotation).to_world(Vec3::splat(glam::DVec3::NEG_Z));
            let from = root + Vec3::new(R::zero(), R::splat(SCAN_FROM), R::zero());
            let mut left = &mut self.scan[..];
            for distances in self.layout.terms.iter().map(ObservationTerm::heights_ahead) {
                let (heights, rest) = left.split_at_mut(distances.len());
                terrain.scan(from, ahead, distances, heights);
                left = rest;
            }
        }
    }
    /// Heights of the ground at `distances` (m) ahead of the root on the reference's way, m against what carries each lane.
    pub fn profile(&self, sim: &Simulator<R>, terrain: &impl Terrain<R>, distances: &[f64], heights: &mut [R]) {
        let from = sim.state.root_position + Vec3::new(R::zero(), R::splat(SCAN_FROM), R::zero());
        terrain.scan(from, self.way(), distances, heights);
        for height in heights {
            *height -= self.support.height;
        }
    }
    /// The way that the reference goes over the ground, world axes. Unlike the root's, it does not sway with every step.
    pub fn way(&self) -> Vec3<R> {
        let mut ahead = self.anchor_heading.to_world(self.now.travel);
        ahead.y = R::zero();
        ahead
    }
    /// Sets the servo gains that the options ask for, in every lane.
    pub fn set_gains(&self, sim: &mut Simulator<R>) {
        if let Some((kp, kd)) = self.options.gains {
            for command in sim.commands.iter_mut().skip(1) {
                command.kp = R::splat(kp);
                command.kd = R::splat(kd);
            }
        }
    }

    /// Puts lane `lane` at tick `tick` of the motion, with the reference's pose and velocity; the root above the origin.
    /// The commanded speed is added along the direction of travel; `start_speed` (m/s) is that of the body itself.
    pub fn begin(&mut self, sim: &mut Simulator<R>, lane: usize, tick: usize, start_speed: f64) {
        self.begin_at(sim, lane, tick, start_speed, Heading::ahead(), glam::DVec3::ZERO);
    }

    /// [`Tracker::begin`] with the reference's world turned by `heading` and the root above `place` (world, m).
    pub fn begin_at(
        &mut self,
        sim: &mut Simulator<R>,
        lane: usize,
        tick: usize,
        start_speed: f64,
        heading: Heading<f64>,
        place: glam::DVec3,
    ) {
        let motion = self.motion.clone();
        self.paces[lane] = motion.pace(start_speed);
        let reference = motion.at_pace(tick, self.paces[lane]);
        let (p, v) = (&reference.pose, &reference.velocity);
        self.enter(lane, tick);
        self.anchor(lane, heading, place);
        let turn = heading.to_quat().lane(0);
        let turned = |v: glam::DVec3| heading.to_world(Vec3::splat(v)).lane(0);
        let now = self.now.root_position.lane(lane);
        let root = glam::DVec3::new(place.x, now.y + place.y, place.z);
        self.set_support(lane, self.now.support.lane(lane) + place.y, glam::DVec3::ZERO);
        sim.state.set_pose(lane, root, turn * p.root_rotation, &p.joints);
        let mean = if motion.levels().is_empty() { motion.mean_speed() } else { self.paces[lane] };
        let added = reference.travel * (start_speed - mean);
        sim.state.set_velocity(lane, turned(v.root_linear + added), turned(v.root_angular), &v.joints);
        for impulse in sim.state.contact_impulses.iter_mut().chain(&mut sim.state.grip_impulses) {
            impulse.set_lane(lane, glam::DVec3::ZERO);
        }
        sim.state_changed();
        for (i, q) in p.joints.iter().enumerate() {
            self.from[i].set_lane(lane, *q);
            self.to[i].set_lane(lane, *q);
        }
    }

    /// Takes lane `lane` over as it moves: the reference goes on from tick `tick`, put where the body is and turned so that
    /// both travel the same way (face the same way, where the body is slower than 0.5 m/s). Targets start from where the
    /// servos have them.
    pub fn join(&mut self, sim: &mut Simulator<R>, lane: usize, tick: usize) {
        let mass = sim.model().mass();
        let velocity = sim.total_momentum().linear.lane(lane) / mass;
        let motion = self.motion.clone();
        let level = velocity * glam::DVec3::new(1.0, 0.0, 1.0);
        self.paces[lane] = motion.pace(level.length());
        let reference = motion.at_pace(tick, self.paces[lane]);
        self.enter(lane, tick);
        let scalar = |q: glam::DQuat| Heading::of(Quat::<f64>::splat(q));
        let (goes, faces) = (glam::DVec3::new(velocity.x, 0.0, velocity.z), sim.state.root_rotation.lane(lane));
        let heading = if goes.length() > 0.5 {
            Heading::towards(goes).relative_to(Heading::towards(reference.travel))
        } else {
            scalar(faces).relative_to(scalar(reference.pose.root_rotation))
        };
        let mut place = sim.state.root_position.lane(lane);
        place.y = self.support.height.lane(lane) - self.now.support.lane(lane);
        self.anchor(lane, heading.normalized(), place);
        for (i, command) in sim.commands.iter().enumerate() {
            self.from[i].set_lane(lane, command.rotation.lane(lane));
            self.to[i].set_lane(lane, command.rotation.lane(lane));
        }
    }

    /// Puts the reference of a lane, turned by `heading`, with its root above `place`, whose height is that of its ground.
    fn anchor(&mut self, lane: usize, heading: Heading<f64>, place: glam::DVec3) {
        self.lean.set_lane(lane, 0.0);
        self.turning.set_lane(lane, 0.0);
        let root = self.now.root_position.lane(lane);
        let offset = heading.to_world(Vec3::<f64>::splat(root)).lane(0);
        self.anchor_heading.c.set_lane(lane, heading.c);
        self.anchor_heading.s.set_lane(lane, heading.s);
        self.anchor_place.set_lane(lane, glam::DVec3::new(place.x - offset.x, place.y, place.z - offset.z));
    }

    /// Turns the reference of every lane about its root by a small angle (rad, positive to the left), once a tick: steering. A gait leans into the
    /// turn, and takes steps on the spot for one where it stands.
    pub fn steer(&mut self, angle: R) {
        self.turning = angle;
        self.turn(angle);
    }

    fn turn(&mut self, angle: R) {
        let pivot = self.reference_root();
        let by = Heading { c: R::one() - angle * angle * R::splat(0.5), s: angle };
        self.anchor_heading = self.anchor_heading.turned(by).normalized();
        let height = self.anchor_place.y;
        self.anchor_place = pivot - self.anchor_heading.to_world(self.leaned(self.now.root_position, &self.now));
        self.anchor_place.y = height;
    }

    /// Where the root of lane `lane` is over the ground at tick `tick` of the motion's own world, m, warped to the lane's parameters.
    pub fn place_of(&mut self, lane: usize, tick: usize) -> glam::DVec3 {
        self.enter(lane, tick);
        self.now.root_position.lane(lane) * glam::DVec3::new(1.0, 0.0, 1.0)
    }

    /// Height of what carries lane `lane` at tick `tick` in the motion's own world, m, warped to the lane's parameters.
    pub fn support_of(&mut self, lane: usize, tick: usize) -> f64 {
        self.enter(lane, tick);
        self.now.support.lane(lane)
    }

    fn enter(&mut self, lane: usize, tick: usize) {
        self.enter_at(lane, tick, 0.0);
    }

    fn enter_at(&mut self, lane: usize, tick: usize, fraction: f64) {
        self.ticks[lane] = tick;
        self.fractions[lane] = fraction;
        if !self.motion.levels().is_empty() {
            let phase = tick as f64 + fraction;
            self.stride(lane, phase);
            return;
        }
        self.now.set_lane(lane, &self.motion, tick, &self.values[lane]);
        self.next.set_lane(lane, &self.motion, self.following(tick), &self.values[lane]);
    }

    /// The tick after `tick`, counted within the cycle for its pose.
    fn following(&self, tick: usize) -> usize {
        match self.motion.cycle() {
            Some(_) if tick >= self.motion.last() => 1,
            _ => (tick + 1).min(self.motion.last()),
        }
    }

    /// The turn from the clip's own world to that of lane `lane`'s reference.
    pub fn heading(&self, lane: usize) -> Heading<f64> {
        Heading { c: self.anchor_heading.c.lane(lane), s: self.anchor_heading.s.lane(lane) }
    }

    /// Where the reference's root is, world frame, m.
    pub fn reference_root(&self) -> Vec3<R> {
        self.anchor_heading.to_world(self.leaned(self.now.root_position, &self.now)) + self.anchor_place
    }

    /// Rotation of a joint of the reference.
    pub(in crate::control::tracking) fn reference_joint(&self, link: usize) -> Quat<R> {
        self.now.joints[link]
    }

    /// Rotation of the reference's root, world frame.
    pub fn reference_rotation(&self) -> Quat<R> {
        self.rotation_of(&self.now)
    }

    fn rotation_of(&self, reference: &Gathered<R>) -> Quat<R> {
        let own = reference.root_rotation;
        self.anchor_heading.to_quat()
            * if self.motion.levels().is_empty() { own } else { self.lean_rotation(reference) * own }
    }

    /// The reference pose of lane `lane` in the world, for ghosts and storyboards.
    pub fn reference_pose(&self, lane: usize) -> ModelPose {
        self.placed(&self.now, lane)
    }

    /// The reference pose at the fraction `part` in [0, 1] of the tick; where a motion begins anew, that at its start.
    pub fn reference_pose_at(&self, lane: usize, part: f64) -> ModelPose {
        let begins_anew = self.motion.cycle().is_some() && self.ticks[lane] >= self.motion.last();
        let now = self.placed(&self.now, lane);
        if !self.motion.levels().is_empty() {
            let mut next = self.placed(&self.next, lane);
            next.root_position += self.gone(lane);
            return now.mix(&next, part.clamp(0.0, 1.0));
        }
        if begins_anew || part <= 0.0 { now } else { now.mix(&self.placed(&self.next, lane), part.min(1.0)) }
    }

    /// A reference in the world.
    fn placed(&self, reference: &Gathered<R>, lane: usize) -> ModelPose {
        let root = self.anchor_heading.to_world(self.leaned(reference.root_position, reference)) + self.anchor_place;
        ModelPose {
            root_position: root.lane(lane),
            root_rotation: self.rotation_of(reference).lane(lane),
            joints: reference.joints.iter().map(|q| q.lane(lane)).collect(),
        }
    }

    /// Velocity that the reference's centre of mass has at the commanded speed, world axes, m/s.
    #[inline]
    fn wanted_velocity(&self) -> Vec3<R> {
        // A gait is at its pace.
        let mean = R::splat(self.motion.mean_speed());
        let added = if self.motion.levels().is_empty() { self.speed - mean } else { R::zero() };
        self.anchor_heading.to_world(self.now.travel.mul_add(added, self.now.com_velocity)) + self.support.velocity
    }

    /// What a policy sees, appended to `out` in the order of [`ObservationLayout`](super::ObservationLayout).
    pub fn observe(&self, sim: &mut Simulator<R>, out: &mut Vec<R>) {
        self.observe_body(&AllLanes::of(sim), out);
    }

    /// [`Tracker::observe`] of a body that may be in a lane of a simulator of another kind.
    #[inline]
    pub(crate) fn observe_body(&self, body: &impl SeenBody<R>, out: &mut Vec<R>) {
        let view = View {
            now: &self.now,
            next: &self.next,
            reference_root: self.reference_root(),
            reference_rotation: self.reference_rotation(),
            wanted_velocity: self.wanted_velocity(),
            speed: self.speed,
            support: &self.support,
            parameters: &self.parameters,
            scan: &self.scan,
        };
        let frame = BodyFrame::of(body);
        for term in &self.layout.terms {
            term.write(&view, body, &frame, out);
        }
    }

    /// Sets the targets of the coming tick: the next reference pose, displaced by the action. `action` gives for a link
    /// (from 1) its three numbers.
    pub fn act(&mut self, mut action: impl FnMut(usize) -> Vec3<R>) {
        let scale = R::splat(0.5 * self.options.action_scale);
        core::mem::swap(&mut self.from, &mut self.to);
        for i in 1..self.to.len() {
            let v = action(i) * scale;
            let s = (R::one() + v.length_squared()).sqrt().recip();
            self.to[i] = self.next.joints[i] * Quat { v: v * s, w: s };
        }
    }

    /// Number of links of the body, the root included.
    pub fn links(&self) -> usize {
        self.to.len()
    }

    /// Sets the gains of the coming tick where the policy has a say in them: `alpha` gives the number of each, -1 to 1.
    pub fn act_gains(&mut self, mut alpha: impl FnMut(usize) -> R) {
        for (k, value) in self.alphas.iter_mut().enumerate() {
            *value = alpha(k).clamp(-R::one(), R::one());
        }
    }

    /// Writes the targets into the simulator's commands, at the fraction `part` in [0, 1] of the tick.
    pub fn command(&self, sim: &mut Simulator<R>, part: f64) {
        let blend = R::splat((part / self.options.ramp).min(1.0));
        for i in 1..self.to.len() {
            let (a, b) = (self.from[i], self.to[i]);
            let dot = a.v.dot(b.v) + a.w * b.w;
            let sign = R::select(dot.lt(R::zero()), -R::one(), R::one());
            let w = (b.w * sign - a.w).mul_add(blend, a.w);
            let v = (b.v * sign - a.v).mul_add(blend, a.v);
            let inverse = w.mul_add(w, v.length_squared()).sqrt().recip();
            let command = &mut sim.commands[i];
            command.rotation = Quat { v: v * inverse, w: w * inverse };
            command.velocity = self.next.joint_velocities[i];
        }
        for (k, (&link, alpha)) in self.layout.gains.links.iter().zip(&self.alphas).enumerate() {
            let (kp, kd) = self.layout.gains.gains(k, *alpha);
            (sim.commands[link].kp, sim.commands[link].kd) = (kp, kd);
        }
    }

    /// The next tick: references move on, and their places follow the characters that are too far away.
    pub fn advance(&mut self, sim: &Simulator<R>) {
        core::mem::swap(&mut self.now, &mut self.next);
        let motion = self.motion.clone();
        let gravity = sim.settings().gravity.length();
        for lane in 0..R::LANES {
            if !motion.levels().is_empty() {
                self.stride_on(lane, gravity);
                continue;
            }
            let tick = self.ticks[lane];
            let following = self.following(tick);
            if let Some(cycle) = motion.cycle()
                && tick >= motion.last()
            {
                // Tick `last` is tick 0 of the next cycle, one shift further.
                let heading = self.heading(lane);
                let turned = heading.turned(Heading { c: cycle.turn.0, s: cycle.turn.1 }).normalized();
                let moved = heading.to_world(Vec3::splat(cycle.shift)).lane(0) + self.anchor_place.lane(lane);
                self.anchor_heading.c.set_lane(lane, turned.c);
                self.anchor_heading.s.set_lane(lane, turned.s);
                self.anchor_place.set_lane(lane, moved);
            }
            self.ticks[lane] = following;
            self.next.set_lane(lane, &motion, self.following(following), &self.values[lane]);
        }
        // What carries the body carries its reference too.
        let tick = R::splat(1.0 / motion.tick_rate());
        self.anchor_place += self.support.velocity * tick;
        if let Some(max_reference_drift) = self.options.max_reference_drift {
            self.follow(sim, max_reference_drift);
        }
    }

    /// Drags the anchors along: first their headings, then their places.
    fn follow(&mut self, sim: &Simulator<R>, max_reference_drift: f64) {
        let (body, reference) = (sim.state.root_rotation, self.reference_rotation());
        let turn = Heading::of(body).relative_to(Heading::of(reference));
        let limit = R::splat(self.options.max_heading_drift);
        let over = (turn.s - limit).max(R::zero()) + (turn.s + limit).min(R::zero());
        // Head over heels the heading jumps by half a turn: nothing to follow.
        let certain = Heading::certainty(body).min(Heading::certainty(reference));
        self.turn(over.masked(R::splat(CERTAIN).lt(certain)));

        let mut away = sim.state.root_position - self.reference_root();
        away.y = R::zero();
        let distance = away.length().max(R::splat(1e-6));
        let part = ((distance - R::splat(max_reference_drift)).max(R::zero())) / distance;
        self.anchor_place += away * part;
    }
}
