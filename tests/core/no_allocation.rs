//! Contract: after warm-up the step does not allocate.
//!
//! A global allocator counts what the test's own thread asks for during `step`. The scenes make contacts come and go,
//! grips close and open, limbs collide and pushes act: a buffer that grows with any of these would show. Warm-up is one
//! step with as many pushes as ever act.

use crate::common::*;
use crate::counting_allocator::allocations;
use bevy_athlete::contact::World;
use bevy_athlete::dynamics::{CentroidalMap, GripAnchor, degrees_of_freedom, point_jacobian, point_jacobian_rate};
use bevy_athlete::math::{F32x8, F64x4, Quat, Real, Vec3};
use bevy_athlete::model::preset;
use bevy_athlete::sim::{ExternalForce, SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};

fn counted<R: Real>(sim: &mut Simulator<R>, world: &World) -> usize {
    let before = allocations();
    step(sim, world);
    allocations() - before
}

/// Every grip of every lane closes about a place: of the first lane a fixed one, of the others one on the ground.
fn hold_all<R: Real>(sim: &mut Simulator<R>, place: DVec3) {
    for grip in 0..sim.model().grips.len() {
        for lane in 0..R::LANES {
            let solid = GripAnchor::Solid { solid: 0, place };
            sim.hold(grip, lane, if lane == 0 { GripAnchor::Fixed(place) } else { solid });
        }
    }
}

fn drive<R: Real>(name: &str) {
    let model = preset(name).unwrap();
    let world = if name == "skater" {
        World::ice()
    } else {
        World::stairs(-0.5, 3, 0.3, 0.1, 2.0, bevy_athlete::contact::Surface::GROUND)
    };
    let mut sim = Simulator::<R>::new(model.clone(), SimulationSettings::of(&model));
    assert!(sim.settings().self_collision.is_some());
    for lane in 0..R::LANES {
        let at = sim.state.root_position.lane(lane) + DVec3::Y * 0.05 * lane as f64;
        sim.state.root_position.set_lane(lane, at);
    }
    sim.state_changed();
    let push = |link: usize| ExternalForce::<R> {
        link,
        position: Vec3::splat(DVec3::new(0.0, 0.05, 0.0)),
        force: Vec3::splat(DVec3::new(60.0, 250.0, -30.0)),
    };
    // Warm-up: as many pushes as will ever act.
    for n in 0..12 {
        sim.external.push(push(n % model.links.len()));
    }
    let warm_up = counted(&mut sim, &world);
    sim.external.clear();

    let tangled = if name == "skater" { tangled_pose(&model) } else { vec![DQuat::IDENTITY; model.links.len()] };
    let (mut allocations, mut touching, mut free) = (0, 0, 0);
    for k in 0..1500 {
        // Flung up and caught, hung by a hand, tangled, loose.
        match k {
            100 => (0..3).for_each(|n| sim.external.push(push(n))),
            200 => sim.external.clear(),
            300 => hold_all(&mut sim, DVec3::new(0.1, 1.6, 0.0)),
            600 => sim.state.release_all(),
            700 => sim.commands.iter_mut().zip(&tangled).for_each(|(c, q)| c.rotation = Quat::splat(*q)),
            1000 => sim.commands.iter_mut().for_each(|c| (c.kp, c.kd) = (R::splat(5.0), R::splat(1.0))),
            _ => {}
        }
        allocations += counted(&mut sim, &world);
        if sim.loaded_points(0) > 0 { touching += 1 } else { free += 1 }
    }
    println!(
        "{name}, {}: {allocations} allocations in 1500 steps (allowed 0), {touching} with and {free} without contact; warm-up {warm_up}",
        R::NAME
    );
    assert!(allocations == 0 && touching > 200 && free > 50);
}

#[test]
fn the_step_does_not_allocate() {
    drive::<f64>("skater");
    drive::<F64x4>("skater");
    drive::<F32x8>("skater");
    drive::<f64>("foot_human");
    drive::<f64>("runner");
    // Nor do the maps that controllers ask for.
    let model = preset("runner").unwrap();
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let constants = sim.constants().to_vec();
    let mut map = CentroidalMap::new(&constants);
    let mut columns = vec![Vec3::zero(); degrees_of_freedom(&constants)];
    let com = sim.center_of_mass() - sim.state.root_position;
    let before = allocations();
    map.update(&constants, sim.kinematics(), com);
    point_jacobian(&constants, sim.kinematics(), 5, Vec3::zero(), &mut columns);
    let _ = point_jacobian_rate(&constants, sim.kinematics(), 5, Vec3::zero());
    assert_eq!(allocations(), before);
    // The counter counts.
    let before = allocations();
    let v = std::hint::black_box(vec![1_u8; 100]);
    assert!(allocations() > before && v.len() == 100);
}
