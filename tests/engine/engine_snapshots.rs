//! Contract: a snapshot holds all that an athlete remembers.
//!
//! A body that is restored goes on with the same bytes as it had, whatever drives it: also in another program, from bytes,
//! and in the middle of a flight, a decision, a program. Going back again and again leaves no trace. Bytes that are no
//! snapshot, or one of something else, are refused with a typed error, and the body stays as it is.
//!
//! A check of the pose alone would pass with warm starts, the clock or the phase of a decision missing; here everything
//! that comes out of 600 more steps is compared, and the snapshot itself.

use crate::engine_support::*;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_athlete::dynamics::GripAnchor;
use bevy_athlete::engine::*;
use bevy_athlete::math::{RandomStream, Vec3 as CoreVec3};
use bevy_athlete::sim::ExternalForce;
use bevy_athlete::skill::{ProgramDefinition, ProgramElement};

const SKILLS: [&str; 3] = ["stroking", "forward_crossover", "two_foot_glide"];

/// Ways to drive a body.
const DRIVERS: [&str; 5] = ["hold", "play", "skill", "program", "steering"];

/// A skater that is driven in one of these ways.
fn spawn(app: &mut App, driver: &str) -> Entity {
    let character = skater_file(app);
    let place = Transform::from_xyz(3.0, 0.0, -2.0).with_rotation(Quat::from_rotation_y(0.7));
    let athlete = app.world_mut().spawn((Athlete(character), place)).id();
    let mut skills = || SKILLS.map(|name| add(app, shipped_skill(name)));
    match driver {
        "hold" => {}
        "play" => {
            let control = add(app, ControlAsset { control: std::sync::Arc::new(glide(2.0)) });
            app.world_mut().entity_mut(athlete).insert(AthleteController::Play(control));
        }
        "skill" => {
            let skill = skills()[1].clone();
            let input = AthleteInput { speed: Some(2.8), turn: 0.1, ..default() };
            app.world_mut().entity_mut(athlete).insert((AthleteController::skill(skill), input));
        }
        "program" => {
            let skills = skills().to_vec();
            let element =
                |k: usize| ProgramElement { skill: SKILLS[k].into(), seconds: 1.0, speed: None, steering: 0.0 };
            let elements = (0..SKILLS.len()).map(element).collect();
            let program = ProgramDefinition { name: "three".into(), character: "skater".into(), elements };
            let program = add(app, ProgramAsset { program, skills });
            app.world_mut().entity_mut(athlete).insert(AthleteController::Program(program));
        }
        _ => {
            let skills = skills().to_vec();
            let input = AthleteInput::towards(Vec3::X).at(2.5);
            app.world_mut().entity_mut(athlete).insert((AthleteController::steer(skills), input));
        }
    }
    app.update();
    if driver == "hold" {
        // One hand holds on, and somebody pulls: state that only such bodies have.
        let mut body = body_mut(app, athlete);
        let hand = body.simulator_mut().kinematics().len() - 1;
        let sim = body.simulator_mut();
        sim.hold(0, 0, GripAnchor::Fixed(DVec3::new(3.0, 1.2, -2.3)));
        let force = CoreVec3::splat(DVec3::new(8.0, 0.0, 3.0));
        sim.external.push(ExternalForce { link: hand, position: CoreVec3::zero(), force });
        sim.commands[4].torque = CoreVec3::splat(DVec3::new(0.5, 0.0, 0.0));
        sim.friction_scale = 0.7;
    }
    athlete
}

/// 600 steps: 32 ticks of 18 or 19.
const SPAN: usize = 32;

