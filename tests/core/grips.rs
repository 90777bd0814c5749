//! Contract: a grip is a hand. It holds on to an edge or a rail with as much force as it has, slips from what pulls harder, and
//! says so; on any other surface it pushes and rubs as a contact point does, and never pulls. It may hold a solid that moves. What it
//! holds on to belongs to a lane and to the state: it survives a copy, and a lane has the bits of a run alone.
//!
//! A grip was once common to all lanes, of any force, at a fixed place; on a flat top a palm could pull a body down.

use crate::common::*;
use bevy_athlete::contact::{Geometry, Material, Solid, Surface, World};
use bevy_athlete::dynamics::GripAnchor;
use bevy_athlete::math::{F64x4, Real, Vec3};
use bevy_athlete::model::{CharacterModel, Grip};
use bevy_athlete::sim::{ExternalForce, Simulator, step};
use glam::{DQuat, DVec3};

const G: f64 = 9.81;
const RAIL: Surface = Surface { material: Material::RAIL, friction: 0.8 };

/// A body that hangs on its grip, its centre of mass 0.4 m below.
fn hanger(mass: f64) -> CharacterModel {
    let mut model = rigid(mass, DVec3::splat(0.02 * mass), DVec3::NEG_Y * 0.4);
    model.grips.push(Grip { name: "hand".into(), link: 0, position: DVec3::ZERO, max_force: 450.0 });
    model
}

/// A bar along x, 4 cm thick, its top at y = 2 m.
fn bar(surface: Surface) -> World {
    let geometry = Geometry::Box {
        center: DVec3::new(0.0, 1.98, 0.0),
        half_extents: DVec3::new(1.0, 0.02, 0.02),
        rotation: DQuat::IDENTITY,
    };
    World { solids: vec![Solid::fixed(geometry, surface)] }
}

fn push<R: Real>(force: DVec3) -> ExternalForce<R> {
    ExternalForce { link: 0, position: Vec3::zero(), force: Vec3::splat(force) }
}

/// 30 kg hang for ever. 60 kg are more than the hand holds: it slips two centimetres under its full force and opens.
#[test]
fn a_hand_holds_what_it_can() {
    let at = DVec3::Y * 2.0;
    for (mass, holds) in [(30.0, true), (60.0, false)] {
        let (world, mut sim) = (bar(RAIL), simulator(hanger(mass)));
        place(&mut sim, at, DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO);
        sim.hold(0, 0, GripAnchor::Fixed(at));
        let (mut strongest, mut opened, mut slid) = (0.0_f64, None, 0.0);
        for k in 0..1200 {
            step(&mut sim, &world);
            strongest = strongest.max(sim.grip_force(0, 0).length());
            if sim.grip_slipped(0, 0) {
                assert_eq!(opened, None, "told once");
                opened = Some(k);
            }
            if opened.is_none() {
                slid = sim.grip_position(0, 0).unwrap().distance(at);
            }
        }
        println!(
            "{mass} kg on a hand of 450 N: at most {strongest:.3} N, opened at step {opened:?}, had slid {slid:.4} m"
        );
        assert!(strongest < 450.0 * (1.0 + 1e-9) && strongest > 0.9 * 450.0_f64.min(mass * G));
        assert_eq!(opened.is_none(), holds);
        assert_eq!(sim.state.anchor(0, 0).is_some(), holds);
        if holds {
            assert!(slid < 1e-3);
        } else {
            // By what it has more than its weight: 60 g - 450 N = 139 N, 2 cm in 0.13 s.
            let time = (2.0 * 0.02 * mass / (mass * G - 450.0)).sqrt() * 1200.0;
            assert!(
                slid > 0.02 && slid < 0.025 && (opened.unwrap() as f64 / time - 1.0).abs() < 0.1,
                "expected {time:.0}"
            );
        }
    }
}

