//! What a policy may see, term by term.

use super::image::{Source, TURN, VECTOR};
use crate::control::tracking::{Gathered, Heading, SeenBody, Support, TrackedMotion};
use crate::math::{Motion, Quat, Real, Vec3};
use crate::model::{CharacterModel, Foot, FootKind, Side};
use serde::{Deserialize, Serialize};

/// Heights of feet are cut at these, m.
const FOOT_HEIGHTS: (f64, f64) = (-0.1, 0.5);
/// Heights ahead are cut at this to either side, m.
const SCAN_CUT: f64 = 2.0;

/// One term of an observation. In a skill file: `observe: [FootForces, Parameters, HeightScan(distances: [0.5, 1.0])]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ObservationTerm {
    /// Place in the motion: hat functions, of which two neighbours are not zero.
    Phase,
    /// The world's up direction in the root's axes.
    Up,
    /// Height of the root above what carries the body, m.
    RootHeight,
    /// Velocity of the root against what carries the body, heading frame, m/s.
    RootVelocity,
    /// Angular velocity of the root, heading frame, rad/s.
    RootSpin,
    /// Rotation vector from the root to the reference's, root axes, rad.
    RootTurn,
    /// Wanted minus present velocity of the centre of mass, heading frame, m/s.
    ComVelocityError,
    /// Cosine and sine of the turn from the root's heading to the reference's.
    Heading,
    /// From the root to the reference's, heading frame, m.
    Offset,
    /// Commanded speed, m/s.
    Speed,
    /// Origin (m) and velocity (m/s) of every link against the root, heading frame.
    Links,
    /// Heights of the ends of the blades above what carries the body, m.
    Blades,
    /// Rotation vector to the next reference (rad) and velocity (rad/s) of every joint, child axes.
    Joints,
    /// Heights of the toe and the heel of each foot with a sole above what carries the body, m.
    Soles,
    /// Middle of each foot against the centre of mass (m) and its velocity (m/s), heading frame.
    FootPlaces,
    /// Load on each foot, in body weights.
    FootForces,
    /// The skill's parameters in the order of its file, each from -1 to 1 over its range.
    Parameters,
    /// Heights of the ground ahead of the root against what carries the body, m.
    HeightScan {
        /// How far ahead each is taken along the root's heading, m.
        distances: Vec<f64>,
    },
}

/// What the terms read of the reference and the surroundings.
pub(crate) struct View<'a, R: Real> {
    pub now: &'a Gathered<R>,
    pub next: &'a Gathered<R>,
    pub reference_root: Vec3<R>,
    pub reference_rotation: Quat<R>,
    pub wanted_velocity: Vec3<R>,
    pub speed: R,
    pub support: &'a Support<R>,
    pub parameters: &'a [R],
    pub scan: &'a [R],
}

/// The root of the body, taken once for all terms.
pub(crate) struct BodyFrame<R: Real> {
    position: Vec3<R>,
    rotation: Quat<R>,
    velocity: Motion<R>,
    heading: Heading<R>,
}

impl<R: Real> BodyFrame<R> {
    #[inline(always)]
    pub fn of(body: &impl SeenBody<R>) -> Self {
        let (position, rotation) = body.root();
        Self { position, rotation, velocity: body.root_velocity(), heading: Heading::of(rotation) }
    }
}

#[inline(always)]
fn vector<R: Real>(v: Vec3<R>, out: &mut Vec<R>) {
    out.extend([v.x, v.y, v.z]);
}

/// The feet that stand with a sole.
fn soles(model: &CharacterModel) -> impl Iterator<Item = &Foot> {
    model.feet().iter().filter(|f| f.kind == FootKind::Sole)
}

/// The foot on the other side than foot `k`; itself if there is none.
fn on_other_side(sides: &[Option<Side>], k: usize) -> usize {
    let other = sides[k].map(Side::other);
    sides.iter().position(|s| s.is_some() && *s == other).unwrap_or(k)
}

/// Height of a contact point of the body in the world, m.
#[inline(always)]
fn point_height<R: Real>(body: &impl SeenBody<R>, root: Vec3<R>, point: usize) -> R {
    let p = &body.model().contact_points[point];
    let arm = body.link_rotation(p.link).mul_vec(Vec3::splat(p.position));
    root.y + body.link(p.link).0.y + arm.y
}

impl ObservationTerm {
    /// What every policy sees, in this order.
    pub const STANDARD: [Self; 14] = [
        Self::Phase,
        Self::Up,
        Self::RootHeight,
        Self::RootVelocity,
        Self::RootSpin,
        Self::RootTurn,
        Self::ComVelocityError,
        Self::Heading,
        Self::Offset,
        Self::Speed,
        Self::Links,
        Self::Blades,
        Self::Joints,
        Self::Soles,
    ];

