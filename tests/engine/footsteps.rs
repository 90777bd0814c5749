//! Contract: who walks is heard. Feet come down in turn, each goes through its phases in an order that feet can, and a foot that has left
//! the ground is pushed by nothing.

use crate::engine_support::{app, body};
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_athlete::engine::*;

#[derive(Resource, Default)]
struct Heard(Vec<Footstep>);

#[test]
fn feet_come_down_in_turn_and_each_goes_through_its_phases() {
    let mut app = app();
    app.init_resource::<Heard>();
    app.insert_resource(AthleteWorld::ground());
    app.add_observer(|step: On<Footstep>, mut heard: ResMut<Heard>| heard.0.push(step.event().clone()));
    let assets = app.world().resource::<AssetServer>().clone();
    let athlete = app
        .world_mut()
        .spawn((
            Athlete(assets.load("characters/foot_human.character.ron")),
            AthleteController::skill(assets.load("skills/walking/walk/walk.skill.ron")),
            AthleteInput { speed: Some(1.2), ..AthleteInput::towards(Vec3::NEG_Z) },
        ))
        .id();
    for _ in 0..100_000 {
        app.update();
        if app.world().get::<AthleteBody>(athlete).is_some_and(|body| body.time() > 6.0) {
            break;
        }
    }
    let weight = 9.81 * body(&app, athlete).model().mass();
    let heard = &app.world().resource::<Heard>().0;
    // The first contact of each stance.
    let (mut up, mut downs) = ([true; 2], Vec::new());
    for step in heard.iter().filter(|s| s.time > 1.0) {
        let lifted = std::mem::replace(&mut up[step.foot], step.phase == FootPhase::ToeOff);
        if lifted && step.phase != FootPhase::ToeOff {
            downs.push(step);
        }
    }
    let steps_a_second = downs.len() as f64 / 5.0;
    println!("{steps_a_second} steps a second");
    assert!((1.5..3.0).contains(&steps_a_second), "{steps_a_second} steps a second");
    for foot in 0..2 {
        let mut up = None;
        for step in heard.iter().filter(|s| s.foot == foot) {
            let lifts = step.phase == FootPhase::ToeOff;
            assert!(up != Some(true) || !matches!(step.phase, FootPhase::ToeOff | FootPhase::HeelOff), "{step:?}");
            up = Some(lifts);
            if lifts {
                assert_eq!((step.force, step.slip), (DVec3::ZERO, 0.0));
            } else {
                assert!(step.force.y > 0.0 && step.force.y < 10.0 * weight, "{step:?}");
                assert!(step.place.y.abs() < 0.02, "it acts on the ground: {step:?}");
            }
        }
    }
    // A foot that scuffs in its swing comes down twice.
    let again = downs.windows(2).filter(|w| w[0].side == w[1].side).count();
    assert!(
        again * 5 <= downs.len() && downs.iter().all(|s| s.side.is_some()),
        "{again} of {} come down again",
        downs.len()
    );
}