/// On a flat top a closed hand is a contact point, bit for bit: pushed down and aside it rubs, lifted it goes.
#[test]
fn a_palm_on_a_flat_top_never_pulls() {
    let surface = Surface { material: Material::GROUND, friction: 0.5 };
    let mut with_point = rigid(20.0, DVec3::splat(0.5), DVec3::ZERO);
    let mut with_grip = with_point.clone();
    add_point(&mut with_point, DVec3::ZERO, 0.0);
    with_grip.grips.push(Grip { name: "palm".into(), link: 0, position: DVec3::ZERO, max_force: 450.0 });
    let top = DVec3::Y * 2.0;
    let run = |model: &CharacterModel| {
        let (world, mut sim) = (bar(surface), simulator(model.clone()));
        place(&mut sim, top, DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO);
        sim.hold(0, 0, GripAnchor::Fixed(top));
        let mut heights = Vec::new();
        for k in 0..900 {
            sim.external.clear();
            // At rest, pushed aside by less than the friction holds, by more, and lifted.
            sim.external.push(push(match k {
                0..200 => DVec3::ZERO,
                200..400 => DVec3::X * 80.0,
                400..600 => DVec3::X * 120.0,
                _ => DVec3::Y * 300.0,
            }));
            step(&mut sim, &world);
            let force = sim.grip_force(0, 0).y;
            assert!(force >= 0.0, "pulls with {force} N");
            assert!(!sim.grip_slipped(0, 0));
            heights.push(sim.state.root_position.lane(0));
        }
        heights
    };
    let (point, grip) = (run(&with_point), run(&with_grip));
    let off = point.iter().zip(&grip).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    println!(
        "palm against contact point: {off:.1e} m apart; it lies at {:.4}, slid to {:.4}, and rose to {:.3} m",
        grip[399].x, grip[599].x, grip[899].y
    );
    assert!(off < 1e-12);
    assert!(grip[399].x.abs() < 1e-4 && grip[599].x > 0.005 && grip[899].y > 2.1);
}

/// A rail that swings to and fro and turns carries the hand with it.
#[test]
fn a_hand_goes_with_a_moving_solid() {
    let place_on = DVec3::new(0.3, 0.02, 0.0);
    let mut sim = simulator(hanger(20.0));
    let h = sim.step_seconds();
    let mut world = bar(RAIL);
    let at = |t: f64| DVec3::new(0.4 * (2.0 * t).sin(), 2.0, 0.5 * t);
    let turned = |t: f64| DQuat::from_rotation_y(0.5 * t);
    let mut worst = 0.0_f64;
    for k in 0..2400 {
        let t = k as f64 * h;
        let solid = &mut world.solids[0];
        let middle = at(t);
        if let Geometry::Box { center, rotation, .. } = &mut solid.geometry {
            (*center, *rotation) = (middle, turned(t));
        }
        (solid.pivot, solid.angular_velocity) = (middle, DVec3::Y * 0.5);
        solid.linear_velocity = DVec3::new(0.8 * (2.0 * t).cos(), 0.0, 0.5);
        let anchor = middle + turned(t) * place_on;
        if k == 0 {
            let velocity = solid.anchor(place_on).velocity;
            place(&mut sim, anchor, DQuat::IDENTITY, velocity, DVec3::ZERO);
            sim.hold(0, 0, GripAnchor::Solid { solid: 0, place: place_on });
        }
        worst = worst.max(sim.grip_position(0, 0).unwrap().distance(anchor));
        step(&mut sim, &world);
    }
    println!("a hand on a rail that swings and turns: at most {:.3} mm away from its place (allowed 2)", worst * 1e3);
    assert!(worst < 2e-3);
    assert!(sim.state.anchor(0, 0).is_some());
    // The rail is gone: the hand is open, and says so.
    world.solids.clear();
    step(&mut sim, &world);
    assert!(sim.grip_slipped(0, 0) && sim.state.anchor(0, 0).is_none());
    step(&mut sim, &world);
    assert!(!sim.grip_slipped(0, 0));
}

