//! Contract: no joint asks for more torque than its limit, whatever asks for it: servo, extra torque and limit spring together, in
//! every step, on every preset; only a limit spring that is stronger by itself, beyond its end stop, keeps its strength. A joint stays
//! what it is meanwhile: it does not explode, and does not lose its range.
//!
//! Checked on the explicit part and on the gain of the implicit one, which shrinks with it. (In a jolt the implicit damping may go
//! beyond the limit for a step.) Extra torque and limit springs once came on top of the limited servo.

use crate::common::*;
use bevy_athlete::contact::World;
use bevy_athlete::dynamics::{
    ArticulatedLink, LimitSpring, ServoOutput, articulated_inertias, forward_accelerations, inverse_dynamics, servo,
};
use bevy_athlete::math::{F64x4, Motion, Quat, RandomStream, Real, Vec3};
use bevy_athlete::model::{CharacterModel, JointKind, JointLimits, PRESET_NAMES, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// How far a torque may be beyond its limit, as a part of it: rounding.
const TOLERANCE: f64 = 1e-9;

/// New targets anywhere within 1.5 rad, and extra torques of up to three times the limit.
fn wild_commands<R: Real>(sim: &mut Simulator<R>, random: &mut RandomStream) {
    let model = sim.model().clone();
    for (link, command) in model.links.iter().zip(&mut sim.commands).skip(1) {
        let most = link.max_torque.min(1000.0);
        command.rotation = Quat::splat(random_rotation(random, 1.5));
        command.torque = Vec3::splat(random_vector(random, 3.0 * most));
    }
}

/// Thrown onto the ground with targets that jump about beyond the joints' ranges, extra torques and stiff servos.
#[test]
fn no_joint_has_more_than_its_limit() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let world = if name == "skater" { World::ice() } else { World::ground() };
        let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
        let mut random = RandomStream::new(11, 3);
        let h = sim.step_seconds();
        let (mut worst, mut at_limit, mut looks) = ((0.0_f64, ""), 0, 0);
        for k in 0..(1.5 * model.step_rate) as usize {
            if k % 60 == 0 {
                wild_commands(&mut sim, &mut random);
            }
            if k % 400 == 0 {
                sim.state.root_velocity.linear = Vec3::splat(random_vector(&mut random, 4.0));
                sim.state_changed();
            }
            let (constants, spring) = (sim.constants().to_vec(), sim.settings().limits);
            for (i, link) in model.links.iter().enumerate().skip(1).filter(|(_, l)| l.max_torque.is_finite()) {
                let command = &sim.commands[i];
                let asked = servo(&constants[i], &sim.state, i, command, spring, h);
                // The limit spring by itself, which the servo yields to.
                let mut loose = *command;
                (loose.kp, loose.kd, loose.torque) = (0.0, 0.0, Vec3::zero());
                let alone = servo(&constants[i], &sim.state, i, &loose, spring, h).torque.length();
                let part = asked.torque.length() / link.max_torque.max(alone);
                looks += 1;
                at_limit += usize::from(part > 0.99);
                if part > worst.0 {
                    worst = (part, &link.name);
                }
                // As much weaker as the servo is, so much softer it is.
                let end_stop = match (link.joint, spring) {
                    (JointKind::Hinge { .. }, Some(s)) => h * (s.damping + h * s.stiffness),
                    _ => 0.0,
                };
                let whole = h * (command.kd + h * command.kp) + end_stop;
                assert!(asked.implicit <= whole * (1.0 + 1e-12));
            }
            step(&mut sim, &world);
        }
        let share = 100.0 * at_limit as f64 / looks as f64;
        println!(
            "{name}: largest torque {:.4} of its limit at {} (allowed {}), at the limit {share:.0} % of the time",
            worst.0,
            worst.1,
            1.0 + TOLERANCE
        );
        assert!(sim.is_sane(0));
        assert!(share > 1.0, "the scene is meant to bring joints to their limits");
        assert!(worst.0 < 1.0 + TOLERANCE);
    }
}

