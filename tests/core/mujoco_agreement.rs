//! MuJoCo computes the same dynamics for the exported characters.
//!
//! For the skater, the foot human and the runner, 100 random states each (`tests/data/mujoco_*.json`, written by
//! `benches/mujoco/reference.py` from the files of `athlete export-mjcf`): products of the mass matrix, the whole matrix in
//! the first states, bias forces and contact-free accelerations under random generalised forces, all below 1e-8 relative.
//!
//! The identities of `dynamics_identities.rs` prove that this crate agrees with itself; they would hold as well for a
//! consistent mistake in a convention (the axes of a joint's velocity, the inertia of a welded blade, the sign of a
//! Coriolis term). Another simulator, which read the same body from a file, does not share it. The export is checked on
//! the way: a wrong mass or offset in the file shows here.

use crate::common::kinematics_of;
use bevy_athlete::dynamics::{
    ArticulatedLink, LinkConstants, LinkKinematics, ServoOutput, State, articulated_inertias,
    contact_free_accelerations, forward_accelerations, inverse_dynamics, mass_matrix,
};
use bevy_athlete::math::{Force, Motion, Vec3};
use bevy_athlete::model::{CharacterModel, JointKind, preset};
use glam::{DQuat, DVec3};
use serde::Deserialize;

/// Allowed difference, relative to the largest entry of the vector compared.
const ALLOWED: f64 = 1e-8;
const GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);

#[derive(Deserialize)]
struct Reference {
    format: String,
    character: String,
    bodies: Vec<String>,
    nv: usize,
    mass: f64,
    states: Vec<Sample>,
}

#[derive(Deserialize)]
struct Sample {
    qpos: Vec<f64>,
    qvel: Vec<f64>,
    tau: Vec<f64>,
    x: Vec<f64>,
    #[serde(rename = "Mx")]
    product: Vec<f64>,
    bias: Vec<f64>,
    qacc: Vec<f64>,
    com: Vec<f64>,
    mass_matrix: Option<Vec<f64>>,
}

fn vector(v: &[f64]) -> DVec3 {
    DVec3::new(v[0], v[1], v[2])
}

fn quaternion(v: &[f64]) -> DQuat {
    DQuat::from_xyzw(v[1], v[2], v[3], v[0])
}

/// Vectors of the joints (child axes) from generalised coordinates.
fn joint_vectors(model: &CharacterModel, coordinates: &[f64]) -> Vec<DVec3> {
    let mut at = 0;
    let next = |link: &bevy_athlete::model::Link| {
        let part = &coordinates[at..at + link.joint.dof()];
        at += link.joint.dof();
        match link.joint {
            JointKind::Free => DVec3::ZERO,
            JointKind::Ball => vector(part),
            JointKind::Hinge { axis } => axis * part[0],
        }
    };
    model.links.iter().map(next).collect()
}

/// Generalised coordinates from a root pair (linear in world axes, angular in world axes, turned into the root's) and
/// joint vectors.
fn generalised(model: &CharacterModel, root: DQuat, linear: DVec3, angular: DVec3, joints: &[Vec3<f64>]) -> Vec<f64> {
    let mut out = linear.to_array().to_vec();
    out.extend((root.conjugate() * angular).to_array());
    for (link, v) in model.links.iter().zip(joints) {
        match link.joint {
            JointKind::Free => {}
            JointKind::Ball => out.extend(v.lane(0).to_array()),
            JointKind::Hinge { axis } => out.push(axis.dot(v.lane(0))),
        }
    }
    out
}

fn state_of(model: &CharacterModel, sample: &Sample) -> (State<f64>, DQuat) {
    let (position, root) = (vector(&sample.qpos), quaternion(&sample.qpos[3..7]));
    let (mut at, mut joints) = (7, vec![DQuat::IDENTITY]);
    for link in &model.links[1..] {
        match link.joint {
            JointKind::Hinge { axis } => {
                joints.push(DQuat::from_axis_angle(axis, sample.qpos[at]));
                at += 1;
            }
            _ => {
                joints.push(quaternion(&sample.qpos[at..]));
                at += 4;
            }
        }
    }
    assert_eq!(at, sample.qpos.len());
    let mut state = State::at_rest(model);
    state.set_pose(0, position, root, &joints);
    let angular = root * vector(&sample.qvel[3..]);
    state.set_velocity(0, vector(&sample.qvel), angular, &joint_vectors(model, &sample.qvel));
    (state, root)
}

/// Largest difference over the largest entry.
fn residual(ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    let scale = theirs.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    ours.iter().zip(theirs).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / scale
}