    /// Its name in the contract.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Phase => "phase",
            Self::Up => "up",
            Self::RootHeight => "root_height",
            Self::RootVelocity => "root_velocity",
            Self::RootSpin => "root_spin",
            Self::RootTurn => "root_turn",
            Self::ComVelocityError => "com_velocity_error",
            Self::Heading => "heading",
            Self::Offset => "offset",
            Self::Speed => "speed",
            Self::Links => "links",
            Self::Blades => "blades",
            Self::Joints => "joints",
            Self::Soles => "soles",
            Self::FootPlaces => "foot_places",
            Self::FootForces => "foot_forces",
            Self::Parameters => "parameters",
            Self::HeightScan { .. } => "height_scan",
        }
    }

    /// Its line in the contract.
    pub fn meaning(&self) -> &'static str {
        match self {
            Self::Phase => "place in the motion, hat functions in [0, 1]",
            Self::Up => "world's up, root axes",
            Self::RootHeight => "m above what carries the body",
            Self::RootVelocity => "m/s against what carries the body, heading frame",
            Self::RootSpin => "rad/s, heading frame",
            Self::RootTurn => "rotation vector from the root to the reference's, root axes, rad",
            Self::ComVelocityError => "wanted minus present velocity of the centre of mass, heading frame, m/s",
            Self::Heading => "cosine and sine of the turn from the root's heading to the reference's",
            Self::Offset => "from the root to the reference's, heading frame, m, level parts cut at 1 m",
            Self::Speed => "commanded speed, m/s",
            Self::Links => "origin (m) and velocity (m/s) against the root, heading frame, link by link",
            Self::Blades => "height of toe and heel, m, cut at -0.1 and 0.5",
            Self::Joints => {
                "rotation vector to the next reference (rad) and velocity (rad/s), child axes, joint by joint"
            }
            Self::Soles => "height of toe and heel above the support, m, cut at -0.1 and 0.5, foot by foot",
            Self::FootPlaces => {
                "middle against the centre of mass (m) and its velocity (m/s), heading frame, foot by foot"
            }
            Self::FootForces => "load in body weights, foot by foot",
            Self::Parameters => "parameters of the skill, each from -1 to 1 over its range",
            Self::HeightScan { .. } => "height of the ground ahead against the support, m, cut at 2",
        }
    }

    /// How many numbers it has for a character, and a skill with so many parameters.
    pub fn size(&self, model: &CharacterModel, parameters: usize) -> usize {
        match self {
            Self::Phase => TrackedMotion::PHASES,
            Self::RootHeight | Self::Speed => 1,
            Self::Heading => 2,
            Self::Up | Self::RootVelocity | Self::RootSpin | Self::RootTurn | Self::ComVelocityError | Self::Offset => {
                3
            }
            Self::Links | Self::Joints => 6 * (model.links.len() - 1),
            Self::Blades => 2 * model.blades.len(),
            Self::Soles => 2 * soles(model).count(),
            Self::FootPlaces => 6 * model.feet().len(),
            Self::FootForces => model.feet().len(),
            Self::Parameters => parameters,
            Self::HeightScan { distances } => distances.len(),
        }
    }

    /// How far ahead it looks at the ground, m; empty for terms that do not.
    pub fn heights_ahead(&self) -> &[f64] {
        match self {
            Self::HeightScan { distances } => distances,
            _ => &[],
        }
    }

    /// Appends its numbers to `out`.
    #[inline]
    pub(crate) fn write<R: Real>(
        &self,
        view: &View<R>,
        body: &impl SeenBody<R>,
        frame: &BodyFrame<R>,
        out: &mut Vec<R>,
    ) {
        let (heading, velocity) = (frame.heading, &frame.velocity);
        let model = body.model();
        let cut = |y: R| y.clamp(R::splat(FOOT_HEIGHTS.0), R::splat(FOOT_HEIGHTS.1));
        match self {
            Self::Phase => out.extend(view.now.phase),
            Self::Up => {
                vector(frame.rotation.conjugate().rotate(Vec3::new(R::zero(), R::one(), R::zero())), out);
            }
            Self::RootHeight => out.push(frame.position.y - view.support.height),
            Self::RootVelocity => vector(heading.to_local(velocity.linear - view.support.velocity), out),
            Self::RootSpin => vector(heading.to_local(velocity.angular), out),
            Self::RootTurn => {
                vector((frame.rotation.conjugate() * view.reference_rotation).to_rotation_vector(), out);
            }
            Self::ComVelocityError => vector(heading.to_local(view.wanted_velocity - body.com_velocity()), out),
            Self::Heading => {
                let turn = Heading::of(view.reference_rotation).relative_to(heading);
                out.extend([turn.c, turn.s]);
            }
            Self::Offset => {
                let offset = heading.to_local(view.reference_root - frame.position);
                let one = R::one();
                out.extend([offset.x.clamp(-one, one), offset.y, offset.z.clamp(-one, one)]);
            }
            Self::Speed => out.push(view.speed),
            Self::Links => {
                for link in 1..model.links.len() {
                    let (origin, moves) = body.link(link);
                    vector(heading.to_local(origin), out);
                    vector(heading.to_local(moves - velocity.linear), out);
                }
            }
            Self::Blades => {
                for blade in &model.blades {
                    for point in [blade.toe, blade.heel] {
                        out.push(cut(point_height(body, frame.position, point) - view.support.height));
                    }
                }
            }
            Self::Joints => {
                for (link, target) in view.next.joints.iter().enumerate().skip(1) {
                    let (rotation, velocity) = body.joint(link);
                    vector((rotation.conjugate() * *target).to_rotation_vector(), out);
                    vector(velocity, out);
                }
            }
            Self::Soles => {
                for foot in soles(model) {
                    for point in [foot.toe, foot.heel] {
                        let radius = R::splat(model.contact_points[point].radius);
                        out.push(cut(point_height(body, frame.position, point) - radius - view.support.height));
                    }
                }
            }
            Self::FootPlaces => {
                let com = body.com_from_root();
                for foot in model.feet() {
                    let link = model.contact_points[foot.toe].link;
                    let place = |point: usize| {
                        let p = &model.contact_points[point];
                        body.link(p.link).0 + body.link_rotation(p.link).mul_vec(Vec3::splat(p.position))
                    };
                    let middle = (place(foot.toe) + place(foot.heel)) * R::splat(0.5);
                    vector(heading.to_local(middle - com), out);
                    vector(heading.to_local(body.link(link).1 - body.com_velocity()), out);
                }
            }
            Self::FootForces => {
                let weight = R::splat(body.steps_per_second() / (9.81 * model.mass()));
                for foot in model.feet() {
                    let mut load = R::zero();
                    for point in model.foot_points(foot) {
                        load += body.contact_impulse(point).length_squared().sqrt();
                    }
                    out.push(load * weight);
                }
            }
            Self::Parameters => out.extend_from_slice(view.parameters),
            Self::HeightScan { distances } => {
                let most = R::splat(SCAN_CUT);
                let seen = view.scan.iter().copied().chain(core::iter::repeat(R::zero()));
                out.extend(seen.take(distances.len()).map(|h| (h - view.support.height).clamp(-most, most)));
            }
        }
    }

    /// Its mirror image: `block` holds for each of its numbers the one that it is copied from and a factor; at first each is its own.
    pub(super) fn mirror(&self, model: &CharacterModel, links: &[usize], block: &mut [Source]) {
        let Some(first) = block.first().map(|b| b.0) else { return };
        // Groups of numbers change places, and numbers within a group their sign.
        let mut change = |other: &dyn Fn(usize) -> usize, size: usize, signs: &[f32]| {
            for (k, source) in block.iter_mut().enumerate() {
                *source = (first + size * other(k / size) + k % size, signs[k % signs.len()]);
            }
        };
        let own = |k: usize| k;
        match self {
            Self::Up | Self::RootVelocity | Self::ComVelocityError | Self::Offset => change(&own, 3, &VECTOR),
            Self::RootSpin | Self::RootTurn => change(&own, 3, &TURN),
            Self::Heading => change(&own, 2, &[1.0, -1.0]),
            Self::Links => change(&|k| links[k + 1] - 1, 6, &VECTOR),
            Self::Joints => change(&|k| links[k + 1] - 1, 6, &TURN),
            Self::Blades => {
                let of = |k: usize| model.blades.iter().position(|b| b.link == links[model.blades[k].link]);
                change(&|k| of(k).unwrap_or(k), 2, &[1.0]);
            }
            Self::Soles => {
                let sides: Vec<_> = soles(model).map(|f| f.side).collect();
                change(&|k| on_other_side(&sides, k), 2, &[1.0]);
            }
            Self::FootPlaces | Self::FootForces => {
                let sides: Vec<_> = model.feet().iter().map(|f| f.side).collect();
                match self {
                    Self::FootForces => change(&|k| on_other_side(&sides, k), 1, &[1.0]),
                    _ => change(&|k| on_other_side(&sides, k), 6, &VECTOR),
                }
            }
            Self::Phase | Self::RootHeight | Self::Speed | Self::Parameters | Self::HeightScan { .. } => {}
        }
    }
}
