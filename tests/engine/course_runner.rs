//! Contract: on what a game puts in its way, a runner tells what it sees and what it plans, jumps onto what it can, and stops before what it
//! cannot. Nobody tells it where anything is.

use crate::engine_support::{add, app, body, skill_in};
use bevy::prelude::*;
use bevy_athlete::contact::{Geometry, Solid, Surface, World as Surroundings};
use bevy_athlete::engine::*;
use bevy_athlete::skill::planner::ObstacleKind;

#[derive(Resource, Default)]
struct Told {
    plans: Vec<ObstaclePlanned>,
    skills: Vec<String>,
}

fn block(height: f64) -> Solid {
    // From 8 m ahead on.
    let half_extents = bevy::math::DVec3::new(5.0, 0.5 * height, 15.0);
    let center = bevy::math::DVec3::new(0.0, 0.5 * height, -23.0);
    Solid::fixed(Geometry::Box { center, half_extents, rotation: bevy::math::DQuat::IDENTITY }, Surface::GROUND)
}

fn run(height: f64, seconds: f64) -> (App, Entity) {
    let mut app = app();
    let mut world = Surroundings::ground();
    world.solids.push(block(height));
    app.insert_resource(AthleteWorld(world)).init_resource::<Told>();
    app.add_observer(|event: On<ObstaclePlanned>, mut told: ResMut<Told>| told.plans.push(event.event().clone()));
    app.add_observer(|event: On<SkillStarted>, mut told: ResMut<Told>| told.skills.push(event.skill.clone()));
    let file = add(&mut app, CharacterAsset::preset("runner").expect("a character"));
    let [gait, jump] = ["running/run", "running/jump"].map(|name| add(&mut app, skill_in(name)));
    let controller = AthleteController::course(gait, [jump]);
    let input = AthleteInput::towards(Vec3::NEG_Z).at(3.2);
    let runner = app.world_mut().spawn((Athlete(file), controller, input)).id();
    for _ in 0..(seconds * 64.0) as usize {
        app.update();
    }
    (app, runner)
}

#[test]
fn it_jumps_onto_a_step_that_it_was_not_told_of() {
    let (app, runner) = run(0.35, 4.0);
    let told = app.world().resource::<Told>();
    let plan = told.plans.first().expect("a plan");
    assert_eq!((plan.kind, plan.skill.as_deref(), plan.refusal), (ObstacleKind::Up, Some("jump"), None));
    assert!((plan.height - 0.35).abs() < 1e-6 && plan.distance > 4.0, "{plan:?}");
    assert!(told.skills.iter().any(|s| s.starts_with("jump")), "{:?}", told.skills);
    let place = body(&app, runner).simulator().state.root_position.lane(0);
    println!("{place}, {:?}", told.skills);
    assert!(place.z < -9.0, "{place}");
}

#[test]
fn it_stops_before_a_wall_and_says_why() {
    let (app, runner) = run(1.6, 8.0);
    let told = app.world().resource::<Told>();
    let plan = told.plans.first().expect("a plan");
    assert!(plan.skill.is_none() && plan.refusal.is_some(), "{plan:?}");
    let place = body(&app, runner).simulator().state.root_position.lane(0);
    println!("{place}, {}", plan.refusal.expect("why"));
    assert!((-7.9..-3.0).contains(&place.z), "{place}");
}
