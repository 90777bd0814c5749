//! The Bevy plugins without a renderer.
//!
//! An `App` is stepped by hand with exact frame durations. What is proven: a spawned athlete moves as the plain simulator
//! does, bit for bit; only the number of fixed ticks counts, not how frames were cut; what cannot be simulated is refused
//! with a reason; one athlete that goes bad leaves the others alone; events arrive both as messages and at observers; no two
//! systems of the fixed schedule are in an order that Bevy may choose.

use crate::engine_support::{TICK, glide};
use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::contact::World as Surroundings;
use bevy_athlete::control::{ControlPlayer, ReconstructedControl};
use bevy_athlete::engine::*;
use bevy_athlete::model::skater;
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use std::time::Duration;

/// Everything that was told, in order, by both ways.
#[derive(Resource, Default)]
struct Heard {
    messages: Vec<(Entity, String)>,
    observed: Vec<(Entity, String)>,
}

fn hear<E>(app: &mut App, name: &'static str)
where
    E: Message + EntityEvent,
{
    app.add_systems(Update, move |mut reader: MessageReader<E>, mut heard: ResMut<Heard>| {
        for event in reader.read() {
            heard.messages.push((event.event_target(), name.into()));
        }
    });
    app.add_observer(move |event: On<E>, mut heard: ResMut<Heard>| {
        heard.observed.push((event.event_target(), name.into()));
    });
}

/// A headless app whose frames last `frame`.
fn app(frame: Duration) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), AthletePlugins));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    app.insert_resource(AthleteWorld::ice());
    app.init_resource::<Heard>();
    app.edit_schedule(FixedPostUpdate, |schedule| {
        schedule
            .set_build_settings(ScheduleBuildSettings { ambiguity_detection: LogLevel::Error, ..Default::default() });
    });
    hear::<BladeEdgeChanged>(&mut app, "edge");
    hear::<TakeOff>(&mut app, "take-off");
    hear::<Landing>(&mut app, "landing");
    hear::<AthleteFell>(&mut app, "fell");
    hear::<ControlFinished>(&mut app, "finished");
    hear::<AthleteQuarantined>(&mut app, "quarantined");
    hear::<AthleteRefused>(&mut app, "refused");
    app.finish();
    app.cleanup();
    // The first frame has no duration and runs no tick.
    app.update();
    app
}

fn spawn(app: &mut App, transform: Transform, control: Option<ReconstructedControl>) -> Entity {
    let character = CharacterAsset::preset("skater").unwrap();
    let character = app.world_mut().resource_mut::<Assets<CharacterAsset>>().add(character);
    let controller = match control {
        Some(control) => AthleteController::Play(app.world_mut().resource_mut::<Assets<ControlAsset>>().add(control)),
        None => AthleteController::Hold,
    };
    app.world_mut().spawn((Athlete(character), controller, transform)).id()
}

fn body(app: &App, athlete: Entity) -> &AthleteBody {
    app.world().get::<AthleteBody>(athlete).expect("a body")
}

fn run_ticks(app: &mut App, ticks: u32, frame: Duration) {
    let frames = (TICK * ticks).as_nanos() / frame.as_nanos();
    for _ in 0..frames {
        app.update();
    }
}

#[test]
fn two_seconds_as_the_plain_simulator_has_them() {
    let mut app = app(TICK);
    let athlete = spawn(&mut app, Transform::IDENTITY, Some(glide(1.0)));
    run_ticks(&mut app, 128, TICK);

    let model = skater();
    let mut sim: Simulator<f64> = Simulator::new(model.clone(), SimulationSettings::of(&model));
    let mut player = ControlPlayer::new(&glide(1.0), &model).unwrap();
    player.restart(&mut sim);
    for _ in 0..1200 {
        player.drive(&mut sim);
        step(&mut sim, &Surroundings::ice());
    }
    for command in &mut sim.commands {
        command.velocity = bevy_athlete::math::Vec3::zero();
    }
    for _ in 0..1200 {
        step(&mut sim, &Surroundings::ice());
    }
    let body = body(&app, athlete);
    println!("time {} s, fingerprint {:016x}", body.time(), body.simulator().state.fingerprint(0));
    assert!((body.time() - 2.0).abs() < 1e-9);
    assert_eq!(body.simulator().state.fingerprint(0), sim.state.fingerprint(0));

    let root = body.simulator().state.root_position.lane(0);
    assert!(root.z < -1.0, "it should have glided ahead: {root}");
    let drawn = app.world().get::<Transform>(athlete).unwrap().translation;
    assert!((drawn - root.as_vec3()).length() < 0.2, "transform {drawn}, root {root}");
    let poses = app.world().get::<LinkPoses>(athlete).unwrap();
    assert_eq!(poses.interpolated.len(), model.links.len());
}

