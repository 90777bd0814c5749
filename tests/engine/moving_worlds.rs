//! Contract: snapshots, rewinds and lanes hold on a course whose solids move, with hands that hold on to them.
//!
//! A grip on a solid that moves belongs to the body (what it holds, how far it has slipped, the impulse that its next step starts from), the
//! solid to the world, which is the game's to put back: here its solids follow from the athletes' own time. Going on from a
//! snapshot or a rewind gives the same bytes as never having stopped; athletes in lanes have the bytes of each alone, on
//! a common world and in an arena. Nothing of that could show on ice at rest.

use crate::engine_support::*;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_athlete::asset::{Course, CourseInstance};
use bevy_athlete::contact::World as Surroundings;
use bevy_athlete::dynamics::GripAnchor;
use bevy_athlete::engine::*;

/// A rail that sways at the height of a hand, a slab that comes and goes underfoot, and one that pushes against the legs; on ice.
fn course(hand: DVec3) -> CourseInstance {
    let text = format!(
        r#"(
        name: "moving",
        ground: (material: "ice", friction: 0.02),
        solids: [
            Rail(ahead: {}, right: {}, up: {}, length: 0.2, radius: 0.02, motion: Sway(along: (0.5, 1, 1), amplitude: 0.03, frequency: 0.5)),
            Box(ahead: -0.4, up: -0.2, depth: 1.2, width: 3, height: 0.205, material: "ice", motion: Cross(by: (0.3, 0, 0.6), speed: 0.5)),
            Box(ahead: 0.5, depth: 0.1, width: 3, height: 0.4, motion: Cross(by: (0, 0, -0.15), speed: 0.3)),
        ],
    )"#,
        -hand.z,
        hand.x,
        hand.y - BELOW
    );
    let course = Course::parse("moving.course.ron", text.as_bytes()).unwrap();
    course.instance(&[], 0).unwrap()
}

/// How far below the hands the axis of the rail is, m.
const BELOW: f64 = 0.055;
/// The rail as the world counts: after the ground.
const RAIL: usize = 1;

/// The course that a world shows, and whose time it goes by.
#[derive(Component)]
struct Moves(CourseInstance, Option<Entity>);

/// Worlds are where their course is at the time of their athlete.
fn move_worlds(
    mut worlds: Query<(&Moves, &mut ArenaWorld)>,
    bodies: Query<&AthleteBody>,
    mut common: ResMut<AthleteWorld>,
) {
    for (Moves(course, clock), mut world) in &mut worlds {
        let time = clock.and_then(|athlete| bodies.get(athlete).ok()).map_or(0.0, AthleteBody::time);
        world.solids = Surroundings::course_solids(course, time).unwrap();
        common.solids.clone_from(&world.solids);
    }
}

fn moving_app(lanes: bool) -> App {
    let mut app = app();
    app.insert_resource(AthleteLanes(lanes));
    app.add_systems(FixedUpdate, move_worlds);
    app
}

/// Where the first hand of a skater is that has just been spawned at the origin.
fn hand() -> DVec3 {
    let mut body = AthleteBody::new(bevy_athlete::model::skater(), Placement::default());
    body.simulator_mut().grip_position(0, 0).expect("a hand")
}

/// Athletes of these kinds in an arena with that course; all start at the same place, and do not feel each other.
fn crowd(app: &mut App, count: usize, in_arena: bool) -> Vec<Entity> {
    let (file, skill) = (skater_file(app), add(app, shipped_skill("stroking")));
    let control = add(app, ControlAsset::from(glide(0.5)));
    let course = course(hand());
    let arena = app.world_mut().spawn((ArenaWorld(Surroundings::empty()), Moves(course, None))).id();
    let crowd: Vec<Entity> = (0..count)
        .map(|k| {
            let controller = match k % 3 {
                0 => AthleteController::Hold,
                1 => AthleteController::skill(skill.clone()),
                _ => AthleteController::Play(control.clone()),
            };
            let athlete = app.world_mut().spawn((Athlete(file.clone()), controller)).id();
            if in_arena {
                app.world_mut().entity_mut(athlete).insert(InArena(arena));
            }
            athlete
        })
        .collect();
    app.world_mut().get_mut::<Moves>(arena).unwrap().1 = Some(crowd[0]);
    run_ticks(app, 1);
    for (k, athlete) in crowd.iter().enumerate() {
        let mut body = body_mut(app, *athlete);
        let sim = body.simulator_mut();
        let on_it = DVec3::new(0.01 * k as f64, BELOW, 0.0);
        match k % 4 {
            3 => {}
            2 => sim.hold(0, 0, GripAnchor::Fixed(hand())),
            _ => sim.hold(0, 0, GripAnchor::Solid { solid: RAIL, place: on_it }),
        }
    }
    crowd
}

fn holds_the_rail(app: &App, athlete: Entity) -> bool {
    let anchor = body(app, athlete).simulator().state.anchor(0, 0);
    matches!(anchor, Some(GripAnchor::Solid { solid: RAIL, .. }))
}

