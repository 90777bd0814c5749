//! Contract: forward dynamics, inverse dynamics, mass matrix, Jacobians and contact mobilities describe one and the
//! same mechanism, in either parametrisation of a ball joint, for random trees and for all characters of the crate.
//!
//! Each is computed by an algorithm of its own, so an error in one of them breaks an identity; a golden number would
//! only tell that something changed. Residuals are printed beside what is allowed.

use crate::common::*;
use bevy_athlete::contact::{ContactGroup, ContactMobility};
use bevy_athlete::dynamics::{
    ArticulatedLink, CentroidalMap, ServoOutput, State, articulated_inertias, contact_free_accelerations,
    degrees_of_freedom, forward_accelerations, generalized_velocity, inverse_dynamics, mass_matrix, momentum,
    point_jacobian, point_jacobian_rate, point_velocity, totals,
};
use bevy_athlete::math::{Force, Motion, RandomStream, Vec3};
use bevy_athlete::model::{CharacterModel, Gains, JointKind, Link, PRESET_NAMES, preset};
use glam::{DMat3, DQuat, DVec3};

/// Random trees with ball joints and hinges, two with an armature on most joints, then the characters of the crate.
fn models() -> Vec<CharacterModel> {
    let trees = (0..4).map(|k| random_tree(k, 6 + 5 * k as usize));
    let geared = (4..6).map(|k| geared(random_tree(k, 12), k));
    trees.chain(geared).chain(PRESET_NAMES.iter().map(|name| (*preset(name).unwrap()).clone())).collect()
}

