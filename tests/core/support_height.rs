//! Contract: `Terrain::height` is the top of what could be stood on in a vertical line, the same for every kind of solid, and
//! the same as what the signed distance says.
//!
//! Proves: level ground gives exactly its height, in every lane type (the skaters' bits depend on it); for random solids the
//! signed distance changes sign at the height told, and nothing lies between it and the point; a brute-force walk along
//! `query` finds the same top; overhangs do not count and walls do; a terrain that only knows its distance finds the same
//! within 1 mm; scans are heights in a row. What it cannot prove is the rule for solids that overlap: that is by definition.

use bevy_athlete::contact::{
    Geometry, HeightField, Material, STEP_UP, Solid, SupportHit, Surface, SurfaceHit, Terrain, World,
};
use bevy_athlete::math::{F32x8Fused, F64x4, RandomStream, Real, Vec3};
use glam::{DQuat, DVec3};
use std::sync::Arc;

fn world(solids: impl IntoIterator<Item = Geometry>) -> World {
    World { solids: solids.into_iter().map(|g| Solid::fixed(g, Surface::GROUND)).collect() }
}

fn height(terrain: &impl Terrain<f64>, x: f64, y: f64, z: f64) -> Option<f64> {
    let hit = terrain.height(Vec3::splat(DVec3::new(x, y, z)));
    hit.found.then_some(hit.height)
}

/// A terrain that says nothing but its distance.
struct Distance<'a>(&'a World);

impl<R: Real> Terrain<R> for Distance<'_> {
    fn query(&self, point: Vec3<R>) -> SurfaceHit<R> {
        self.0.query(point)
    }
}

#[test]
fn level_ground_is_exactly_at_its_height() {
    fn exact<R: Real>(worlds: &[World]) {
        let mut random = RandomStream::new(5, 1);
        for world in worlds {
            for _ in 0..200 {
                let point = DVec3::from_array(core::array::from_fn(|_| random.range(-50.0, 50.0)));
                let hit: SupportHit<R> = world.height(Vec3::splat(point));
                for lane in 0..R::LANES {
                    assert_eq!(hit.height.lane(lane).to_bits(), 0.0f64.to_bits(), "{point}");
                    assert_eq!(hit.normal.lane(lane), DVec3::Y);
                    assert!(R::mask_lane(hit.found, lane));
                }
            }
        }
    }
    let far_box = Geometry::Box {
        center: DVec3::new(0.0, 0.5, -200.0),
        half_extents: DVec3::splat(0.5),
        rotation: DQuat::IDENTITY,
    };
    let mut two = World::ice();
    two.solids.push(Solid::fixed(far_box, Surface::WALL));
    let worlds = [World::ice(), World::ground(), two];
    exact::<f64>(&worlds);
    exact::<f32>(&worlds);
    exact::<F64x4>(&worlds);
    exact::<F32x8Fused>(&worlds);
}

/// One of each kind, above the ground or on it.
fn kinds() -> Vec<Geometry> {
    let turn = |v: [f64; 3]| DQuat::from_scaled_axis(DVec3::from_array(v));
    let heights = (0..36).map(|k| 0.1 * f64::from(k * 7 % 5)).collect();
    let field = HeightField::new(DVec3::new(-1.0, 0.0, -1.0), 0.4, 6, 6, heights).expect("a field");
    vec![
        Geometry::Plane { point: DVec3::new(0.0, 0.2, 0.0), normal: turn([0.2, 0.0, -0.1]) * DVec3::Y },
        Geometry::Box {
            center: DVec3::new(0.1, 0.4, 0.2),
            half_extents: DVec3::new(0.5, 0.2, 0.8),
            rotation: turn([0.0, 0.7, 0.0]),
        },
        Geometry::Box {
            center: DVec3::new(0.1, 0.4, 0.2),
            half_extents: DVec3::new(0.5, 0.2, 0.8),
            rotation: turn([0.3, 0.7, -0.5]),
        },
        Geometry::Sphere { center: DVec3::new(0.1, 0.4, 0.2), radius: 0.7 },
        Geometry::Rail { center: DVec3::new(0.1, 0.9, 0.2), half: DVec3::new(0.5, 0.0, 0.3), radius: 0.2 },
        Geometry::Strip { top: 0.3, near: 0.6, far: -0.5 },
        Geometry::Strip { top: 0.3, near: f64::INFINITY, far: 0.2 },
        Geometry::HeightField(Arc::new(field)),
    ]
}

