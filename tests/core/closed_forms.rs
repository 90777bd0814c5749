//! Contract: where mechanics has a formula, the simulation follows it.
//!
//! Falling, swinging, sliding, standing on a slope, rolling, carving, being carried, holding on. Each test prints what
//! was measured beside the formula. These are the only tests that would notice a wrong constant (g, the friction
//! coefficient, an inertia): the identities hold for any value of them.

use crate::common::*;
use bevy_athlete::contact::{Geometry, Material, Solid, Surface, World};
use bevy_athlete::dynamics::GripAnchor;
use bevy_athlete::model::{Grip, LeanLaw, skater};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

const G: f64 = 9.81;

#[test]
fn free_fall() {
    for rate in [300.0, 1200.0] {
        let model = skater();
        let settings = SimulationSettings { rate, ..SimulationSettings::of(&model) };
        let mut sim = Simulator::<f64>::new(model.clone(), settings);
        place(&mut sim, DVec3::Y * 100.0, DQuat::IDENTITY, DVec3::new(1.0, 5.0, 2.0), DVec3::new(0.5, 3.0, -1.0));
        let p0 = sim.center_of_mass().lane(0);
        let v0 = sim.total_momentum().linear.lane(0) / model.mass();
        let world = World::ice();
        for _ in 0..(2.0 * rate) as usize {
            step(&mut sim, &world);
        }
        let p = sim.center_of_mass().lane(0);
        let v = sim.total_momentum().linear.lane(0) / model.mass();
        let gravity = -DVec3::Y * G;
        // The step reads its end velocity, so it falls by g t (t + h) / 2: the parabola's points, half a step early.
        let stepped = (p - (p0 + v0 * 2.0 + gravity * (2.0 * (2.0 + 1.0 / rate) / 2.0))).length();
        let parabola = (p - (p0 + v0 * 2.0 + gravity * 2.0)).length();
        let speed = (v - (v0 + gravity * 2.0)).length();
        let allowed = G * 2.0 / (2.0 * rate) + 1e-10;
        println!(
            "{rate} Hz, 2 s: speed off {speed:.1e} m/s (allowed 1e-11), parabola {parabola:.2e} m (allowed g t h / 2 = {allowed:.2e}), \
             its stepped form {stepped:.1e} m (allowed 1e-10)"
        );
        assert!(speed < 1e-11 && stepped < 1e-10 && parabola < allowed);
    }
}

/// A rod held at one end by a grip is a physical pendulum: `T = 2 pi sqrt(I / (m g d)) (1 + a^2 / 16)`.
#[test]
fn pendulum_on_a_grip() {
    let (mass, length) = (3.0, 0.8);
    let about_middle = mass * length * length / 12.0;
    let mut model = rigid(mass, DVec3::new(about_middle, 1e-3, about_middle), DVec3::new(0.0, -0.5 * length, 0.0));
    model.grips.push(Grip { name: "end".into(), link: 0, position: DVec3::ZERO, max_force: 450.0 });
    let period = TAU * ((about_middle + mass * 0.25 * length * length) / (mass * G * 0.5 * length)).sqrt();
    for axis in [DVec3::X, DVec3::new(0.6, 0.0, 0.8)] {
        let mut sim = simulator(model.clone());
        let anchor = DVec3::new(0.3, 2.0, -0.2);
        let amplitude = 0.1_f64;
        place(&mut sim, anchor, DQuat::from_axis_angle(axis, amplitude), DVec3::ZERO, DVec3::ZERO);
        sim.hold(0, 0, GripAnchor::Fixed(anchor));
        let world = World::empty();
        let (mut crossings, mut last, mut apart, mut widest) = (Vec::new(), amplitude, 0.0_f64, 0.0_f64);
        let h = sim.step_seconds();
        for k in 0..(10.0 * period / h) as usize {
            step(&mut sim, &world);
            let q = sim.state.root_rotation.lane(0);
            let angle = 2.0 * q.xyz().dot(axis).atan2(q.w);
            if last < 0.0 && angle >= 0.0 {
                crossings.push((k as f64 + 1.0 - angle / (angle - last)) * h);
            }
            last = angle;
            if k as f64 * h > 9.0 * period {
                widest = widest.max(angle.abs());
            }
            apart = apart.max(sim.state.root_position.lane(0).distance(anchor));
        }
        let n = crossings.len() - 1;
        let measured = (crossings[n] - crossings[0]) / n as f64;
        let expected = period * (1.0 + amplitude * amplitude / 16.0);
        let off = (measured / expected - 1.0).abs();
        println!(
            "pendulum about {axis}: period {measured:.5} s, formula {expected:.5} s, off {off:.1e} (allowed 1e-3); grip \
             open by {apart:.1e} m (allowed 1e-4); amplitude after 10 swings {:.3} of the first (allowed 0.98 to 1.02)",
            widest / amplitude
        );
        assert!(off < 1e-3 && apart < 1e-4 && (widest / amplitude - 1.0).abs() < 0.02);

        // Let go: free fall from here on.
        sim.release(0, 0);
        let v0 = sim.total_momentum().linear.lane(0) / mass;
        for _ in 0..600 {
            step(&mut sim, &world);
        }
        let v = sim.total_momentum().linear.lane(0) / mass;
        let off = (v - v0 + DVec3::Y * (G * 600.0 * h)).length();
        println!("  released: velocity off free fall by {off:.1e} m/s (allowed 1e-11)");
        assert!(off < 1e-11 && sim.state.grip_impulses[0].lane(0) == DVec3::ZERO);
    }
}