#[test]
fn a_restored_body_goes_on_with_the_same_bytes_whatever_drives_it() {
    for driver in DRIVERS {
        // At several moments: at rest, within decisions, past the end of the control, across changes of skills.
        for before in [1, 37, 140] {
            let mut app = app();
            let athlete = spawn(&mut app, driver);
            run_ticks(&mut app, before);
            let snapshot = body(&app, athlete).snapshot();
            run_ticks(&mut app, SPAN);
            let straight = body(&app, athlete).snapshot();
            let moved = straight != snapshot;
            body_mut(&mut app, athlete).restore(&snapshot).unwrap();
            assert!(body(&app, athlete).snapshot() == snapshot, "{driver}: not what was put in");
            run_ticks(&mut app, SPAN);
            let again = body(&app, athlete).snapshot();

            // In another program, whose body is somewhere else by now.
            let bytes = snapshot.to_bytes();
            let mut other = crate::engine_support::app();
            let twin = spawn(&mut other, driver);
            run_ticks(&mut other, 11);
            let read = AthleteSnapshot::from_bytes(&bytes).unwrap();
            body_mut(&mut other, twin).restore(&read).unwrap();
            run_ticks(&mut other, SPAN);
            let elsewhere = body(&other, twin).snapshot();
            println!(
                "{driver} after {before} ticks: {} bytes, same {}, elsewhere {}",
                bytes.len(),
                again == straight,
                elsewhere == straight
            );
            assert!(moved, "{driver}: nothing moved");
            assert!(again == straight, "{driver}: another motion after restoring");
            assert_eq!(elsewhere.to_bytes(), straight.to_bytes(), "{driver}: another motion in another program");
        }
    }
}

#[test]
fn a_thousand_rewinds_change_nothing() {
    let mut app = app();
    let athlete = spawn(&mut app, "steering");
    app.world_mut().entity_mut(athlete).insert(AthleteHistory::new(2.0));
    run_ticks(&mut app, 20);

    // What it is like without any.
    let mut straight = crate::engine_support::app();
    let twin = spawn(&mut straight, "steering");
    run_ticks(&mut straight, 20);

    let mut reference = vec![body(&straight, twin).snapshot()];
    let mut random = RandomStream::new(5, 0);
    let mut ticks = 0;
    for k in 0..1000 {
        let back = 1 + random.below(12);
        let rewind = AthleteRewind { entity: athlete, seconds: back as f32 / 64.0 };
        if k % 2 == 0 {
            app.world_mut().trigger(rewind);
        } else {
            app.world_mut().write_message(rewind);
        }
        run_ticks(&mut straight, 1);
        reference.push(body(&straight, twin).snapshot());
        run_ticks(&mut app, back + 1);
        ticks += back + 1;
        let now = body(&app, athlete).snapshot();
        assert!(now == reference[k + 1], "rewind {k}, by {back} ticks");
    }
    let history = app.world().get::<AthleteHistory>(athlete).unwrap();
    println!("{ticks} ticks simulated, {} kept: {:.2} s, {} bytes", history.len(), history.span(), history.size());
    assert!((history.span() - 2.0).abs() < 0.02);
    // The poses that are drawn went along.
    let poses = app.world().get::<LinkPoses>(athlete).unwrap();
    let root = body(&app, athlete).simulator().state.root_position.lane(0);
    assert_eq!(poses.current[0].position, root);
}

#[test]
fn a_rewind_acts_while_time_stands_still_and_undoes_a_quarantine() {
    let mut app = app();
    let athlete = spawn(&mut app, "skill");
    app.world_mut().entity_mut(athlete).insert(AthleteHistory::default());
    run_ticks(&mut app, 64);
    let (time, good) = (body(&app, athlete).time(), body(&app, athlete).snapshot());
    body_mut(&mut app, athlete).simulator_mut().state.root_velocity.linear = CoreVec3::splat(DVec3::NAN);
    run_ticks(&mut app, 4);
    assert_eq!(body(&app, athlete).status(), BodyStatus::Quarantined);
    app.world_mut().resource_mut::<PlaybackSpeed>().paused = true;
    app.update();
    app.world_mut().write_message(AthleteRewind { entity: athlete, seconds: 0.5 });
    app.update();
    let back = body(&app, athlete);
    assert_eq!(back.status(), BodyStatus::Running);
    assert!((time - back.time() - 0.5).abs() < 1e-3, "{} s", back.time());
    let shown = app.world().get::<Transform>(athlete).unwrap().translation;
    assert!((shown - back.simulator().state.root_position.lane(0).as_vec3()).length() < 1e-5);
    app.world_mut().resource_mut::<PlaybackSpeed>().paused = false;
    run_ticks(&mut app, 33);
    assert!(body(&app, athlete).snapshot() == good, "it does not come by where it was");
}

