//! Contract: a game sets the parameters of skills by name, and what it sets is followed, seen, kept in snapshots and told where it
//! cannot be.
//!
//! What a value does to reference and policy is proven without the engine; here that it gets there from the component, in a lane as
//! alone, and back after a snapshot; that what is out of range is told as a message and at an observer, once; and that the first decision of an
//! athlete sees the heights ahead, on solids, in an arena and on Avian's colliders.

use crate::engine_support::*;
use crate::plain_skill::{jump_over, seen, silent};
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_athlete::asset::Course;
use bevy_athlete::contact::World as Surroundings;
use bevy_athlete::engine::*;
use bevy_athlete::skill::BadParameter;
use std::sync::Arc;

/// The skill and the body that it is for.
fn files(app: &mut App) -> (Handle<CharacterAsset>, Handle<SkillAsset>) {
    let asset = CharacterAsset::preset("runner").unwrap();
    let model = asset.model.clone();
    let skill = SkillAsset::made_for(&model, Arc::new(silent(jump_over(&model), &model)));
    (add(app, asset), add(app, skill))
}

fn runner(app: &mut App, input: AthleteInput, x: f32) -> Entity {
    let (character, skill) = files(app);
    spawn(app, &character, &skill, input, x)
}

fn spawn(
    app: &mut App,
    character: &Handle<CharacterAsset>,
    skill: &Handle<SkillAsset>,
    input: AthleteInput,
    x: f32,
) -> Entity {
    let controller = AthleteController::skill(skill.clone());
    app.world_mut().spawn((Athlete(character.clone()), controller, input, Transform::from_xyz(x, 0.0, 0.0))).id()
}

fn reference(app: &App, athlete: Entity) -> DVec3 {
    body(app, athlete).skill_player().unwrap().reference_pose().root_position
}

fn observation(app: &App, athlete: Entity) -> ([f32; 3], [f32; 3]) {
    seen(body(app, athlete).skill_player().unwrap().observation())
}

/// What was told, by both ways.
#[derive(Resource, Default)]
struct Told {
    messages: Vec<ParameterRefused>,
    observed: Vec<ParameterRefused>,
}

fn listening() -> App {
    let mut app = app();
    app.insert_resource(AthleteWorld::ground());
    app.init_resource::<Told>();
    app.add_systems(Update, |mut reader: MessageReader<ParameterRefused>, mut told: ResMut<Told>| {
        told.messages.extend(reader.read().cloned());
    });
    app.add_observer(|event: On<ParameterRefused>, mut told: ResMut<Told>| told.observed.push(event.event().clone()));
    app
}

#[test]
fn one_skill_with_two_values_follows_two_references() {
    let mut app = listening();
    let low = runner(&mut app, AthleteInput::default().with("height", 0.4).with("distance", 2.0), 0.0);
    let high = runner(&mut app, AthleteInput::default().with("height", 0.6).with("distance", 3.0), 5.0);
    let plain = runner(&mut app, AthleteInput::default(), 10.0);
    run_ticks(&mut app, 32);
    let apart = reference(&app, high) - reference(&app, low) - DVec3::X * 5.0;
    println!("references {apart:?} apart");
    assert!((apart - DVec3::new(0.0, 0.2, -1.0)).length() < 1e-6, "{apart}");
    // Each stands on the same ground, so heights are those of the warps alone.
    assert!((reference(&app, plain) - reference(&app, low) - DVec3::new(10.0, 0.1, 0.0)).length() < 1e-6);
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close(observation(&app, low).0, [-1.0, -0.5, 0.0]), "{:?}", observation(&app, low));
    assert!(close(observation(&app, high).0, [1.0, 0.0, 0.0]), "{:?}", observation(&app, high));
    assert!(close(observation(&app, plain).0, [0.0, -0.5, 0.0]));

    // A change while it plays counts from the next decision on, and nothing else starts anew.
    let time = body(&app, low).time();
    app.world_mut().get_mut::<AthleteInput>(low).unwrap().parameters.set("height", 0.6);
    run_ticks(&mut app, 4);
    assert!(close(observation(&app, low).0, [1.0, -0.5, 0.0]));
    assert!(body(&app, low).time() > time);
    assert!((reference(&app, high) - reference(&app, low)).y.abs() < 1e-6);
    let told = app.world().resource::<Told>();
    assert!(told.messages.is_empty() && told.observed.is_empty(), "{:?}", told.messages);
}

#[test]
fn what_cannot_be_is_told_once() {
    let mut app = listening();
    let input = AthleteInput::default().with("height", 3.0).with("colour", 1.0).with("mood", f64::INFINITY);
    let athlete = runner(&mut app, input, 0.0);
    run_ticks(&mut app, 40);
    let told = app.world().resource::<Told>();
    let found: Vec<_> = told.messages.iter().map(|t| (t.entity, t.parameter.as_str(), t.reason.clone())).collect();
    found.iter().for_each(|(_, name, reason)| println!("{name}: {reason}"));
    let known = ["distance", "height", "mood"].map(String::from).to_vec();
    let wanted = [
        (athlete, "height", BadParameter::OutOfRange { value: 3.0, low: 0.4, high: 0.6 }),
        (athlete, "mood", BadParameter::NotANumber { taken: 0.5 }),
        (athlete, "colour", BadParameter::Unknown { known }),
    ];
    assert_eq!(found, wanted);
    assert!(told.messages.iter().all(|t| t.skill == "jump_over"));
    assert_eq!(told.messages, told.observed);
    assert_eq!(body(&app, athlete).skill_player().unwrap().parameters(), [0.6, 2.0, 0.5]);
}