/// The skater hangs by both hands: the grips carry its weight and do not open; when they let go it falls.
#[test]
fn skater_hangs_by_its_hands() {
    let model = skater();
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let arms = pose(&model, &[("bicep_left", [0.0, 0.0, -160.0]), ("bicep_right", [0.0, 0.0, 160.0])]);
    sim.state.set_pose(0, DVec3::Y * 3.0, DQuat::IDENTITY, &arms);
    for (command, q) in sim.commands.iter_mut().zip(&arms) {
        command.rotation = bevy_athlete::math::Quat::splat(*q);
    }
    sim.state_changed();
    let mut anchors = [DVec3::ZERO; 2];
    for (g, anchor) in anchors.iter_mut().enumerate() {
        *anchor = sim.grip_position(g, 0).unwrap();
        sim.hold(g, 0, GripAnchor::Fixed(*anchor));
    }
    let world = World::empty();
    let mut apart = 0.0_f64;
    let mut held = 0.0;
    for k in 0..2400 {
        step(&mut sim, &world);
        for (g, anchor) in anchors.iter().enumerate() {
            let p = sim.grip_position(g, 0).unwrap();
            apart = apart.max(p.distance(*anchor));
            if k >= 1200 {
                held += sim.state.grip_impulses[g].lane(0).y;
            }
        }
    }
    let weight = held / 1.0 / (model.mass() * G);
    println!(
        "hanging 2 s: grips open by at most {:.3} mm (allowed 1 mm); they carry {weight:.3} of the weight (allowed 0.97 to 1.03)",
        apart * 1e3
    );
    assert!(apart < 1e-3 && (weight - 1.0).abs() < 0.03);
    (0..2).for_each(|g| sim.release(g, 0));
    let v0 = sim.total_momentum().linear.lane(0).y / model.mass();
    for _ in 0..120 {
        step(&mut sim, &world);
    }
    let fall = sim.total_momentum().linear.lane(0).y / model.mass() - v0;
    println!("released 0.1 s: speed {fall:.6} m/s, formula {:.6}", -G * 0.1);
    assert!((fall + G * 0.1).abs() < 1e-9);
}

/// On ice a body that slides at v stops after `v^2 / (2 mu g)`.
#[test]
fn sliding_stop_distance() {
    for direction in [DVec3::X, DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8)] {
        let mut sim = simulator(crate_box(DVec3::new(0.2, 0.05, 0.2)));
        place(&mut sim, DVec3::Y * 0.05, DQuat::IDENTITY, direction, DVec3::ZERO);
        let world = World::ice();
        let mu = Surface::ICE.friction;
        let mut stopped = 0.0;
        for _ in 0..(6.0 * 1200.0) as usize {
            step(&mut sim, &world);
            if stopped == 0.0 && sim.state.root_velocity.linear.lane(0).length() < 1e-3 {
                stopped = sim.state.time;
            }
        }
        let distance = sim.state.root_position.lane(0).dot(direction);
        let (expected, expected_time) = (1.0 / (2.0 * mu * G), 1.0 / (mu * G));
        let aside = (sim.state.root_position.lane(0) - direction * distance - DVec3::Y * 0.05).length();
        println!(
            "sliding along {direction}: stops after {distance:.4} m (formula {expected:.4}), {stopped:.3} s ({expected_time:.3}), \
             {:.2} % off (allowed 0.2 %), {aside:.1e} m aside (allowed 1e-3)",
            100.0 * (distance / expected - 1.0).abs()
        );
        assert!(
            (distance / expected - 1.0).abs() < 2e-3 && (stopped / expected_time - 1.0).abs() < 5e-3 && aside < 1e-3
        );
    }
}