#[test]
fn a_controller_of_before_comes_back_with_the_snapshot() {
    let mut app = app();
    let athlete = spawn(&mut app, "skill");
    run_ticks(&mut app, 30);
    let snapshot = body(&app, athlete).snapshot();
    run_ticks(&mut app, SPAN);
    let straight = body(&app, athlete).snapshot();
    app.world_mut().entity_mut(athlete).insert(AthleteController::Hold);
    run_ticks(&mut app, 5);
    assert!(body(&app, athlete).skill_player().is_none());
    // From bytes the body's own driver has to be the one.
    let bytes = snapshot.to_bytes();
    let before = body(&app, athlete).snapshot();
    let refused = body_mut(&mut app, athlete).restore(&AthleteSnapshot::from_bytes(&bytes).unwrap()).unwrap_err();
    println!("{refused}");
    assert!(matches!(refused, SnapshotError::Controller { .. }));
    assert!(body(&app, athlete).snapshot() == before);
    // From memory it comes along.
    body_mut(&mut app, athlete).restore(&snapshot).unwrap();
    assert!(body(&app, athlete).skill_player().is_some());
    run_ticks(&mut app, SPAN);
    // The wishes of the removed component stay as they were.
    assert!(body(&app, athlete).snapshot() == straight);
}

/// 64-bit FNV-1a, as at the end of a snapshot.
fn checksum(bytes: &[u8]) -> [u8; 8] {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
        .to_le_bytes()
}

#[test]
fn what_is_no_snapshot_or_another_ones_is_refused() {
    let mut app = app();
    let athlete = spawn(&mut app, "program");
    run_ticks(&mut app, 30);
    let good = body(&app, athlete).snapshot().to_bytes();
    assert_eq!(AthleteSnapshot::from_bytes(&good).unwrap().to_bytes(), good);
    for cut in 0..good.len() {
        assert!(AthleteSnapshot::from_bytes(&good[..cut]).is_err(), "{cut} of {} bytes", good.len());
    }
    let changed = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 1;
        AthleteSnapshot::from_bytes(&bytes).unwrap_err()
    };
    assert_eq!(changed(0), SnapshotError::NotASnapshot);
    assert_eq!(
        changed(8),
        SnapshotError::Version { found: AthleteSnapshot::VERSION ^ 1, supported: AthleteSnapshot::VERSION }
    );
    assert!(matches!(changed(good.len() / 2), SnapshotError::Damaged { .. }));

    let runner = std::sync::Arc::new(bevy_athlete::model::CharacterModel::clone(
        &bevy_athlete::model::preset("runner").unwrap(),
    ));
    let mut other = AthleteBody::new(runner, Placement::default());
    let refused = other.restore(&AthleteSnapshot::from_bytes(&good).unwrap()).unwrap_err();
    println!("{refused}");
    assert!(matches!(refused, SnapshotError::Character { .. }));

    // Contents that were tampered with under a good checksum: refused and nothing changed, or taken; never a panic, also
    // not in what follows.
    let mut random = RandomStream::new(6, 0);
    let (mut refusals, mut taken) = (0, 0);
    for _ in 0..400 {
        let mut bytes = good.clone();
        let end = bytes.len() - 8;
        for _ in 0..1 + random.below(4) {
            let at = 16 + random.below(end - 16);
            bytes[at] = if random.below(2) == 0 { 0xff } else { random.bits() as u8 };
        }
        let seal = checksum(&bytes[..end]);
        bytes[end..].copy_from_slice(&seal);
        let before = body(&app, athlete).snapshot();
        let result = AthleteSnapshot::from_bytes(&bytes).and_then(|s| body_mut(&mut app, athlete).restore(&s));
        match result {
            Err(_) => {
                refusals += 1;
                assert!(body(&app, athlete).snapshot() == before, "a refused snapshot left traces");
            }
            Ok(()) => {
                taken += 1;
                // Wild numbers may mean very many steps a tick; the rate is one of them.
                if body(&app, athlete).simulator().settings().rate <= 1200.0 {
                    run_ticks(&mut app, 2);
                }
                body_mut(&mut app, athlete).restore(&AthleteSnapshot::from_bytes(&good).unwrap()).unwrap();
            }
        }
    }
    println!("{refusals} refused, {taken} taken");
    assert!(refusals > 20 && taken > 20);
    run_ticks(&mut app, 2);
}
