//! Contract: an athlete is the body and is at the place that it was given, not what its name or its local transform suggests.
//!
//! Skills are made for the body that performs them; one that does not fit is refused with a reason and the athlete holds, whatever it is
//! called. (A body that was called like a preset was taken for it, and the game panicked.) Models are told apart by their numbers.
//! A child of a moved parent starts where both put it, and its entity stays where its body is, whatever the parent does. Athletes
//! in different arenas stand on different worlds, with the bits that they have alone.

use super::engine_support::*;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_athlete::asset::{Character, JointEntry};
use bevy_athlete::contact::World as Surroundings;
use bevy_athlete::engine::*;
use bevy_athlete::model::{CharacterModel, SharedModel, preset_source};
use bevy_athlete::skill::NoEntry;
use std::sync::Arc;

/// The skater's file, changed, as a user's own character.
fn own_skater(change: impl FnOnce(&mut Character)) -> SharedModel {
    let (file, text) = preset_source("skater").unwrap();
    let mut character = Character::parse(file, text.as_bytes()).unwrap();
    change(&mut character);
    Arc::new(CharacterModel::build(&character).unwrap())
}

fn weld_head(character: &mut Character) {
    let head = character.links.iter_mut().find(|l| l.name == "head").unwrap();
    (head.joint, head.limits, head.max_torque, head.gains) = (JointEntry::Weld, None, None, None);
}

fn reasons(app: &mut App) -> Vec<(Entity, String)> {
    let mut messages = app.world_mut().resource_mut::<Messages<AthleteRefused>>();
    messages.drain().map(|r| (r.entity, r.reason.to_string())).collect()
}

#[test]
fn a_body_that_is_only_called_like_a_preset_holds() {
    let mut app = app();
    let file = add(&mut app, CharacterAsset { model: own_skater(weld_head) });
    let stroking = add(&mut app, shipped_skill("stroking"));
    let glide = add(&mut app, shipped_skill("two_foot_glide"));
    for controller in [
        AthleteController::skill(stroking.clone()),
        AthleteController::skill(glide.clone()),
        AthleteController::steer([stroking.clone(), glide.clone()]),
    ] {
        let athlete = app.world_mut().spawn((Athlete(file.clone()), controller)).id();
        // A message is kept for two frames.
        let mut told = Vec::new();
        for _ in 0..8 {
            run_ticks(&mut app, 1);
            told.extend(reasons(&mut app));
        }
        println!("{told:?}");
        assert!(matches!(&told[..], [(who, why)] if *who == athlete && why.contains("skater")), "{told:?}");
        let body = body(&app, athlete);
        assert!(body.director().is_none() && body.status() == BodyStatus::Running && body.time() > 0.1, "it holds");
        // What fits is taken afterwards.
        app.world_mut().entity_mut(athlete).insert(AthleteController::Hold);
        run_ticks(&mut app, 2);
        assert!(reasons(&mut app).is_empty());
    }
    // The same skill goes on with the preset.
    let file = skater_file(&mut app);
    let skater = app.world_mut().spawn((Athlete(file), AthleteController::skill(stroking))).id();
    run_ticks(&mut app, 8);
    assert!(body(&app, skater).director().is_some() && reasons(&mut app).is_empty());
}

#[test]
fn models_are_compared_by_their_numbers() {
    let (a, b) = (own_skater(|_| {}), own_skater(|_| {}));
    assert!(!Arc::ptr_eq(&a, &b));
    // What was made for one is there for the other.
    let skill = shipped_skill("stroking");
    assert!(Arc::ptr_eq(&skill.bind(&a).unwrap(), &skill.bind(&b).unwrap()));

    let snapshot = |model: &SharedModel| AthleteBody::new(model.clone(), Placement::default()).snapshot();
    let mut body = AthleteBody::new(a.clone(), Placement::default());
    let renamed = own_skater(|c| c.name = "somebody".into());
    let heavier = own_skater(|c| c.links[3].mass += 0.01);
    for (model, fits) in [(&b, true), (&renamed, true), (&heavier, false)] {
        let taken = snapshot(model);
        let read = AthleteSnapshot::from_bytes(&taken.to_bytes()).unwrap();
        assert_eq!(body.restore(&taken).is_ok(), fits, "{}", model.name);
        match body.restore(&read) {
            Ok(()) => assert!(fits),
            Err(error) => assert!(!fits && matches!(error, SnapshotError::Character { .. }), "{error}"),
        }
    }
}

