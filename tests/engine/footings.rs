//! Contract: a skill that was learnt on level ground at rest is performed on what a game puts under it.
//!
//! On a block it is the same motion, higher up. On a platform of Avian that moves at 1 m/s it is the same motion seen from the
//! platform (Galileo), and who begins at rest in the world, not on the platform, comes to the same speed on it. On slopes
//! of ice what nothing holds glides by its weight: `g sin a` along the slope, no more and no less. Slopes that a skill does not last on yet are
//! listed with how long it does, so that a skill that lasts longer shows.

use crate::grounds::{Footing, Outcome, Performer, perform_on};
use bevy::math::DVec3;

const GLIDE: &str = "skating/two_foot_glide";
const STROKING: &str = "skating/stroking";
const CROSSOVER: &str = "skating/forward_crossover";
const WALK: &str = "walking/walk";
const RUN: &str = "running/run";

/// Who goes on feet, and how fast, m/s.
fn gaits() -> [(Performer, f64); 4] {
    let at = |character, skill, speed: f64| (Performer::new(character, skill).at(speed as f32), speed);
    [at("foot_human", WALK, 0.6), at("foot_human", WALK, 1.2), at("runner", RUN, 2.2), at("runner", RUN, 3.2)]
}

/// Who performs, for how long (s), and how far off the way may be from that on the level after it (m).
fn rows() -> Vec<(Performer, f64, f64)> {
    let skater = |skill, speed| Performer::new("skater", skill).at(speed);
    vec![(skater(GLIDE, 2.0), 3.5, 0.05), (skater(STROKING, 2.5), 6.0, 0.25), (skater(CROSSOVER, 3.0), 6.0, 0.1)]
}

fn told(what: &str, outcome: &Outcome) {
    println!(
        "{what}: fell {:?}, root {:.2} to {:.2} m above it, way {:.2} m, {:.2} m/s at the end, touching {:.0} %",
        outcome.fell,
        outcome.height.0,
        outcome.height.1,
        outcome.end(),
        outcome.speed,
        100.0 * outcome.touching
    );
}

#[test]
fn on_a_block_it_is_the_same_motion_higher_up() {
    for (performer, seconds, _) in rows() {
        let [level, block] = [0.0, 0.5].map(|height| perform_on(&performer, Footing::Block { height }, seconds));
        told(performer.skill, &block);
        let apart = level.apart(&block);
        println!("{apart:.1e} m from the way on the level");
        assert!(level.stands() && block.stands() && apart < 1e-3, "{}: {apart} m", performer.skill);
        assert!((block.height.0 - level.height.0).abs() < 1e-3 && (block.height.1 - level.height.1).abs() < 1e-3);
    }
}

#[cfg(feature = "avian")]
#[test]
fn on_a_platform_that_moves_it_is_the_same_motion_seen_from_there() {
    for (performer, seconds, allowed) in rows() {
        let on =
            |velocity, carried| perform_on(&performer, Footing::Platform { height: 0.5, velocity, carried }, seconds);
        let still = on(DVec3::ZERO, false);
        assert!(still.stands() && still.end().length() > 3.0, "{still:?}");
        for velocity in [DVec3::Z, DVec3::new(0.6, 0.0, -0.8)] {
            let carried = on(velocity, true);
            told(&format!("{} on a platform at {velocity}", performer.skill), &carried);
            let apart = still.apart(&carried);
            println!("{apart:.3} m from the way on one at rest (allowed {allowed})");
            assert!(carried.stands() && apart < allowed, "{} at {velocity}: {apart} m", performer.skill);
            assert!((carried.speed - still.speed).abs() < 0.05, "{} m/s, {} m/s", carried.speed, still.speed);
        }
    }
}

/// Put on a moving platform with the skill's own speed in the world, a skater who strokes finds the speed that it is to have on the platform.
#[cfg(feature = "avian")]
#[test]
fn who_steps_onto_a_moving_platform_finds_its_speed() {
    let performer = Performer::new("skater", STROKING).at(2.5);
    let still = perform_on(&performer, Footing::Block { height: 0.5 }, 6.0);
    for velocity in [DVec3::X, DVec3::Z, DVec3::NEG_Z] {
        let found = perform_on(&performer, Footing::Platform { height: 0.5, velocity, carried: false }, 6.0);
        told(&format!("onto a platform at {velocity}"), &found);
        assert!(found.stands());
        assert!(
            (found.speed - still.speed).abs() < 0.1,
            "{} m/s on it, {} m/s on one at rest",
            found.speed,
            still.speed
        );
    }
}

