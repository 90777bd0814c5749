//! Contract: many athletes in one app do not disturb each other.
//!
//! Of 64 skaters who perform a trained skill one is made bad in each of seven ways. It alone is stopped, with the reason,
//! and the other 63 have the bits of a run in which nothing was wrong: they share lanes, threads and a policy with the bad
//! one, so a NaN has ways to travel. Neither how bodies are grouped, nor lanes, nor the number of threads, nor how frames
//! are cut shows in any bit.

use crate::engine_support::*;
use bevy::diagnostic::DiagnosticsStore;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::asset::dense_layers::{Activation, DenseLayer, DenseLayers};
use bevy_athlete::contact::{Geometry, Solid, Surface};
use bevy_athlete::control::Policy;
use bevy_athlete::dynamics::GripAnchor;
use bevy_athlete::engine::*;
use bevy_athlete::math::Vec3 as CoreVec3;
use bevy_athlete::sim::ExternalForce;
use bevy_athlete::skill::TrainedSkill;
use bevy_athlete::train::policy_bytes;
use std::sync::Arc;
use std::time::Duration;

const CROWD: usize = 64;
/// The one that goes bad.
const BAD: usize = 21;

fn place(k: usize) -> Transform {
    let (row, column) = ((k / 8) as f32, (k % 8) as f32);
    Transform::from_xyz(column * 8.0, 0.0, row * 8.0).with_rotation(Quat::from_rotation_y(k as f32))
}

/// A policy file's worth of network whose outputs are no numbers wherever the body is upright: two infinite units,
/// subtracted. Its golden pair, of an observation of zeros, is sound.
fn bad_policy(good: &Policy) -> Policy {
    let mut contract = good.contract().clone();
    let (inputs, outputs) = (contract.observation_size(), contract.action_size());
    // Largest weights for the phase and the component of up along the body: their sum is beyond single precision.
    let mut weights = vec![0.0; 2 * inputs];
    for row in weights.chunks_exact_mut(inputs) {
        row[..10].fill(3e38);
        row[11] = 3e38;
    }
    let hidden = DenseLayer { weights, bias: vec![0.0; 2] };
    let last = DenseLayer { weights: [1.0, -1.0].repeat(outputs), bias: vec![0.0; outputs] };
    let layers =
        DenseLayers { sizes: vec![inputs, 2, outputs], activation: Activation::Relu, layers: vec![hidden, last] };
    contract.normaliser.mean.fill(0.0);
    contract.normaliser.scale.fill(1.0);
    contract.golden.observation.fill(0.0);
    contract.golden.action.fill(0.0);
    Policy::from_bytes(&policy_bytes(&layers, &contract).unwrap(), "bad.onnx").unwrap()
}

/// The ways in which one athlete is made bad.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    Position,
    Velocity,
    Target,
    Policy,
    Terrain,
    Transform,
    Force,
}

/// What was told of athletes that were stopped.
#[derive(Resource, Default)]
struct Stopped(Vec<(Entity, QuarantineReason)>);