#[test]
fn a_child_of_a_moved_parent_is_where_both_put_it() {
    let mut app = app();
    let file = skater_file(&mut app);
    let quarter = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let place = Transform::from_xyz(10.0, 0.0, 4.0).with_rotation(quarter);
    let parent = app.world_mut().spawn(place).id();
    let control = add(&mut app, ControlAsset::from(glide(1.0)));
    let local = Transform::from_xyz(2.0, 0.0, 0.0);
    let athlete = app
        .world_mut()
        .spawn((Athlete(file.clone()), AthleteController::Play(control.clone()), local, ChildOf(parent)))
        .id();
    // One that stands in the world where that one should.
    let twin = app.world_mut().spawn((Athlete(file), AthleteController::Play(control), place * local)).id();
    let root = |app: &App, who: Entity| body(app, who).simulator().state.root_position.lane(0);
    // Two units along the parent's +X, which is the world's -Z; ahead is the world's -X.
    for k in 0..24 {
        app.update();
        if k == 11 {
            // A parent that goes elsewhere takes nobody with it.
            app.world_mut().get_mut::<Transform>(parent).unwrap().translation = Vec3::new(-3.0, 1.0, 7.0);
            app.update();
        }
        let apart = root(&app, athlete).distance(root(&app, twin));
        assert!(apart < 1e-4, "{apart} m from one that was spawned in the world");
        let shown = |who: Entity| {
            let mut chain = Transform::IDENTITY;
            let mut at = Some(who);
            while let Some(entity) = at {
                chain = *app.world().get::<Transform>(entity).unwrap() * chain;
                at = app.world().get::<ChildOf>(entity).map(|c| c.parent());
            }
            chain
        };
        let (child, alone) = (shown(athlete), shown(twin));
        let apart = child.translation.distance(alone.translation);
        assert!(apart < 1e-4, "shown {apart} m from where it is: {child:?}, {alone:?}");
        assert!(child.rotation.angle_between(alone.rotation) < 1e-3);
    }
    let at = root(&app, athlete);
    assert!(at.distance(DVec3::new(10.0, at.y, 2.0)) < 1.2 && at.x < 9.8, "{at}");

    // A parent's size is refused like an own one.
    let big = app.world_mut().spawn(Transform::from_scale(Vec3::splat(2.0))).id();
    let file = skater_file(&mut app);
    let child = app.world_mut().spawn((Athlete(file), ChildOf(big))).id();
    run_ticks(&mut app, 2);
    assert!(matches!(app.world().get::<Refused>(child), Some(Refused(AthleteRefusal::Scale { .. }))));
}

#[test]
fn arenas_have_worlds_of_their_own() {
    // Two on ice of their own, two on the common ground, all gliding by the same control.
    let run = |arenas: [bool; 4], lanes: bool| {
        let mut app = app();
        app.insert_resource(AthleteWorld::ground());
        app.insert_resource(AthleteLanes(lanes));
        let rink = app.world_mut().spawn(ArenaWorld(Surroundings::ice())).id();
        let (file, control) = (skater_file(&mut app), add(&mut app, ControlAsset::from(glide(1.0))));
        let athletes = arenas.map(|on_ice| {
            let athlete = app.world_mut().spawn((Athlete(file.clone()), AthleteController::Play(control.clone()))).id();
            if on_ice {
                app.world_mut().entity_mut(athlete).insert(InArena(rink));
            }
            athlete
        });
        run_ticks(&mut app, 32);
        athletes.map(|who| body(&app, who).simulator().state.fingerprint(0))
    };
    let mixed = run([true, false, true, false], true);
    println!("{mixed:016x?}");
    assert_eq!(mixed[0], mixed[2]);
    assert_eq!(mixed[1], mixed[3]);
    assert!(mixed[0] != mixed[1], "ice and ground are the same");
    assert_eq!(mixed, run([true, false, true, false], false), "lanes show");
    assert_eq!(mixed[0], run([true; 4], true)[0]);
    assert_eq!(mixed[1], run([false; 4], true)[1]);
}

#[test]
fn an_entity_follows_a_link_by_its_name() {
    let mut app = app();
    let (file, control) = (skater_file(&mut app), add(&mut app, ControlAsset::from(glide(1.0))));
    let place = Transform::from_xyz(4.0, 0.0, -1.0).with_rotation(Quat::from_rotation_y(0.8));
    let athlete = app.world_mut().spawn((Athlete(file), AthleteController::Play(control), place)).id();
    let local = Transform::from_xyz(0.0, 0.1, -0.2).with_rotation(Quat::from_rotation_x(0.3));
    let lamp = app.world_mut().spawn((AtLink::new("head").with_place(local), ChildOf(athlete))).id();
    let lost = app.world_mut().spawn((AtLink::new("tail"), ChildOf(athlete))).id();
    run_ticks(&mut app, 20);
    let body = body(&app, athlete);
    let head = body.link("head").unwrap();
    assert_eq!((head.name(body.model()), body.link("tail")), (Some("head"), None));
    let wanted = app.world().get::<LinkPoses>(athlete).unwrap().link(head) * local;
    let at = |who: Entity| *app.world().get::<Transform>(who).unwrap();
    let found = at(athlete) * at(lamp);
    assert!(found.translation.distance(wanted.translation) < 1e-5, "{found:?}, {wanted:?}");
    assert!(found.rotation.angle_between(wanted.rotation) < 1e-3);
    assert_eq!(at(lost), Transform::IDENTITY, "no such link");
}