/// Driven by all it has against the end of its range for a second, a joint gives way as far as the limit spring is soft for that
/// torque, no further. Swung at it by all it has through the whole range it goes beyond (nothing else may stop it), but it stays
/// sound. Both ways it comes back when it is let go.
#[test]
fn a_joint_driven_beyond_its_range_keeps_it() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let spring = LimitSpring::default();
        let (mut softest, mut farthest) = (0.0_f64, 0.0_f64);
        for (i, link) in model.links.iter().enumerate().skip(1) {
            let Some(limits) = link.limits.filter(|_| link.joint == JointKind::Ball) else { continue };
            // A range that ends near half a turn has no beyond in rotation vectors.
            if limits.high.x > 2.6 {
                continue;
            }
            for from_the_end in [true, false] {
                let mut settings = SimulationSettings::of(&model);
                settings.gravity = DVec3::ZERO;
                settings.self_collision = None;
                let mut sim = Simulator::<f64>::new(model.clone(), settings);
                let beyond = |sim: &Simulator<f64>| {
                    let r = sim.state.joints[i].rotation.to_rotation_vector().lane(0);
                    ((r - limits.high).max(DVec3::ZERO) + (limits.low - r).max(DVec3::ZERO)).max_element()
                };
                if from_the_end {
                    let end = DQuat::from_scaled_axis(DVec3::X * limits.high.x);
                    sim.state.joints[i].rotation = Quat::splat(end);
                    sim.state_changed();
                }
                let target = DVec3::X * (limits.high.x + 0.7).min(3.0);
                sim.commands[i].rotation = Quat::splat(DQuat::from_scaled_axis(target));
                sim.commands[i].torque = Vec3::splat(DVec3::X * 5.0 * link.max_torque);
                let mut worst = 0.0_f64;
                for _ in 0..model.step_rate as usize {
                    step(&mut sim, &World::empty());
                    worst = worst.max(beyond(&sim));
                }
                assert!(sim.is_sane(0), "{name}, {}", link.name);
                if from_the_end {
                    softest = softest.max(worst);
                    // What the spring gives way by, and as much again for the swing with which the limb arrives there.
                    let allowed = 2.0 * link.max_torque / spring.stiffness + 0.05;
                    assert!(worst < allowed, "{name}, {}: {worst:.3} rad beyond, allowed {allowed:.3}", link.name);
                } else {
                    farthest = farthest.max(worst);
                }
                sim.commands[i].rotation = Quat::identity();
                sim.commands[i].torque = Vec3::zero();
                for _ in 0..(2.0 * model.step_rate) as usize {
                    step(&mut sim, &World::empty());
                }
                let left = beyond(&sim);
                assert!(left < 0.02, "{name}, {}: {left:.3} rad beyond its range for ever", link.name);
            }
        }
        println!(
            "{name}: pressed against the end of a range {softest:.3} rad beyond it, swung at it {farthest:.3} rad"
        );
    }
}

/// Two bars: the second turns against the first.
fn two_bars(limits: Option<JointLimits>, max_torque: f64) -> CharacterModel {
    let mut model = random_tree(5, 2);
    let link = &mut model.links[1];
    (link.joint, link.limits, link.max_torque) = (JointKind::Ball, limits, max_torque);
    model
}

/// Where there is no limit, all that is asked for acts.
#[test]
fn a_joint_without_a_limit_gives_what_is_asked_for() {
    let model = two_bars(None, f64::INFINITY);
    let mut sim = Simulator::<f64>::new(Arc::new(model.clone()), SimulationSettings::of(&model));
    let asked = DVec3::new(3000.0, -4000.0, 500.0);
    sim.commands[1].torque = Vec3::splat(asked);
    (sim.commands[1].kp, sim.commands[1].kd) = (0.0, 0.0);
    step(&mut sim, &World::empty());
    assert!(sim.joint_torque(1).lane(0).distance(asked) < 1e-9 * asked.length());
}

/// A limit spring brakes the component of the rotation vector that is beyond its range and no other.
#[test]
fn a_limit_acts_on_the_axes_beyond_it() {
    let wide = DVec3::splat(1.5);
    let limits = JointLimits { low: -wide, high: DVec3::new(0.2, 1.5, 1.5) };
    let (model, free) = (two_bars(Some(limits), f64::INFINITY), two_bars(None, f64::INFINITY));
    let run = |model: &CharacterModel| {
        let mut settings = SimulationSettings::of(model);
        settings.gravity = DVec3::ZERO;
        let mut sim = Simulator::<f64>::new(Arc::new(model.clone()), settings);
        let still = [DVec3::ZERO; 2];
        let turned = [DQuat::IDENTITY, DQuat::from_scaled_axis(DVec3::X * 0.21)];
        sim.state.set_pose(0, DVec3::ZERO, DQuat::IDENTITY, &turned);
        sim.state.set_velocity(0, DVec3::ZERO, DVec3::ZERO, &still);
        sim.state_changed();
        (sim.commands[1].kp, sim.commands[1].kd) = (0.0, 0.0);
        sim.commands[1].torque = Vec3::splat(DVec3::new(0.0, 20.0, -10.0));
        step(&mut sim, &World::empty());
        sim.joint_torque(1).lane(0)
    };
    let (with, without) = (run(&model), run(&free));
    println!("torque with the first axis beyond its range {with:.3?}, without a limit {without:.3?} N m");
    assert!((with - without).with_x(0.0).length() < 1e-9);
    assert!(with.x < -1.0, "the spring of the first axis acts");
}