/// Accelerations under all generalised forces, those on the root included.
fn accelerations(
    model: &CharacterModel,
    constants: &[LinkConstants<f64>],
    links: &[LinkKinematics<f64>],
    root: DQuat,
    tau: &[f64],
) -> Vec<f64> {
    let torques: Vec<Vec3<f64>> = joint_vectors(model, tau).into_iter().map(Vec3::splat).collect();
    let gravity = Vec3::splat(GRAVITY);
    let wrench = Force { moment: Vec3::splat(root * vector(&tau[3..])), force: Vec3::splat(vector(tau)) };
    let mut external = vec![Force::zero(); links.len()];
    external[0] = wrench;
    let servos: Vec<_> = torques.iter().map(|t| ServoOutput { torque: *t, ..Default::default() }).collect();
    let mut articulated = vec![ArticulatedLink::default(); links.len()];
    let mobility = articulated_inertias(constants, links, &servos, &external, &mut articulated);
    let mut motions = vec![Motion::zero(); links.len()];
    let mut joints = vec![Vec3::zero(); links.len()];
    let found = forward_accelerations(constants, links, &articulated, &mobility, gravity, &mut motions, &mut joints);

    // Without the wrench on the root, the public short form says the same.
    let (short, _) = contact_free_accelerations(constants, links, &torques, gravity);
    let pushed = mobility.mul_force(&wrench);
    let sum = short.linear + pushed.linear;
    assert!((sum - found.linear).lane(0).length() <= 1e-9 * found.linear.lane(0).length().max(1.0));
    generalised(model, root, found.linear.lane(0), found.angular.lane(0), &joints)
}

/// Largest residuals: centre of mass, mass matrix, its products, bias forces, accelerations.
fn compare(name: &str) -> [f64; 5] {
    let path = format!("{}/tests/data/mujoco_{name}.json", env!("CARGO_MANIFEST_DIR"));
    let reference: Reference = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let model = preset(name).unwrap();
    assert_eq!(reference.format, "athlete-mujoco-reference-1");
    assert_eq!(reference.character, name);
    assert_eq!(reference.nv, model.dof());
    assert_eq!(reference.states.len(), 100);
    assert!((reference.mass - model.mass()).abs() < 1e-9);
    assert!(reference.bodies.iter().eq(model.links.iter().map(|l| &l.name)));

    let mut worst = [0.0_f64; 5];
    let mut matrices = 0;
    for sample in &reference.states {
        let (state, root) = state_of(&model, sample);
        let (constants, links) = kinematics_of(&model, &state);
        let com = bevy_athlete::dynamics::totals(&constants, &links, model.mass()).com + state.root_position;
        worst[0] = worst[0].max(residual(&com.lane(0).to_array(), &sample.com));

        let matrix = mass_matrix(&constants, &links);
        let product: Vec<f64> = matrix.iter().map(|r| r.iter().zip(&sample.x).map(|(m, x)| m * x).sum()).collect();
        if let Some(theirs) = &sample.mass_matrix {
            let upper: Vec<f64> = matrix.iter().enumerate().flat_map(|(i, row)| row[i..].to_vec()).collect();
            worst[1] = worst[1].max(residual(&upper, theirs));
            matrices += 1;
        }
        worst[2] = worst[2].max(residual(&product, &sample.product));

        let still = vec![Vec3::zero(); links.len()];
        let (wrench, torques) = inverse_dynamics(&constants, &links, Motion::zero(), &still, Vec3::splat(GRAVITY));
        let bias = generalised(&model, root, wrench.force.lane(0), wrench.moment.lane(0), &torques);
        worst[3] = worst[3].max(residual(&bias, &sample.bias));

        let qacc = accelerations(&model, &constants, &links, root, &sample.tau);
        worst[4] = worst[4].max(residual(&qacc, &sample.qacc));
    }
    assert!(matrices >= 3);
    worst
}

fn check(name: &str) {
    let worst = compare(name);
    let what = ["centre of mass", "mass matrix", "mass matrix products", "bias forces", "accelerations"];
    for (what, residual) in what.into_iter().zip(worst) {
        println!("{name:<11} {what:<21} residual {residual:.1e}, allowed {ALLOWED:.0e}");
        assert!(residual < ALLOWED, "{name}: {what}: {residual:e}");
    }
}

#[test]
fn skater_has_the_dynamics_that_mujoco_computes() {
    check("skater");
}

#[test]
fn foot_human_has_the_dynamics_that_mujoco_computes() {
    check("foot_human");
}

#[test]
fn runner_has_the_dynamics_that_mujoco_computes() {
    check("runner");
}
