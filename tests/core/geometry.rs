//! Contract: the world's signed distance is a distance, and its normal is its gradient.
//!
//! Each shape is compared with a brute-force search over its surface and with finite differences; a wrong normal on one
//! face would otherwise show only when somebody leans on that face. The four lanes of a wide query are four different
//! points, and each must have the bits of the scalar query.
//!
//! Has caught: steep height fields whose linear distance overstates the room left, so that a link above a flat cell
//! was not asked about its points in the slope beside it.

use crate::common::*;
use bevy_athlete::contact::{Geometry, HeightField, Solid, Surface, Terrain, World};
use bevy_athlete::math::{F64x4, RandomStream, Real, Vec3};
use bevy_athlete::sim::step;
use glam::{DQuat, DVec3};
use std::sync::Arc;

fn distance(geometry: &Geometry, p: DVec3) -> (f64, DVec3) {
    let hit = geometry.signed_distance(Vec3::<f64>::splat(p));
    (hit.distance, hit.normal.lane(0))
}

/// Largest difference between the normal and the central-difference gradient, over points where the gradient exists.
fn gradient_error(geometry: &Geometry, random: &mut RandomStream, range: f64) -> (f64, f64, usize) {
    let (mut worst, mut unit, mut used) = (0.0_f64, 0.0_f64, 0);
    for _ in 0..2000 {
        let p = random_vector(random, range);
        let (_, n) = distance(geometry, p);
        unit = unit.max((n.length() - 1.0).abs());
        let at = |d: DVec3| distance(geometry, p + d).0;
        let gradient =
            |h: f64| DVec3::from_array([DVec3::X, DVec3::Y, DVec3::Z].map(|a| (at(a * h) - at(-a * h)) / (2.0 * h)));
        let (fine, coarse) = (gradient(1e-6), gradient(1e-3));
        // Where the two differ a ridge (of equal distance to two faces) is near: no gradient there.
        if fine.distance(coarse) > 1e-3 || (fine.length() - 1.0).abs() > 1e-6 {
            continue;
        }
        used += 1;
        worst = worst.max(fine.distance(n));
    }
    (worst, unit, used)
}

/// Points of the surface of a box, on a grid of `n` by `n` a face.
fn box_surface(center: DVec3, half: DVec3, rotation: DQuat, n: usize) -> Vec<DVec3> {
    let mut points = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            for i in 0..=n {
                for j in 0..=n {
                    let (u, v) = (2.0 * i as f64 / n as f64 - 1.0, 2.0 * j as f64 / n as f64 - 1.0);
                    let mut p = [0.0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
                    points.push(center + rotation * (DVec3::from_array(p) * half));
                }
            }
        }
    }
    points
}

#[test]
fn boxes_spheres_and_planes() {
    let mut random = RandomStream::new(1, 50);
    for _ in 0..4 {
        let (center, rotation) = (random_vector(&mut random, 0.3), random_rotation(&mut random, 3.0));
        let half = DVec3::new(random.range(0.2, 0.8), random.range(0.2, 0.8), random.range(0.2, 0.8));
        let shape = Geometry::Box { center, half_extents: half, rotation };
        let n = 60;
        let surface = box_surface(center, half, rotation, n);
        let cell = half.max_element() * 2.0 / n as f64;
        let mut worst = 0.0_f64;
        for _ in 0..100 {
            let p = random_vector(&mut random, 1.5);
            let (d, _) = distance(&shape, p);
            let local = rotation.inverse() * (p - center);
            let inside = (local.abs() - half).max_element() < 0.0;
            let brute = surface.iter().map(|q| q.distance(p)).fold(f64::MAX, f64::min);
            assert_eq!(inside, d < 0.0);
            // The grid's nearest point is at most half a diagonal of a cell from the true one.
            worst = worst.max((brute - d.abs()).abs() / cell);
            assert!(brute >= d.abs() - 1e-12);
        }
        let (gradient, unit, used) = gradient_error(&shape, &mut random, 1.2);
        println!(
            "box: brute force off by {worst:.2} cells (allowed 0.71), gradient {gradient:.1e} (allowed 1e-6, {used} points), unit {unit:.0e}"
        );
        assert!(worst < 0.71 && gradient < 1e-6 && unit < 1e-12 && used > 1000);
    }
    let ball = Geometry::Sphere { center: DVec3::new(0.1, 0.2, 0.3), radius: 0.4 };
    let (gradient, unit, used) = gradient_error(&ball, &mut random, 1.2);
    println!("sphere: gradient {gradient:.1e} (allowed 1e-6, {used} points), unit {unit:.0e}");
    assert!(gradient < 1e-6 && unit < 1e-12 && used > 1000);
    let (d, n) = distance(&ball, DVec3::new(0.1, 0.2, 0.3));
    assert!(d == -0.4 && n == DVec3::Y, "at the very centre");
    let p = DVec3::new(1.0, -0.5, 0.25);
    assert!((distance(&ball, p).0 - (p.distance(DVec3::new(0.1, 0.2, 0.3)) - 0.4)).abs() < 1e-15);

    let normal = DVec3::new(0.2, 0.9, -0.3).normalize();
    let plane = Geometry::Plane { point: DVec3::new(0.0, 0.3, 0.1), normal };
    let (gradient, ..) = gradient_error(&plane, &mut random, 2.0);
    println!("plane: gradient {gradient:.1e} (allowed 1e-6)");
    assert!(gradient < 1e-6);
}