/// Lanes close about different things at different times, some slip, one palm lies on a flat top; each has the bits of a run alone.
#[test]
fn grips_belong_to_their_lanes() {
    let mut world = bar(RAIL);
    world.solids.push(bar(Surface::GROUND).solids.remove(0));
    if let Geometry::Box { center, .. } = &mut world.solids[1].geometry {
        *center = DVec3::new(0.0, 0.98, 0.0);
    }
    let mut model = hanger(60.0);
    model.grips[0].max_force = 700.0;
    let mut wide = Simulator::<F64x4>::new(std::sync::Arc::new(model.clone()), *simulator(model.clone()).settings());
    let mut alone: Vec<_> = (0..4).map(|_| simulator(model.clone())).collect();
    let starts = [(0.0, 2.0), (0.1, 2.0), (0.2, 1.0), (0.3, 2.0)];
    let anchor = |lane: usize, at: DVec3| match lane {
        1 => GripAnchor::Solid { solid: 0, place: at - DVec3::new(0.0, 1.98, 0.0) },
        _ => GripAnchor::Fixed(at),
    };
    for (lane, (x, y)) in starts.into_iter().enumerate() {
        let at = DVec3::new(x, y, 0.0);
        place(&mut alone[lane], at, DQuat::from_rotation_x(0.2 * lane as f64), DVec3::ZERO, DVec3::ZERO);
        if lane != 3 {
            alone[lane].hold(0, 0, anchor(lane, at));
        }
        wide.put_lane(lane, &alone[lane], 0);
    }
    let mut slipped = [false; 4];
    for k in 0..600 {
        if k == 20 {
            let at = DVec3::new(0.3, 2.0, 0.0);
            alone[3].hold(0, 0, anchor(3, at));
            wide.hold(0, 3, anchor(3, at));
        }
        if k == 300 {
            alone[0].release(0, 0);
            wide.release(0, 0);
        }
        // What pulls at the second is more than a hand has.
        for sim in &mut alone {
            sim.external.clear();
        }
        wide.external.clear();
        let mut force = push::<F64x4>(DVec3::ZERO);
        if k > 200 {
            force.force.set_lane(1, DVec3::NEG_Y * 300.0);
            alone[1].external.push(push(DVec3::NEG_Y * 300.0));
        }
        wide.external.push(force);
        step(&mut wide, &world);
        for (lane, sim) in alone.iter_mut().enumerate() {
            if sim.external.is_empty() {
                sim.external.push(push(DVec3::ZERO));
            }
            step(sim, &world);
            slipped[lane] |= sim.grip_slipped(0, 0);
            assert_eq!(wide.grip_slipped(0, lane), sim.grip_slipped(0, 0));
            assert_eq!(wide.state.fingerprint(lane), sim.state.fingerprint(0), "step {k}, lane {lane}");
        }
    }
    assert_eq!(slipped, [false, true, false, slipped[3]]);
    assert!(wide.state.anchor(0, 0).is_none() && wide.state.anchor(0, 1).is_none());
    assert!(wide.state.anchor(0, 2).is_some());
}

/// A copy of a lane holds on to what the lane holds on to, and the fingerprint knows of it.
#[test]
fn a_grip_is_part_of_the_state() {
    let mut sim = simulator(hanger(20.0));
    let open = sim.state.fingerprint(0);
    let anchor = GripAnchor::Solid { solid: 3, place: DVec3::new(0.1, 0.2, 0.3) };
    sim.hold(0, 0, anchor);
    let closed = sim.state.fingerprint(0);
    assert_ne!(open, closed);
    let wide = sim.state.lane::<F64x4>(sim.model(), 0);
    let back = wide.lane::<f64>(sim.model(), 2);
    assert_eq!(back.anchor(0, 0), Some(anchor));
    assert_eq!(back.fingerprint(0), closed);
    sim.release(0, 0);
    assert_eq!(sim.state.fingerprint(0), open);
    // A number that there is not.
    sim.hold(7, 0, anchor);
    sim.release(7, 0);
    assert_eq!((sim.state.anchor(7, 0), sim.grip_position(7, 0), sim.grip_force(7, 0)), (None, None, DVec3::ZERO));
}