/// The recursion with gains about single axes solves the equations of motion: the accelerations that it finds need, by inverse
/// dynamics, the torques `T - (e + l) a` that it says it took.
#[test]
fn accelerations_need_the_torques_that_acted() {
    let (mut worst, mut beyond) = (0.0_f64, 0);
    for seed in 0..40 {
        let mut model = random_tree(seed, 9);
        let mut random = RandomStream::new(seed, 9);
        for link in model.links.iter_mut().skip(1) {
            let bound =
                |random: &mut RandomStream| DVec3::from_array(core::array::from_fn(|_| random.range(0.05, 1.2)));
            link.limits = Some(JointLimits { low: -bound(&mut random), high: bound(&mut random) });
        }
        let state = random_state::<f64>(&model, &mut random, 1.0, 2.0);
        let (constants, kinematics) = kinematics_of(&model, &state);
        let sim = Simulator::<f64>::new(Arc::new(model.clone()), SimulationSettings::of(&model));
        let servos: Vec<ServoOutput<f64>> = (0..model.links.len())
            .map(|i| {
                if i == 0 {
                    return ServoOutput::default();
                }
                servo(&constants[i], &state, i, &sim.commands[i], Some(LimitSpring::default()), 1.0 / 1200.0)
            })
            .collect();
        beyond += servos.iter().filter(|s| s.beyond.is_some()).count();
        let gravity = Vec3::splat(DVec3::NEG_Y * 9.81);
        let mut links = vec![ArticulatedLink::default(); constants.len()];
        let mobility = articulated_inertias(&constants, &kinematics, &servos, &[], &mut links);
        let mut accelerations = vec![Motion::zero(); constants.len()];
        let mut joints = vec![Vec3::zero(); constants.len()];
        let root =
            forward_accelerations(&constants, &kinematics, &links, &mobility, gravity, &mut accelerations, &mut joints);
        let (wrench, needed) = inverse_dynamics(&constants, &kinematics, root, &joints, gravity);
        let scale = 1.0 + needed.iter().map(|t| t.length()).fold(0.0, f64::max);
        worst = worst.max(wrench.force.length() / scale).max(wrench.moment.length() / scale);
        for i in 1..constants.len() {
            let acted = servos[i].torque_at(joints[i]);
            let acted = match constants[i].hinge {
                Some(axis) => axis * axis.dot(acted),
                None => acted,
            };
            worst = worst.max((acted - needed[i]).length() / scale);
        }
    }
    println!(
        "{beyond} joints beyond their ranges in 40 random trees: torques agree to {worst:.1e} of the largest (allowed 1e-9)"
    );
    assert!(worst < 1e-9 && beyond > 100);
}

/// A lane that is beyond its range or at its torque limit does not change its neighbours' bits, nor they its own.
#[test]
fn lanes_at_their_limits_are_scalars_at_their_limits() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let world = if name == "skater" { World::ice() } else { World::ground() };
        let mut wide = Simulator::<F64x4>::new(model.clone(), SimulationSettings::of(&model));
        let mut alone: Vec<_> =
            (0..4).map(|_| Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model))).collect();
        let mut random = RandomStream::new(31, 1);
        for k in 0..600 {
            // Lane 0 stays quiet; the others are driven wildly at different times.
            for (lane, sim) in alone.iter_mut().enumerate().skip(1) {
                if k % (40 * lane) == 20 {
                    wild_commands(sim, &mut random);
                    wide.put_commands(lane, sim, 0);
                }
            }
            step(&mut wide, &world);
            for (lane, sim) in alone.iter_mut().enumerate() {
                step(sim, &world);
                assert_eq!(wide.state.fingerprint(lane), sim.state.fingerprint(0), "{name}, step {k}, lane {lane}");
            }
        }
    }
}
