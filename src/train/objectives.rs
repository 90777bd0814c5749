//! The objectives of a window, measured on a simulation, lane by lane.
//!
//! Yu, Park, Lee 2019, "Figure Skating Simulation from Video", Section 6.1, equations (7) to (15). The functions return the
//! plain quantity of the paper in SI units (or a number without unit where a quantity should grow); [`Meter::measure`] divides by
//! the square of a scale, so that an error of that size costs 1 and weights compare likes with likes:
//!
//! | objective | quantity | costs 1 at |
//! | --- | --- | --- |
//! | BladeOnGround | squared heights of both ends, m^2 | 0.02 m |
//! | COMHeight | squared difference of heights, m^2 | 0.05 m |
//! | MaxCOMHeight | reciprocal square of the height, 1/m^2 | 1 m |
//! | OnCOM | squared horizontal distance, m^2 | 0.10 m |
//! | MaxAngularMomentum | falls with the momentum over 5 kg m^2/s | none, growing against it |
//! | MaxVelocity | falls with the vertical velocity over 1 m/s | rest, growing downwards |
//! | COMVelocity | squared difference of velocities, m^2/s^2 | 0.20 m/s |
//! | PelvisHeading | squared difference of unit vectors | 0.20 (11 degrees) |
//! | TrackPose | weighted mean of squared angles, rad^2 | 0.20 rad |
//! | TrackVelocity | weighted mean of squared differences, rad^2/s^2 | 3 rad/s |
//! | TrackPath | squared distance of the roots, m^2 | 0.10 m |

use crate::control::ReferenceTick;
use crate::control::joint_weights;
use crate::math::{Quat, Real, Vec3};
use crate::model::{Blade, BodyPart, CharacterModel, Objective, Side};
use crate::sim::Simulator;
use glam::DVec3;

/// Scale of BladeOnGround, m.
const BLADE_SCALE: f64 = 0.02;
/// Scale of COMHeight, m.
const HEIGHT_SCALE: f64 = 0.05;
/// Scale of OnCOM, m.
const ON_COM_SCALE: f64 = 0.10;
/// Scale of MaxAngularMomentum, kg m^2/s: about one turn per second with the arms close to the body.
const MOMENTUM_SCALE: f64 = 5.0;
/// Scale of MaxVelocity, m/s.
const RISE_SCALE: f64 = 1.0;
/// Scale of COMVelocity, m/s.
const VELOCITY_SCALE: f64 = 0.20;
/// Scale of PelvisHeading, no unit.
const HEADING_SCALE: f64 = 0.20;
/// Scale of TrackPose, rad.
const POSE_SCALE: f64 = 0.20;
/// Scale of TrackVelocity, rad/s.
const JOINT_VELOCITY_SCALE: f64 = 3.0;
/// Scale of TrackPath, m.
const PATH_SCALE: f64 = 0.10;
/// Height below which the centre of mass counts as being there, m: the reciprocal square has no bound at the ground.
const LEAST_HEIGHT: f64 = 0.1;

/// (7) Squared heights of both ends of a blade above the plane y = 0, summed, m^2. It grows on either side: a blade
/// does not gain by being pressed into the ice.
pub fn blade_on_ground<R: Real>(sim: &mut Simulator<R>, blade: &Blade) -> R {
    let (toe, heel) = sim.blade_ends(blade);
    let root = sim.state.root_position.y;
    let (a, b) = (toe.y + root, heel.y + root);
    a * a + b * b
}

/// (8) Squared difference between the height of the centre of mass and `height` (m), m^2.
pub fn com_height<R: Real>(sim: &mut Simulator<R>, height: f64) -> R {
    let d = sim.center_of_mass().y - R::splat(height);
    d * d
}

/// (9) Reciprocal square of the height of the centre of mass, 1/m^2: it falls as the centre of mass rises, steeply below
/// 1 m. Heights below 0.1 m count as 0.1 m.
pub fn max_com_height<R: Real>(sim: &mut Simulator<R>) -> R {
    let height = sim.center_of_mass().y.max(R::splat(LEAST_HEIGHT));
    (height * height).recip()
}