/// Runs the crowd, making one bad after 20 ticks; fingerprints of all after 40, who was stopped and why, and the app.
fn run_crowd(skill: &SkillAsset, fault: Fault) -> (Vec<u64>, Vec<(Entity, QuarantineReason)>, App, Vec<Entity>) {
    let mut app = app();
    app.init_resource::<Stopped>();
    app.add_observer(|event: On<AthleteQuarantined>, mut stopped: ResMut<Stopped>| {
        stopped.0.push((event.entity, event.reason));
    });
    // A platform under the bad one, a millimetre above the ice.
    let center = place(BAD).translation.as_dvec3() + DVec3::Y * -0.049;
    let half_extents = DVec3::new(3.0, 0.05, 3.0);
    let slab = Geometry::Box { center, half_extents, rotation: bevy::math::DQuat::IDENTITY };
    app.world_mut().resource_mut::<AthleteWorld>().solids.push(Solid::fixed(slab, Surface::ICE));
    let (file, handle) = (skater_file(&mut app), add(&mut app, skill.clone()));
    let crowd: Vec<Entity> = (0..CROWD)
        .map(|k| {
            let controller = AthleteController::skill(handle.clone());
            let input = AthleteInput { turn: 0.01 * k as f32, ..default() };
            app.world_mut().spawn((Athlete(file.clone()), place(k), controller, input)).id()
        })
        .collect();
    if fault == Fault::Policy {
        let model = bevy_athlete::model::skater();
        let good = skill.bind(&model).unwrap();
        let policy = bad_policy(&good.policy);
        let mut bad = TrainedSkill::clone(&good);
        bad.policy = policy;
        let handle = add(&mut app, SkillAsset::made_for(&model, Arc::new(bad)));
        app.world_mut().entity_mut(crowd[BAD]).insert(AthleteController::skill(handle));
    }
    run_ticks(&mut app, 20);
    let bad = crowd[BAD];
    let nan = CoreVec3::splat(DVec3::new(1.0, f64::NAN, 0.0));
    match fault {
        Fault::None | Fault::Policy => {}
        Fault::Position => body_mut(&mut app, bad).simulator_mut().state.root_position = nan,
        Fault::Velocity => body_mut(&mut app, bad).simulator_mut().state.joints[5].velocity = nan,
        Fault::Target => body_mut(&mut app, bad).simulator_mut().commands[7].velocity = nan,
        Fault::Terrain => {
            app.world_mut().resource_mut::<AthleteWorld>().solids[1].linear_velocity = DVec3::new(f64::NAN, 0.0, 0.0);
        }
        Fault::Transform => app.world_mut().get_mut::<Transform>(bad).unwrap().translation.x = f32::NAN,
        Fault::Force => {
            let force = CoreVec3::splat(DVec3::new(0.0, f64::INFINITY, 0.0));
            let push = ExternalForce { link: 3, position: CoreVec3::zero(), force };
            body_mut(&mut app, bad).simulator_mut().external.push(push);
        }
    }
    body_mut(&mut app, bad).simulator_mut().state_changed();
    run_ticks(&mut app, 20);
    let prints = crowd.iter().map(|e| body(&app, *e).simulator().state.fingerprint(0)).collect();
    let stopped = std::mem::take(&mut app.world_mut().resource_mut::<Stopped>().0);
    (prints, stopped, app, crowd)
}

#[test]
fn of_64_only_the_one_that_goes_bad_is_stopped() {
    let skill = shipped_skill("stroking");
    let (reference, stopped, ..) = run_crowd(&skill, Fault::None);
    assert!(stopped.is_empty(), "{stopped:?}");
    for (fault, reason) in [
        (Fault::Position, QuarantineReason::Position),
        (Fault::Velocity, QuarantineReason::Velocity),
        (Fault::Target, QuarantineReason::Target),
        (Fault::Policy, QuarantineReason::Policy),
        (Fault::Terrain, QuarantineReason::Terrain),
        (Fault::Transform, QuarantineReason::Transform),
        (Fault::Force, QuarantineReason::Force),
    ] {
        let (prints, stopped, mut app, crowd) = run_crowd(&skill, fault);
        let differing: Vec<usize> = (0..CROWD).filter(|k| prints[*k] != reference[*k]).collect();
        println!("{fault:?}: stopped {stopped:?}; other bits than without it: {differing:?}");
        assert_eq!(stopped, [(crowd[BAD], reason)], "{fault:?}");
        assert!(differing.iter().all(|k| *k == BAD), "{fault:?} reached {differing:?}");
        assert_eq!(body(&app, crowd[BAD]).quarantine_reason(), Some(reason));
        let shown = app.world().get::<Transform>(crowd[BAD]).unwrap();
        assert!(shown.is_finite(), "{fault:?}: {shown:?} is drawn");
        let quarantined = figure(&app, &AthleteDiagnosticsPlugin::QUARANTINED);
        assert_eq!(quarantined, 1.0);

        // What made it bad being gone, a reset gives it a new life.
        if fault == Fault::Terrain {
            app.world_mut().resource_mut::<AthleteWorld>().solids[1].linear_velocity = DVec3::ZERO;
        }
        if fault != Fault::Policy {
            app.world_mut().trigger(AthleteReset::new(crowd[BAD]));
            run_ticks(&mut app, 8);
            assert_eq!(body(&app, crowd[BAD]).status(), BodyStatus::Running, "{fault:?}");
        }
    }
}

fn figure(app: &App, path: &bevy::diagnostic::DiagnosticPath) -> f64 {
    let store = app.world().resource::<DiagnosticsStore>();
    store.get_measurement(path).expect("a measurement").value
}