/// The same tree with armatures of up to 0.1 kg m^2, none on every third joint.
fn geared(mut model: CharacterModel, seed: u64) -> CharacterModel {
    let mut random = RandomStream::new(seed, 2);
    for (i, link) in model.links.iter_mut().enumerate().skip(1) {
        link.armature = if i % 3 == 0 { 0.0 } else { random.range(0.0, 0.1) };
    }
    model.name = "random tree with armatures".into();
    model
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

/// The state after `h` seconds in which no generalised velocity changed: of the root, that in its own axes.
fn advanced(model: &CharacterModel, state: &State<f64>, h: f64) -> State<f64> {
    let mut moved = state.clone();
    let turn = |q: DQuat, w: DVec3| q * DQuat::from_scaled_axis(w * h);
    let before = state.root_rotation.lane(0);
    let spin = before.inverse() * state.root_velocity.angular.lane(0);
    let root = turn(before, spin);
    let joints: Vec<_> = state.joints.iter().map(|j| turn(j.rotation.lane(0), j.velocity.lane(0))).collect();
    let velocities: Vec<_> = state.joints.iter().map(|j| j.velocity.lane(0)).collect();
    let linear = state.root_velocity.linear.lane(0);
    moved.set_pose(0, state.root_position.lane(0) + linear * h, root, &joints);
    moved.set_velocity(0, linear, root * spin, &velocities);
    assert_eq!(model.links.len(), joints.len());
    moved
}

/// Jacobian rate times velocity: the change of a point's velocity while no generalised velocity changes.
#[test]
fn jacobian_rates_are_derivatives_of_velocities() {
    for model in models() {
        let mut random = RandomStream::new(19, model.links.len() as u64);
        let mut worst = 0.0_f64;
        for _ in 0..20 {
            let state = random_state::<f64>(&model, &mut random, 2.0, 2.0);
            let (constants, links) = kinematics_of(&model, &state);
            let link = random.below(model.links.len());
            let local = Vec3::splat(random_vector(&mut random, 0.3));
            let rate = point_jacobian_rate(&constants, &links, link, local).lane(0);
            let velocity =
                |h: f64| point_velocity(&kinematics_of(&model, &advanced(&model, &state, h)).1, link, local).lane(0);
            let difference = (velocity(1e-5) - velocity(-1e-5)) / 2e-5;
            worst = worst.max((rate - difference).length());
        }
        println!("{}: Jacobian rate against central differences {worst:.2e} m/s^2 (allowed 1e-5)", model.name);
        assert!(worst < 1e-5);
    }
}

/// The centroidal map gives the momentum that the links have, its rate how that changes while no generalised velocity does.
#[test]
fn the_centroidal_map_is_the_derivative_of_momentum() {
    for model in models() {
        let mut random = RandomStream::new(29, model.links.len() as u64);
        let (mut worst, mut worst_rate) = (0.0_f64, 0.0_f64);
        let momentum_of = |state: &State<f64>| {
            let (constants, links) = kinematics_of(&model, state);
            let body = totals(&constants, &links, model.mass());
            (momentum(&constants, &links, body.com), body.com, constants, links)
        };
        for _ in 0..20 {
            let state = random_state::<f64>(&model, &mut random, 2.0, 2.0);
            let (h, com, constants, links) = momentum_of(&state);
            let mut map = CentroidalMap::new(&constants);
            map.update(&constants, &links, com);
            let mut velocity = vec![0.0; degrees_of_freedom(&constants)];
            generalized_velocity(&constants, &links, &state, &mut velocity);
            assert_eq!(map.columns().len(), velocity.len());
            let found = map.momentum(&velocity);
            let scale = 1.0 + h.linear.length() + h.angular.length();
            worst =
                worst.max((found.force - h.linear).length() / scale).max((found.moment - h.angular).length() / scale);
            let at = |step: f64| momentum_of(&advanced(&model, &state, step)).0;
            let (after, before) = (at(1e-5), at(-1e-5));
            let rate = map.rate();
            let linear = (after.linear - before.linear) * 5e4;
            let angular = (after.angular - before.angular) * 5e4;
            let scale = 1.0 + linear.length() + angular.length();
            worst_rate =
                worst_rate.max((rate.force - linear).length() / scale).max((rate.moment - angular).length() / scale);
        }
        println!(
            "{}: A v against momentum {worst:.1e} (allowed 1e-12), A' v against central differences {worst_rate:.1e} (allowed 1e-6)",
            model.name
        );
        assert!(worst < 1e-12 && worst_rate < 1e-6);
    }
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
            let mut columns = vec![Vec3::zero(); degrees_of_freedom(&constants)];
            point_jacobian(&constants, &links, link, Vec3::splat(local), &mut columns);
            let mut generalized = vec![0.0; columns.len()];
            generalized_velocity(&constants, &links, &state, &mut generalized);
            let by_jacobian: DVec3 = columns.iter().zip(&generalized).map(|(c, v)| c.lane(0) * *v).sum();
            // And by moving the character a little, both ways.
            let place = |h: f64| {
                let moved = advanced(&model, &state, h);
                let (_, links) = kinematics_of(&model, &moved);
                moved.root_position.lane(0)
                    + (links[link].origin + links[link].rotation.mul_vec(Vec3::splat(local))).lane(0)
            };
            let difference = (place(1e-5) - place(-1e-5)) / 2e-5;
            worst = worst.max((velocity - by_jacobian).length()).max((velocity - difference).length());
        }
        println!("{}: Jacobian against central differences {worst:.2e} m/s (allowed 1e-6)", model.name);
        assert!(worst < 1e-6);
    }
}