fn tilted(normal: DVec3, friction: f64) -> World {
    let surface = Surface { material: Material::GROUND, friction };
    World { solids: vec![Solid::fixed(Geometry::Plane { point: DVec3::ZERO, normal }, surface)] }
}

/// A body stays on a slope below `atan(mu)` and slides down at `g (sin - mu cos)` above it, whatever way the slope faces.
#[test]
fn friction_cone_on_a_slope() {
    let mu = 0.5_f64;
    for heading in [0.0, 0.25 * PI, 0.7 * PI, 1.5 * PI] {
        let axis = DVec3::new(f64::cos(heading), 0.0, f64::sin(heading));
        for beyond in [-0.5, 0.5] {
            let angle = mu.atan() + f64::to_radians(beyond);
            let turn = DQuat::from_axis_angle(axis, angle);
            let normal = turn * DVec3::Y;
            let world = tilted(normal, mu);
            let mut sim = simulator(crate_box(DVec3::new(0.2, 0.05, 0.2)));
            place(&mut sim, normal * 0.05, turn, DVec3::ZERO, DVec3::ZERO);
            for _ in 0..600 {
                step(&mut sim, &world);
            }
            let (p0, v0) = (sim.state.root_position.lane(0), sim.state.root_velocity.linear.lane(0));
            for _ in 0..1200 {
                step(&mut sim, &world);
            }
            let moved = sim.state.root_position.lane(0).distance(p0);
            let gained = (sim.state.root_velocity.linear.lane(0) - v0).length();
            let expected = (G * (angle.sin() - mu * angle.cos())).max(0.0);
            println!(
                "slope {:.2} deg facing {:.0} deg, cone {:.2} deg: moves {:.4} mm in 1 s, gains {gained:.5} m/s (formula {expected:.5})",
                angle.to_degrees(),
                heading.to_degrees(),
                mu.atan().to_degrees(),
                moved * 1e3
            );
            if beyond < 0.0 {
                assert!(moved < 1e-4, "holds below the cone (allowed 0.1 mm)");
            } else {
                assert!((gained / expected - 1.0).abs() < 0.01, "slides above it (allowed 1 %)");
            }
        }
    }
}

/// A ball set sliding without spin ends rolling at 5/7 of its speed after `2 v / (7 mu g)`.
#[test]
fn sliding_ball_ends_rolling() {
    let (radius, mass, v) = (0.1, 2.0, 2.0);
    let surface = Surface { material: Material::GROUND, friction: 0.3 };
    for direction in [DVec3::X, DVec3::new(-0.8, 0.0, 0.6)] {
        let mut model = rigid(mass, DVec3::splat(0.4 * mass * radius * radius), DVec3::ZERO);
        add_point(&mut model, DVec3::ZERO, radius);
        let mut sim = simulator(model);
        place(&mut sim, DVec3::Y * radius, DQuat::IDENTITY, direction * v, DVec3::ZERO);
        let world = World::plane(surface);
        let mut rolls_at = 0.0;
        for _ in 0..1200 {
            step(&mut sim, &world);
            let m = sim.state.root_velocity;
            let slip = (m.linear.lane(0) + m.angular.lane(0).cross(-DVec3::Y * radius)).length();
            if rolls_at == 0.0 && slip < 1e-6 {
                rolls_at = sim.state.time;
            }
        }
        let speed = sim.state.root_velocity.linear.lane(0).dot(direction);
        let spin = sim.state.root_velocity.angular.lane(0).length() * radius;
        let expected_time = 2.0 * v / (7.0 * surface.friction * G);
        println!(
            "ball: ends at {speed:.9} m/s, rim {spin:.9} m/s (formula {:.9}, allowed 1e-6); rolls after {rolls_at:.4} s (formula {expected_time:.4}, allowed 2 steps)",
            v * 5.0 / 7.0
        );
        assert!((speed - v * 5.0 / 7.0).abs() < 1e-6 && (spin - v * 5.0 / 7.0).abs() < 1e-6);
        assert!((rolls_at - expected_time).abs() < 2.0 / 1200.0);
    }
}

