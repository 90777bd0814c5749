//! Contract: feet do what they are asked. Segments that shall touch carry the body and the others hang free, the ankle goes where it is asked to, what nobody
//! can stand on is refused; a lump that comes up under a foot is stood on. A click on the contact plate asks the same.

use crate::engine_support::{add, app, body, run_ticks};
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_athlete::contact::{Geometry, Solid, Surface, World as Surroundings};
use bevy_athlete::control::balance::AnkleStance;
use bevy_athlete::control::foot::{FootAnatomy, SegmentSet};
use bevy_athlete::engine::*;

fn spawn(app: &mut App, character: &str) -> Entity {
    app.insert_resource(AthleteWorld(Surroundings::ground()));
    let file = add(app, CharacterAsset::preset(character).expect("a character"));
    let athlete = app.world_mut().spawn((Athlete(file), AthleteController::Balance(BalancePose::Rest))).id();
    run_ticks(app, 96);
    athlete
}

fn ask(app: &mut App, athlete: Entity, feet: [AnkleStance; 2]) {
    *app.world_mut().get_mut::<AthleteController>(athlete).expect("a controller") =
        AthleteController::Balance(BalancePose::Feet(feet));
}

fn anatomy(app: &App, athlete: Entity, foot: usize) -> FootAnatomy {
    FootAnatomy::of(body(app, athlete).model(), foot).expect("a foot")
}

/// Upward force on each segment of a foot, N, averaged over a second.
fn loads(app: &mut App, athlete: Entity, foot: usize) -> Vec<f64> {
    let anatomy = anatomy(app, athlete, foot);
    let mut loads = vec![0.0; anatomy.segments().len()];
    for _ in 0..64 {
        app.update();
        let sim = body(app, athlete).simulator();
        for (load, segment) in loads.iter_mut().zip(anatomy.segments()) {
            *load += segment.points.iter().map(|p| sim.contact_force(p.2, 0).y).sum::<f64>() / 64.0;
        }
    }
    loads
}

fn ankle(app: &mut App, athlete: Entity, foot: usize) -> DVec3 {
    let link = anatomy(app, athlete, foot).ankle();
    app.world().get::<LinkPoses>(athlete).expect("poses").current[link].position
}

fn stands(app: &App, athlete: Entity) -> bool {
    let body = body(app, athlete);
    body.quarantine_reason().is_none() && body.simulator().state.root_position.lane(0).y > 0.6
}

#[test]
fn segments_that_are_asked_to_touch_carry_and_the_others_hang() {
    let mut app = app();
    let athlete = spawn(&mut app, "foot_human");
    let feet = [0, 1].map(|foot| anatomy(&app, athlete, foot));
    let heel = feet[0].segments().iter().position(|s| s.name == "heel_left").expect("a heel");
    let without = feet[0].standing().without(heel);
    let whole = AnkleStance { touch: feet[1].standing(), ..AnkleStance::default() };
    ask(&mut app, athlete, [AnkleStance { touch: without, rise: 0.02, roll: 0.0 }, whole]);
    run_ticks(&mut app, 192);
    let left = loads(&mut app, athlete, 0);
    let right: f64 = loads(&mut app, athlete, 1).iter().sum();
    let weight = body(&app, athlete).model().mass() * 9.81;
    println!("left foot by segment {left:.0?} N, right foot {right:.0} N of {weight:.0} N");
    assert!(stands(&app, athlete));
    assert!(left[heel] < 1.0, "{} N on the heel", left[heel]);
    let carried: f64 = left.iter().sum();
    assert!(carried > 0.1 * weight && (carried + right - weight).abs() < 0.1 * weight, "{carried} N, {right} N");
    assert_eq!(body(&app, athlete).feet_asked().map(|feet| feet[0].touch), Some(without));

    // And back again.
    ask(&mut app, athlete, [AnkleStance { touch: feet[0].standing(), ..AnkleStance::default() }, whole]);
    run_ticks(&mut app, 192);
    let left = loads(&mut app, athlete, 0);
    assert!(left[heel] > 10.0 && stands(&app, athlete), "{} N on the heel", left[heel]);
}

