//! Contract: steps and stumbles are told. Who walks steps in turn, as far as it goes; who is pushed while it balances loses its balance, steps, and only then;
//! who jumps takes no step; a foot that meets a sill in its swing is caught. Steps are on what is there.

use crate::engine_support::{add, app, body, run_ticks};
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy_athlete::contact::{Geometry, Material, Solid, Surface, World as Surroundings};
use bevy_athlete::engine::*;

#[derive(Resource, Default)]
struct Heard {
    steps: Vec<StepTaken>,
    stumbles: Vec<Stumbled>,
    footsteps: Vec<Footstep>,
    falls: usize,
}

fn listening() -> App {
    let mut app = app();
    app.init_resource::<Heard>();
    app.insert_resource(AthleteWorld::ground());
    app.add_observer(|step: On<StepTaken>, mut heard: ResMut<Heard>| heard.steps.push(step.event().clone()));
    app.add_observer(|stumble: On<Stumbled>, mut heard: ResMut<Heard>| heard.stumbles.push(stumble.event().clone()));
    app.add_observer(|step: On<Footstep>, mut heard: ResMut<Heard>| heard.footsteps.push(step.event().clone()));
    app.add_observer(|_: On<AthleteFell>, mut heard: ResMut<Heard>| heard.falls += 1);
    app
}

/// Performs a skill of the foot human until so much time has been simulated.
fn perform(app: &mut App, skill: &str, input: AthleteInput, seconds: f64) -> Entity {
    let assets = app.world().resource::<AssetServer>().clone();
    let athlete = app
        .world_mut()
        .spawn((
            Athlete(assets.load("characters/foot_human.character.ron")),
            AthleteController::skill(assets.load(format!("skills/{skill}.skill.ron"))),
            input,
        ))
        .id();
    for _ in 0..100_000 {
        app.update();
        if app.world().get::<AthleteBody>(athlete).is_some_and(|body| body.time() > seconds) {
            break;
        }
    }
    athlete
}

const WALK: &str = "walking/walk/walk";

#[test]
fn who_walks_steps_in_turn_and_does_not_stumble() {
    let mut app = listening();
    let athlete = perform(&mut app, WALK, AthleteInput::towards(Vec3::NEG_Z).at(1.2), 8.0);
    let way = -body(&app, athlete).simulator().state.root_position.lane(0).z;
    let heard = app.world().resource::<Heard>();
    let far: f64 = heard.steps.iter().filter(|s| s.foot == 0).map(|s| s.from.z - s.to.z).sum();
    println!("{} steps, the left foot came {far:.2} m far, the root {way:.2} m", heard.steps.len());
    for stumble in &heard.stumbles {
        println!("{stumble:?}");
    }
    // The strides of one foot add up to the way.
    assert!((far - way).abs() < 1.6, "{far} m, {way} m");
    assert!(heard.steps.len() >= 10 && heard.falls == 0);
    assert!(heard.steps.iter().all(|s| (0.05..1.0).contains(&s.airtime) && s.side.is_some()));
    let again = heard.steps.windows(2).filter(|w| w[0].foot == w[1].foot).count();
    assert!(again * 5 <= heard.steps.len(), "{again} of {} by the same foot again", heard.steps.len());
    assert!(heard.stumbles.is_empty(), "{:?}", heard.stumbles);
}

#[test]
fn a_foot_that_meets_a_sill_is_caught_and_falls_are_told_after_stumbles() {
    let mut app = listening();
    let mut world = Surroundings::ground();
    for k in 0..6 {
        let center = DVec3::new(0.0, 0.04, -2.3 - 0.35 * f64::from(k));
        let sill = Geometry::Box { center, half_extents: DVec3::new(2.0, 0.04, 0.02), rotation: DQuat::IDENTITY };
        world.solids.push(Solid::fixed(sill, Surface::WALL));
    }
    app.insert_resource(AthleteWorld(world));
    perform(&mut app, WALK, AthleteInput::towards(Vec3::NEG_Z).at(1.5), 6.0);
    let heard = app.world().resource::<Heard>();
    println!("{:?}; {} falls", heard.stumbles, heard.falls);
    let caught =
        |s: &Stumbled| matches!(s.cause, StumbleCause::FootCaught { speed, .. } if speed > StumbleCause::CAUGHT);
    assert!(!heard.stumbles.is_empty() && heard.stumbles.iter().all(caught));
    let on_wall = heard.footsteps.iter().filter(|s| s.material == Material::WALL).count();
    assert!(on_wall > 0, "a sole has stood on a sill");
}

#[test]
fn who_is_pushed_loses_balance_and_steps_and_who_is_not_does_not() {
    let mut app = listening();
    let file = add(&mut app, CharacterAsset::preset("foot_human").expect("a character"));
    let athlete = app.world_mut().spawn((Athlete(file), AthleteController::Balance(BalancePose::Rest))).id();
    run_ticks(&mut app, 192);
    let heard = app.world().resource::<Heard>();
    assert!(heard.steps.is_empty() && heard.stumbles.is_empty(), "{:?} {:?}", heard.steps, heard.stumbles);
    let begin = body(&app, athlete).time();
    let chest = body(&app, athlete).link("chest").expect("a chest");
    let position = body(&app, athlete).model().links[chest.index()].com;
    // From behind: it faces -Z.
    let push = AthleteForce { link: chest, position, force: DVec3::NEG_Z * 110.0, seconds: Some(0.4) };
    app.world_mut().get_mut::<AthleteForces>(athlete).expect("forces").push(push);
    run_ticks(&mut app, 192);
    let heard = app.world().resource::<Heard>();
    println!("{:?}", heard.stumbles);
    println!("{:?}", heard.steps);
    let lost = heard.stumbles.first().expect("a stumble");
    assert!(matches!(lost.cause, StumbleCause::BalanceLost { outside } if outside > StumbleCause::OUTSIDE));
    let step = heard.steps.first().expect("a step");
    assert!(begin < lost.time && lost.time < step.time, "{} s, {} s, {} s", begin, lost.time, step.time);
    assert!(step.from.z - step.to.z > 0.05, "a step ahead: {step:?}");
    assert!(heard.falls == 0 && heard.steps.len() <= 3, "{:?}", heard.steps);
}

#[test]
fn a_jump_on_both_feet_is_no_step_and_comes_down_harder_than_it_stands() {
    let mut app = listening();
    let athlete = perform(&mut app, "standing/in_place_jump/in_place_jump", AthleteInput::default(), 3.5);
    let weight = body(&app, athlete).model().mass() * 9.81;
    let heard = app.world().resource::<Heard>();
    let up = heard.footsteps.iter().filter(|s| s.phase == FootPhase::ToeOff).map(|s| s.time).fold(0.0, f64::max);
    let down: Vec<&Footstep> = heard.footsteps.iter().filter(|s| s.time > up && up > 0.0).collect();
    println!("up at {up:.2} s; {:?}; then {down:?}", heard.steps);
    // At its very start the body comes down onto its feet, one after the other.
    assert!(up > 0.5 && heard.steps.iter().all(|s| s.time < 0.5), "{:?}", heard.steps);
    let hardest = down.iter().map(|s| s.impulse.y).fold(0.0, f64::max);
    // Ten milliseconds of half the weight are what a foot that only stands would have.
    assert!(hardest > 0.010 * 0.5 * weight, "{hardest} N s");
    assert!(down.iter().all(|s| s.material == Material::GROUND));
}