#[test]
fn the_same_ticks_give_the_same_bits_whatever_the_frames() {
    let run = |frame: Duration| {
        let mut app = app(frame);
        let athlete = spawn(&mut app, Transform::from_xyz(3.0, 0.0, -7.0), Some(glide(0.5)));
        // The first tick gives the body; from a known tick on, count.
        run_ticks(&mut app, 64, frame);
        let body = body(&app, athlete);
        (body.time(), body.simulator().state.fingerprint(0))
    };
    let reference = run(TICK);
    // Five ticks in a frame, and four frames in a tick.
    let frames = [TICK * 4, TICK / 5, TICK * 8];
    for frame in frames {
        let other = run(frame);
        println!("frames of {frame:?}: {:.6} s {:016x}", other.0, other.1);
        assert_eq!(other, reference, "frames of {frame:?}");
    }
}

#[test]
fn a_placement_moves_and_turns_the_motion() {
    let mut app = app(TICK);
    let turned = Transform::from_xyz(5.0, 0.0, 2.0).with_rotation(Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2));
    let athlete = spawn(&mut app, turned, Some(glide(0.5)));
    run_ticks(&mut app, 16, TICK);
    // -Z turned by -90 degrees about Y is +X.
    let root = body(&app, athlete).simulator().state.root_position.lane(0);
    println!("root after 0.25 s: {root}");
    assert!((root.x - 5.5).abs() < 0.02 && (root.z - 2.0).abs() < 0.02, "{root}");
}

#[test]
fn bad_transforms_are_refused_with_a_reason() {
    let mut app = app(TICK);
    let big = spawn(&mut app, Transform::from_scale(Vec3::splat(2.0)), None);
    let lost = spawn(&mut app, Transform::from_xyz(0.0, f32::INFINITY, 0.0), None);
    let other = ReconstructedControl { character: "runner".into(), ..glide(1.0) };
    let misfit = spawn(&mut app, Transform::IDENTITY, Some(other));
    let good = spawn(&mut app, Transform::IDENTITY, None);
    run_ticks(&mut app, 2, TICK);
    for athlete in [big, lost] {
        assert!(app.world().get::<AthleteBody>(athlete).is_none());
        println!("{}", app.world().get::<Refused>(athlete).expect("a reason").0);
    }
    // A controller that does not fit is no reason not to be there: it holds.
    assert!(body(&app, misfit).control_seconds().is_none());
    assert!(matches!(app.world().get::<Refused>(big).unwrap().0, AthleteRefusal::Scale { .. }));
    assert!(app.world().get::<AthleteBody>(good).is_some());
    let heard = app.world().resource::<Heard>();
    assert_eq!(heard.messages.iter().filter(|h| h.1 == "refused").count(), 3);
    assert_eq!(heard.observed.iter().filter(|h| h.1 == "refused").count(), 3);
}

#[test]
fn one_that_goes_bad_leaves_the_other_alone() {
    let mut app = app(TICK);
    let bad = spawn(&mut app, Transform::IDENTITY, Some(glide(1.0)));
    let good = spawn(&mut app, Transform::IDENTITY, Some(glide(1.0)));
    run_ticks(&mut app, 8, TICK);
    let mut broken = app.world_mut().get_mut::<AthleteBody>(bad).unwrap();
    broken.simulator_mut().state.root_velocity.linear.set_lane(0, bevy::math::DVec3::NAN);
    broken.simulator_mut().state_changed();
    run_ticks(&mut app, 16, TICK);
    assert_eq!(body(&app, bad).status(), BodyStatus::Quarantined);
    assert_eq!(body(&app, good).status(), BodyStatus::Running);
    assert!((body(&app, good).time() - 24.0 / 64.0).abs() < 1e-3);
    assert!(app.world().get::<Transform>(bad).unwrap().translation.is_finite());
    let quarantined = (bad, "quarantined".to_string());
    let heard = app.world().resource::<Heard>();
    assert_eq!(heard.messages.iter().filter(|h| **h == quarantined).count(), 1);
    assert_eq!(heard.observed.iter().filter(|h| **h == quarantined).count(), 1);

    // A reset gives it a second life, with the bits of the first.
    app.world_mut().trigger(AthleteReset::new(bad));
    run_ticks(&mut app, 8, TICK);
    let again = body(&app, bad).simulator().state.fingerprint(0);
    let athlete = spawn(&mut app, Transform::IDENTITY, Some(glide(1.0)));
    run_ticks(&mut app, 8, TICK);
    assert_eq!(again, body(&app, athlete).simulator().state.fingerprint(0));
}