/// A glide down a slope of ice lasts as long as on the level, and gains what the slope gives; up a gentle one it lasts until it has
/// lost its speed.
#[test]
fn a_glide_on_a_slope_goes_as_the_slope_makes_it() {
    let (speed, seconds, g) = (2.0, 3.5, 9.81);
    let performer = Performer::new("skater", GLIDE).at(speed as f32);
    let level = perform_on(&performer, Footing::Block { height: 0.0 }, seconds);
    told("level", &level);
    for degrees in [-5.0_f64, -2.0, 2.0] {
        let slope = perform_on(&performer, Footing::Slope { degrees }, seconds);
        told(&format!("slope of {degrees} degrees"), &slope);
        assert!(slope.stands(), "fell at {:?}", slope.fell);
        assert!(slope.height.0 > level.height.0 - 0.05, "{:?} of {:?}", slope.height, level.height);
        // Along the level: g sin a cos a, for friction is the same on both.
        let a = degrees.to_radians();
        let gained = -0.5 * g * a.sin() * a.cos() * seconds * seconds;
        let found = -slope.end().z + level.end().z;
        println!("{found:.2} m farther than on the level, of which the slope gives {gained:.2}");
        assert!((found - gained).abs() < 0.15 * gained.abs() + 0.1, "{found} m, {gained} m");
    }
}

/// How long skills last at least on slopes of 5 degrees and up ones of 2, on which none was learnt, s; and that they do not last a minute
/// longer is no promise.
#[test]
fn on_steep_slopes_skills_last_as_long_as_they_do() {
    for (skill, speed, degrees, at_least) in [
        (GLIDE, 2.0, 5.0, 0.8),
        (STROKING, 2.5, -2.0, 6.0),
        (STROKING, 2.5, -5.0, 3.5),
        (STROKING, 2.5, 2.0, 0.8),
        (STROKING, 2.5, 5.0, 0.4),
        (CROSSOVER, 3.0, -5.0, 6.0),
        (CROSSOVER, 3.0, 2.0, 6.0),
        (CROSSOVER, 3.0, 5.0, 4.5),
    ] {
        let found = perform_on(&Performer::new("skater", skill).at(speed), Footing::Slope { degrees }, 6.0);
        told(&format!("{skill}, {degrees} degrees"), &found);
        let lasted = found.fell.unwrap_or(6.0);
        assert!(found.stopped.is_none() && lasted >= at_least, "{skill} on {degrees} degrees: {lasted} s");
    }
}

/// A walk and a run hold their speed, and their way, on the level and on a block.
#[test]
fn gaits_go_on_level_ground_and_on_blocks() {
    for (performer, speed) in gaits() {
        for height in [0.0, 0.5] {
            goes(&performer, speed, Footing::Block { height });
        }
    }
}

/// How long they last at least on slopes of 5 degrees, on which none was learnt, s; that they do not last longer is no promise.
#[test]
fn gaits_last_on_slopes_as_long_as_they_do() {
    let mut short = Vec::new();
    for ((performer, speed), least) in gaits().into_iter().zip([(3.0, 8.0), (1.0, 8.0), (8.0, 8.0), (0.8, 8.0)]) {
        for (degrees, at_least) in [(5.0, least.0), (-5.0, least.1)] {
            let found = perform_on(&performer, Footing::Slope { degrees }, 10.0);
            told(&format!("{} at {speed} m/s, {degrees} degrees", performer.skill), &found);
            let lasted = found.fell.unwrap_or(10.0);
            short.extend((found.stopped.is_some() || lasted < at_least).then_some((
                performer.skill,
                speed,
                degrees,
                lasted,
            )));
        }
    }
    assert!(short.is_empty(), "{short:?}");
}

/// On a platform of Avian that moves at 1 m/s, too, at the same speed over it: each in another direction.
#[cfg(feature = "avian")]
#[test]
fn gaits_go_on_platforms_that_move() {
    let ways = [DVec3::X, DVec3::new(0.6, 0.0, -0.8), DVec3::Z, DVec3::NEG_Z];
    for ((performer, speed), velocity) in gaits().into_iter().zip(ways) {
        goes(&performer, speed, Footing::Platform { height: 0.5, velocity, carried: true });
    }
}

/// Six seconds ahead on a footing.
fn goes(performer: &Performer, speed: f64, footing: Footing) {
    const SECONDS: f64 = 6.0;
    let found = perform_on(performer, footing, SECONDS);
    let what = format!("{} at {speed} m/s on {footing:?}", performer.skill);
    told(&what, &found);
    assert!(found.stands(), "{what}: fell at {:?}", found.fell);
    assert!((-found.end().z - SECONDS * speed).abs() < 0.15 * SECONDS * speed, "{what}: {:?}", found.end());
    assert!(found.end().x.abs() < 0.3 * SECONDS * speed, "{what}: {:?}", found.end());
}
