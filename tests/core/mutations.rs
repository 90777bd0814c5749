//! Contract: whatever comes in, nothing panics, and a lane that goes bad stays alone.
//!
//! More than 10,000 mutated inputs: controls, characters, motions, clips, joint maps, key poses and
//! joint positions as text, and commands
//! as numbers (NaN, infinities, huge, tiny, in targets, gains, torques, pushes, friction, states) to a running batch. What
//! is accepted is used: models are built and stepped, clips sampled, controls played, motions imported by mutated maps.
//! The other lanes of a batch must keep the bits they have without the bad one, at every step.
//!
//! Has caught: a control whose tick rate is far above its rate, or whose length is an hour at 20 kHz, asking for more
//! memory than there is.

use crate::common::*;
use crate::motion_support::{TINY, TINY_MAP, mutate, tiny_model, wild_clip};
use bevy_athlete::asset::Character;
use bevy_athlete::asset::bvh::Bvh;
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::asset::joint_map::JointMap;
use bevy_athlete::asset::joint_positions::{JointPositions, PositionOptions};
use bevy_athlete::asset::landmark_layout::LandmarkLayout;
use bevy_athlete::contact::{Geometry, HeightField, Solid, Surface, World};
use bevy_athlete::control::{ControlError, ControlPlayer, ReconstructedControl};
use bevy_athlete::dynamics::{GripAnchor, State};
use bevy_athlete::math::{F64x4, RandomStream, Real, Vec3};
use bevy_athlete::model::{
    BodyLandmarks, CharacterModel, KeyPoses, PRESET_NAMES, PositionImportOptions, SharedModel, import_bvh,
    import_positions, preset, preset_source, skater,
};
use bevy_athlete::sim::{ExternalForce, SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// A valid control of the skater as text.
fn control_text() -> String {
    let model = skater();
    let mut random = RandomStream::new(5, 5);
    let mut clip = wild_clip(&mut random, 3);
    clip.poses.iter_mut().for_each(|p| p.joints.truncate(4));
    clip.joints.truncate(4);
    let control = ReconstructedControl {
        version: 1,
        character: "skater".into(),
        world: "ice".into(),
        rate: 1200.0,
        tick_rate: 100.0,
        ticks_per_window: 5,
        seconds: 0.066,
        gains: Some((600.0, 49.0)),
        clip,
        offsets: vec![vec![DVec3::new(0.01, 0.0, -0.02); model.links.len()]; 2],
    };
    let path = std::env::temp_dir().join(format!("athlete-mutations-{}.control.ron", std::process::id()));
    control.save(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    text
}

#[test]
fn controls() {
    let text = control_text();
    let model = skater();
    let mut random = RandomStream::new(20_190_101, 1);
    let (mut accepted, mut played) = (0, 0);
    for _ in 0..3000 {
        let Ok(control) = ReconstructedControl::from_ron(&mutate(&text, &mut random), "mutated.ron") else { continue };
        accepted += 1;
        let Ok(mut player) = ControlPlayer::new(&control, &model) else { continue };
        played += 1;
        let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
        player.restart(&mut sim);
        for _ in 0..15 {
            player.drive(&mut sim);
            step(&mut sim, &World::ice());
        }
    }
    println!("controls: of 3000 mutations {accepted} accepted, {played} fit the skater and were played");
    assert!(played > 100, "mutations that are always refused test only the first check");

    // Numbers that would ask for the world's memory are refused by name.
    let refused = |field: &str, edit: &dyn Fn(&mut ReconstructedControl)| {
        let mut control = ReconstructedControl::from_ron(&text, "fine.ron").unwrap();
        edit(&mut control);
        match ControlPlayer::new(&control, &model) {
            Err(ControlError::Value { field: found, .. }) => assert_eq!(found, field),
            other => panic!("{field}: {:?}", other.map(|_| ())),
        }
    };
    refused("tick_rate", &|c| c.tick_rate = 1e15);
    refused("tick_rate", &|c| c.tick_rate = f64::NAN);
    refused("seconds", &|c| (c.rate, c.tick_rate, c.seconds) = (20_000.0, 20_000.0, 3600.0));
    refused("seconds", &|c| c.seconds = f64::INFINITY);
    refused("ticks_per_window", &|c| c.ticks_per_window = 0);
    refused("gains", &|c| c.gains = Some((f64::NAN, 1.0)));
    refused("offsets", &|c| c.offsets[0][1].x = f64::NAN);
}

#[test]
fn characters() {
    let mut random = RandomStream::new(20_190_102, 1);
    let (mut accepted, count) = (0, 1500);
    for k in 0..count {
        let (file, text) = preset_source(PRESET_NAMES[k % PRESET_NAMES.len()]).unwrap();
        let Ok(character) = Character::parse(file, mutate(text, &mut random).as_bytes()) else { continue };
        let Ok(model) = CharacterModel::build(&character) else { continue };
        accepted += 1;
        let settings = SimulationSettings::of(&model);
        let mut sim = Simulator::<f64>::new(Arc::new(model), settings);
        for _ in 0..3 {
            step(&mut sim, &World::ice());
        }
    }
    println!("characters: of {count} mutations {accepted} built and stepped");
    assert!(accepted > 100);
}

#[test]
fn motions_and_clips() {
    let model = tiny_model();
    let map = JointMap::from_ron(TINY_MAP).unwrap();
    let clip = import_bvh(&Bvh::parse(TINY).unwrap(), &map, &model).unwrap().to_ron().unwrap();
    let mut random = RandomStream::new(20_190_103, 1);
    let (mut accepted, count) = ([0, 0], 750);
    for _ in 0..count {
        let bvh = Bvh::parse(&mutate(TINY, &mut random)).ok().and_then(|b| import_bvh(&b, &map, &model).ok());
        let clip = MotionClip::from_ron(&mutate(&clip, &mut random)).ok();
        for (n, clip) in [bvh, clip].into_iter().enumerate() {
            accepted[n] += usize::from(clip.is_some_and(|clip| sampled(&clip, &model)));
        }
    }
    println!("motions and clips: of {count} mutations each {accepted:?} accepted and sampled");
    assert!(accepted.iter().all(|n| *n > 20));
}

/// Whether a clip fits the model; if so it is sampled at times good and bad.
fn sampled(clip: &MotionClip, model: &CharacterModel) -> bool {
    let Ok(fitted) = clip.to_model(model) else { return false };
    for t in [-1.0, 0.0, 0.03, 1e300, f64::NAN] {
        fitted.sample(t);
        fitted.sample_velocity(t);
    }
    true
}

#[test]
fn joint_maps() {
    let (tiny, bvh) = (tiny_model(), Bvh::parse(TINY).unwrap());
    let mut random = RandomStream::new(20_190_106, 1);
    let (mut accepted, mut imported, count) = (0, 0, 1500);
    for _ in 0..count {
        let Ok(map) = JointMap::from_ron(&mutate(TINY_MAP, &mut random)) else { continue };
        accepted += 1;
        imported += usize::from(import_bvh(&bvh, &map, &tiny).is_ok_and(|clip| sampled(&clip, &tiny)));
    }
    println!("joint maps: of {count} mutations {accepted} accepted, {imported} imported a motion that was sampled");
    assert!(imported > 50 && accepted > imported);
}

#[test]
fn key_poses() {
    let model = skater();
    let text = include_str!("../../assets/skills/skating/stroking/stroking.keyposes.ron");
    let mut random = RandomStream::new(20_190_107, 1);
    let (mut accepted, mut fitted, count) = (0, 0, 1500);
    for _ in 0..count {
        let Ok(keys) = KeyPoses::from_ron(&mutate(text, &mut random), "mutated.keyposes.ron") else { continue };
        accepted += 1;
        fitted += usize::from(keys.to_clip(&model).is_ok_and(|clip| sampled(&clip, &model)));
    }
    println!("key poses: of {count} mutations {accepted} accepted, {fitted} became a clip that was sampled");
    assert!(fitted > 100 && accepted > fitted);
}

/// Positions of a few frames as an estimator writes them, and landmark layouts.
#[test]
fn joint_positions() {
    let model = skater();
    let layout = LandmarkLayout::built_in("smpl24").unwrap();
    let body = BodyLandmarks::new(&layout, &model).unwrap();
    let rest = model.rest_positions();
    let joints: Vec<String> = body
        .points
        .iter()
        .map(|p| {
            let p = layout.axes.from_ours(p.map_or(DVec3::ZERO, |p| rest[p.link] + p.position));
            format!("[{:.3}, {:.3}, {:.3}, 0.9]", p.x, p.y, p.z)
        })
        .collect();
    let frame = joints.join(", ");
    let text = format!(
        "{{\"layout\": \"smpl24\", \"axes\": \"y_up\", \"fps\": 30, \"frames\": [[{frame}], {{\"time\": 0.1, \"joints\": [{frame}]}}]}}"
    );
    let mut random = RandomStream::new(20_190_108, 1);
    let (mut accepted, mut imported, count) = (0, 0, 1500);
    for _ in 0..count {
        let mutated = mutate(&text, &mut random);
        let Ok(positions) = JointPositions::from_json(&mutated, &PositionOptions::default()) else { continue };
        accepted += 1;
        // Inverse kinematics of each takes its time.
        if accepted % 10 == 0
            && let Ok(poses) = import_positions(&model, &positions, &PositionImportOptions::default())
        {
            assert!(sampled(&poses.key_poses.to_clip(&model).unwrap(), &model));
            imported += 1;
        }
    }
    println!("joint positions: of {count} mutations {accepted} accepted; of each tenth {imported} became key poses");
    assert!(accepted > 100 && imported > 10);

    let text = include_str!("../../assets/landmarks/smpl24.landmarks.ron");
    let mut fitted = 0;
    for _ in 0..count {
        let Ok(layout) = LandmarkLayout::from_ron(&mutate(text, &mut random)) else { continue };
        fitted += usize::from(BodyLandmarks::new(&layout, &model).is_ok());
    }
    println!("landmark layouts: of {count} mutations {fitted} fit the skater");
    assert!(fitted > 50);
}

/// Numbers that nobody should send.
fn wild(random: &mut RandomStream) -> f64 {
    const ODD: [f64; 16] = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN,
        f64::MIN_POSITIVE,
        1e-320,
        1e300,
        -1e300,
        1e150,
        1e20,
        -1e12,
        1e6,
        -0.0,
        0.0,
        1e-200,
    ];
    if random.uniform() < 0.7 { ODD[random.below(16)] } else { random.normal() * 10f64.powf(random.range(-3.0, 12.0)) }
}

fn wild_vector(random: &mut RandomStream, mild: DVec3) -> DVec3 {
    let mut v = mild.to_array();
    let from = random.below(3);
    for x in &mut v[from..] {
        *x = wild(random);
    }
    DVec3::from_array(v)
}

const STEPS: usize = 50;

struct Scene {
    model: SharedModel,
    world: World,
    /// Start of all lanes, and what every lane looks like after each step when nothing wild comes in.
    start: State<F64x4>,
    prints: Vec<[u64; 4]>,
}

fn push() -> ExternalForce<F64x4> {
    ExternalForce { link: 1, position: Vec3::splat(DVec3::ZERO), force: Vec3::splat(DVec3::new(5.0, -3.0, 2.0)) }
}

fn scene(name: &str, world: World, seed: u64) -> Scene {
    let model = preset(name).unwrap();
    let mut sim = Simulator::<F64x4>::new(model.clone(), SimulationSettings::of(&model));
    let mut random = RandomStream::new(seed, 9);
    for lane in 0..4 {
        let joints: Vec<DQuat> = model.links.iter().map(|_| random_rotation(&mut random, 0.3)).collect();
        let velocities: Vec<DVec3> = model.links.iter().map(|_| random_vector(&mut random, 1.0)).collect();
        let height = model.rest_root_height() + random.range(-0.03, 0.01);
        // One lane lies down, so that other points touch.
        let (height, turn) = if lane == 3 { (0.12, DQuat::from_rotation_x(1.4)) } else { (height, DQuat::IDENTITY) };
        sim.state.set_pose(lane, DVec3::Y * height, turn, &joints);
        sim.state.set_velocity(lane, random_vector(&mut random, 1.0), random_vector(&mut random, 1.0), &velocities);
    }
    sim.state_changed();
    sim.external.push(push());
    let start = sim.state.clone();
    let prints = (0..STEPS)
        .map(|_| {
            step(&mut sim, &world);
            std::array::from_fn(|lane| sim.state.fingerprint(lane))
        })
        .collect();
    assert!((0..4).all(|lane| sim.is_sane(lane)));
    Scene { model, world, start, prints }
}

#[test]
fn commands() {
    let heights = (0..100).map(|k| 0.02 * f64::from(k * 37 % 10)).collect();
    let field = HeightField::new(DVec3::new(-2.0, -0.15, -2.0), 0.4, 10, 10, heights).unwrap();
    let rough = World { solids: vec![Solid::fixed(Geometry::HeightField(Arc::new(field)), Surface::GROUND)] };
    let scenes = [
        scene("skater", World::ice(), 1),
        scene("runner", World::stairs(-0.05, 3, 0.3, 0.1, 2.0, Surface::GROUND), 2),
        scene("foot_human", World::ground(), 3),
        scene("two_segment_human", rough, 4),
    ];
    let mut random = RandomStream::new(20_190_104, 1);
    let count = 4000;
    let (mut bad, mut checks, mut steps) = (0, 0_u64, 0_u64);
    let mut sims: Vec<Simulator<F64x4>> =
        scenes.iter().map(|s| Simulator::new(s.model.clone(), SimulationSettings::of(&s.model))).collect();
    let fresh: Vec<_> = sims.iter().map(|s| s.commands.clone()).collect();
    for k in 0..count {
        let (scene, sim) = (&scenes[k % 4], &mut sims[k % 4]);
        sim.state.clone_from(&scene.start);
        sim.commands.clone_from(&fresh[k % 4]);
        sim.external.clear();
        sim.external.push(push());
        sim.friction_scale = F64x4::one();
        let lane = random.below(4);
        for _ in 0..1 + random.below(3) {
            let link = random.below(scene.model.links.len());
            let c = &mut sim.commands[link];
            match random.below(12) {
                0 => c.kp.set_lane(lane, wild(&mut random)),
                1 => c.kd.set_lane(lane, wild(&mut random)),
                2 => c.torque.set_lane(lane, wild_vector(&mut random, DVec3::ZERO)),
                3 => c.velocity.set_lane(lane, wild_vector(&mut random, DVec3::ZERO)),
                4 => {
                    let v = wild_vector(&mut random, DVec3::ZERO);
                    c.rotation.set_lane(lane, DQuat::from_xyzw(v.x, v.y, v.z, wild(&mut random)));
                }
                5 => sim.external[0].force.set_lane(lane, wild_vector(&mut random, DVec3::ZERO)),
                6 => sim.external[0].position.set_lane(lane, wild_vector(&mut random, DVec3::ZERO)),
                7 => sim.friction_scale.set_lane(lane, wild(&mut random)),
                8 => sim.state.root_position.set_lane(lane, wild_vector(&mut random, DVec3::Y)),
                9 => sim.state.root_velocity.linear.set_lane(lane, wild_vector(&mut random, DVec3::ZERO)),
                10 => sim.state.joints[link].velocity.set_lane(lane, wild_vector(&mut random, DVec3::ZERO)),
                _ => {
                    let v = wild_vector(&mut random, DVec3::ZERO);
                    sim.state.joints[link].rotation.set_lane(lane, DQuat::from_xyzw(v.x, v.y, v.z, 1.0));
                }
            }
        }
        sim.state_changed();
        // Most runs are short; every tenth goes all the way.
        let length = if k % 10 == 0 { STEPS } else { 1 + random.below(12) };
        for n in 0..length {
            step(sim, &scene.world);
            steps += 1;
            if n % 4 == 3 || n + 1 == length {
                for other in (0..4).filter(|l| *l != lane) {
                    checks += 1;
                    let (found, expected) = (sim.state.fingerprint(other), scene.prints[n][other]);
                    assert_eq!(found, expected, "case {k}, {}, bad lane {lane} changed lane {other}", scene.model.name);
                }
            }
        }
        bad += usize::from(!sim.is_sane(lane));
    }
    println!(
        "commands: {count} wild inputs, {steps} steps of 4 lanes; the lane went bad {bad} times, its neighbours kept their bits in {checks} comparisons"
    );
    assert!(bad > count / 4);
}

/// What all lanes share is no other lane's matter, but must not panic either: settings, anchors, worlds.
#[test]
fn shared_inputs() {
    let mut random = RandomStream::new(20_190_105, 1);
    let model = skater();
    let count = 1000;
    for _ in 0..count {
        let mut settings = SimulationSettings::of(&model);
        let mut world = World::ice();
        match random.below(8) {
            0 => settings.rate = wild(&mut random),
            1 => settings.gravity = wild_vector(&mut random, DVec3::ZERO),
            2 => settings.contact.margin = wild(&mut random),
            3 => settings.contact.correction_speed = wild(&mut random),
            4 => world.solids[0].linear_velocity = wild_vector(&mut random, DVec3::ZERO),
            5 => world.solids[0].surface.friction = wild(&mut random),
            6 => {
                world.solids[0].geometry =
                    Geometry::Sphere { center: wild_vector(&mut random, DVec3::ZERO), radius: wild(&mut random) }
            }
            _ => {
                world.solids[0].geometry = Geometry::Box {
                    center: wild_vector(&mut random, DVec3::ZERO),
                    half_extents: wild_vector(&mut random, DVec3::ONE),
                    rotation: DQuat::IDENTITY,
                }
            }
        }
        let mut sim = Simulator::<F64x4>::new(model.clone(), settings);
        for lane in 0..4 {
            let place = wild_vector(&mut random, DVec3::Y);
            let solid = GripAnchor::Solid { solid: lane, place };
            sim.hold(0, lane, if lane < 2 { GripAnchor::Fixed(place) } else { solid });
        }
        for _ in 0..4 {
            step(&mut sim, &world);
        }
        let _ = (sim.energy(), sim.center_of_mass(), sim.loaded_points(1), sim.external_points(0), sim.is_sane(2));
    }
    println!("shared inputs: {count} wild settings, worlds and anchors, no panic");
}
