//! Contract: an armature is inertia on a joint's own velocity, on the diagonal of the joint-space mass matrix, and nothing else.
//!
//! The identities between forward dynamics, inverse dynamics, mass matrix and contact mobilities are in `dynamics_identities.rs`, whose
//! list has trees with armatures; here is what those would not see: that it is on the diagonal and there alone, that its energy
//! counts and is kept, that it gives no momentum to the body, the closed forms of two wheels and of a pendulum, and that a body without
//! one has the bits that it had.

use crate::common::*;
use bevy_athlete::asset::Character;
use bevy_athlete::contact::World;
use bevy_athlete::dynamics::{
    contact_free_accelerations, degrees_of_freedom, energy, generalized_velocity, mass_matrix,
};
use bevy_athlete::math::{RandomStream, Vec3};
use bevy_athlete::model::{CharacterModel, JointKind, export_mjcf, preset_source};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;

/// A random tree and the same with an armature on every joint.
fn pair(seed: u64) -> (CharacterModel, CharacterModel) {
    let plain = random_tree(seed, 9);
    let mut geared = plain.clone();
    for (i, link) in geared.links.iter_mut().enumerate().skip(1) {
        link.armature = 0.01 * (i as f64);
    }
    (plain, geared)
}

#[test]
fn it_is_on_the_diagonal_of_the_mass_matrix_and_its_energy_is_that_of_the_matrix() {
    for seed in 0..10 {
        let (plain, geared) = pair(seed);
        let mut random = RandomStream::new(seed, 3);
        let state = random_state::<f64>(&plain, &mut random, 2.0, 3.0);
        let (constants, links) = kinematics_of(&geared, &state);
        let (with, without) = (mass_matrix(&constants, &links), mass_matrix(&kinematics_of(&plain, &state).0, &links));
        let mut armatures = vec![0.0; 6];
        for link in &geared.links[1..] {
            armatures.extend(vec![link.armature; link.joint.dof()]);
        }
        for (i, row) in with.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let added = if i == j { armatures[i] } else { 0.0 };
                assert!((value - without[i][j] - added).abs() < 1e-12, "entry {i}, {j}");
            }
        }
        let mut v = vec![0.0; degrees_of_freedom(&constants)];
        generalized_velocity(&constants, &links, &state, &mut v);
        let by_matrix: f64 =
            0.5 * (0..v.len()).map(|i| v[i] * (0..v.len()).map(|j| with[i][j] * v[j]).sum::<f64>()).sum::<f64>();
        let (kinetic, _) = energy(&constants, &links, Vec3::zero(), Vec3::zero());
        assert!((kinetic - by_matrix).abs() < 1e-10 * by_matrix, "{kinetic} J is not {by_matrix} J");
    }
}

/// Two wheels on one axle, free in space: `tau = (I1 I2 / (I1 + I2) + A) q''`.
#[test]
fn two_wheels_turn_against_each_other_by_their_reduced_inertia_and_the_armature() {
    let mut model = random_tree(1, 2);
    let (one, two, armature, torque) = (0.3, 0.05, 0.2, 4.0);
    for (link, inertia) in model.links.iter_mut().zip([one, two]) {
        (link.offset, link.com, link.inertia) =
            (DVec3::ZERO, DVec3::ZERO, DMat3::from_diagonal(DVec3::new(inertia, inertia, inertia)));
    }
    (model.links[1].joint, model.links[1].armature) = (JointKind::Hinge { axis: DVec3::Y }, armature);
    let state = random_state::<f64>(&model, &mut RandomStream::new(1, 1), 1.0, 0.0);
    let (constants, links) = kinematics_of(&model, &state);
    let torques = [Vec3::zero(), Vec3::splat(DVec3::Y * torque)];
    let (_, joints) = contact_free_accelerations(&constants, &links, &torques, Vec3::zero());
    let expected = torque / (one * two / (one + two) + armature);
    assert!((joints[1].lane(0).y - expected).abs() < 1e-9 * expected, "{} is not {expected}", joints[1].lane(0).y);
}