/// What came of requests.
#[derive(Resource, Default)]
struct Answers(Vec<(Entity, String, Option<NoEntry>)>);

#[test]
fn a_request_is_answered() {
    let mut app = app();
    app.init_resource::<Answers>();
    app.add_observer(|event: On<SkillStarted>, mut answers: ResMut<Answers>| {
        answers.0.push((event.entity, event.skill.clone(), None));
    });
    app.add_observer(|event: On<SkillRefused>, mut answers: ResMut<Answers>| {
        answers.0.push((event.entity, event.skill.clone(), Some(event.reason.clone())));
    });
    let file = skater_file(&mut app);
    let skills = ["stroking", "forward_three_turn"].map(|name| add(&mut app, shipped_skill(name)));
    let input = AthleteInput::default().at(2.5);
    let steered = app.world_mut().spawn((Athlete(file.clone()), AthleteController::steer(skills.clone()), input)).id();
    let holding = app.world_mut().spawn((Athlete(file), Transform::from_xyz(30.0, 0.0, 0.0))).id();
    // Before there is a body, there is nobody to ask.
    app.world_mut().trigger(PerformSkill::new(steered, "forward_three_turn"));
    run_ticks(&mut app, 30);
    app.world_mut().write_message(PerformSkill::new(steered, "forward_three_turn"));
    app.world_mut().trigger(PerformSkill::new(steered, "axel"));
    app.world_mut().write_message(PerformSkill::new(holding, "stroking"));
    run_ticks(&mut app, 64 * 4);
    let answers = std::mem::take(&mut app.world_mut().resource_mut::<Answers>().0);
    println!("{answers:?}");
    let of = |who: Entity, skill: &str| {
        let all = answers.iter().filter(|(entity, name, _)| *entity == who && name == skill);
        all.map(|(.., reason)| reason.clone()).collect::<Vec<_>>()
    };
    assert_eq!(of(steered, "forward_three_turn"), [Some(NoEntry::NotSimulated), None]);
    assert!(matches!(&of(steered, "axel")[..], [Some(NoEntry::Unknown { known })] if known.len() == 2));
    assert_eq!(of(holding, "stroking"), [Some(NoEntry::NotSteered)]);
    assert_eq!(of(steered, "stroking")[0], None, "it began with the first skill");
}

/// A block of ice on the ground, its top at `height`.
fn block(height: f64) -> Surroundings {
    use bevy_athlete::contact::{Geometry, Solid, Surface};
    let mut world = Surroundings::ground();
    let geometry = Geometry::Box {
        center: DVec3::Y * (0.5 * height),
        half_extents: DVec3::new(60.0, 0.5 * height, 60.0),
        rotation: bevy::math::DQuat::IDENTITY,
    };
    world.solids.push(Solid::fixed(geometry, Surface::ICE));
    world
}

/// A skill that was learnt on level ice at y = 0 is performed on a block of it: the skater is put onto the block, not into it, and
/// strokes on. (It once lay there, started inside the block.)
#[test]
fn a_skill_goes_on_on_a_raised_block() {
    let mut app = app();
    let file = skater_file(&mut app);
    let stroking = add(&mut app, shipped_skill("stroking"));
    app.insert_resource(AthleteWorld(block(0.5)));
    let at = Transform::from_xyz(0.0, 0.5, 20.0);
    let skater = app.world_mut().spawn((Athlete(file), AthleteController::skill(stroking), at)).id();
    run_ticks(&mut app, 2);
    let start = body(&app, skater).simulator().state.root_position.lane(0);
    let (mut lowest, mut highest) = (f64::INFINITY, 0.0_f64);
    for _ in 0..8 * 64 {
        app.update();
        let y = body(&app, skater).simulator().state.root_position.lane(0).y - 0.5;
        (lowest, highest) = (lowest.min(y), highest.max(y));
    }
    let way = (body(&app, skater).simulator().state.root_position.lane(0) - start).length();
    println!("pelvis {lowest:.2} to {highest:.2} m above the block, {way:.1} m on the way");
    assert!(lowest > 0.6 && highest < 1.0, "pelvis {lowest} to {highest} m above the block");
    assert!(way > 8.0, "{way} m");
}