#[test]
fn events_arrive_both_ways() {
    let mut app = app(TICK);
    // Stands on its blades, and is pushed over.
    let standing = spawn(&mut app, Transform::IDENTITY, Some(glide(0.5)));
    // Starts half a metre up.
    let dropped = spawn(&mut app, Transform::from_xyz(4.0, 0.0, 0.0), None);
    run_ticks(&mut app, 16, TICK);
    app.world_mut().get_mut::<AthleteBody>(dropped).unwrap().simulator_mut().state.root_velocity.linear.y = 3.0;
    app.world_mut().get_mut::<AthleteBody>(dropped).unwrap().simulator_mut().state_changed();
    let push = bevy_athlete::sim::ExternalForce {
        link: 0,
        position: bevy_athlete::math::Vec3::zero(),
        force: bevy_athlete::math::Vec3::splat(bevy::math::DVec3::new(200.0, 0.0, 0.0)),
    };
    app.world_mut().get_mut::<AthleteBody>(standing).unwrap().simulator_mut().external.push(push);
    run_ticks(&mut app, 16, TICK);
    app.world_mut().get_mut::<AthleteBody>(standing).unwrap().simulator_mut().external.clear();
    run_ticks(&mut app, 256, TICK);
    let heard = app.world().resource::<Heard>();
    println!("{:?}", heard.messages);
    for (athlete, name) in
        [(standing, "edge"), (standing, "finished"), (standing, "fell"), (dropped, "take-off"), (dropped, "landing")]
    {
        let wanted = (athlete, name.to_string());
        assert!(heard.messages.contains(&wanted), "no message {name}");
        assert!(heard.observed.contains(&wanted), "no event {name}");
    }
    let sorted = |list: &[(Entity, String)]| {
        let mut list = list.to_vec();
        list.sort();
        list
    };
    assert_eq!(sorted(&heard.messages), sorted(&heard.observed));
}

#[test]
fn targets_of_a_user_move_the_joints() {
    let mut app = app(TICK);
    let athlete = spawn(&mut app, Transform::IDENTITY, None);
    let model = skater();
    let arm = model.link_index("bicep_left").unwrap();
    let mut rotations = vec![bevy::math::DQuat::IDENTITY; model.links.len()];
    rotations[arm] = bevy::math::DQuat::from_rotation_x(0.6);
    let targets = AthleteTargets { rotations: rotations.clone(), velocities: Vec::new() };
    app.world_mut().entity_mut(athlete).insert((AthleteController::External, targets));
    run_ticks(&mut app, 48, TICK);
    let reached = body(&app, athlete).simulator().state.joints[arm].rotation.lane(0);
    let off = reached.angle_between(rotations[arm]).to_degrees();
    println!("arm off by {off:.2} degrees");
    assert!(off < 5.0);
}

#[test]
fn pause_stops_time_and_slow_motion_keeps_the_bits() {
    let mut app = app(TICK);
    let athlete = spawn(&mut app, Transform::IDENTITY, Some(glide(1.0)));
    run_ticks(&mut app, 8, TICK);
    app.world_mut().resource_mut::<PlaybackSpeed>().paused = true;
    app.update();
    let before = body(&app, athlete).time();
    run_ticks(&mut app, 8, TICK);
    assert_eq!(body(&app, athlete).time(), before);
    *app.world_mut().resource_mut::<PlaybackSpeed>() = PlaybackSpeed { speed: 0.25, paused: false };
    run_ticks(&mut app, 64, TICK);
    let slow = body(&app, athlete).time();
    println!("{before:.4} s, then 64 ticks of real time at a quarter speed: {slow:.4} s");
    assert!((slow - before - 0.25).abs() < 0.02);
}