/// The servo's implicit part is a torque like any other: the torque that inverse dynamics finds is `tau - e a`.
#[test]
fn implicit_gains_are_torques() {
    let gravity = Vec3::splat(DVec3::new(0.0, -9.81, 0.0));
    for model in models() {
        let mut random = RandomStream::new(10, model.links.len() as u64);
        let mut worst = 0.0_f64;
        for _ in 0..200 {
            let state = random_state::<f64>(&model, &mut random, 2.0, 5.0);
            let (constants, links) = kinematics_of(&model, &state);
            let torques = random_joint_vectors(&model, &mut random, 50.0);
            let servos: Vec<_> = torques
                .iter()
                .map(|t| ServoOutput {
                    torque: *t,
                    implicit: if random.uniform() < 0.3 { 0.0 } else { random.range(0.0, 0.1) },
                    beyond: None,
                })
                .collect();
            let (root, joints) = accelerations_of(&constants, &links, &servos, &[], gravity);
            let (wrench, found) = inverse_dynamics(&constants, &links, root[0], &joints, gravity);
            let scale = torques.iter().map(|t| t.length()).fold(1.0, f64::max);
            worst = worst.max(wrench.moment.length() / scale).max(wrench.force.length() / scale);
            for i in 1..model.links.len() {
                worst = worst.max((torques[i] - joints[i] * servos[i].implicit - found[i]).length() / scale);
            }
        }
        println!("{}: implicit gains against RNEA {worst:.2e} (allowed 1e-9)", model.name);
        assert!(worst < 1e-9);
    }
}

/// Accelerations of all links and joints with servos and external wrenches.
fn accelerations_of(
    constants: &[bevy_athlete::dynamics::LinkConstants<f64>],
    links: &[bevy_athlete::dynamics::LinkKinematics<f64>],
    servos: &[ServoOutput<f64>],
    wrenches: &[Force<f64>],
    gravity: Vec3<f64>,
) -> (Vec<Motion<f64>>, Vec<Vec3<f64>>) {
    let n = constants.len();
    let mut articulated = vec![ArticulatedLink::default(); n];
    let root = articulated_inertias(constants, links, servos, wrenches, &mut articulated);
    let (mut all, mut joints) = (vec![Motion::zero(); n], vec![Vec3::zero(); n]);
    let with_gravity = forward_accelerations(constants, links, &articulated, &root, gravity, &mut all, &mut joints);
    // The others stay counted from the coasting body: their differences are what the tests use.
    all[0] = with_gravity;
    (all, joints)
}

/// The contact solver's mobility blocks are the change of the links' accelerations that a wrench brings, implicit gains
/// included, from none to stiff. The momentum correction at the end of a step would hide most of an error here.
#[test]
fn contact_mobilities_are_responses_to_wrenches() {
    for model in models() {
        let n = model.links.len();
        let mut random = RandomStream::new(11, n as u64);
        let mut worst = 0.0_f64;
        for _ in 0..20 {
            let state = random_state::<f64>(&model, &mut random, 2.0, 5.0);
            let (constants, links) = kinematics_of(&model, &state);
            let servos: Vec<_> = (0..n)
                .map(|_| ServoOutput { implicit: random.range(-0.1, 1.0).max(0.0), ..Default::default() })
                .collect();
            let mut articulated = vec![ArticulatedLink::default(); n];
            let root = articulated_inertias(&constants, &links, &servos, &[], &mut articulated);
            let touching: Vec<usize> = (0..n).filter(|_| random.uniform() < 0.3).collect();
            let blank = |&link: &usize| ContactGroup {
                link,
                start: 0,
                end: 0,
                velocity: Motion::zero(),
                wrench: Force::zero(),
            };
            let groups: Vec<_> = touching.iter().map(blank).collect();
            if groups.is_empty() {
                continue;
            }
            let mut mobility = ContactMobility::new(&model);
            mobility.update(&constants, &links, &articulated, &root, &groups);
            let (before, _) = accelerations_of(&constants, &links, &servos, &[], Vec3::zero());
            for &pushed in &touching {
                let mut wrenches = vec![Force::zero(); n];
                let vector = |random: &mut RandomStream| Vec3::splat(random_vector(random, 1.0));
                wrenches[pushed] = Force { moment: vector(&mut random), force: vector(&mut random) };
                let (after, _) = accelerations_of(&constants, &links, &servos, &wrenches, Vec3::zero());
                let size = |m: &Motion<f64>| m.angular.length() + m.linear.length();
                let scale = touching.iter().map(|&i| size(&(after[i] - before[i]))).fold(1e-9, f64::max);
                for &i in &touching {
                    let found = mobility.response(i, pushed, &wrenches[pushed]);
                    worst = worst.max(size(&(found - (after[i] - before[i]))) / scale);
                }
            }
        }
        println!("{}: mobilities against responses {worst:.2e} (allowed 1e-9)", model.name);
        assert!(worst < 1e-9);
    }
}

