//! Contract: an athlete that is told to balance stands without a policy, takes another pose of its feet when it is told to, goes on from a
//! snapshot with the same bits, and is refused where its feet lack what the pose stands on.

use crate::engine_support::{add, app, body};
use bevy::prelude::*;
use bevy_athlete::engine::*;

fn stands(app: &App, athlete: Entity) -> (f64, f64) {
    let body = body(app, athlete);
    let root = body.simulator().state.root_position.lane(0);
    (root.y, body.time())
}

fn spawn(app: &mut App, character: &str, pose: BalancePose) -> Entity {
    app.insert_resource(AthleteWorld(bevy_athlete::contact::World::ground()));
    let file = add(app, CharacterAsset::preset(character).expect("a character"));
    app.world_mut().spawn((Athlete(file), AthleteController::Balance(pose))).id()
}

#[test]
fn it_stands_and_goes_over_to_its_toes() {
    let mut app = app();
    let athlete = spawn(&mut app, "foot_human", BalancePose::Rest);
    for _ in 0..128 {
        app.update();
    }
    let (rest, time) = stands(&app, athlete);
    assert!(time > 1.9 && body(&app, athlete).quarantine_reason().is_none());
    assert!(rest > 0.7, "{rest} m");
    *app.world_mut().get_mut::<AthleteController>(athlete).expect("a controller") =
        AthleteController::Balance(BalancePose::Tiptoe);
    let restarted = |app: &App| body(app, athlete).time() < time;
    for _ in 0..192 {
        app.update();
    }
    let (tiptoe, _) = stands(&app, athlete);
    println!("root at {rest:.3} m, on the toes at {tiptoe:.3} m");
    assert!(!restarted(&app), "it goes over, it does not begin anew");
    assert!(tiptoe > rest + 0.01, "{tiptoe} m, {rest} m");
}

#[test]
fn a_snapshot_goes_on_with_the_same_bits() {
    let mut app = app();
    let athlete = spawn(&mut app, "foot_human", BalancePose::Rest);
    for _ in 0..40 {
        app.update();
    }
    let snapshot = body(&app, athlete).snapshot();
    let go = |app: &mut App| {
        for _ in 0..40 {
            app.update();
        }
        body(app, athlete).simulator().state.root_position.lane(0)
    };
    let first = go(&mut app);
    app.world_mut().get_mut::<AthleteBody>(athlete).expect("a body").restore(&snapshot).expect("its own snapshot");
    assert_eq!(first, go(&mut app));
}

#[derive(Resource, Default)]
struct Refusals(Vec<AthleteRefusal>);

#[test]
fn feet_that_cannot_stand_so_are_refused() {
    let mut app = app();
    app.init_resource::<Refusals>();
    app.add_observer(|refused: On<AthleteRefused>, mut all: ResMut<Refusals>| all.0.push(refused.reason.clone()));
    // On blades nobody stands by segments of a foot.
    let athlete = spawn(&mut app, "skater", BalancePose::Rest);
    for _ in 0..4 {
        app.update();
    }
    let all = &app.world().resource::<Refusals>().0;
    println!("{all:?}");
    assert!(matches!(all.as_slice(), [AthleteRefusal::Balance(_)]), "{all:?}");
    assert!(body(&app, athlete).quarantine_reason().is_none(), "it holds");
}