/// (10) Squared horizontal distance between the centre of mass and a part of the body, m^2. Zero for a character that
/// has no such part.
pub fn on_com<R: Real>(sim: &mut Simulator<R>, part: BodyPart) -> R {
    let model = sim.model().clone();
    let place = match part {
        BodyPart::Head => {
            let Some(head) = model.link_index("head") else { return R::zero() };
            let link = &sim.kinematics()[head];
            link.origin + link.com
        }
        BodyPart::BladeLeft | BodyPart::BladeRight => {
            let side = if part == BodyPart::BladeLeft { Side::Left } else { Side::Right };
            let Some(blade) = model.blade_of(side) else { return R::zero() };
            let (toe, heel) = sim.blade_ends(blade);
            (toe + heel) * R::splat(0.5)
        }
    };
    let d = place + sim.state.root_position - sim.center_of_mass();
    d.x * d.x + d.z * d.z
}

/// The reciprocal square `1 / (1 + x)^2` of what should grow, continued by its tangent `1 - 2 x` below zero: it falls
/// everywhere, so a motion in the wrong direction is worse than none. The paper's `1 / x^2` is the same far from zero,
/// but rewards both directions and has no bound between them.
fn falling<R: Real>(x: R) -> R {
    let one = R::one();
    let above = one + x.max(R::zero());
    R::select(x.lt(R::zero()), one - x * R::splat(2.0), (above * above).recip())
}

/// (11) Falls as the angular momentum about the vertical through the centre of mass grows towards a side (to the left is
/// counter-clockwise seen from above); 1 without any, a quarter at 5 kg m^2/s. No unit.
pub fn max_angular_momentum<R: Real>(sim: &mut Simulator<R>, to: Side) -> R {
    let sign = if to == Side::Left { 1.0 } else { -1.0 };
    falling(sim.total_momentum().angular.y * R::splat(sign / MOMENTUM_SCALE))
}

/// (12) Falls as the vertical velocity of the centre of mass grows; 1 at rest, a quarter at 1 m/s upwards, 3 at 1 m/s
/// downwards. No unit.
pub fn max_velocity<R: Real>(sim: &mut Simulator<R>) -> R {
    falling(velocity(sim).y * R::splat(1.0 / RISE_SCALE))
}

/// Velocity of the centre of mass, world axes, m/s.
fn velocity<R: Real>(sim: &mut Simulator<R>) -> Vec3<R> {
    let inverse = R::splat(1.0 / sim.model().mass());
    sim.total_momentum().linear * inverse
}

/// (13) Squared difference between the velocity of the centre of mass and `desired` (world axes, m/s), m^2/s^2.
pub fn com_velocity<R: Real>(sim: &mut Simulator<R>, desired: DVec3) -> R {
    (velocity(sim) - Vec3::splat(desired)).length_squared()
}

/// (14) Squared difference between the root's X axis (to the athlete's right) and the direction `desired` (world axes, any
/// length but zero), both of length one: 0 to 4.
pub fn pelvis_heading<R: Real>(sim: &mut Simulator<R>, desired: DVec3) -> R {
    let axis = sim.kinematics()[0].rotation.mul_vec(Vec3::splat(DVec3::X));
    (axis - Vec3::splat(desired.normalize_or_zero())).length_squared()
}

/// Squared angle between two rotations by its sine, `(2 sin(angle / 2))^2`, rad^2.
fn squared_angle<R: Real>(a: Quat<R>, b: Quat<R>) -> R {
    let dot = a.v.dot_add(b.v, a.w * b.w);
    (R::one() - (dot * dot).min(R::one())) * R::splat(4.0)
}

/// (15) Squared angles between the joints and those of the key poses, a mean weighted by `weights` (one for each link, by
/// the mass it carries), plus the squared angle between the roots' rotations, rad^2.
pub fn track_pose<R: Real>(sim: &Simulator<R>, joints: &[Quat<R>], root: Quat<R>, weights: &[f64]) -> R {
    let (mut sum, mut whole) = (R::zero(), 0.0);
    for ((state, target), weight) in sim.state.joints.iter().zip(joints).zip(weights).skip(1) {
        sum += squared_angle(state.rotation, *target) * R::splat(*weight);
        whole += weight;
    }
    sum * R::splat(1.0 / whole.max(1e-9)) + squared_angle(sim.state.root_rotation, root)
}