#[test]
fn an_ankle_goes_where_it_is_asked() {
    let mut app = app();
    let athlete = spawn(&mut app, "foot_human");
    let toes = [0, 1].map(|foot| {
        let anatomy = anatomy(&app, athlete, foot);
        anatomy.set(bevy_athlete::control::foot::BasicPose::Tiptoe).expect("toes")
    });
    let at = |rise| toes.map(|touch| AnkleStance { touch, rise, roll: 0.0 });
    let mut heights = Vec::new();
    for rise in [0.02, 0.05] {
        ask(&mut app, athlete, at(rise));
        run_ticks(&mut app, 192);
        heights.push(ankle(&mut app, athlete, 0).y);
        assert!(stands(&app, athlete));
    }
    println!("ankle at {heights:.3?} m");
    let gained = heights[1] - heights[0];
    assert!((gained - 0.03).abs() < 0.012, "3 cm higher were asked, {gained} m came");
}

#[test]
fn feet_that_cannot_be_asked_so_are_refused() {
    #[derive(Resource, Default)]
    struct Refusals(Vec<AthleteRefusal>);
    let mut app = app();
    app.init_resource::<Refusals>();
    app.add_observer(|refused: On<AthleteRefused>, mut all: ResMut<Refusals>| all.0.push(refused.reason.clone()));
    for touch in [SegmentSet::NONE, SegmentSet::of(&[6])] {
        let athlete = spawn(&mut app, "two_segment_human");
        ask(&mut app, athlete, [AnkleStance { touch, ..AnkleStance::default() }; 2]);
        run_ticks(&mut app, 2);
        let all = std::mem::take(&mut app.world_mut().resource_mut::<Refusals>().0);
        assert!(matches!(all.as_slice(), [AthleteRefusal::Balance(_)]), "{all:?}");
        app.world_mut().despawn(athlete);
    }
}

/// Upward force on points of a foot that are higher than this over the floor (m), N.
fn load_above(app: &App, athlete: Entity, foot: usize, height: f64) -> f64 {
    let (body, poses) = (body(app, athlete), app.world().get::<LinkPoses>(athlete).expect("poses"));
    let model = body.model();
    let bottom = |k: usize| {
        let (point, link) = (&model.contact_points[k], &poses.current[model.contact_points[k].link]);
        (link.position + link.rotation * point.position).y - point.radius
    };
    let points = model.foot_points(&model.feet()[foot]).filter(|&k| bottom(k) > height);
    points.map(|k| body.simulator().contact_force(k, 0).y).sum()
}

/// Either body stands on with a bump or a ball under its left foot, and bears on it.
#[test]
fn a_lump_under_a_foot_is_stood_on() {
    for (character, radius, high) in
        [("foot_human", 0.12, 0.03), ("foot_human", 0.05, 0.02), ("two_segment_human", 0.12, 0.03)]
    {
        let mut app = app();
        let athlete = spawn(&mut app, character);
        // Under the ball of the foot: the arch of one of five segments goes over a lump without touching it.
        let under = ankle(&mut app, athlete, 0) + DVec3::NEG_Z * 0.1;
        let rate = 0.02;
        let (mut raised, mut borne) = (0.0, 0.0);
        for tick in 0..256 {
            let before = raised;
            raised = f64::min(raised + rate / 64.0, high);
            let center = DVec3::new(under.x, raised - radius, under.z);
            let mut lump = Solid::fixed(Geometry::Sphere { center, radius }, Surface::GROUND);
            lump.linear_velocity = DVec3::Y * ((raised - before) * 64.0);
            let mut world = Surroundings::ground();
            world.solids.push(lump);
            app.insert_resource(AthleteWorld(world));
            app.update();
            if tick >= 192 {
                borne += load_above(&app, athlete, 0, 0.4 * high) / 64.0;
            }
        }
        println!("{character}, a lump of {radius} m radius {high} m high bears {borne:.0} N");
        assert!(stands(&app, athlete), "{character} on a lump of {radius} m");
        assert!(borne > 20.0, "{character} on a lump of {radius} m: {borne} N");
    }
}

#[test]
fn a_circle_is_gone_round_and_left() {
    let mut app = app();
    let athlete = spawn(&mut app, "foot_human");
    for quarter in 0..8 {
        *app.world_mut().get_mut::<AthleteController>(athlete).expect("a controller") =
            AthleteController::Balance(BalancePose::Circling { foot: 0, quarter });
        run_ticks(&mut app, 48);
        assert!(stands(&app, athlete), "quarter {quarter}");
    }
    assert!(body(&app, athlete).time() > 7.0, "it goes over, it does not begin anew");
}
