//! Contract: a character's motion does not depend on its company. Lane k of a wide type has the bits of the scalar run,
//! whatever the other lanes touch; and a body that slides to rest on the ground does so at Coulomb's distance. Residuals are
//! printed beside what is allowed.

use crate::common::*;
use bevy_athlete::contact::{Geometry, HeightField, Solid, Surface, World};
use bevy_athlete::dynamics::GripAnchor;
use bevy_athlete::math::{F32x8, F64x4, RandomStream, Real, Vec3};
use bevy_athlete::model::*;
use bevy_athlete::sim::{ExternalForce, SimulationSettings, Simulator, step};
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;

/// A small walker: pelvis, trunk, one arm with a hinge and a hand that can hold on, and two legs whose feet have a toe
/// and a heel of their own; a blade under each foot.
pub fn walker() -> CharacterModel {
    let mut links: Vec<Link> = Vec::new();
    let mut points: Vec<ContactPoint> = Vec::new();
    let mut blades = Vec::new();
    let mut add = |name: &str, parent: Option<usize>, joint: JointKind, offset: [f64; 3], mass: f64, com: [f64; 3]| {
        let size = 0.02 + 0.01 * mass;
        links.push(Link {
            name: name.into(),
            parent,
            joint,
            offset: offset.into(),
            mass,
            com: com.into(),
            inertia: DMat3::from_diagonal(DVec3::new(1.0, 0.8, 1.1) * mass * size * size),
            gains: Gains { kp: 300.0, kd: 20.0 },
            max_torque: 60.0,
            limits: Some(JointLimits { low: DVec3::splat(-0.9), high: DVec3::splat(0.9) }),
            armature: 0.0,
            spring: None,
            shapes: Vec::new(),
        });
        links.len() - 1
    };
    let pelvis = add("pelvis", None, JointKind::Free, [0.0; 3], 9.0, [0.0, 0.02, 0.0]);
    let mut feet = Vec::new();
    for side in [-1.0, 1.0] {
        let ball = JointKind::Ball;
        let thigh = add("thigh", Some(pelvis), ball, [side * 0.1, 0.0, 0.0], 5.0, [0.0, -0.15, 0.0]);
        let foot = add("foot", Some(thigh), ball, [0.0, -0.35, 0.0], 1.5, [0.0, -0.03, -0.02]);
        let toe = add("toe", Some(foot), ball, [0.0, -0.05, -0.12], 0.3, [0.0, 0.0, -0.03]);
        let tip =
            add("toe tip", Some(toe), JointKind::Hinge { axis: DVec3::X }, [0.0, 0.0, -0.04], 0.1, [0.0, 0.0, -0.02]);
        let heel = add("heel", Some(foot), ball, [0.0, -0.05, 0.05], 0.3, [0.0, 0.0, 0.02]);
        feet.push([foot, toe, tip, heel]);
    }
    let trunk = add("trunk", Some(pelvis), JointKind::Ball, [0.0, 0.1, 0.0], 12.0, [0.0, 0.2, 0.0]);
    let arm = add("arm", Some(trunk), JointKind::Ball, [0.2, 0.3, 0.0], 2.0, [0.0, -0.12, 0.0]);
    let axis = JointKind::Hinge { axis: DVec3::new(0.6, 0.0, 0.8) };
    let hand = add("hand", Some(arm), axis, [0.0, -0.3, 0.0], 1.0, [0.0, -0.1, 0.0]);
    let mut point = |link: usize, position: [f64; 3], radius: f64, kind: ContactKind| {
        points.push(ContactPoint {
            name: format!("p{}", points.len()),
            link,
            position: position.into(),
            radius,
            friction: 1.0,
            kind,
            role: bevy_athlete::model::PointRole::Body,
        });
        points.len() - 1
    };
    for (b, [foot, toe, tip, heel]) in feet.into_iter().enumerate() {
        let ends = [
            point(foot, [0.0, -0.08, -0.1], 0.0, ContactKind::BladeToe(b)),
            point(foot, [0.0, -0.08, 0.1], 0.0, ContactKind::BladeHeel(b)),
        ];
        for x in [-0.03, 0.03] {
            point(toe, [x, -0.01, -0.02], 0.02, ContactKind::Point);
            point(tip, [x, -0.01, -0.03], 0.02, ContactKind::Point);
            point(heel, [x, -0.01, 0.02], 0.02, ContactKind::Point);
        }
        blades.push(Blade {
            name: format!("blade{b}"),
            link: foot,
            toe: ends[0],
            heel: ends[1],
            inside: if b == 0 { DVec3::X } else { -DVec3::X },
            lean_law: LeanLaw::DeadZone { dead_zone: 0.1, gain: 6.0 },
            bite: Some(4.0),
        });
    }
    point(trunk, [0.0, 0.4, 0.0], 0.12, ContactKind::Point);
    point(pelvis, [0.0, 0.0, 0.0], 0.1, ContactKind::Point);
    point(hand, [0.0, -0.2, 0.0], 0.04, ContactKind::Point);
    CharacterModel {
        name: "walker".into(),
        step_rate: 600.0,
        links,
        contact_points: points,
        blades,
        grips: vec![Grip { name: "hand".into(), link: hand, position: DVec3::new(0.0, -0.2, 0.0), max_force: 450.0 }],
        collision_pairs: Vec::new(),
        feet: Vec::new(),
        trunk: 0,
    }
}