/// The path curvature of a body gliding on a blade that leans by `lean`: by positions alone, positive to the inside; and
/// how much its heading turns per metre.
///
/// Two points without friction beside the blade keep the leaning body from falling over.
fn carve(law: LeanLaw, lean: f64, speed: f64) -> (f64, f64) {
    // Inside is +x: leaning to the inside turns +x down, about -z.
    let turn = DQuat::from_rotation_z(-lean);
    let upright = |p: DVec3| turn.inverse() * p;
    let mut model = rigid(50.0, DVec3::splat(3.0), upright(DVec3::Y * 0.1));
    add_blade(&mut model, DVec3::ZERO, 0.208, law);
    for x in [-0.8, 0.8] {
        add_point(&mut model, upright(DVec3::X * x), 0.0);
        model.contact_points.last_mut().unwrap().friction = 0.0;
    }
    let mut sim = simulator(model);
    place(&mut sim, DVec3::ZERO, turn, DVec3::NEG_Z * speed, DVec3::ZERO);
    let world = World::ice();
    let middle = |sim: &mut Simulator<f64>| (point_position(sim, 0) + point_position(sim, 1)) * 0.5;
    for _ in 0..60 {
        step(&mut sim, &world);
    }
    let mut path = vec![middle(&mut sim)];
    let forward = |sim: &Simulator<f64>| sim.state.root_rotation.lane(0) * DVec3::NEG_Z;
    let away = |sim: &Simulator<f64>| {
        let f = forward(sim);
        f.z.atan2(f.x)
    };
    let (mut length, mut turned, mut last) = (0.0, 0.0, away(&sim));
    for _ in 0..360 {
        step(&mut sim, &world);
        let p = middle(&mut sim);
        length += p.distance(*path.last().unwrap());
        path.push(p);
        let now = away(&sim);
        turned += (now - last + PI).rem_euclid(TAU) - PI;
        last = now;
    }
    // The circle through three points of the path.
    let (a, b, c) = (path[0], path[180], path[360]);
    let cross = (b - a).cross(c - b);
    let circle = 2.0 * cross.length() / (a.distance(b) * b.distance(c) * a.distance(c));
    // Forwards, turning to the right (towards +x) is about -y.
    let side = -cross.y.signum() * speed.signum();
    (circle * side, turned.abs() / length)
}

#[test]
fn leaning_blade_carves_its_radius() {
    let dead_zone = LeanLaw::DeadZone { dead_zone: f64::to_radians(15.0), gain: 6.0 };
    let rocker = LeanLaw::Rocker { radius: 2.2 };
    for (law, name) in [(dead_zone, "dead zone"), (rocker, "rocker")] {
        for degrees in [20.0_f64, 27.0, 32.0] {
            for (edge, travel) in [(1.0, 3.0), (1.0, -3.0), (-1.0, 3.0), (-1.0, -3.0)] {
                let lean = degrees.to_radians() * edge;
                let expected = match law {
                    LeanLaw::DeadZone { dead_zone, gain } => gain * (lean.abs() - dead_zone) * edge,
                    LeanLaw::Rocker { radius } => lean.sin() / radius,
                };
                let (circle, heading) = carve(law, lean, travel);
                println!(
                    "{name}, lean {:+.0} deg, {travel:+.0} m/s: radius {:+.4} m (law {:+.4}, off {:.2} %, allowed 0.5 %), heading per metre off {:.2} %",
                    degrees * edge,
                    1.0 / circle,
                    1.0 / expected,
                    100.0 * (circle / expected - 1.0).abs(),
                    100.0 * (heading / expected.abs() - 1.0).abs(),
                );
                assert!((circle / expected - 1.0).abs() < 0.005);
                assert!((heading / expected.abs() - 1.0).abs() < 0.005);
            }
        }
    }
    // Within the dead zone it goes straight.
    let (circle, _) = carve(dead_zone, f64::to_radians(14.0), 3.0);
    println!("dead zone, lean 14 deg: curvature {circle:.1e} 1/m (allowed 1e-3)");
    assert!(circle.abs() < 1e-3);
}

