//! What a reconstruction sample is judged by.

use crate::control::{FALL_DEPTH, ReferenceTick};
use crate::dynamics::{LinkConstants, LinkKinematics, State, totals, update_positions, update_velocities};
use crate::math::{Motion, Real, Vec3};
use crate::model::CharacterModel;
use crate::sim::Simulator;
use glam::{DQuat, DVec3};

/// Scales of the cost: each term is one where its error is that large.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CostScales {
    /// Joint angle, rad.
    pub joint: f64,
    /// Joint angular velocity, rad/s.
    pub joint_velocity: f64,
    /// Root position, m.
    pub root: f64,
    /// Distance of the root beyond which it counts eight times over, m.
    pub root_free: f64,
    /// Root height, m.
    pub height: f64,
    /// Root rotation, rad.
    pub root_angle: f64,
    /// Root angular velocity, rad/s.
    pub root_velocity: f64,
    /// Velocity of the centre of mass, m/s.
    pub com_velocity: f64,
    /// End effectors relative to the centre of mass, m.
    pub ends: f64,
    /// Rotation of links that the reference has on the ground, rad: a blade glides on both its ends.
    pub stance: f64,
}

impl Default for CostScales {
    fn default() -> Self {
        Self {
            joint: 0.20,
            joint_velocity: 3.0,
            root: 0.10,
            root_free: 0.15,
            height: 0.05,
            root_angle: 0.15,
            root_velocity: 1.0,
            com_velocity: 0.12,
            ends: 0.08,
            stance: 0.20,
        }
    }
}

/// What a reference tick looks like to the cost.
#[derive(Clone, Debug)]
pub(crate) struct CostTarget {
    pub joints: Vec<DQuat>,
    pub joint_velocities: Vec<DVec3>,
    pub root_position: DVec3,
    pub root_rotation: DQuat,
    pub root_angular: DVec3,
    pub com: DVec3,
    pub com_velocity: DVec3,
    pub ends: Vec<DVec3>,
    /// Links on the ground and their rotations, link axes to world axes.
    pub stance: Vec<(usize, DQuat)>,
}

/// Height below which a link of the reference counts as on the ground, m.
const ON_GROUND: f64 = 0.015;

impl CostTarget {
    pub fn new(model: &CharacterModel, ends: &[usize], tick: &ReferenceTick) -> Self {
        let mut state = State::<f64>::at_rest(model);
        let (p, v) = (&tick.pose, &tick.velocity);
        state.set_pose(0, p.root_position, p.root_rotation, &p.joints);
        state.set_velocity(0, v.root_linear, v.root_angular, &v.joints);
        let constants = LinkConstants::<f64>::of(model);
        let mut links = vec![LinkKinematics::default(); model.links.len()];
        update_positions(&constants, &state, &mut links);
        update_velocities(&constants, &state, &mut links);
        let mass = model.mass();
        let com = totals(&constants, &links, mass).com;
        let momentum = crate::dynamics::momentum(&constants, &links, com);
        let root = p.root_position;
        let lowest = |i: usize| {
            let points = model.contact_points.iter().filter(|c| c.link == i);
            let height = |c: &crate::model::ContactPoint| {
                (root + (links[i].origin + links[i].rotation.mul_vec(Vec3::splat(c.position))).lane(0)).y - c.radius
            };
            points.map(height).fold(f64::INFINITY, f64::min)
        };
        let stance = ends
            .iter()
            .filter(|&&i| lowest(i) < ON_GROUND)
            .map(|&i| (i, DQuat::from_mat3(&links[i].rotation.lane(0)).normalize()))
            .collect();
        Self {
            stance,
            joints: p.joints.clone(),
            joint_velocities: v.joints.clone(),
            root_position: root,
            root_rotation: p.root_rotation,
            root_angular: v.root_angular,
            com: root + com.lane(0),
            com_velocity: momentum.linear.lane(0) / mass,
            ends: ends.iter().map(|&i| (links[i].origin - com).lane(0)).collect(),
        }
    }
}

/// Squared angle between rotations, by its sine: `(2 sin(angle / 2))^2`.
fn squared_angle(a: DQuat, b: DQuat) -> f64 {
    let dot = a.dot(b);
    4.0 * (1.0 - (dot * dot).min(1.0))
}

/// The cost of lane `lane`; infinite for a lane that has gone bad or fallen far from the reference.
pub(crate) fn cost<R: Real>(
    sim: &mut Simulator<R>,
    lane: usize,
    target: &CostTarget,
    ends: &[usize],
    weights: &[f64],
    scales: &CostScales,
) -> f64 {
    if !sim.is_sane(lane) {
        return f64::INFINITY;
    }
    let com = sim.center_of_mass().lane(lane);
    let mass = sim.model().mass();
    let com_velocity = sim.total_momentum().linear.lane(lane) / mass;
    let root = sim.state.root_position.lane(lane);
    let Motion { angular, .. } = sim.state.root_velocity;

    let (mut pose, mut speed, mut sum) = (0.0, 0.0, 0.0);
    for (i, joint) in sim.state.joints.iter().enumerate().skip(1) {
        let w = weights[i];
        pose += w * squared_angle(joint.rotation.lane(lane), target.joints[i]);
        speed += w * (joint.velocity.lane(lane) - target.joint_velocities[i]).length_squared();
        sum += w;
    }
    let root_rotation = squared_angle(sim.state.root_rotation.lane(lane), target.root_rotation);
    let offset = root - target.root_position;
    let fallen = offset.y.abs() > FALL_DEPTH || root_rotation > 1.5;
    let ends_error: f64 = sim.kinematics()[..]
        .iter()
        .enumerate()
        .filter_map(|(i, k)| ends.iter().position(|&e| e == i).map(|n| (n, k)))
        .map(|(n, k)| {
            let place = root + k.origin.lane(lane) - com;
            (place - target.ends[n]).length_squared()
        })
        .sum::<f64>()
        / ends.len().max(1) as f64;

    let stance_error: f64 = target
        .stance
        .iter()
        .map(|(i, q)| squared_angle(DQuat::from_mat3(&sim.kinematics()[*i].rotation.lane(lane)).normalize(), *q))
        .sum();

    let s = scales;
    let level = DVec3::new(offset.x, 0.0, offset.z).length_squared();
    let total = pose / sum / (s.joint * s.joint)
        + 0.3 * speed / sum / (s.joint_velocity * s.joint_velocity)
        + level / (s.root * s.root)
        + 8.0 * (offset.length() - s.root_free).max(0.0).powi(2) / (s.root * s.root)
        + (com.y - target.com.y).powi(2) / (s.height * s.height)
        + root_rotation / (s.root_angle * s.root_angle)
        + (angular.lane(lane) - target.root_angular).length_squared() / (s.root_velocity * s.root_velocity)
        + (com_velocity - target.com_velocity).length_squared() / (s.com_velocity * s.com_velocity)
        + ends_error / (s.ends * s.ends)
        + stance_error / (s.stance * s.stance);
    if fallen { total + 1e6 } else { total }
}