#[test]
fn the_distance_changes_its_sign_at_the_height() {
    let mut random = RandomStream::new(9, 2);
    for geometry in kinds() {
        let name = format!("{geometry:?}").chars().take(60).collect::<String>();
        let world = world([geometry]);
        let distance =
            |x: f64, y: f64, z: f64| -> f64 { world.query(Vec3::<f64>::splat(DVec3::new(x, y, z))).distance };
        let (mut met, mut missed) = (0, 0);
        for _ in 0..400 {
            let [x, z] = core::array::from_fn(|_| random.range(-1.2, 1.2));
            let from = 1.5;
            let hit: SupportHit<f64> = world.height(Vec3::splat(DVec3::new(x, from, z)));
            // The brute force: down in steps of 2 mm to the first place inside.
            let mut walked = None;
            for k in 0..2000 {
                let y = from + STEP_UP - 0.002 * f64::from(k);
                if distance(x, y, z) < 0.0 {
                    walked = Some(y);
                    break;
                }
            }
            match (hit.found, walked) {
                (true, Some(y)) => {
                    met += 1;
                    assert!((hit.height - y).abs() < 0.0025, "{name} at {x} {z}: {} and {y}", hit.height);
                    let (above, below) = (distance(x, hit.height + 1e-6, z), distance(x, hit.height - 1e-6, z));
                    assert!(above > 0.0 && below < 0.0 || above.abs().max(below.abs()) < 1e-5, "{name} at {x} {z}");
                    let near: SurfaceHit<f64> = world.query(Vec3::splat(DVec3::new(x, hit.height, z)));
                    // On edges two normals are as good.
                    let edge = distance(x + 1e-3, hit.height, z).abs().max(distance(x, hit.height, z + 1e-3).abs());
                    assert!(edge > 1e-6 || (near.normal - hit.normal).length() < 1e-6, "{name} at {x} {z}");
                }
                (false, None) => missed += 1,
                // The rim: a line that the walk of 2 mm steps over.
                (found, _) => assert!(!found || distance(x, hit.height - 1e-3, z).abs() < 2e-3, "{name} at {x} {z}"),
            }
        }
        println!("{name}: {met} met, {missed} missed");
        assert!(met > 20);
    }
}

#[test]
fn a_terrain_that_only_knows_distances_finds_the_same() {
    let mut random = RandomStream::new(10, 2);
    let mut worst = 0.0f64;
    for geometry in kinds() {
        let world = world([geometry]);
        for _ in 0..200 {
            let point = DVec3::new(random.range(-1.2, 1.2), random.range(0.0, 2.0), random.range(-1.2, 1.2));
            let known = world.height(Vec3::<f64>::splat(point));
            let traced = Distance(&world).height(Vec3::<f64>::splat(point));
            if known.found && traced.found {
                // A line that grazes a rim falls by the steepness of it.
                let steep = known.normal.lane(0).y < 0.3;
                if !steep && world.solids.len() == 1 {
                    worst = worst.max((known.height - traced.height).abs());
                }
            }
        }
    }
    println!("sphere tracing is off by {:.2} mm (allowed 1)", worst * 1e3);
    assert!(worst < 1e-3);
    let nowhere = Distance(&World::empty()).height(Vec3::<f64>::splat(DVec3::Y));
    assert!(!nowhere.found && nowhere.height == SupportHit::<f64>::BOTTOMLESS);
}

#[test]
fn overhead_does_not_count_and_walls_do() {
    let block = |center: [f64; 3], half: [f64; 3]| Geometry::Box {
        center: center.into(),
        half_extents: half.into(),
        rotation: DQuat::IDENTITY,
    };
    let ground = Geometry::Plane { point: DVec3::ZERO, normal: DVec3::Y };
    // A wall of 2 m, a bridge from 1.8 to 2 m, a table on legs that are not there from 0.7 to 0.75 m.
    let world = world([
        ground,
        block([0.0, 1.0, -2.0], [1.0, 1.0, 0.1]),
        block([0.0, 1.9, -4.0], [1.0, 0.1, 0.5]),
        block([0.0, 0.725, -6.0], [1.0, 0.025, 0.5]),
    ]);
    let at = |y: f64, z: f64| height(&world, 0.0, y, z).expect("ground");
    assert_eq!([at(0.9, 0.0), at(0.9, -2.0), at(0.1, -2.0)], [0.0, 2.0, 2.0]);
    assert_eq!([at(0.9, -4.0), at(1.7, -4.0), at(1.76, -4.0), at(2.0, -4.0)], [0.0, 0.0, 2.0, 2.0]);
    assert_eq!([at(0.6, -6.0), at(0.66, -6.0)], [0.0, 0.75]);
    // A plane that faces down is a ceiling.
    let ceiling = Geometry::Plane { point: DVec3::Y * 3.0, normal: -DVec3::Y };
    assert_eq!(height(&World { solids: vec![Solid::fixed(ceiling, Surface::WALL)] }, 0.0, 1.0, 0.0), None);
}

#[test]
fn what_moves_carries_and_scans_are_heights_in_a_row() {
    let mut world = World::ground();
    let slab = Geometry::Box {
        center: DVec3::new(0.0, 0.2, -3.0),
        half_extents: DVec3::new(1.0, 0.2, 0.5),
        rotation: DQuat::IDENTITY,
    };
    let mut solid = Solid::fixed(slab, Surface { material: Material::WALL, friction: 0.5 });
    (solid.linear_velocity, solid.angular_velocity) = (DVec3::X * 0.3, DVec3::Y);
    solid.pivot = DVec3::new(0.0, 0.0, -3.0);
    world.solids.push(solid);
    let hit: SupportHit<f64> = world.height(Vec3::splat(DVec3::new(0.5, 1.0, -3.0)));
    assert_eq!((hit.height, hit.velocity.lane(0)), (0.4, DVec3::new(0.3, 0.0, -0.5)));

    let origin = Vec3::<F64x4>::splat(DVec3::new(0.0, 1.0, 0.0));
    let mut heading = Vec3::<F64x4>::splat(DVec3::NEG_Z);
    heading.set_lane(2, DVec3::X);
    let distances = [0.0, 2.0, 2.6, 3.4, 3.6];
    let mut out = [F64x4::splat(7.0); 5];
    world.scan(origin, heading, &distances, &mut out);
    let lane = |k: usize| out.map(|h| h.lane(k));
    assert_eq!((lane(0), lane(2)), ([0.0, 0.0, 0.4, 0.4, 0.0], [0.0; 5]));
}