/// A pendulum on a heavy block swings with `omega^2 = m g l / (I + m l^2 + A)`.
#[test]
fn a_pendulum_with_an_armature_swings_slower() {
    let (mass, length, armature) = (2.0, 0.4, 0.25);
    let period = |armature: f64| {
        let mut model = random_tree(1, 2);
        model.links[0].mass = 1e9;
        (model.links[0].com, model.links[0].inertia) = (DVec3::ZERO, DMat3::from_diagonal(DVec3::splat(1e9)));
        let link = &mut model.links[1];
        (link.joint, link.offset, link.mass) = (JointKind::Hinge { axis: DVec3::X }, DVec3::ZERO, mass);
        (link.com, link.inertia) = (DVec3::NEG_Y * length, DMat3::from_diagonal(DVec3::splat(0.01)));
        (link.armature, link.gains.kp, link.gains.kd) = (armature, 0.0, 0.0);
        // The block does not fall: gravity is a force on the pendulum's centre of mass.
        let settings = SimulationSettings { gravity: DVec3::ZERO, rate: 2000.0, ..SimulationSettings::of(&model) };
        let mut sim = Simulator::<f64>::new(Arc::new(model), settings);
        let start = 0.02;
        sim.state.joints[1].rotation.set_lane(0, DQuat::from_rotation_x(start));
        sim.state_changed();
        sim.external.push(bevy_athlete::sim::ExternalForce {
            link: 1,
            position: Vec3::splat(DVec3::NEG_Y * length),
            force: Vec3::splat(DVec3::NEG_Y * mass * 9.81),
        });
        // From the top of a swing to the second crossing after it: three quarters of a period.
        let (mut crossings, mut before) = (0, start);
        loop {
            step(&mut sim, &World::empty());
            let angle = sim.state.joints[1].rotation.to_rotation_vector().lane(0).x;
            if angle * before < 0.0 {
                crossings += 1;
            }
            if crossings == 2 {
                return sim.state.time / 0.75;
            }
            before = angle;
        }
    };
    for a in [0.0, armature] {
        let expected = std::f64::consts::TAU * ((0.01 + mass * length * length + a) / (mass * 9.81 * length)).sqrt();
        let found = period(a);
        println!("armature {a}: period {found:.4} s, closed form {expected:.4} s (allowed 0.2 %)");
        assert!((found - expected).abs() < 2e-3 * expected);
    }
}

#[test]
fn a_tumbling_tree_keeps_momentum_and_energy() {
    for seed in 0..4 {
        let (_, mut geared) = pair(seed);
        geared.links.iter_mut().for_each(|l| (l.gains.kp, l.gains.kd) = (0.0, 0.0));
        let drift = |rate: f64| {
            let settings = SimulationSettings { gravity: DVec3::ZERO, rate, ..SimulationSettings::of(&geared) };
            let mut sim = Simulator::<f64>::new(Arc::new(geared.clone()), settings);
            sim.state = random_state::<f64>(&geared, &mut RandomStream::new(seed, 4), 1.0, 1.0);
            sim.state_changed();
            let (before, energy) = (sim.total_momentum(), sim.energy().0);
            for _ in 0..(0.3 * rate) as usize {
                step(&mut sim, &World::empty());
            }
            let after = sim.total_momentum();
            let scale = before.linear.length() + before.angular.length();
            let lost = ((after.linear - before.linear).length() + (after.angular - before.angular).length()) / scale;
            assert!(lost < 1e-10, "momentum changed by {lost:.1e} of itself");
            (sim.energy().0 - energy).abs() / energy
        };
        let (coarse, fine) = (drift(2000.0), drift(8000.0));
        println!("tree {seed}: energy off by {coarse:.1e} at 2000/s, {fine:.1e} at 8000/s");
        assert!(fine < 2e-3 && fine < 0.5 * coarse + 1e-6, "the error of a first-order step falls with the step");
    }
}

#[test]
fn a_file_says_it_and_zero_is_none() {
    let (file, text) = preset_source("foot_human").unwrap();
    let build = |armature: &str| {
        let edited =
            text.replace("gains: (kp: 100.0, kd: 10.0),", &format!("gains: (kp: 100.0, kd: 10.0), {armature}"));
        CharacterModel::build(&Character::parse(file, edited.as_bytes()).unwrap()).unwrap()
    };
    let (none, zero, some) = (build(""), build("armature: 0.0,"), build("armature: 0.002,"));
    assert_eq!(none, zero);
    assert_eq!(none.fingerprint(), zero.fingerprint());
    assert_ne!(none.fingerprint(), some.fingerprint());
    let toes = |m: &CharacterModel| m.links.iter().filter(|l| l.armature == 0.002).count();
    assert_eq!((toes(&none), toes(&some)), (0, 4));
    assert_eq!(export_mjcf(&some).matches("armature=\"0.002\"").count(), 4);
}
