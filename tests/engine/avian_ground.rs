//! Contract: the ground that is made of colliders, without an app.
//!
//! A signed distance is proven by what makes it one, for every shape alike: it is as long as the way along its normal to a
//! place where it is zero; its slope is its normal; where a closed form exists it is that. And after warm-up a step on
//! colliders does not allocate, whatever the shapes.

use crate::counting_allocator::allocations;
use avian3d::prelude::Collider;
use bevy::math::{DQuat, DVec3, Quat, Vec3};
use bevy_athlete::contact::{SurfaceHit, Terrain};
use bevy_athlete::engine::avian::{AthleteSurface, ColliderGround};
use bevy_athlete::math::{RandomStream, Vec3 as Lanes};
use bevy_athlete::model::preset;
use bevy_athlete::sim::{SimulationSettings, Simulator, step};

const REGION: (DVec3, DVec3) = (DVec3::splat(-3.0), DVec3::splat(3.0));

/// A cube of half edge 0.5 as a mesh.
fn cube_mesh() -> Collider {
    let vertices = (0..8).map(|k| {
        let side = |bit: u32| if k & bit == 0 { -0.5 } else { 0.5 };
        Vec3::new(side(1), side(2), side(4))
    });
    let quads: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    Collider::trimesh(vertices.collect(), triangles.collect())
}

fn hilly() -> Collider {
    let height = |i: usize, j: usize| 0.05 * ((i * i + 3 * j) % 7) as f32;
    let heights = (0..12).map(|i| (0..12).map(|j| height(i, j)).collect()).collect();
    Collider::heightfield(heights, Vec3::new(6.0, 1.0, 6.0))
}

/// Every kind of shape, by name.
fn shapes() -> Vec<(&'static str, Collider)> {
    let octahedron = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z].map(|v| v * 0.7);
    vec![
        ("box", Collider::cuboid(1.0, 0.6, 0.8)),
        ("ball", Collider::sphere(0.6)),
        ("capsule", Collider::capsule(0.3, 0.7)),
        ("cylinder", Collider::cylinder(0.4, 0.9)),
        ("cone", Collider::cone(0.5, 1.0)),
        ("round box", Collider::round_cuboid(0.8, 0.5, 0.6, 0.1)),
        ("half space", Collider::half_space(Vec3::new(0.6, 0.8, 0.0))),
        ("hull", Collider::convex_hull(octahedron.to_vec()).expect("a hull")),
        ("mesh", cube_mesh()),
        ("height field", hilly()),
        (
            "compound",
            Collider::compound(vec![
                (Vec3::new(0.4, 0.0, 0.0), Quat::from_rotation_z(0.4), Collider::cuboid(0.5, 0.5, 0.5)),
                (Vec3::new(-0.5, 0.1, 0.0), Quat::IDENTITY, Collider::sphere(0.3)),
            ]),
        ),
        ("by projection", Collider::voxels(Vec3::splat(0.4), &[Default::default()])),
    ]
}

fn ask(ground: &ColliderGround, p: DVec3) -> SurfaceHit<f64> {
    ground.query(Lanes::splat(p))
}