#[test]
fn the_figures_of_a_tick_are_in_the_store() {
    let mut app = app();
    let file = skater_file(&mut app);
    for k in 0..5 {
        app.world_mut().spawn((Athlete(file.clone()), place(k)));
    }
    run_ticks(&mut app, 4);
    assert_eq!(figure(&app, &AthleteDiagnosticsPlugin::BODIES), 5.0);
    // The fourth tick of 18.75 steps ends with a whole one.
    assert_eq!(figure(&app, &AthleteDiagnosticsPlugin::STEPS), 5.0 * 19.0);
    assert_eq!(figure(&app, &AthleteDiagnosticsPlugin::QUARANTINED), 0.0);
    let milliseconds = figure(&app, &AthleteDiagnosticsPlugin::STEP_TIME);
    assert!(milliseconds > 0.0 && milliseconds < 1e4, "{milliseconds} ms");
}

/// Skaters who do different things: a mixed crowd. They come one after the other, so their clocks differ.
fn mixed(app: &mut App, count: usize, precision: fn(usize) -> AthletePrecision) -> Vec<Entity> {
    let file = skater_file(app);
    let skills = ["stroking", "forward_crossover"].map(|name| add(app, shipped_skill(name)));
    let control = add(app, ControlAsset { control: Arc::new(glide(0.4)) });
    (0..count)
        .map(|k| {
            let settings = AthleteSettings { precision: precision(k), ..default() };
            let athlete = app.world_mut().spawn((Athlete(file.clone()), settings, place(k))).id();
            let mut entity = app.world_mut().entity_mut(athlete);
            match k % 4 {
                0 | 1 => entity.insert(AthleteController::skill(skills[k % 2].clone())),
                2 => entity.insert(AthleteController::Play(control.clone())),
                _ => {
                    let input = AthleteInput::towards(Vec3::X).at(2.5);
                    entity.insert((AthleteController::steer(skills.clone()), input))
                }
            };
            if k % 3 == 0 {
                app.update();
            }
            athlete
        })
        .collect()
}

const PRECISIONS: [fn(usize) -> AthletePrecision; 3] =
    [|_| AthletePrecision::Double, |_| AthletePrecision::Single, |k| PRECISIONS[k / 2 % 2](k)];

/// Snapshots of a mixed crowd after a second. Some hold on to something: a place in the air, and one on the ice, which slides from
/// their hands.
fn crowd_bytes(count: usize, lanes: bool, precision: fn(usize) -> AthletePrecision) -> Vec<Vec<u8>> {
    let mut app = app();
    app.insert_resource(AthleteLanes(lanes));
    let crowd = mixed(&mut app, count, precision);
    run_ticks(&mut app, 1);
    for (k, athlete) in crowd.iter().enumerate().filter(|(k, _)| k % 3 == 1) {
        let mut body = body_mut(&mut app, *athlete);
        let sim = body.simulator_mut();
        let hand = sim.grip_position(0, 0).expect("the skater has hands");
        let on_ice = GripAnchor::Solid { solid: 0, place: hand.with_y(0.0) };
        sim.hold(0, 0, if k % 2 == 1 { GripAnchor::Fixed(hand) } else { on_ice });
    }
    run_ticks(&mut app, 64);
    crowd.iter().map(|e| body(&app, *e).snapshot().to_bytes()).collect()
}

#[test]
fn lanes_and_grouping_do_not_show() {
    for precision in PRECISIONS {
        let alone = crowd_bytes(11, false, precision);
        let together = crowd_bytes(11, true, precision);
        for (k, (a, b)) in alone.iter().zip(&together).enumerate() {
            assert!(a == b, "skater {k} in a lane moves otherwise than alone");
        }
        // Fewer neighbours, other groups.
        for count in [1, 2, 6, 10] {
            let fewer = crowd_bytes(count, true, precision);
            // Those who came before the first tick of the last one have lived as long.
            let ticks = |count: usize| count.div_ceil(3);
            let some = (0..count).filter(|_| ticks(count) == ticks(11));
            for k in some {
                assert!(fewer[k] == alone[k], "skater {k} among {count} moves otherwise");
            }
            assert_eq!(fewer, crowd_bytes(count, false, precision), "{count} skaters");
        }
    }
}