#[test]
fn a_snapshot_with_a_hand_on_a_moving_rail_goes_on_with_the_same_bytes() {
    for who in 0..3 {
        // At several moments: the rail on its way up and down, the slab under the blades or not.
        for before in [2, 21, 60] {
            let mut app = moving_app(true);
            let crowd = crowd(&mut app, who + 1, true);
            let athlete = crowd[who];
            run_ticks(&mut app, before);
            let held = holds_the_rail(&app, athlete);
            let hand_before = body_mut(&mut app, athlete).simulator_mut().grip_position(0, 0).unwrap();
            let snapshots: Vec<_> = crowd.iter().map(|e| body(&app, *e).snapshot()).collect();
            run_ticks(&mut app, 32);
            let straight = body(&app, athlete).snapshot();
            let force = body(&app, athlete).simulator().grip_force(0, 0).length();
            let hand_moved =
                (body_mut(&mut app, athlete).simulator_mut().grip_position(0, 0).unwrap() - hand_before).length();
            for (e, snapshot) in crowd.iter().zip(&snapshots) {
                body_mut(&mut app, *e).restore(snapshot).unwrap();
            }
            assert!(body(&app, athlete).snapshot() == snapshots[who]);
            assert_eq!(holds_the_rail(&app, athlete), held);
            run_ticks(&mut app, 32);
            let again = body(&app, athlete).snapshot();
            // From bytes, in another program.
            let mut other = moving_app(false);
            let twins = self::crowd(&mut other, who + 1, true);
            run_ticks(&mut other, 7);
            for (e, snapshot) in twins.iter().zip(&snapshots) {
                let read = AthleteSnapshot::from_bytes(&snapshot.to_bytes()).unwrap();
                body_mut(&mut other, *e).restore(&read).unwrap();
            }
            run_ticks(&mut other, 32);
            let elsewhere = body(&other, twins[who]).snapshot();
            println!(
                "{who} after {before} ticks: on the rail {held}, {force:.0} N, its hand moved by {hand_moved:.3} m"
            );
            assert!(again == straight, "{who} after {before} ticks: another motion after restoring");
            assert!(elsewhere == straight, "{who} after {before} ticks: another motion in another program");
            assert!(who > 1 || before > 30 || held, "{who}: it should hold on");
            assert!(hand_moved > 0.005);
        }
    }
}

#[test]
fn rewinds_on_a_moving_course_change_nothing() {
    let mut app = moving_app(true);
    let athlete = crowd(&mut app, 1, true)[0];
    app.world_mut().entity_mut(athlete).insert(AthleteHistory::new(1.0));
    run_ticks(&mut app, 10);
    let mut straight = moving_app(true);
    let twin = crowd(&mut straight, 1, true)[0];
    run_ticks(&mut straight, 10);
    let mut random = bevy_athlete::math::RandomStream::new(12, 0);
    let mut held = 0;
    for k in 0..120 {
        let back = 1 + random.below(8);
        let rewind = AthleteRewind { entity: athlete, seconds: back as f32 / 64.0 };
        if k % 2 == 0 {
            app.world_mut().trigger(rewind);
        } else {
            app.world_mut().write_message(rewind);
        }
        run_ticks(&mut straight, 1);
        run_ticks(&mut app, back + 1);
        held += usize::from(holds_the_rail(&app, athlete));
        assert!(body(&app, athlete).snapshot() == body(&straight, twin).snapshot(), "rewind {k}, by {back} ticks");
    }
    println!("on the rail after {held} of 120 rewinds");
    assert!(held > 30);
}

#[test]
fn company_does_not_show_on_a_moving_course() {
    // The bytes of everybody after each tick, and how often a hand was on the rail.
    let bytes = |count: usize, lanes: bool, in_arena: bool| {
        let mut app = moving_app(lanes);
        let crowd = crowd(&mut app, count, in_arena);
        let (mut ticks, mut held) = (Vec::new(), 0);
        for _ in 0..50 {
            app.update();
            held += crowd.iter().filter(|e| holds_the_rail(&app, **e)).count();
            ticks.push(crowd.iter().map(|e| body(&app, *e).snapshot().to_bytes()).collect::<Vec<_>>());
        }
        (ticks, held)
    };
    let (alone, held) = bytes(9, false, true);
    println!("9 athletes held the rail in {held} of 450 ticks");
    assert!(held > 100);
    for in_arena in [true, false] {
        for count in [9, 7, 5, 2] {
            let (together, _) = bytes(count, true, in_arena);
            for (tick, (together, alone)) in together.iter().zip(&alone).enumerate() {
                for (k, (a, b)) in together.iter().zip(alone).enumerate() {
                    let at = a.iter().zip(b).position(|(a, b)| a != b);
                    assert!(
                        a == b,
                        "tick {tick}, athlete {k} of {count}, in an arena {in_arena}: byte {at:?} of {}",
                        a.len()
                    );
                }
            }
        }
    }
}