#[test]
fn every_shape_has_a_signed_distance() {
    let mut random = RandomStream::new(7, 0);
    for (name, collider) in shapes() {
        let (position, rotation) = (Vec3::new(0.2, -0.3, 0.1), Quat::from_euler(Default::default(), 0.3, -0.2, 0.5));
        // Height fields are upright here so that what lies off them stays off.
        let rotation = if name == "height field" { Quat::IDENTITY } else { rotation };
        let mut ground = ColliderGround::default();
        ground.clear(REGION);
        ground.add(&collider, position, rotation, AthleteSurface::GROUND);
        let allowed = if name == "by projection" { 2e-6 } else { 1e-8 };
        let (mut on_surface, mut slope, mut below, mut asked): (f64, f64, f64, u32) = (0.0, 0.0, 0.0, 0);
        for _ in 0..3000 {
            let mut number = || random.range(-1.2, 1.2);
            let p = DVec3::new(number(), number(), number());
            let hit = ask(&ground, p);
            let normal = hit.normal.lane(0);
            if hit.distance > 0.34 && name == "height field" || hit.distance > 1e8 {
                continue;
            }
            asked += 1;
            assert!((normal.length() - 1.0).abs() < 1e-6, "{name}: normal {normal} at {p}");
            // Outside, the way back along the normal ends on the surface; so does the way out of convex shapes.
            if hit.distance > 0.0 {
                on_surface = on_surface.max(ask(&ground, p - normal * hit.distance).distance.abs());
                // No two places differ by more than the way between them.
                let q = p + DVec3::new(number(), number(), number()) * 0.05;
                let other = ask(&ground, q);
                if other.distance < 1e8 && (name != "height field" || other.distance < 0.34) {
                    slope = slope.max((other.distance - hit.distance).abs() - (q - p).length());
                }
            }
            let clearance = ground.clearance(Lanes::splat(p));
            below = below.max(if hit.distance > 0.0 { clearance - hit.distance } else { 0.0 });
        }
        println!(
            "{name}: {asked} places; off the surface {on_surface:.1e} m, too steep {slope:.1e} m, clearance over {below:.1e} m (allowed {allowed:.0e})"
        );
        assert!(asked > 300, "{name}");
        assert!(on_surface < allowed && slope < allowed && below < allowed, "{name}");
    }
}

#[test]
fn closed_forms() {
    let (position, rotation) = (Vec3::new(0.5, -0.25, 2.0), Quat::from_rotation_y(0.75));
    let frame = |p: DVec3| rotation.as_dquat().normalize().inverse() * (p - position.as_dvec3());
    let of_box = |p: DVec3, half: DVec3| {
        let q = p.abs() - half;
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    };
    let mut random = RandomStream::new(3, 0);
    for (name, collider) in [("box", Collider::cuboid(1.0, 1.0, 1.0)), ("mesh", cube_mesh())] {
        let mut ground = ColliderGround::default();
        ground.clear(REGION);
        ground.add(&collider, position, rotation, AthleteSurface::ICE);
        let mut worst: f64 = 0.0;
        for _ in 0..3000 {
            let mut number = || random.range(-1.0, 1.0);
            let local = DVec3::new(number(), number(), number());
            let p = position.as_dvec3() + rotation.as_dquat().normalize() * local;
            let expected = of_box(frame(p), DVec3::splat(0.5));
            // A mesh is solid behind its front, not to its middle.
            if expected > -0.19 {
                let hit = ask(&ground, p);
                assert!(hit.carves && hit.friction == 0.02);
                worst = worst.max((hit.distance - expected).abs());
            }
        }
        println!("{name}: {worst:.1e} m from the closed form (allowed 1e-12)");
        assert!(worst < 1e-12);
    }
}

#[test]
fn steps_on_colliders_do_not_allocate() {
    let model = preset("runner").unwrap();
    for (name, collider) in shapes() {
        // Voxels are parry's own affair.
        if name == "by projection" {
            continue;
        }
        let mut ground = ColliderGround::default();
        ground.clear(REGION);
        ground.add(&collider, Vec3::new(0.0, -0.3, 0.0), Quat::IDENTITY, AthleteSurface::GROUND);
        let mut sim: Simulator<f64> = Simulator::new(model.clone(), SimulationSettings::of(&model));
        let standing = sim.state.root_position.lane(0) + DVec3::Y * 0.4;
        let joints = vec![DQuat::IDENTITY; model.links.len()];
        sim.state.set_pose(0, standing, DQuat::IDENTITY, &joints);
        sim.state_changed();
        step(&mut sim, &ground);
        let before = allocations();
        let (mut touching, start) = (0, std::time::Instant::now());
        for _ in 0..1200 {
            step(&mut sim, &ground);
            touching += u32::from(sim.loaded_points(0) > 0);
        }
        let made = allocations() - before;
        let each = start.elapsed().as_secs_f64() / 1200.0 * 1e6;
        println!("{name}: {made} allocations in 1200 steps (allowed 0), {touching} with contact, {each:.1} us each");
        assert_eq!(made, 0, "{name}");
        assert!(touching > 10, "{name}: it should fall on it");
    }
}