/// What stands on a moving surface is carried: along with a belt, up with a lift, around with a tilting slope.
#[test]
fn moving_ground_carries() {
    let half = DVec3::new(0.2, 0.05, 0.2);
    // A belt: the body is brought to the belt's speed and kept there.
    let belt = DVec3::new(0.5, 0.0, -0.3);
    let mut world = World::ground();
    world.solids[0].linear_velocity = belt;
    let mut sim = simulator(crate_box(half));
    place(&mut sim, DVec3::Y * half.y, DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO);
    for _ in 0..600 {
        step(&mut sim, &world);
    }
    let off = (sim.state.root_velocity.linear.lane(0) - belt).length();
    println!("belt: off its speed by {off:.1e} m/s (allowed 1e-6)");
    assert!(off < 1e-6);

    // A turntable: the body goes round with it.
    let mut world = World::ground();
    world.solids[0].angular_velocity = DVec3::Y * 0.8;
    let mut sim = simulator(crate_box(half));
    place(&mut sim, DVec3::new(1.0, half.y, 0.0), DQuat::IDENTITY, DVec3::NEG_Z * 0.8, DVec3::Y * 0.8);
    for _ in 0..2400 {
        step(&mut sim, &world);
    }
    let expected = DQuat::from_rotation_y(1.6) * DVec3::new(1.0, half.y, 0.0);
    let off = sim.state.root_position.lane(0).distance(expected);
    println!("turntable, 2 s at 0.8 rad/s, 1 m out: off by {:.3} mm (allowed 5 mm)", off * 1e3);
    assert!(off < 5e-3);

    // A slope that tilts to 15 degrees, and a lift: the body keeps its place on them.
    let (rate, seconds) = (f64::to_radians(7.5), 2.0);
    let axis = DVec3::Z;
    let ground = Surface::GROUND;
    let mut sim = simulator(crate_box(half));
    place(&mut sim, DVec3::new(0.5, half.y, 0.0), DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO);
    let steps = (seconds * 1200.0) as usize;
    for k in 0..steps {
        let angle = rate * k as f64 / 1200.0;
        let world = World { solids: vec![Solid::tilted_plane(DVec3::ZERO, axis, angle, rate, ground)] };
        step(&mut sim, &world);
    }
    let expected = DQuat::from_axis_angle(axis, rate * seconds) * DVec3::new(0.5, half.y, 0.0);
    let off = sim.state.root_position.lane(0).distance(expected);
    println!("tilting slope, 15 degrees in 2 s, 0.5 m out: off its place by {:.3} mm (allowed 2 mm)", off * 1e3);
    assert!(off < 2e-3);

    let mut sim = simulator(crate_box(half));
    place(&mut sim, DVec3::Y * half.y, DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO);
    for k in 0..1200 {
        let mut solid =
            Solid::fixed(Geometry::Plane { point: DVec3::Y * (0.5 * k as f64 / 1200.0), normal: DVec3::Y }, ground);
        solid.linear_velocity = DVec3::Y * 0.5;
        step(&mut sim, &World { solids: vec![solid] });
    }
    let off = (sim.state.root_position.lane(0).y - half.y - 0.5).abs();
    println!("lift at 0.5 m/s: off its place by {:.3} mm (allowed 1 mm)", off * 1e3);
    assert!(off < 1e-3);
}

/// A body that starts deep in the ground is pushed out at a walking pace, not shot out.
#[test]
fn deep_start_is_not_shot_out() {
    let deep = 0.1;
    let model = skater();
    let mut skater = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let mut block = simulator(crate_box(DVec3::new(0.2, 0.05, 0.2)));
    for (sim, name) in [(&mut skater, "skater"), (&mut block, "box")] {
        let rest = sim.model().rest_root_height();
        place(sim, DVec3::Y * (rest - deep), DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO);
        let world = World::ground();
        let mass = sim.model().mass();
        let com0 = sim.center_of_mass().lane(0).y;
        let (mut fastest, mut highest) = (0.0_f64, 0.0_f64);
        for _ in 0..1200 {
            step(sim, &world);
            fastest = fastest.max(sim.total_momentum().linear.lane(0).y / mass);
            highest = highest.max(sim.center_of_mass().lane(0).y - com0 - deep);
        }
        let allowed = sim.settings().contact.correction_speed * 1.3;
        println!(
            "{name} 10 cm deep: comes out at {fastest:.3} m/s (allowed {allowed:.2}), flies {:.1} mm above its place (allowed 20 mm)",
            highest * 1e3
        );
        assert!(fastest < allowed && highest < 0.02);
    }
}