#[test]
#[should_panic(expected = "ambig")]
fn ambiguous_systems_would_be_noticed() {
    #[derive(Resource, Default)]
    struct Shared(u32);
    let mut app = app(TICK);
    app.init_resource::<Shared>();
    let system = |add: u32| move |mut shared: ResMut<Shared>| shared.0 += add;
    app.add_systems(FixedPostUpdate, (system(1), system(2)));
    run_ticks(&mut app, 2, TICK);
}

#[test]
fn files_of_the_crate_load_by_path() {
    let mut app = app(TICK);
    let server = app.world().resource::<AssetServer>().clone();
    let good = server.load::<CharacterAsset>("embedded://bevy_athlete/runner.character.ron");
    let missing = server.load::<CharacterAsset>("embedded://bevy_athlete/nobody.character.ron");
    let good = app.world_mut().spawn(Athlete(good)).id();
    let missing = app.world_mut().spawn(Athlete(missing)).id();
    for _ in 0..500 {
        app.update();
        let done = app.world().get::<AthleteBody>(good).is_some() && app.world().get::<Refused>(missing).is_some();
        if done {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(body(&app, good).model().dof(), 45);
    let reason = &app.world().get::<Refused>(missing).expect("refused").0;
    println!("{reason}");
    assert!(matches!(reason, AthleteRefusal::Load { .. }));
}

/// An asset handle of a file, loaded before the test goes on.
fn loaded<A: Asset>(app: &mut App, path: &str) -> Handle<A> {
    let handle: Handle<A> = app.world().resource::<AssetServer>().load(path.to_owned());
    for _ in 0..2000 {
        if app.world().resource::<AssetServer>().is_loaded_with_dependencies(&handle) {
            return handle;
        }
        std::thread::sleep(Duration::from_millis(5));
        app.update();
    }
    panic!("{path} did not load: {:?}", app.world().resource::<AssetServer>().load_state(&handle));
}

/// An app that reads the crate's own assets.
fn app_with_files() -> App {
    let mut app = app(TICK);
    hear::<SkillStarted>(&mut app, "started");
    hear::<SkillEnded>(&mut app, "ended");
    app
}

#[test]
fn a_trained_skater_goes_round_and_its_speed_can_be_told() {
    let mut app = app_with_files();
    let skill: Handle<SkillAsset> = loaded(&mut app, "skills/skating/forward_crossover/forward_crossover.skill.ron");
    let athlete = spawn(&mut app, Transform::from_xyz(3.0, 0.0, 1.0), None);
    app.world_mut().entity_mut(athlete).insert(AthleteController::skill(skill.clone()));
    run_ticks(&mut app, 64 * 8, TICK);
    let heard = app.world().resource::<Heard>();
    assert!(heard.messages.iter().any(|(_, what)| what == "started"));
    assert!(!heard.messages.iter().any(|(_, what)| what == "fell" || what == "refused"), "{:?}", heard.messages);
    let body = body(&app, athlete);
    assert!(body.tracking_error().is_some() && body.skill_player().is_some());
    let speed = body.root_velocity().length();
    assert!((2.0..4.0).contains(&speed), "{speed} m/s");
    // Eight seconds of circles bring it no further than a circle is wide.
    let place = app.world().get::<Transform>(athlete).unwrap().translation;
    assert!(place.distance(Vec3::new(3.0, place.y, 1.0)) < 12.0, "{place}");

    // Taken away, the joints hold; given back, it begins anew.
    app.world_mut().entity_mut(athlete).insert(AthleteController::Hold);
    run_ticks(&mut app, 4, TICK);
    assert!(app.world().get::<AthleteBody>(athlete).unwrap().skill_player().is_none());
    app.world_mut().entity_mut(athlete).insert((AthleteController::skill(skill), AthleteInput::default().at(f32::NAN)));
    run_ticks(&mut app, 4, TICK);
    assert!(app.world().get::<AthleteBody>(athlete).unwrap().skill_player().is_some());
}

#[cfg(feature = "skills")]
#[test]
fn the_skills_inside_the_program_are_those_of_the_folder() {
    let mut app = app_with_files();
    let within = "embedded://bevy_athlete/skills/skating/short_program.program.ron";
    let within: Handle<ProgramAsset> = loaded(&mut app, within);
    let beside: Handle<ProgramAsset> = loaded(&mut app, "skills/skating/short_program.program.ron");
    let (programs, skills) =
        (app.world().resource::<Assets<ProgramAsset>>(), app.world().resource::<Assets<SkillAsset>>());
    let (within, beside) = (programs.get(&within).unwrap(), programs.get(&beside).unwrap());
    assert_eq!(within.program, beside.program);
    for (a, b) in within.skills.iter().zip(&beside.skills) {
        let [a, b] = [a, b].map(|handle| skills.get(handle).unwrap().bind(&skater()).unwrap());
        assert_eq!((a.name(), a.policy.fingerprint()), (b.name(), b.policy.fingerprint()));
        assert_eq!(a.motion.last(), b.motion.last());
    }
}

#[test]
fn a_program_and_a_wish_begin_their_skills() {
    let mut app = app_with_files();
    let program: Handle<ProgramAsset> = loaded(&mut app, "skills/skating/short_program.program.ron");
    let athlete = spawn(&mut app, Transform::IDENTITY, None);
    app.world_mut().entity_mut(athlete).insert(AthleteController::Program(program.clone()));
    let skills = app.world().resource::<Assets<ProgramAsset>>().get(&program).unwrap().skills.clone();
    let steered = spawn(&mut app, Transform::from_xyz(20.0, 0.0, 0.0), None);
    // Straight on, then to the left.
    let input = AthleteInput::towards(Vec3::NEG_Z).at(2.5);
    app.world_mut().entity_mut(steered).insert((AthleteController::steer(skills), input));
    run_ticks(&mut app, 64 * 2, TICK);
    app.world_mut().get_mut::<AthleteInput>(steered).unwrap().direction = Vec3::NEG_X;
    run_ticks(&mut app, 64 * 7, TICK);
    let started = |app: &App, who: Entity| {
        let heard = app.world().resource::<Heard>();
        heard.messages.iter().filter(|(e, what)| *e == who && what == "started").count()
    };
    assert!(started(&app, athlete) >= 2, "stroking and the crossovers after it");
    assert!(started(&app, steered) >= 2, "stroking and the crossovers round the curve");
    // Both ways tell the same; each kind has a reader of its own, so only the order differs.
    let mut heard = app.world_mut().resource_mut::<Heard>();
    heard.messages.sort();
    heard.observed.sort();
    assert!(heard.messages == heard.observed, "messages and observers differ");
    assert!(heard.messages.iter().any(|(e, what)| *e == athlete && what == "ended"));
}

#[test]
fn a_skill_without_its_policy_is_refused_by_name() {
    let mut app = app_with_files();
    let handle: Handle<SkillAsset> = app.world().resource::<AssetServer>().load("skills/skating/none/none.skill.ron");
    let athlete = spawn(&mut app, Transform::IDENTITY, None);
    app.world_mut().entity_mut(athlete).insert(AthleteController::skill(handle));
    for _ in 0..400 {
        std::thread::sleep(Duration::from_millis(5));
        app.update();
        if app.world().get::<AthleteBody>(athlete).is_some() {
            break;
        }
    }
    assert!(body(&app, athlete).director().is_none(), "it holds");
    let mut refusals = app.world_mut().resource_mut::<Messages<AthleteRefused>>();
    let reasons: Vec<String> = refusals.drain().map(|r| r.reason.to_string()).collect();
    assert!(reasons.len() == 1 && reasons[0].contains("none.skill.ron"), "{reasons:?}");
}

/// What `bsn! { Athlete("embedded://bevy_athlete/runner.character.ron") }` does.
#[test]
fn a_scene_names_its_athlete_by_path() {
    let mut app = app(TICK);
    type Named = <Athlete as FromTemplate>::Template;
    let template = Named { 0: "embedded://bevy_athlete/runner.character.ron".into() };
    let mut entity = app.world_mut().spawn_empty();
    let athlete = entity.build_template(&template).unwrap();
    let entity = entity.insert(athlete).id();
    for _ in 0..200 {
        app.update();
        if app.world().get::<AthleteBody>(entity).is_some() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(body(&app, entity).model().name, "runner");
}