/// Sets up character number `index` in lane `lane`.
pub fn place<R: Real>(sim: &mut Simulator<R>, lane: usize, index: u64) {
    let mut random = RandomStream::new(3, index);
    let model = sim.model().clone();
    let joints: Vec<DQuat> = model
        .links
        .iter()
        .map(|l| match l.joint {
            JointKind::Hinge { axis } => DQuat::from_axis_angle(axis, random.range(-0.3, 0.3)),
            _ => random_rotation(&mut random, 0.2),
        })
        .collect();
    let at_rest = vec![DVec3::ZERO; joints.len()];
    let height = model.rest_root_height() + 0.1 * index as f64 * random.uniform();
    let position = DVec3::new(random.range(-0.5, 0.5), height, random.range(-0.5, 0.5));
    sim.state.set_pose(lane, position, random_rotation(&mut random, 0.1 + 0.2 * index as f64), &joints);
    sim.state.set_velocity(lane, random_vector(&mut random, 1.0), random_vector(&mut random, 1.0), &at_rest);
    sim.state_changed();
}

/// New targets for lane `lane`, which holds character `index`.
fn command<R: Real>(sim: &mut Simulator<R>, lane: usize, index: u64, k: usize) {
    let mut random = RandomStream::new(4 + k as u64, index);
    let model = sim.model().clone();
    for (command, link) in sim.commands.iter_mut().zip(&model.links).skip(1) {
        let target = match link.joint {
            JointKind::Hinge { axis } => DQuat::from_axis_angle(axis, random.range(-1.0, 1.0)),
            _ => random_rotation(&mut random, 0.5),
        };
        command.rotation.set_lane(lane, target);
    }
    sim.external[0].force.set_lane(lane, random_vector(&mut random, 30.0));
}

/// A body in a world, and whether it holds on to something for the first half of the time.
struct Scene {
    name: String,
    model: SharedModel,
    world: World,
    holds_on: bool,
    steps: usize,
}

/// Fingerprints of the characters `first..first + LANES` after every 50 steps, and how often each had contact.
fn fingerprints<R: Real>(scene: &Scene, first: u64) -> (Vec<Vec<u64>>, Vec<usize>) {
    let Scene { model, world, holds_on, steps, .. } = scene;
    let mut sim = Simulator::<R>::new(model.clone(), SimulationSettings::of(model));
    sim.external.push(ExternalForce { link: 7, position: Vec3::splat(DVec3::Y * 0.1), force: Vec3::zero() });
    (0..R::LANES).for_each(|lane| place(&mut sim, lane, first + lane as u64));
    if *holds_on {
        // Every lane its own place, one none, one on a solid.
        for lane in (0..R::LANES).filter(|lane| (first + *lane as u64) % 4 != 1) {
            let index = first + lane as u64;
            let place = DVec3::new(0.2 + 0.03 * index as f64, 1.0, 0.0);
            let anchor = if index % 4 == 2 { GripAnchor::Solid { solid: 0, place } } else { GripAnchor::Fixed(place) };
            sim.hold(0, lane, anchor);
        }
    }
    let (mut prints, mut touching) = (vec![Vec::new(); R::LANES], vec![0; R::LANES]);
    for k in 0..*steps {
        if k % 50 == 0 {
            for (lane, prints) in prints.iter_mut().enumerate() {
                command(&mut sim, lane, first + lane as u64, k);
                prints.push(sim.state.fingerprint(lane));
            }
        }
        if *holds_on && k == steps / 2 {
            (0..R::LANES).for_each(|lane| sim.release(0, lane));
        }
        step(&mut sim, world);
        for (lane, touching) in touching.iter_mut().enumerate() {
            *touching += usize::from(sim.loaded_points(lane) > 0);
            assert!(sim.is_sane(lane), "lane {lane} went bad in step {k}");
        }
    }
    (0..R::LANES).for_each(|lane| prints[lane].push(sim.state.fingerprint(lane)));
    (prints, touching)
}