/// The model with every ball joint replaced by three hinges (about x, y, z of the frame so far) with two massless links
/// between, and for each link of the first its index in the second.
fn with_hinges(model: &CharacterModel) -> (CharacterModel, Vec<usize>) {
    let mut links: Vec<Link> = Vec::new();
    let mut place = Vec::new();
    for link in &model.links {
        let parent = link.parent.map(|p: usize| place[p]);
        if link.joint != JointKind::Ball {
            place.push(links.len());
            links.push(Link { parent, ..link.clone() });
            continue;
        }
        for (k, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            let first = k == 0;
            let body = Link {
                name: format!("{}.{k}", link.name),
                parent: if first { parent } else { Some(links.len() - 1) },
                joint: JointKind::Hinge { axis },
                offset: if first { link.offset } else { DVec3::ZERO },
                ..link.clone()
            };
            let massless =
                Link { mass: 0.0, com: DVec3::ZERO, inertia: DMat3::ZERO, shapes: Vec::new(), ..body.clone() };
            links.push(if k == 2 { body } else { massless });
        }
        place.push(links.len() - 1);
    }
    let model = CharacterModel {
        links,
        contact_points: vec![],
        blades: vec![],
        grips: vec![],
        collision_pairs: vec![],
        feet: Vec::new(),
        trunk: 0,
        ..model.clone()
    };
    (model, place)
}