#[test]
fn stairs_are_the_union_of_their_solids() {
    let world = World::stairs(-1.0, 4, 0.3, 0.17, 1.2, Surface::GROUND);
    let mut random = RandomStream::new(2, 50);
    for _ in 0..2000 {
        let p = DVec3::new(random.range(-1.0, 1.0), random.range(-0.2, 1.5), random.range(-3.0, 1.0));
        let hit = Terrain::<f64>::query(&world, Vec3::splat(p));
        let nearest = world.solids.iter().map(|s| distance(&s.geometry, p).0).fold(f64::MAX, f64::min);
        assert_eq!(hit.distance, nearest);
    }
    // On each tread, along the flight: the height above it, straight up; and the riser ahead of it.
    let mut worst = 0.0_f64;
    for k in 0..4 {
        let tread = 0.17 * (k + 1) as f64;
        let p = DVec3::new(0.1, tread + 0.02, -1.0 - 0.3 * k as f64 - 0.15);
        let hit = Terrain::<f64>::query(&world, Vec3::splat(p));
        worst = worst.max((hit.distance - 0.02).abs()).max(hit.normal.lane(0).distance(DVec3::Y));
        let p = DVec3::new(0.1, tread - 0.08, -1.0 - 0.3 * k as f64 + 0.03);
        let hit = Terrain::<f64>::query(&world, Vec3::splat(p));
        worst = worst.max((hit.distance - 0.03).abs()).max(hit.normal.lane(0).distance(DVec3::Z));
    }
    println!("stairs: treads and risers off by {worst:.1e} (allowed 1e-12)");
    assert!(worst < 1e-12);
}

fn bumps() -> HeightField {
    let (columns, rows, spacing) = (41, 33, 0.25);
    let height = |i: usize, j: usize| {
        let (x, z) = (i as f64 * spacing, j as f64 * spacing);
        0.15 * (1.3 * x).sin() * (0.9 * z + 0.4).cos() + 0.05 * (2.9 * x + z).sin()
    };
    let heights = (0..rows).flat_map(|j| (0..columns).map(move |i| height(i, j))).collect();
    HeightField::new(DVec3::new(-5.0, 0.2, -4.0), spacing, columns, rows, heights).unwrap()
}

#[test]
fn height_fields() {
    // An inclined plane is met exactly.
    let heights = (0..6).flat_map(|j| (0..6).map(move |i| 0.3 * i as f64 * 0.5 - 0.2 * j as f64 * 0.5)).collect();
    let slope = HeightField::new(DVec3::new(-1.0, 0.1, -1.0), 0.5, 6, 6, heights).unwrap();
    let normal = DVec3::new(-0.3, 1.0, 0.2).normalize();
    let plane = Geometry::Plane { point: DVec3::new(-1.0, 0.1, -1.0), normal };
    let field = Geometry::HeightField(Arc::new(slope));
    let mut random = RandomStream::new(3, 50);
    let mut worst = 0.0_f64;
    for _ in 0..500 {
        let p = DVec3::new(random.range(-0.9, 1.4), random.range(-1.0, 1.0), random.range(-0.9, 1.4));
        let ((a, n), (b, m)) = (distance(&field, p), distance(&plane, p));
        worst = worst.max((a - b).abs()).max(n.distance(m));
    }
    println!("inclined field against plane: {worst:.1e} (allowed 1e-12)");
    assert!(worst < 1e-12);

    // Bumps: right in sign, exact on the surface, of first order near it.
    let bumps = Arc::new(bumps());
    let field = Geometry::HeightField(bumps.clone());
    let (mut off, mut normals) = (0.0_f64, 0.0_f64);
    for _ in 0..300 {
        let (x, z, up) = (random.range(-4.0, 4.0), random.range(-3.0, 3.0), random.range(-0.05, 0.05));
        let p = DVec3::new(x, bumps.height(x, z) + up, z);
        let (d, n) = distance(&field, p);
        assert_eq!(d < 0.0, up < 0.0);
        let mut brute = f64::MAX;
        for i in -40..=40 {
            for j in -40..=40 {
                let (qx, qz) = (x + 0.002 * i as f64, z + 0.002 * j as f64);
                brute = brute.min(DVec3::new(qx, bumps.height(qx, qz), qz).distance(p));
            }
        }
        off = off.max((d.abs() - brute).abs());
        let h = 1e-6;
        let slope = |a: DVec3| {
            let (b, c) = (p + a * h, p - a * h);
            (bumps.height(b.x, b.z) - bumps.height(c.x, c.z)) / (2.0 * h)
        };
        // At the line between two cells the slope has two values: the field takes either.
        let cell = |v: f64| ((v / 0.25).fract() - 0.5).abs() < 0.499;
        if cell(x + 5.0) && cell(z + 4.0) {
            normals = normals.max(n.distance(DVec3::new(-slope(DVec3::X), 1.0, -slope(DVec3::Z)).normalize()));
        }
    }
    println!(
        "bumps within 5 cm: distance off brute force by {:.2} mm (allowed 4 mm), normals {normals:.1e} (allowed 1e-6)",
        off * 1e3
    );
    assert!(off < 4e-3 && normals < 1e-6);
    // Beyond the grid: level at the border's height.
    let (d, n) = distance(&field, DVec3::new(50.0, 3.0, 60.0));
    assert!((d - (3.0 - bumps.height(5.0, 4.0))).abs() < 1e-12 && n == DVec3::Y);
}