/// The walker in every kind of world, with and without something to hold on to; the characters of the crate where they live.
fn scenes() -> Vec<Scene> {
    let mut random = RandomStream::new(11, 0);
    let heights = (0..40 * 40).map(|_| random.range(0.0, 0.15)).collect();
    let field = HeightField::new(DVec3::new(-4.0, -0.1, -4.0), 0.2, 40, 40, heights).unwrap();
    let mut rough = World::ice();
    rough.solids.push(Solid::fixed(Geometry::HeightField(Arc::new(field)), Surface::GROUND));
    let stairs = World::stairs(-0.2, 4, 0.3, 0.1, 3.0, Surface::GROUND);
    let model = Arc::new(walker());
    let mut scenes = Vec::new();
    for (name, world) in [("ice", World::ice()), ("ground", World::ground()), ("stairs", stairs), ("rough", rough)] {
        for holds_on in [false, true] {
            let name = format!("walker, {name}, grip {holds_on}");
            scenes.push(Scene { name, model: model.clone(), world: world.clone(), holds_on, steps: 1000 });
        }
    }
    for name in PRESET_NAMES {
        let world = if name == "skater" { World::ice() } else { World::ground() };
        let model = preset(name).unwrap();
        scenes.push(Scene { name: name.into(), model, world, holds_on: false, steps: 500 });
    }
    scenes
}

fn lanes_equal_scalars<W: Real, S: Real>() {
    for scene in scenes() {
        let (together, touching) = fingerprints::<W>(&scene, 0);
        for lane in 0..W::LANES {
            let (alone, _) = fingerprints::<S>(&scene, lane as u64);
            let differing = together[lane].iter().zip(&alone[0]).filter(|(a, b)| a != b).count();
            println!(
                "{}, {} lane {lane}: in contact for {} of {} steps, {differing} of {} fingerprints differ from {}",
                scene.name,
                W::NAME,
                touching[lane],
                scene.steps,
                alone[0].len(),
                S::NAME
            );
            assert_eq!(differing, 0);
        }
        assert!(touching.iter().any(|steps| *steps > scene.steps / 4), "{}: hardly any contact", scene.name);
    }
}

#[test]
fn four_lanes_have_the_bits_of_four_scalar_runs() {
    lanes_equal_scalars::<F64x4, f64>();
}

#[test]
fn eight_lanes_have_the_bits_of_eight_scalar_runs() {
    lanes_equal_scalars::<F32x8, f32>();
}

#[test]
fn characters_go_into_lanes_and_come_out_again_with_the_bits_of_scalar_runs() {
    let model = preset("skater").unwrap();
    let new = |k: u64| {
        let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
        place(&mut sim, 0, k);
        sim.friction_scale = 0.5 + 0.5 * k as f64;
        sim
    };
    let target = |sim: &mut Simulator<f64>, k: u64, at: usize| {
        let mut random = RandomStream::new(20 + k, at as u64);
        sim.commands.iter_mut().skip(1).for_each(|c| {
            c.rotation = bevy_athlete::math::Quat::splat(random_rotation(&mut random, 0.3));
        });
    };
    let world = World::ice();
    let mut alone: Vec<Simulator<f64>> = (0..4).map(new).collect();
    let mut guests: Vec<Simulator<f64>> = (0..4).map(new).collect();
    // Used before for something else: nothing of it may show.
    let mut lanes = Simulator::<F64x4>::new(model.clone(), SimulationSettings::of(&model));
    (0..40).for_each(|_| step(&mut lanes, &world));
    for visit in 0..20 {
        for (lane, guest) in guests.iter().enumerate() {
            lanes.put_lane(lane, guest, 0);
        }
        for at in 0..19 {
            for k in 0..4 {
                if (at + k) % 7 == 0 {
                    target(&mut alone[k], k as u64, 100 * visit + at);
                    target(&mut guests[k], k as u64, 100 * visit + at);
                    lanes.put_commands(k, &guests[k], 0);
                }
                step(&mut alone[k], &world);
            }
            step(&mut lanes, &world);
        }
        for (k, guest) in guests.iter_mut().enumerate() {
            guest.take_lane(&lanes, k);
            assert_eq!(guest.state.fingerprint(0), alone[k].state.fingerprint(0), "guest {k}, visit {visit}");
            for link in 1..model.links.len() {
                assert_eq!(guest.joint_torque(link).lane(0), alone[k].joint_torque(link).lane(0));
            }
            for blade in 0..model.blades.len() {
                assert_eq!(guest.blade_lean(blade, 0), alone[k].blade_lean(blade, 0));
                assert_eq!(guest.blade_edge(blade, 0), alone[k].blade_edge(blade, 0));
            }
            assert!(!guest.terrain_failed(0));
        }
    }
}