/// Squared differences between the angular velocities of the joints and those of the key poses (child axes, rad/s), a mean
/// weighted as in [`track_pose`], rad^2/s^2.
pub fn track_velocity<R: Real>(sim: &Simulator<R>, velocities: &[DVec3], weights: &[f64]) -> R {
    let (mut sum, mut whole) = (R::zero(), 0.0);
    for ((state, target), weight) in sim.state.joints.iter().zip(velocities).zip(weights).skip(1) {
        sum += (state.velocity - Vec3::splat(*target)).length_squared() * R::splat(*weight);
        whole += weight;
    }
    sum * R::splat(1.0 / whole.max(1e-9))
}

/// Squared distance between the root and its place in the key poses, m^2.
pub fn track_path<R: Real>(sim: &Simulator<R>, place: DVec3) -> R {
    (sim.state.root_position - Vec3::splat(place)).length_squared()
}

/// What the key poses have at a moment, ready for comparison.
#[derive(Clone, Debug)]
pub struct Target<R> {
    joints: Vec<Quat<R>>,
    root: Quat<R>,
    place: DVec3,
    velocities: Vec<DVec3>,
}

impl<R: Real> Target<R> {
    /// Of a tick, the same in every lane.
    pub fn new(tick: &ReferenceTick) -> Self {
        let pose = &tick.pose;
        Self {
            velocities: tick.velocity.joints.clone(),
            joints: pose.joints.iter().map(|q| Quat::splat(*q)).collect(),
            root: Quat::splat(pose.root_rotation),
            place: pose.root_position,
        }
    }
}

/// Measures objectives on a character.
#[derive(Clone, Debug)]
pub struct Meter {
    weights: Vec<f64>,
}

impl Meter {
    /// For a character.
    pub fn new(model: &CharacterModel) -> Self {
        Self { weights: joint_weights(model) }
    }

    /// Whether a character has what an objective speaks of; what is missing, where not.
    pub fn lacks(model: &CharacterModel, objective: &Objective) -> Option<String> {
        let blade = |side: Side| model.blade_of(side).is_none().then(|| format!("no {} blade", side.name()));
        match objective {
            Objective::BladeOnGround { side, .. } => blade(*side),
            Objective::OnCOM { part: BodyPart::BladeLeft, .. } => blade(Side::Left),
            Objective::OnCOM { part: BodyPart::BladeRight, .. } => blade(Side::Right),
            Objective::OnCOM { part: BodyPart::Head, .. } => {
                model.link_index("head").is_none().then(|| "no link `head`".to_owned())
            }
            _ => None,
        }
    }

    /// The present cost of an objective in every lane, its weight left aside: 1 where its quantity has the size of its
    /// scale.
    pub fn measure<R: Real>(&self, sim: &mut Simulator<R>, objective: &Objective, target: &Target<R>) -> R {
        let over = |value: R, scale: f64| value * R::splat(1.0 / (scale * scale));
        match *objective {
            Objective::BladeOnGround { side, .. } => {
                let model = sim.model().clone();
                model.blade_of(side).map_or(R::zero(), |blade| over(blade_on_ground(sim, blade), BLADE_SCALE))
            }
            Objective::COMHeight { height, .. } => over(com_height(sim, height), HEIGHT_SCALE),
            Objective::MaxCOMHeight { .. } => max_com_height(sim),
            Objective::OnCOM { part, .. } => over(on_com(sim, part), ON_COM_SCALE),
            Objective::MaxAngularMomentum { to, .. } => max_angular_momentum(sim, to),
            Objective::MaxVelocity { .. } => max_velocity(sim),
            Objective::COMVelocity { velocity: (x, y, z), .. } => {
                over(com_velocity(sim, DVec3::new(x, y, z)), VELOCITY_SCALE)
            }
            Objective::PelvisHeading { direction: (x, y, z), .. } => {
                over(pelvis_heading(sim, DVec3::new(x, y, z)), HEADING_SCALE)
            }
            Objective::TrackPose { .. } => {
                over(track_pose(sim, &target.joints, target.root, &self.weights), POSE_SCALE)
            }
            Objective::TrackVelocity { .. } => {
                over(track_velocity(sim, &target.velocities, &self.weights), JOINT_VELOCITY_SCALE)
            }
            Objective::TrackPath { .. } => over(track_path(sim, target.place), PATH_SCALE),
        }
    }
}
