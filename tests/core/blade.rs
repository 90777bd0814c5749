//! Contract: a blade is a knife edge. It glides along its line, does not slip aside, loses speed by its friction only,
//! and what turns it does no work.
//!
//! The carve radius is in `closed_forms.rs`; here is what a knife edge must not do.

use crate::common::*;
use bevy_athlete::contact::{BladeEdge, Surface, World};
use bevy_athlete::model::{LeanLaw, skater};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};

const G: f64 = 9.81;
/// Speed across the blade that is allowed while flat, m/s.
const SLIP: f64 = 1e-3;

/// Largest speed of the blade's ends across the blade (ice plane), m/s, by where they were before and are now.
fn slip(before: &[DVec3], after: &[DVec3], h: f64) -> f64 {
    let along = (before[0] - before[1]).with_y(0.0).normalize();
    let across = DVec3::Y.cross(along);
    before.iter().zip(after).map(|(a, b)| ((*b - *a).dot(across) / h).abs()).fold(0.0, f64::max)
}

fn ends(sim: &mut Simulator<f64>, blade: usize) -> Vec<DVec3> {
    let b = sim.model().blades[blade].clone();
    vec![point_position(sim, b.toe), point_position(sim, b.heel)]
}

struct Glide {
    drift: f64,
    slip: f64,
    speed: f64,
    upright: f64,
}

/// Glides for 5 s towards -z.
fn glide(sim: &mut Simulator<f64>, push: impl Fn(&mut Simulator<f64>)) -> Glide {
    let world = World::ice();
    let h = sim.step_seconds();
    let mass = sim.model().mass();
    let blades = sim.model().blades.len();
    let start = sim.center_of_mass().lane(0).x;
    let mut worst = 0.0_f64;
    for _ in 0..(5.0 / h) as usize {
        let before: Vec<_> = (0..blades).map(|b| ends(sim, b)).collect();
        push(sim);
        step(sim, &world);
        for (b, before) in before.iter().enumerate() {
            if sim.blade_edge(b, 0) == BladeEdge::Flat {
                let after = ends(sim, b);
                worst = worst.max(slip(before, &after, h));
            }
        }
    }
    Glide {
        drift: (sim.center_of_mass().lane(0).x - start).abs(),
        slip: worst,
        speed: -sim.total_momentum().linear.lane(0).z / mass,
        upright: (sim.state.root_rotation.lane(0) * DVec3::Y).y,
    }
}

fn report(name: &str, g: &Glide) {
    let expected = 3.0 - Surface::ICE.friction * G * 5.0;
    println!(
        "{name}: after 5 s drifted {:.4} mm aside, slipped at most {:.5} mm/s (allowed 1), {:.5} m/s left (mu g t: {expected:.5}, \
         off {:.2} %, allowed 1 %), upright {:.6}",
        g.drift * 1e3,
        g.slip * 1e3,
        g.speed,
        100.0 * (g.speed / expected - 1.0).abs(),
        g.upright,
    );
    assert!(g.slip < SLIP && (g.speed / expected - 1.0).abs() < 0.01 && g.upright > 0.99);
}

const LAW: LeanLaw = LeanLaw::DeadZone { dead_zone: 15.0 * std::f64::consts::PI / 180.0, gain: 6.0 };

/// One blade: a rigid body of a person's size, its centre of mass above the blade. Nothing holds it up but its balance. The
/// skater itself on one blade is in `one_blade.rs`.
#[test]
fn gliding_straight_on_one_blade() {
    let mut model = rigid(50.0, DVec3::new(8.0, 1.0, 8.0), DVec3::ZERO);
    add_blade(&mut model, -DVec3::Y * 0.9, 0.208, LAW);
    let mut sim = simulator(model);
    place(&mut sim, DVec3::Y * 0.9, DQuat::IDENTITY, DVec3::NEG_Z * 3.0, DVec3::ZERO);
    let g = glide(&mut sim, |_| {});
    report("one blade", &g);
    assert!(g.drift < 1e-3, "allowed 1 mm");
}

/// Two blades: the skater itself, holding its pose.
#[test]
fn gliding_straight_on_two_blades() {
    let model = skater();
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let at = sim.state.root_position.lane(0);
    place(&mut sim, at, DQuat::IDENTITY, DVec3::NEG_Z * 3.0, DVec3::ZERO);
    let g = glide(&mut sim, |_| {});
    report("skater on two blades", &g);
    assert!(g.drift < 5e-3, "allowed 5 mm");
}