#[test]
fn a_change_of_rate_keeps_the_forces() {
    let model = preset("skater").unwrap();
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let world = World::ice();
    (0..600).for_each(|_| step(&mut sim, &world));
    let weight = model.mass() * 9.81;
    let force =
        |sim: &Simulator<f64>| (0..model.contact_points.len()).map(|p| sim.contact_force(p, 0).y).sum::<f64>() / weight;
    let before = force(&sim);
    for rate in [600.0, 1200.0] {
        sim.change_rate(rate);
        let warm = force(&sim);
        step(&mut sim, &world);
        println!(
            "{rate} Hz: {before:.4} of the weight before, {warm:.4} as warm start, {:.4} after a step",
            force(&sim)
        );
        assert!((warm - before).abs() < 0.01 && (force(&sim) - before).abs() < 0.05);
        assert!((sim.step_seconds() * rate - 1.0).abs() < 1e-12);
    }
}

#[test]
fn an_answer_that_is_no_number_is_noticed_in_its_lane_alone() {
    let model = preset("skater").unwrap();
    let mut sim = Simulator::<F64x4>::new(model.clone(), SimulationSettings::of(&model));
    for lane in 0..4 {
        let place = sim.state.root_position.lane(lane) + DVec3::X * 10.0 * lane as f64;
        sim.state.root_position.set_lane(lane, place);
    }
    sim.state_changed();
    // A slab under lane 2 whose velocity is no number.
    let center = DVec3::new(20.0, -0.049, 0.0);
    let half_extents = DVec3::new(2.0, 0.05, 2.0);
    let slab = Geometry::Box { center, half_extents, rotation: DQuat::IDENTITY };
    let mut world = World::ice();
    world.solids.push(Solid { linear_velocity: DVec3::splat(f64::NAN), ..Solid::fixed(slab, Surface::ICE) });
    step(&mut sim, &world);
    let failed: Vec<bool> = (0..4).map(|lane| sim.terrain_failed(lane)).collect();
    assert_eq!(failed, [false, false, true, false]);
    // The solver's limits may swallow it, so the state need not show it; nor do the neighbours.
    assert!([0, 1, 3].iter().all(|lane| sim.is_sane(*lane)));
    // A bad body in a sound world is not the terrain's fault.
    sim.state.root_position.set_lane(1, DVec3::NAN);
    sim.state_changed();
    sim.forget_terrain_failures();
    step(&mut sim, &World::ice());
    assert!(!sim.is_sane(1) && (0..4).all(|lane| !sim.terrain_failed(lane)));
    // An empty world answers, too.
    step(&mut sim, &World::empty());
    assert!((0..4).all(|lane| !sim.terrain_failed(lane)));
}

#[test]
fn a_falling_ball_slides_to_rest_at_coulombs_distance() {
    let (radius, speed, drop, rate) = (0.1, 3.0, 0.2, 1000.0);
    let ball = CharacterModel {
        name: "ball".into(),
        step_rate: rate,
        links: vec![Link {
            name: "ball".into(),
            parent: None,
            joint: JointKind::Free,
            offset: DVec3::ZERO,
            mass: 2.0,
            com: DVec3::ZERO,
            // So hard to turn that it slides without rolling.
            inertia: DMat3::from_diagonal(DVec3::splat(1e9)),
            gains: Gains { kp: 0.0, kd: 0.0 },
            max_torque: f64::INFINITY,
            limits: None,
            armature: 0.0,
            spring: None,
            shapes: Vec::new(),
        }],
        contact_points: vec![ContactPoint {
            name: "skin".into(),
            link: 0,
            position: DVec3::ZERO,
            radius,
            friction: 0.5,
            kind: ContactKind::Point,
            role: bevy_athlete::model::PointRole::Body,
        }],
        blades: Vec::new(),
        grips: Vec::new(),
        collision_pairs: Vec::new(),
        feet: Vec::new(),
        trunk: 0,
    };
    let model = Arc::new(ball);
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    sim.state.root_position = Vec3::new(0.0, radius + drop, 0.0);
    sim.state.root_velocity.linear = Vec3::new(speed * 0.6, 0.0, -speed * 0.8);
    sim.state_changed();
    let world = World::ground();
    for _ in 0..(4.0 * rate) as usize {
        step(&mut sim, &world);
    }
    // In the air at full speed, a landing that takes mu times the speed of impact, then an even deceleration.
    let (mu, g) = (0.5 * Surface::GROUND.friction, 9.81);
    let fall_time = (2.0_f64 * drop / g).sqrt();
    let landed = speed - mu * g * fall_time;
    let expected = speed * fall_time + landed * landed / (2.0 * mu * g);
    let place = sim.state.root_position.lane(0);
    let found = place.x.hypot(place.z);
    let sideways = (place.x * 0.8 + place.z * 0.6).abs();
    let left = sim.state.root_velocity.linear.lane(0).length();
    println!(
        "slid {found:.4} m, expected {expected:.4} (allowed 1 %); off the line {sideways:.1e} m; speed left {left:.1e} m/s"
    );
    assert!((found - expected).abs() < 0.01 * expected && sideways < 1e-9 && left < 1e-9);
}
