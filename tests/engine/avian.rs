//! Contract: athletes in a world of Avian.
//!
//! What is proven: what an athlete gives to a body, the body gets, and nothing else (momentum and angular momentum before
//! and after, not a velocity that happened to come out); a moving platform carries; a floor of triangles is felt as the plane
//! it is; what stands on a body that stands on the floor stands still; and the same world gives the same bits. The residuals
//! are printed beside what is allowed.

use avian3d::prelude::*;
use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings};
use bevy::math::{DMat3, DVec3};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::contact::World as Solids;
use bevy_athlete::engine::avian::{AthleteAvianPlugin, AthleteSurface, ColliderGround};
use bevy_athlete::engine::*;
use bevy_athlete::sim::SimulationSettings;
use std::time::Duration;

const TICK: Duration = Duration::from_micros(15_625);

/// A headless app with Avian in which every frame is one tick.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default()));
    app.add_plugins((PhysicsPlugins::default(), AthletePlugins, AthleteAvianPlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
    app.finish();
    app.cleanup();
    app.update();
    app
}

fn spawn(app: &mut App, character: &str, place: Transform) -> Entity {
    let character = CharacterAsset::preset(character).unwrap();
    let character = app.world_mut().resource_mut::<Assets<CharacterAsset>>().add(character);
    app.world_mut().spawn((Athlete(character), place)).id()
}

fn floor(app: &mut App, surface: AthleteSurface) -> Entity {
    let place = Transform::from_xyz(0.0, -0.5, 0.0);
    app.world_mut().spawn((RigidBody::Static, Collider::cuboid(60.0, 1.0, 60.0), surface, place)).id()
}

fn run(app: &mut App, ticks: usize) {
    (0..ticks).for_each(|_| app.update());
}

fn body(app: &App, athlete: Entity) -> &AthleteBody {
    app.world().get::<AthleteBody>(athlete).expect("a body")
}

fn change(app: &mut App, athlete: Entity, change: impl FnOnce(&mut AthleteBody)) {
    let mut body = app.world_mut().get_mut::<AthleteBody>(athlete).expect("a body");
    change(&mut body);
    body.simulator_mut().state_changed();
}

/// Sends the whole athlete off with a velocity (m/s).
fn throw(body: &mut AthleteBody, velocity: DVec3) {
    body.simulator_mut().state.root_velocity.linear = bevy_athlete::math::Vec3::splat(velocity);
}

fn root(app: &App, athlete: Entity) -> DVec3 {
    body(app, athlete).simulator().state.root_position.lane(0)
}

/// Linear momentum and angular momentum about the world's origin of an athlete.
fn athlete_momentum(app: &mut App, athlete: Entity) -> (DVec3, DVec3) {
    let mut body = app.world_mut().get_mut::<AthleteBody>(athlete).unwrap();
    let simulator = body.simulator_mut();
    let (momentum, center) = (simulator.total_momentum(), simulator.center_of_mass().lane(0));
    let linear = momentum.linear.lane(0);
    (linear, momentum.angular.lane(0) + center.cross(linear))
}

/// The same of a body of Avian.
fn body_momentum(app: &App, entity: Entity) -> (DVec3, DVec3) {
    let entity = app.world().entity(entity);
    let rotation = entity.get::<Rotation>().unwrap().0;
    let mass = f64::from(entity.get::<ComputedMass>().unwrap().value());
    let inertia = entity.get::<ComputedAngularInertia>().unwrap().rotated(rotation).value();
    let inertia = [0, 1, 2].map(|k| inertia.col(k).as_dvec3());
    let center = entity.get::<Position>().unwrap().0 + rotation * entity.get::<ComputedCenterOfMass>().unwrap().0;
    let linear = entity.get::<LinearVelocity>().unwrap().0.as_dvec3() * mass;
    let turning = entity.get::<AngularVelocity>().unwrap().0.as_dvec3();
    let spin = DMat3::from_cols(inertia[0], inertia[1], inertia[2]) * turning;
    (linear, spin + center.as_dvec3().cross(linear))
}

/// A skater and a box of 5 kg that meet, with nothing else acting: no gravity, no floor. The box is off the skater's
/// middle, so both turn. Velocities along z, m/s.
fn they_meet(skater_speed: f64, box_speed: f32) {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let skater = spawn(&mut app, "skater", Transform::IDENTITY);
    let crate_ = app
        .world_mut()
        .spawn((
            RigidBody::Dynamic,
            Collider::cuboid(0.4, 0.4, 0.4),
            Mass(5.0),
            SleepingDisabled,
            LinearVelocity(Vec3::Z * box_speed),
            Transform::from_xyz(0.22, 0.55, -0.9),
        ))
        .id();
    run(&mut app, 1);
    change(&mut app, skater, |body| {
        let settings = *body.simulator().settings();
        body.simulator_mut().set_settings(SimulationSettings { gravity: DVec3::ZERO, ..settings });
        throw(body, DVec3::new(0.0, 0.0, skater_speed));
    });
    // The tick before had gravity: take what is there as the start.
    let before = (athlete_momentum(&mut app, skater), body_momentum(&app, crate_));
    let (mut pushed, mut pushes) = (DVec3::ZERO, 0);
    let mut worst: f64 = 0.0;
    for _ in 0..64 {
        app.update();
        for push in app.world().get::<ColliderGround>(skater).unwrap().pushes() {
            assert_eq!(push.body, crate_);
            pushed += push.impulse;
            pushes += 1;
        }
        let linear = athlete_momentum(&mut app, skater).0 - before.0.0 + body_momentum(&app, crate_).0 - before.1.0;
        worst = worst.max(linear.length());
    }
    let after = (athlete_momentum(&mut app, skater), body_momentum(&app, crate_));
    let skater_got = after.0.0 - before.0.0;
    let box_got = after.1.0 - before.1.0;
    let angular = (after.0.1 - before.0.1) + (after.1.1 - before.1.1);
    let given = (after.1.1 - before.1.1).length();
    let speeds = (after.1.0.length() / 5.0, after.0.0.z / body(&app, skater).model().mass());
    println!(
        "skater at {skater_speed} m/s, box at {box_speed} m/s: {pushes} ticks with pushes, {:.2} N s",
        pushed.length()
    );
    println!(
        "skater {skater_got:.4} N s, box {box_got:.4} N s; then the box goes {:.2} m/s, the skater {:.2} m/s",
        speeds.0, speeds.1
    );
    println!("linear: worst residual {worst:.1e} N s of {:.2} (allowed 1e-4)", box_got.length());
    println!("angular about the origin: residual {:.1e} N m s of {given:.2} (allowed 1e-3)", angular.length());
    assert!(box_got.z < -5.0, "it was hit");
    assert!(worst < 1e-4);
    assert!((pushed - box_got).length() < 1e-4, "what is told is what it got");
    assert!(given > 1.0 && angular.length() < 1e-3);
    // Inelastic: they part no faster than they met.
    assert!(after.1.0.z / 5.0 - speeds.1 > -1.2 * (f64::from(box_speed) - skater_speed));
}

#[test]
fn a_skater_hits_a_box_of_5_kg_and_both_momenta_balance() {
    they_meet(-3.0, 0.0);
}

#[test]
fn a_box_of_5_kg_hits_a_skater_and_both_momenta_balance() {
    they_meet(0.0, 3.0);
}

/// A level floor of triangles at y = 0 over [-20, 20]^2, its corners not on any round number.
fn triangle_floor() -> Collider {
    let (cells, size) = (53_u32, 40.0_f32);
    let mut vertices = Vec::new();
    for j in 0..=cells {
        for i in 0..=cells {
            let at = |k: u32| (k as f32 / cells as f32 - 0.5) * size;
            vertices.push(Vec3::new(at(i), 0.0, at(j)));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..cells {
        for i in 0..cells {
            let a = j * (cells + 1) + i;
            let (b, c, d) = (a + 1, a + cells + 1, a + cells + 2);
            if (i + j) % 2 == 0 {
                triangles.extend([[a, c, b], [b, c, d]]);
            } else {
                triangles.extend([[a, c, d], [a, d, b]]);
            }
        }
    }
    Collider::trimesh(vertices, triangles)
}

/// Where a skater is that glides for three seconds on its own.
fn glide_on(make_floor: impl FnOnce(&mut App)) -> (DVec3, usize) {
    let mut app = app();
    make_floor(&mut app);
    let skater = spawn(&mut app, "skater", Transform::from_xyz(0.31, 0.0, 4.0));
    run(&mut app, 1);
    change(&mut app, skater, |body| throw(body, DVec3::new(0.0, 0.0, -2.0)));
    run(&mut app, 192);
    (root(&app, skater), body(&app, skater).simulator().loaded_points(0))
}

#[test]
fn a_floor_of_triangles_is_skated_on_as_the_plane() {
    let plane = glide_on(|app| {
        app.insert_resource(AthleteWorld(Solids::ice()));
    });
    assert!(plane.0.z < -1.0 && plane.1 > 0, "it glides: {plane:?}");
    let ice = |collider: Collider, height: f32| {
        glide_on(move |app| {
            let place = Transform::from_xyz(0.0, height, 0.0);
            app.world_mut().spawn((RigidBody::Static, collider, AthleteSurface::ICE, place));
        })
    };
    let heights = vec![vec![0.0; 41]; 41];
    for (name, found, allowed) in [
        ("trimesh", ice(triangle_floor(), 0.0), 1e-9),
        ("height field", ice(Collider::heightfield(heights, Vec3::new(40.0, 1.0, 40.0)), 0.0), 1e-9),
        ("half space", ice(Collider::half_space(Vec3::Y), 0.0), 1e-9),
        ("box", ice(Collider::cuboid(60.0, 1.0, 60.0), -0.5), 1e-9),
        ("hull", ice(convex_slab(), -0.5), 1e-6),
    ] {
        let drift = (found.0 - plane.0).length();
        println!("{name}: {drift:.1e} m from the plane's after 3 s and 6 m (allowed {allowed:.0e})");
        assert!(drift < allowed, "{name}: {} on it, {} on the plane", found.0, plane.0);
    }
}

/// A slab of 40 x 1 x 40 m as a convex hull.
fn convex_slab() -> Collider {
    let corners = (0..8).map(|k| {
        let side = |bit: u32, half: f32| if k & bit == 0 { -half } else { half };
        Vec3::new(side(1, 20.0), side(2, 0.5), side(4, 20.0))
    });
    Collider::convex_hull(corners.collect()).expect("a hull")
}

#[test]
fn a_moving_platform_carries() {
    let mut app = app();
    let platform = app
        .world_mut()
        .spawn((
            RigidBody::Kinematic,
            Collider::cuboid(6.0, 0.2, 6.0),
            AthleteSurface::GROUND,
            Transform::from_xyz(0.0, -0.1, 0.0),
        ))
        .id();
    let human = spawn(&mut app, "foot_human", Transform::IDENTITY);
    run(&mut app, 32);
    let offset = |app: &App| root(app, human) - app.world().get::<Position>(platform).unwrap().0.as_dvec3();
    let (start, start_root) = (offset(&app), root(&app, human));
    // Half a second to get going, then steadily aside and up.
    let goal = Vec3::new(0.4, 0.3, 0.0);
    let (mut worst, mut sink): (f64, f64) = (0.0, 0.0);
    for tick in 0..160 {
        let part = (tick as f32 / 64.0).min(1.0);
        app.world_mut().get_mut::<LinearVelocity>(platform).unwrap().0 = goal * part;
        app.update();
        let off = offset(&app) - start;
        worst = worst.max(off.with_y(0.0).length());
        sink = sink.max(off.y.abs());
    }
    let way = (root(&app, human) - start_root).length();
    println!(
        "carried {way:.3} m; moved on the platform by at most {:.1} mm, {:.1} mm up or down",
        worst * 1e3,
        sink * 1e3
    );
    assert!(way > 0.9, "it is taken along");
    assert!(body(&app, human).simulator().loaded_points(0) > 0, "it still stands");
    assert!(worst < 0.05 && sink < 0.02);
}

#[test]
fn what_stands_on_a_body_that_stands_on_the_floor_stands_still() {
    let mut app = app();
    floor(&mut app, AthleteSurface::GROUND);
    // Lighter than the human on it.
    let podium = app
        .world_mut()
        .spawn((
            RigidBody::Dynamic,
            Collider::cuboid(1.2, 0.3, 1.2),
            Mass(20.0),
            AthleteSurface::GROUND,
            Transform::from_xyz(0.0, 0.15, 0.0),
        ))
        .id();
    run(&mut app, 32);
    let human = spawn(&mut app, "foot_human", Transform::from_xyz(0.0, 0.3, 0.0));
    run(&mut app, 64);
    let (start, start_podium) = (root(&app, human), app.world().get::<Position>(podium).unwrap().0);
    let (mut worst, mut pressed): (f64, f64) = (0.0, 0.0);
    for _ in 0..64 {
        app.update();
        worst = worst.max((root(&app, human) - start).y.abs());
        pressed -= app.world().get::<ColliderGround>(human).unwrap().pushes().map(|p| p.impulse.y).sum::<f64>();
    }
    let moved = (app.world().get::<Position>(podium).unwrap().0 - start_podium).length();
    // A second of ticks is a second of steps.
    let weight = pressed / 1.0;
    let expected = body(&app, human).model().mass() * 9.81;
    println!("up and down by {:.2} mm, the podium by {:.2} mm", worst * 1e3, moved * 1e3);
    println!("presses on it with {weight:.0} N, weighs {expected:.0} N");
    assert!(worst < 0.01 && moved < 0.005);
    assert!((weight / expected - 1.0).abs() < 0.01);
}

#[test]
fn the_same_world_gives_the_same_bits() {
    let run_once = || {
        let mut app = app();
        floor(&mut app, AthleteSurface::ICE);
        for k in 0..6 {
            app.world_mut().spawn((
                RigidBody::Dynamic,
                Collider::cuboid(0.4, 0.5, 0.4),
                Mass(5.0),
                Friction::new(0.1),
                Transform::from_xyz(-0.5 + 0.4 * k as f32, 0.25, -1.0 - 0.1 * k as f32),
            ));
        }
        let skaters = [-0.5, 0.6].map(|x| spawn(&mut app, "skater", Transform::from_xyz(x, 0.0, 0.0)));
        run(&mut app, 1);
        for skater in skaters {
            change(&mut app, skater, |body| throw(body, DVec3::new(0.1, 0.0, -2.0)));
        }
        run(&mut app, 96);
        skaters.map(|s| body(&app, s).simulator().state.fingerprint(0))
    };
    let (once, again) = (run_once(), run_once());
    println!("{once:016x?}");
    assert_eq!(once, again);
}

#[test]
fn sensors_other_layers_and_disabled_colliders_are_not_felt() {
    let falls = |extra: fn(&mut EntityWorldMut)| {
        let mut app = app();
        let floor = floor(&mut app, AthleteSurface::GROUND);
        extra(&mut app.world_mut().entity_mut(floor));
        let human = spawn(&mut app, "runner", Transform::IDENTITY);
        run(&mut app, 1);
        let start = root(&app, human).y;
        run(&mut app, 20);
        start - root(&app, human).y > 0.2
    };
    assert!(!falls(|_| {}));
    assert!(falls(|floor| {
        floor.insert(Sensor);
    }));
    assert!(falls(|floor| {
        floor.insert(ColliderDisabled);
    }));
    assert!(falls(|floor| {
        floor.insert(CollisionLayers::NONE);
    }));
}

#[test]
fn athletes_add_no_order_that_bevy_may_choose() {
    // Pairs of systems of a fixed tick that conflict and are not ordered: Avian has some of its own.
    let pairs = |athletes: bool| {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), PhysicsPlugins::default()));
        if athletes {
            app.add_plugins((AthletePlugins, AthleteAvianPlugin));
        }
        app.edit_schedule(FixedPostUpdate, |schedule| {
            schedule.set_build_settings(ScheduleBuildSettings {
                ambiguity_detection: LogLevel::Warn,
                ..Default::default()
            });
        });
        app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
        app.finish();
        app.cleanup();
        run(&mut app, 3);
        app.get_schedule(FixedPostUpdate).expect("a schedule").graph().conflicting_systems().0.len()
    };
    let (without, with) = (pairs(false), pairs(true));
    println!("{without} such pairs in Avian alone, {with} with athletes");
    assert_eq!(with, without);
}