/// Pushed sideways with 100 N all the way, the edge holds its line.
#[test]
fn edge_holds_against_a_push() {
    let mut model = rigid(50.0, DVec3::splat(3.0), DVec3::Y * 0.1);
    add_blade(&mut model, DVec3::ZERO, 0.208, LAW);
    for x in [-0.8, 0.8] {
        add_point(&mut model, DVec3::X * x, 0.0);
        model.contact_points.last_mut().unwrap().friction = 0.0;
    }
    let mut sim = simulator(model);
    place(&mut sim, DVec3::ZERO, DQuat::IDENTITY, DVec3::NEG_Z * 3.0, DVec3::ZERO);
    let push = bevy_athlete::sim::ExternalForce {
        link: 0,
        position: bevy_athlete::math::Vec3::splat(DVec3::Y * 0.1),
        force: bevy_athlete::math::Vec3::splat(DVec3::X * 100.0),
    };
    sim.external.push(push);
    let g = glide(&mut sim, |_| {});
    println!(
        "pushed by 100 N: drifted {:.5} mm (allowed 5), slipped at most {:.5} mm/s (allowed 1)",
        g.drift * 1e3,
        g.slip * 1e3
    );
    assert!(g.slip < SLIP && g.drift < 5e-3);
}

/// The weight is over the heel, and the toe is pushed aside: the end with next to no load of its own holds by that of the other. What
/// it carried in the last step is where the next begins, so even one sweep a step comes to hold it. (Rows once kept an end's
/// side impulse within its own load: the toe began each step from next to nothing, and slipped for ever.)
#[test]
fn an_unloaded_end_keeps_its_side_impulse() {
    let heel = DVec3::Z * 0.104;
    let mut model = rigid(50.0, DVec3::splat(3.0), heel + DVec3::Y * 0.1);
    add_blade(&mut model, DVec3::ZERO, 0.208, LAW);
    model.blades[0].bite = Some(1.0);
    for x in [-0.8, 0.8] {
        add_point(&mut model, heel + DVec3::X * x, 0.0);
        model.contact_points.last_mut().unwrap().friction = 0.0;
    }
    let toe = model.blades[0].toe;
    let mut sim = simulator(model);
    let mut settings = *sim.settings();
    settings.contact.iterations = 1;
    sim.set_settings(settings);
    place(&mut sim, DVec3::ZERO, DQuat::IDENTITY, DVec3::NEG_Z * 3.0, DVec3::ZERO);
    sim.external.push(bevy_athlete::sim::ExternalForce {
        link: 0,
        position: bevy_athlete::math::Vec3::splat(-heel),
        force: bevy_athlete::math::Vec3::splat(DVec3::X * 100.0),
    });
    let (world, h) = (World::ice(), sim.step_seconds());
    let (mut worst, mut load) = (0.0_f64, 0.0_f64);
    for k in 0..1200 {
        let before = ends(&mut sim, 0);
        step(&mut sim, &world);
        if k >= 600 {
            worst = worst.max(slip(&before, &ends(&mut sim, 0), h));
            load = load.max(sim.contact_force(toe, 0).y);
        }
    }
    println!(
        "toe without load ({load:.3} N at most), pushed by 100 N: slips at most {:.5} mm/s (allowed 0.1)",
        worst * 1e3
    );
    assert!(load < 10.0, "the toe is meant to carry next to nothing");
    assert!(worst < 0.1 * SLIP);
}

/// Carving without friction keeps the kinetic energy: the edge's force is square to the motion.
#[test]
fn carving_does_no_work() {
    for (degrees, speed) in [(20.0_f64, 3.0), (27.0, 3.0), (32.0, 3.0), (27.0, 6.0)] {
        let turn = DQuat::from_rotation_z(-degrees.to_radians());
        let upright = |p: DVec3| turn.inverse() * p;
        let mut model = rigid(50.0, DVec3::splat(3.0), upright(DVec3::Y * 0.05));
        add_blade(&mut model, DVec3::ZERO, 0.208, LAW);
        for x in [-1.5, 1.5] {
            add_point(&mut model, upright(DVec3::X * x), 0.0);
        }
        for point in &mut model.contact_points {
            point.friction = 0.0;
        }
        let mut sim = simulator(model);
        place(&mut sim, DVec3::ZERO, turn, DVec3::NEG_Z * speed, DVec3::ZERO);
        let world = World::ice();
        for _ in 0..60 {
            step(&mut sim, &world);
        }
        let before = sim.energy().0;
        let mut travelled = 0.0;
        for _ in 0..1200 {
            step(&mut sim, &world);
            travelled += sim.state.root_velocity.linear.lane(0).length() / 1200.0;
        }
        let after = sim.energy().0;
        // As a coefficient of friction that would cost as much.
        let mu = (before - after) / (50.0 * G * travelled);
        println!(
            "lean {degrees} deg, {speed} m/s: energy {:+.4} % in 1 s, like friction of {mu:.1e} (allowed 1e-3; ice has 2e-2)",
            100.0 * (after / before - 1.0)
        );
        assert!(mu.abs() < 1e-3);
    }
}