/// Whether each of a crowd that performs skills still stands, and where its root is after two seconds.
fn places_after_two_seconds(precision: fn(usize) -> AthletePrecision) -> Vec<DVec3> {
    let mut app = app();
    let crowd = mixed(&mut app, 10, precision);
    run_ticks(&mut app, 128);
    let skating = crowd.into_iter().enumerate().filter(|(k, _)| k % 4 < 2).map(|(_, e)| e);
    let places = skating.map(|e| {
        assert_eq!(body(&app, e).status(), BodyStatus::Running);
        body(&app, e).simulator().state.root_position.lane(0)
    });
    places.collect()
}

#[test]
fn in_single_precision_they_skate_as_well() {
    let (double, single) = (places_after_two_seconds(PRECISIONS[0]), places_after_two_seconds(PRECISIONS[1]));
    for (k, (a, b)) in double.into_iter().zip(single).enumerate() {
        let apart = a.distance(b);
        println!("skater {k}: {:.3} m up, {apart:.5} m apart after two seconds", b.y);
        assert!(b.y > 0.6 && apart < 0.1 && apart > 0.0);
        // Single precision: nothing is lost on the way to f32 and back.
        assert_eq!(b.y, f64::from(b.y as f32));
    }
}

#[test]
#[ignore = "run by any_number_of_threads_gives_the_same_bits in processes of their own"]
fn a_crowd_prints_itself() {
    let threads = std::env::var("ATHLETE_THREADS").map_or(1, |n| n.parse().unwrap());
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(threads).build());
    let crowd = crowd_bytes(11, true, PRECISIONS[2]);
    let sum = crowd.iter().flatten().fold(7_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
    println!("{} threads, crowd {sum:016x}", ComputeTaskPool::get().thread_num());
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let prints: Vec<String> = [1, 2, 3, 8]
        .into_iter()
        .map(|threads: u32| {
            let mut command = std::process::Command::new(std::env::current_exe().unwrap());
            command.args(["engine_rooms::a_crowd_prints_itself", "--exact", "--ignored", "--nocapture"]);
            let output = command.env("ATHLETE_THREADS", threads.to_string()).output().unwrap();
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            let line = text.lines().find(|l| l.contains("crowd ")).unwrap_or_else(|| panic!("{text}"));
            println!("{line}");
            assert!(line.contains(&format!("{threads} threads")), "{line}");
            line.rsplit(' ').next().unwrap().to_owned()
        })
        .collect();
    assert!(prints.iter().all(|p| *p == prints[0]), "{prints:?}");
}

/// The fingerprint of an athlete after each fixed tick.
#[derive(Resource, Default)]
struct TickPrints(Vec<u64>);

#[test]
fn frames_of_30_60_144_hz_and_uneven_ones_give_the_same_bits_per_tick() {
    let run = |frames: &mut dyn FnMut(usize) -> Duration| {
        let mut app = app();
        app.init_resource::<TickPrints>();
        app.add_systems(FixedLast, |bodies: Query<&AthleteBody>, mut prints: ResMut<TickPrints>| {
            for body in &bodies {
                prints.0.push(body.simulator().state.fingerprint(0));
            }
        });
        let (file, skill) = (skater_file(&mut app), add(&mut app, shipped_skill("stroking")));
        app.world_mut().spawn((Athlete(file), place(9), AthleteController::skill(skill)));
        let mut k = 0;
        while app.world().resource::<TickPrints>().0.len() < 128 {
            app.insert_resource(TimeUpdateStrategy::ManualDuration(frames(k)));
            app.update();
            k += 1;
        }
        let mut prints = std::mem::take(&mut app.world_mut().resource_mut::<TickPrints>().0);
        prints.truncate(128);
        (k, prints)
    };
    let (_, reference) = run(&mut |_| TICK);
    let even = |hertz: u64| move |_: usize| Duration::from_nanos(1_000_000_000 / hertz);
    let mut random = bevy_athlete::math::RandomStream::new(8, 0);
    let mut uneven = |_: usize| Duration::from_micros(1000 + random.below(60_000) as u64);
    let patterns: [(&str, &mut dyn FnMut(usize) -> Duration); 4] =
        [("30 Hz", &mut even(30)), ("60 Hz", &mut even(60)), ("144 Hz", &mut even(144)), ("uneven", &mut uneven)];
    for (name, frames) in patterns {
        let (frames, prints) = run(frames);
        let differing = prints.iter().zip(&reference).filter(|(a, b)| a != b).count();
        println!("{name}: {frames} frames, {differing} of 128 ticks differ");
        assert_eq!(differing, 0, "{name}");
    }
}