/// A ball standing beside a ramp of 45 degrees whose contact point reaches into the ramp: the link's own place is above
/// the flat cell, where the distance along the normal overstates the room.
#[test]
fn points_in_a_steep_slope_are_found() {
    let heights = (0..2).flat_map(|_| [0.0, 0.0, 1.0, 1.0]).collect();
    let field = HeightField::new(DVec3::new(-1.0, 0.0, -1.0), 1.0, 4, 2, heights).unwrap();
    let world = World { solids: vec![Solid::fixed(Geometry::HeightField(Arc::new(field)), Surface::GROUND)] };
    // The link's origin hovers 0.3 m over the flat part next to the ramp; the point is 0.28 m away, inside the ramp.
    let mut model = rigid(5.0, DVec3::splat(0.1), DVec3::ZERO);
    let arm = DVec3::new(0.2, -0.2, 0.0);
    add_point(&mut model, arm, 0.0);
    let mut sim = simulator(model);
    place(&mut sim, DVec3::new(-0.01, 0.3, -0.5), DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO);
    let gap = Terrain::<f64>::query(&world, Vec3::splat(point_position(&mut sim, 0))).distance;
    step(&mut sim, &world);
    let force = sim.contact_force(0, 0);
    println!("point {:.0} mm deep in the ramp: force {force:.1} N", -gap * 1e3);
    assert!(gap < -0.05 && force.length() > 1.0);
}

#[test]
fn lanes_have_the_bits_of_the_scalar_query() {
    let mut world = World::stairs(-1.0, 3, 0.3, 0.17, 1.2, Surface::GROUND);
    world.solids.push(Solid::fixed(Geometry::Sphere { center: DVec3::new(0.5, 0.3, 0.5), radius: 0.4 }, Surface::ICE));
    world.solids.push(Solid::fixed(Geometry::HeightField(Arc::new(bumps())), Surface::ICE));
    let tilt = DQuat::from_axis_angle(DVec3::X, 0.3);
    let tilted = Geometry::Box { center: DVec3::Z * 2.0, half_extents: DVec3::new(0.3, 0.2, 0.5), rotation: tilt };
    world.solids.push(Solid { angular_velocity: DVec3::Y, ..Solid::fixed(tilted, Surface::GROUND) });
    let mut random = RandomStream::new(4, 50);
    for _ in 0..500 {
        let points: Vec<DVec3> = (0..4).map(|_| random_vector(&mut random, 2.5)).collect();
        let mut wide = Vec3::<F64x4>::zero();
        for (lane, p) in points.iter().enumerate() {
            wide.set_lane(lane, *p);
        }
        let hit = world.query(wide);
        for (lane, p) in points.iter().enumerate() {
            let one = Terrain::<f64>::query(&world, Vec3::splat(*p));
            assert_eq!(hit.distance.lane(lane).to_bits(), one.distance.to_bits());
            assert_eq!(hit.normal.lane(lane), one.normal.lane(0));
            assert_eq!(hit.velocity.lane(lane), one.velocity.lane(0));
            assert_eq!(hit.friction.lane(lane), one.friction);
            assert_eq!(F64x4::mask_lane(hit.carves, lane), one.carves);
        }
    }
    println!("500 queries of 4 lanes: bit-equal to the scalar query");
}
