//! The hopper in a game: spawned from its files, in front of a step, and told how high it is. It hops up and stands there.
//!
//! Proves that a family of files alone plays in Bevy: character, skill, motion, course and policy come through the asset server, the
//! game builds the same step into the world, and the skill's parameter reaches reference and policy. A low step, a high
//! one and one between, by the network and by one matrix with an offset. What is not chosen is in the middle of its range.

use crate::engine_support::{TICK, body, run_ticks};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::asset::Course;
use bevy_athlete::contact::World as Surroundings;
use bevy_athlete::engine::*;
use std::path::Path;

const FAMILY: &str = "tests/families/hopper";

/// What was told of the athletes.
#[derive(Resource, Default)]
struct Told {
    took_off: Vec<Entity>,
    landed: Vec<Entity>,
    ended: Vec<Entity>,
    fell: Vec<Entity>,
    refused: Vec<String>,
}

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin { file_path: FAMILY.into(), ..default() }, AthletePlugins));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
    app.init_resource::<Told>();
    app.add_observer(|event: On<TakeOff>, mut told: ResMut<Told>| told.took_off.push(event.entity));
    app.add_observer(|event: On<Landing>, mut told: ResMut<Told>| told.landed.push(event.entity));
    app.add_observer(|event: On<SkillEnded>, mut told: ResMut<Told>| told.ended.push(event.entity));
    app.add_observer(|event: On<AthleteFell>, mut told: ResMut<Told>| told.fell.push(event.entity));
    app.add_observer(|event: On<AthleteRefused>, mut told: ResMut<Told>| told.refused.push(event.reason.to_string()));
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// The step of the course, so high, as a world.
fn step_of(height: f64) -> Surroundings {
    let course = Course::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(FAMILY).join("step.course.ron")).unwrap();
    let mut values = course.defaults();
    course.set(&mut values, "height", height).unwrap();
    Surroundings::with_course(&Surroundings::empty(), &course.instance(&values, 0).unwrap()).unwrap()
}

/// A hopper before a step of its own; the motion begins a little behind the place from which the step is measured.
fn spawn(app: &mut App, skill: &str, height: f64, told: Option<f64>) -> Entity {
    let arena = app.world_mut().spawn(ArenaWorld(step_of(height))).id();
    let server = app.world().resource::<AssetServer>().clone();
    let hopper = app.world_mut().spawn((
        Athlete(server.load("hopper.character.ron")),
        AthleteController::skill(server.load(format!("{skill}/{skill}.skill.ron"))),
        Transform::from_xyz(0.0, 0.0, 0.09),
        InArena(arena),
    ));
    let hopper = hopper.id();
    if let Some(height) = told {
        app.world_mut().entity_mut(hopper).insert(AthleteInput::default().with("height", height));
    }
    hopper
}

/// Runs until all have a body.
fn wait_for_bodies(app: &mut App, hoppers: &[Entity]) {
    for _ in 0..2000 {
        if hoppers.iter().all(|h| app.world().get::<AthleteBody>(*h).is_some()) {
            return;
        }
        app.update();
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    panic!("no bodies: {:?}", app.world().resource::<Told>().refused);
}

#[test]
fn it_hops_up_the_step_and_stands_there() {
    let mut app = app();
    let steps = [("hop_up", [0.06, 0.125, 0.19]), ("hop_up_affine", [0.06, 0.11, 0.16])];
    let cases: Vec<(&str, f64)> = steps.iter().flat_map(|(skill, heights)| heights.map(|h| (*skill, h))).collect();
    let hoppers: Vec<Entity> =
        cases.iter().map(|(skill, height)| spawn(&mut app, skill, *height, Some(*height))).collect();
    wait_for_bodies(&mut app, &hoppers);
    run_ticks(&mut app, (2.8 / TICK.as_secs_f64()) as usize);
    let told = app.world().resource::<Told>();
    assert!(told.refused.is_empty(), "{:?}", told.refused);
    for (hopper, (skill, height)) in hoppers.iter().zip(&cases) {
        let body = body(&app, *hopper);
        let state = &body.simulator().state;
        let (root, up) = (state.root_position.lane(0), state.root_rotation.lane(0) * bevy::math::DVec3::Y);
        let player = body.skill_player().unwrap();
        println!("{skill} on {height}: root {root:.3}, up {:.3}, support {:.3}", up.y, player.support().height);
        assert_eq!(player.parameters(), [*height], "{skill}: what the game chose");
        assert!((player.support().height - height).abs() < 1e-6, "{skill}: stands on the step of {height}");
        assert!(root.z < -0.4 && root.x.abs() < 0.3, "{skill} on {height}: {root}");
        assert!(root.y - height > 0.65 && up.y > 0.85, "{skill} on {height}: upright, {root} {up}");
        let count = |list: &[Entity]| list.iter().filter(|e| *e == hopper).count();
        assert!(count(&told.took_off) >= 1 && count(&told.landed) >= 1, "{skill} on {height}: it hopped");
        assert_eq!((count(&told.ended), count(&told.fell)), (1, 0), "{skill} on {height}");
    }
}

#[test]
fn what_is_chosen_can_change_and_stays_within_its_range() {
    let mut app = app();
    let hopper = spawn(&mut app, "hop_up", 0.125, None);
    wait_for_bodies(&mut app, &[hopper]);
    let chosen = |app: &App| body(app, hopper).skill_player().unwrap().parameters()[0];
    assert!((chosen(&app) - 0.12).abs() < 1e-12, "nothing is chosen: what the motion was made for");
    for (told, becomes) in [(0.07, 0.07), (9.0, 0.2), (f64::NAN, 0.12)] {
        app.world_mut().entity_mut(hopper).insert(AthleteInput::default().with("height", told).with("width", 3.0));
        // They count from the next decision on.
        run_ticks(&mut app, 4);
        assert!((chosen(&app) - becomes).abs() < 1e-12, "{told}: {}", chosen(&app));
    }
    app.world_mut().entity_mut(hopper).insert(AthleteInput::default());
    run_ticks(&mut app, 4);
    assert!((chosen(&app) - 0.12).abs() < 1e-12);
}