/// One mechanism in two parametrisations: a ball joint, and three hinges in series with massless links between. Forward
/// dynamics of both must give the same accelerations, the ball's mapped by `w' = S q'' + S' q'`.
#[test]
fn ball_joint_is_three_hinges() {
    let gravity = Vec3::splat(DVec3::new(0.3, -9.81, 0.1));
    // (Rotors on three hinges in series are others than one about every axis of a ball.)
    for model in models().into_iter().filter(|m| m.links.iter().all(|l| l.armature == 0.0)) {
        let (hinged, place) = with_hinges(&model);
        let mut random = RandomStream::new(12, model.links.len() as u64);
        let mut worst = 0.0_f64;
        for _ in 0..100 {
            let n = hinged.links.len();
            let (mut angles, mut rates) = (vec![0.0; n], vec![0.0; n]);
            for i in 1..n {
                // Away from the gimbal lock at a right angle of the second hinge.
                angles[i] = random.range(-1.0, 1.0);
                rates[i] = random.range(-4.0, 4.0);
            }
            // The ball joints' rotations, child-axes velocities w = S q', and the drift S' q'.
            let mut rotations = vec![DQuat::IDENTITY; model.links.len()];
            let mut velocities = vec![DVec3::ZERO; model.links.len()];
            let mut drifts = vec![DVec3::ZERO; model.links.len()];
            let mut maps = vec![DMat3::ZERO; model.links.len()];
            let mut torques = vec![Vec3::zero(); model.links.len()];
            let mut hinge_torques = vec![Vec3::zero(); n];
            for (i, link) in model.links.iter().enumerate().skip(1) {
                let at = place[i];
                let torque = random_vector(&mut random, 30.0);
                if let JointKind::Hinge { axis } = link.joint {
                    rotations[i] = DQuat::from_axis_angle(axis, angles[at]);
                    velocities[i] = axis * rates[at];
                    torques[i] = Vec3::splat(axis * torque.x);
                    hinge_torques[at] = torques[i];
                    continue;
                }
                let [a, b, c] = [at - 2, at - 1, at].map(|k| angles[k]);
                let [da, db, dc] = [at - 2, at - 1, at].map(|k| rates[k]);
                let (rx, ry, rz) = (DQuat::from_rotation_x(a), DQuat::from_rotation_y(b), DQuat::from_rotation_z(c));
                rotations[i] = rx * ry * rz;
                let axes = [(ry * rz).inverse() * DVec3::X, rz.inverse() * DVec3::Y, DVec3::Z];
                velocities[i] = axes[0] * da + axes[1] * db + axes[2] * dc;
                // Seen from the child, an earlier axis turns against all later joint velocities.
                drifts[i] = (axes[0] * da).cross(axes[1] * db + axes[2] * dc) + (axes[1] * db).cross(axes[2] * dc);
                maps[i] = DMat3::from_cols(axes[0], axes[1], axes[2]);
                torques[i] = Vec3::splat(torque);
                // The same power in both: tau_k = axis_k . tau.
                for k in 0..3 {
                    let axis = [DVec3::X, DVec3::Y, DVec3::Z][k];
                    hinge_torques[at - 2 + k] = Vec3::splat(axis * axes[k].dot(torque));
                }
            }
            let (position, rotation) = (random_vector(&mut random, 1.0), random_rotation(&mut random, 3.0));
            let (linear, angular) = (random_vector(&mut random, 3.0), random_vector(&mut random, 3.0));
            let mut state = State::<f64>::at_rest(&model);
            state.set_pose(0, position, rotation, &rotations);
            state.set_velocity(0, linear, angular, &velocities);
            let mut other = State::<f64>::at_rest(&hinged);
            let axis = |k: usize| match hinged.links[k].joint {
                JointKind::Hinge { axis } => axis,
                _ => DVec3::X,
            };
            let turns: Vec<_> = (0..n).map(|k| DQuat::from_axis_angle(axis(k), angles[k])).collect();
            let spins: Vec<_> = (0..n).map(|k| axis(k) * rates[k]).collect();
            other.set_pose(0, position, rotation, &turns);
            other.set_velocity(0, linear, angular, &spins);

            let (constants, links) = kinematics_of(&model, &state);
            let (root, joints) = contact_free_accelerations(&constants, &links, &torques, gravity);
            let (constants, links) = kinematics_of(&hinged, &other);
            let (root_h, joints_h) = contact_free_accelerations(&constants, &links, &hinge_torques, gravity);
            let scale = joints.iter().map(|a| a.length()).fold(1.0, f64::max);
            worst = worst.max((root.angular - root_h.angular).length() / scale);
            worst = worst.max((root.linear - root_h.linear).length() / scale);
            for (i, link) in model.links.iter().enumerate().skip(1) {
                let at = place[i];
                let mapped = match link.joint {
                    JointKind::Ball => {
                        let q = DVec3::from_array([at - 2, at - 1, at].map(|k| joints_h[k].lane(0).dot(axis(k))));
                        maps[i] * q + drifts[i]
                    }
                    _ => joints_h[at].lane(0),
                };
                worst = worst.max((mapped - joints[i].lane(0)).length() / scale);
            }
        }
        println!("{}: ball joints against three hinges {worst:.2e} (allowed 1e-9)", model.name);
        assert!(worst < 1e-9);
    }
}

/// A model of one free body for the bounds above would be too easy: this one says what the list covers.
#[test]
fn the_list_covers_all_joint_kinds() {
    let models = models();
    let count = |pick: fn(&JointKind) -> bool| models.iter().flat_map(|m| &m.links).filter(|l| pick(&l.joint)).count();
    let (balls, hinges) = (count(|j| *j == JointKind::Ball), count(|j| matches!(j, JointKind::Hinge { .. })));
    println!("{} models, {balls} ball joints, {hinges} hinges", models.len());
    assert!(balls > 50 && hinges > 5);
    assert!(models.iter().skip(4).all(|m| m.links[1].gains != Gains { kp: 0.0, kd: 0.0 }));
}