#[test]
fn a_snapshot_holds_what_was_set() {
    let wish = |height: f64| AthleteInput::default().with("height", height).with("distance", 4.0);
    let mut app = listening();
    let athlete = runner(&mut app, wish(0.45), 0.0);
    run_ticks(&mut app, 9);
    app.world_mut().get_mut::<AthleteInput>(athlete).unwrap().parameters.set("height", 0.55);
    run_ticks(&mut app, 1);
    let snapshot = body(&app, athlete).snapshot();
    run_ticks(&mut app, 20);
    let straight = body(&app, athlete).snapshot();
    // In another program that was told otherwise, and whose component says the same by now.
    let mut other = listening();
    let twin = runner(&mut other, wish(0.45), 0.0);
    run_ticks(&mut other, 5);
    other.world_mut().get_mut::<AthleteInput>(twin).unwrap().parameters.set("height", 0.55);
    let read = AthleteSnapshot::from_bytes(&snapshot.to_bytes()).unwrap();
    body_mut(&mut other, twin).restore(&read).unwrap();
    // What was wished waits for the next decision, in the snapshot as well.
    assert_eq!(body(&other, twin).skill_player().unwrap().parameters(), [0.45, 4.0, 0.5]);
    assert!(body(&other, twin).snapshot() == snapshot);
    run_ticks(&mut other, 20);
    assert_eq!(body(&other, twin).skill_player().unwrap().parameters(), [0.55, 4.0, 0.5]);
    assert_eq!(body(&other, twin).snapshot().to_bytes(), straight.to_bytes());
    // Other values would have led elsewhere.
    let mut third = listening();
    let lower = runner(&mut third, wish(0.4), 0.0);
    run_ticks(&mut third, 30);
    assert!(body(&third, lower).snapshot() != straight);
}

#[test]
fn lanes_do_not_mix_parameters_up() {
    let run = |lanes: bool| {
        let mut app = listening();
        app.insert_resource(AthleteLanes(lanes));
        let (character, skill) = files(&mut app);
        let wish = |k: usize| AthleteInput::default().with("height", 0.4 + 0.03 * k as f64).with("distance", k as f64);
        let crowd: Vec<Entity> = (0..6).map(|k| spawn(&mut app, &character, &skill, wish(k), 4.0 * k as f32)).collect();
        run_ticks(&mut app, 40);
        crowd.iter().map(|e| body(&app, *e).snapshot().to_bytes()).collect::<Vec<_>>()
    };
    let (alone, together) = (run(false), run(true));
    assert!(alone == together, "lanes show");
    assert!(alone.windows(2).all(|pair| pair[0] != pair[1]));
}

/// A box of half a metre from 1 to 1.5 m ahead, on the ground.
fn box_ahead() -> Surroundings {
    let text = r#"(name: "box", solids: [Box(ahead: 1, depth: 0.5, width: 2, height: 0.5)])"#;
    let course = Course::parse("box.course.ron", text.as_bytes()).unwrap();
    Surroundings::with_course(&Surroundings::ground(), &course.instance(&[], 0).unwrap()).unwrap()
}

#[test]
fn the_first_decision_sees_the_heights_ahead() {
    // A fixed tick is shorter than one between decisions: the first decision is the only one.
    let decided_once = |app: &App, athlete: Entity| {
        let player = body(app, athlete).skill_player().unwrap();
        assert_eq!((player.tick(), player.at_decision()), (0, false));
    };
    for lanes in [false, true] {
        let mut app = listening();
        app.insert_resource(AthleteLanes(lanes));
        let arena = app.world_mut().spawn(ArenaWorld(box_ahead())).id();
        let (character, skill) = files(&mut app);
        let [on_ground, with_box, beside] =
            [0.0, 0.0, 3.0].map(|x| spawn(&mut app, &character, &skill, AthleteInput::default(), x));
        for athlete in [with_box, beside] {
            app.world_mut().entity_mut(athlete).insert(InArena(arena));
        }
        run_ticks(&mut app, 1);
        for (athlete, wanted) in [(on_ground, [0.0; 3]), (with_box, [0.0, 0.5, 0.0]), (beside, [0.0; 3])] {
            decided_once(&app, athlete);
            assert_eq!(observation(&app, athlete).1, wanted, "lanes {lanes}");
        }
        // After a reset it is a first decision again.
        run_ticks(&mut app, 20);
        app.world_mut().trigger(AthleteReset::at(beside, Transform::from_xyz(0.5, 0.0, 0.0)));
        run_ticks(&mut app, 1);
        decided_once(&app, beside);
        assert_eq!(observation(&app, beside).1, [0.0, 0.5, 0.0]);
    }
}

/// Avian's colliders are gathered in the neighbourhood of an athlete: what its policy looks at belongs to it.
#[cfg(feature = "avian")]
#[test]
fn colliders_ahead_are_seen_from_the_first_decision_on() {
    use crate::grounds::avian_app;
    use avian3d::prelude::*;
    let mut app = avian_app();
    let still = |collider: Collider, place: Vec3| (RigidBody::Static, collider, Transform::from_translation(place));
    app.world_mut().spawn(still(Collider::cuboid(40.0, 1.0, 40.0), Vec3::Y * -0.5));
    app.world_mut().spawn(still(Collider::cuboid(2.0, 0.5, 0.5), Vec3::new(0.0, 0.25, -1.25)));
    run_ticks(&mut app, 1);
    let athlete = runner(&mut app, AthleteInput::default(), 0.0);
    for ticks in [1, 12] {
        run_ticks(&mut app, ticks);
        let heights = observation(&app, athlete).1;
        // Found by sphere tracing, to a millimetre.
        let wanted = [0.0, 0.5, 0.0];
        assert!(heights.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 2e-3), "{heights:?}");
    }
}
