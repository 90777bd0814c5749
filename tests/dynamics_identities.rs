//! Contract: forward dynamics, inverse dynamics, mass matrix and Jacobians describe one and the same mechanism.
//!
//! Each is computed by an algorithm of its own, so an error in one of them breaks an identity; a golden number would
//! only tell that something changed. Residuals are printed beside what is allowed.

mod common;

use bevy_athlete::dynamics::{
    contact_free_accelerations, inverse_dynamics, mass_matrix, point_jacobian, point_velocity,
};
use bevy_athlete::math::{Motion, RandomStream, Vec3};
use bevy_athlete::model::{CharacterModel, JointKind};
use common::*;
use glam::DVec3;

fn models() -> Vec<CharacterModel> {
    (0..4).map(|k| random_tree(k, 6 + 5 * k as usize)).collect()
}

#[test]
fn forward_dynamics_inverts_inverse_dynamics() {
    let gravity = Vec3::splat(DVec3::new(0.3, -9.81, 0.1));
    for model in models() {
        let mut random = RandomStream::new(7, model.links.len() as u64);
        let mut worst = 0.0_f64;
        for _ in 0..1000 {
            let state = random_state::<f64>(&model, &mut random, 2.0, 5.0);
            let (constants, links) = kinematics_of(&model, &state);
            let torques = random_joint_vectors(&model, &mut random, 50.0);
            let (root, joints) = contact_free_accelerations(&constants, &links, &torques, gravity);
            let (wrench, again) = inverse_dynamics(&constants, &links, root, &joints, gravity);
            let scale = torques.iter().map(|t| t.length()).fold(1.0, f64::max);
            worst = worst.max(wrench.moment.length() / scale).max(wrench.force.length() / scale);
            for (a, b) in torques.iter().zip(&again).skip(1) {
                worst = worst.max((*a - *b).length() / scale);
            }
        }
        println!("{}: {} links, ABA against RNEA {worst:.2e} (allowed 1e-9)", model.name, model.links.len());
        assert!(worst < 1e-9);
    }
}

#[test]
fn mass_matrix_columns_are_inverse_dynamics() {
    for model in models() {
        let mut random = RandomStream::new(8, model.links.len() as u64);
        let mut worst = 0.0_f64;
        for _ in 0..20 {
            let mut state = random_state::<f64>(&model, &mut random, 2.0, 0.0);
            state.root_velocity = Motion::zero();
            let (constants, links) = kinematics_of(&model, &state);
            let matrix = mass_matrix(&constants, &links);
            let scale = matrix.iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()));
            // Unit accelerations in the order of the generalised velocity.
            let mut units: Vec<(Motion<f64>, Vec<Vec3<f64>>)> = Vec::new();
            let still = || vec![Vec3::zero(); model.links.len()];
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                units.push((Motion { angular: Vec3::zero(), linear: Vec3::splat(axis) }, still()));
            }
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let angular = links[0].rotation.mul_vec(Vec3::splat(axis));
                units.push((Motion { angular, linear: Vec3::zero() }, still()));
            }
            for (i, link) in model.links.iter().enumerate().skip(1) {
                let axes = match link.joint {
                    JointKind::Hinge { axis } => vec![axis],
                    _ => vec![DVec3::X, DVec3::Y, DVec3::Z],
                };
                for axis in axes {
                    let mut joints = still();
                    joints[i] = Vec3::splat(axis);
                    units.push((Motion::zero(), joints));
                }
            }
            for (column, (root, joints)) in units.iter().enumerate() {
                let (w, torques) = inverse_dynamics(&constants, &links, *root, joints, Vec3::zero());
                let mut found = w.force.lane(0).to_array().to_vec();
                found.extend(links[0].rotation.tr_mul_vec(w.moment).lane(0).to_array());
                for (link, t) in model.links.iter().zip(&torques).skip(1) {
                    match link.joint {
                        JointKind::Hinge { axis } => found.push(axis.dot(t.lane(0))),
                        _ => found.extend(t.lane(0).to_array()),
                    }
                }
                for (row, value) in found.iter().enumerate() {
                    worst = worst.max((matrix[row][column] - value).abs() / scale);
                }
            }
            assert!(is_positive_definite(&matrix), "{}: mass matrix is not positive definite", model.name);
        }
        println!("{}: CRBA against RNEA columns {worst:.2e} (allowed 1e-10)", model.name);
        assert!(worst < 1e-10);
    }
}

fn is_positive_definite(m: &[Vec<f64>]) -> bool {
    let n = m.len();
    let mut l = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = m[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if i == j {
                if sum <= 0.0 {
                    return false;
                }
                l[i][i] = sum.sqrt();
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    true
}

#[test]
fn jacobians_are_derivatives_of_positions() {
    for model in models() {
        let mut random = RandomStream::new(9, model.links.len() as u64);
        let mut worst = 0.0_f64;
        for _ in 0..20 {
            let state = random_state::<f64>(&model, &mut random, 2.0, 2.0);
            let (constants, links) = kinematics_of(&model, &state);
            let link = random.below(model.links.len());
            let local = random_vector(&mut random, 0.3);
            let velocity = point_velocity(&links, link, Vec3::splat(local)).lane(0);
            // The velocity by the Jacobian.
            let columns = point_jacobian(&constants, &links, link, Vec3::splat(local));
            let mut generalized = state.root_velocity.linear.lane(0).to_array().to_vec();
            generalized.extend(links[0].rotation.tr_mul_vec(state.root_velocity.angular).lane(0).to_array());
            for (l, j) in model.links.iter().zip(&state.joints).skip(1) {
                match l.joint {
                    JointKind::Hinge { axis } => generalized.push(axis.dot(j.velocity.lane(0))),
                    _ => generalized.extend(j.velocity.lane(0).to_array()),
                }
            }
            let by_jacobian: DVec3 = columns.iter().zip(&generalized).map(|(c, v)| *c * *v).sum();
            // And by moving the character a little, both ways.
            let place = |h: f64| {
                let mut moved = state.clone();
                let turn = |q: glam::DQuat, w: DVec3| q * glam::DQuat::from_scaled_axis(w * h);
                let root = glam::DQuat::from_scaled_axis(state.root_velocity.angular.lane(0) * h)
                    * state.root_rotation.lane(0);
                let joints: Vec<_> =
                    state.joints.iter().map(|j| turn(j.rotation.lane(0), j.velocity.lane(0))).collect();
                let position = state.root_position.lane(0) + state.root_velocity.linear.lane(0) * h;
                moved.set_pose(0, position, root, &joints);
                let (_, links) = kinematics_of(&model, &moved);
                position + (links[link].origin + links[link].rotation.mul_vec(Vec3::splat(local))).lane(0)
            };
            let difference = (place(1e-5) - place(-1e-5)) / 2e-5;
            worst = worst.max((velocity - by_jacobian).length()).max((velocity - difference).length());
        }
        println!("{}: Jacobian against central differences {worst:.2e} m/s (allowed 1e-6)", model.name);
        assert!(worst < 1e-6);
    }
}
