//! The conditions on trials, on skaters whose moves are written down: each is met by what it asks for and by nothing less.

use bevy_athlete::model::Side;
use bevy_athlete::skill::{Criterion, FootSample, PerformanceSample, Way, crossings, flights, strokes};
use glam::{DQuat, DVec3};

const RATE: f64 = 120.0;

/// A skater that glides along -Z at 2 m/s, feet 0.2 m apart, both blades on the ice.
fn glide(seconds: f64) -> Vec<PerformanceSample> {
    (1..=(seconds * RATE) as usize)
        .map(|k| {
            let time = k as f64 / RATE;
            let z = -2.0 * time;
            let blade = |x: f64| FootSample {
                toe: DVec3::new(x, 0.0, z - 0.1),
                heel: DVec3::new(x, 0.0, z + 0.1),
                pressed: true,
                lean: Some(0.0),
                ground: 0.0,
            };
            PerformanceSample {
                time,
                root_position: DVec3::new(0.0, 0.8, z),
                root_rotation: DQuat::IDENTITY,
                com_velocity: DVec3::new(0.0, 0.0, -2.0),
                feet: [blade(-0.1), blade(0.1)],
                ..PerformanceSample::default()
            }
        })
        .collect()
}

fn lift(sample: &mut PerformanceSample, foot: usize, height: f64) {
    let blade = &mut sample.feet[foot];
    (blade.pressed, blade.lean) = (false, None);
    (blade.toe.y, blade.heel.y) = (height, height);
}

/// Turned about the vertical through the root by `angle`, the way of travel as it was.
fn turn(sample: &mut PerformanceSample, angle: f64) {
    let q = DQuat::from_rotation_y(angle);
    sample.root_rotation = q * sample.root_rotation;
    for blade in &mut sample.feet {
        for end in [&mut blade.toe, &mut blade.heel] {
            *end = sample.root_position + q * (*end - sample.root_position);
        }
    }
}

fn meets(criterion: Criterion, samples: &[PerformanceSample]) -> bool {
    criterion.check(samples).is_ok()
}

#[test]
fn strokes_are_counted_leg_by_leg() {
    let mut samples = glide(4.0);
    for (k, sample) in samples.iter_mut().enumerate() {
        // Half a second on each foot, the other lifted.
        lift(sample, (k / 60) % 2, 0.1);
    }
    assert_eq!(strokes(&samples), [Side::Right, Side::Left].repeat(4));
    assert!(meets(Criterion::Strokes { count: 8 }, &samples) && !meets(Criterion::Strokes { count: 9 }, &samples));
    // The same foot again is no new stroke; a touch of a moment is none.
    let mut same = glide(4.0);
    for (k, sample) in same.iter_mut().enumerate() {
        if (k / 60) % 2 == 0 {
            lift(sample, 0, 0.1);
        } else if k % 60 < 5 {
            lift(sample, 1, 0.1);
        }
    }
    assert_eq!(strokes(&same), [Side::Right]);
    assert!(!meets(Criterion::Strokes { count: 1 }, &glide(4.0)), "two feet make no stroke");
}

#[test]
fn speed_is_that_of_the_end() {
    let mut samples = glide(4.0);
    for sample in &mut samples[..240] {
        sample.com_velocity *= 0.25;
    }
    assert!(meets(Criterion::KeptSpeed { at_least: 1.99, seconds: 1.9 }, &samples));
    assert!(!meets(Criterion::KeptSpeed { at_least: 1.99, seconds: 3.0 }, &samples));
}

#[test]
fn a_crossing_needs_the_feet_apart_again() {
    let mut samples = glide(4.0);
    let shift = |k: usize| 0.2 * (1.0 - (k as f64 / 30.0 * core::f64::consts::PI).cos());
    for (k, sample) in samples.iter_mut().enumerate() {
        // From 0.2 m to the right of the left foot to 0.2 m to its left, and back, every half second.
        let to_left = DVec3::X * shift(k);
        sample.feet[1].toe -= to_left;
        sample.feet[1].heel -= to_left;
    }
    assert_eq!(crossings(&samples), 8);
    let mut half = glide(4.0);
    for (k, sample) in half.iter_mut().enumerate() {
        let to_left = DVec3::X * (0.45 * shift(k));
        sample.feet[1].toe -= to_left;
        sample.feet[1].heel -= to_left;
    }
    assert_eq!(crossings(&half), 0, "side by side is not across");
}

#[test]
fn the_way_counts_from_the_pelvis() {
    let mut samples = glide(2.0);
    assert!(meets(Criterion::Travels { way: Way::Forward }, &samples));
    samples.iter_mut().for_each(|s| turn(s, core::f64::consts::PI));
    assert!(meets(Criterion::Travels { way: Way::Backward }, &samples));
    assert!(!meets(Criterion::Travels { way: Way::Forward }, &samples));
}

#[test]
fn circles_are_those_of_the_way() {
    let mut samples = glide(6.0);
    for sample in &mut samples {
        sample.com_velocity = DQuat::from_rotation_y(sample.time * core::f64::consts::TAU / 4.0) * sample.com_velocity;
    }
    assert!(
        meets(Criterion::Circles { turns: 1.45 }, &samples) && !meets(Criterion::Circles { turns: 1.55 }, &samples)
    );
}

/// A three-turn on the left foot: one second forwards, half round in 0.2 s, then backwards.
fn three_turn() -> Vec<PerformanceSample> {
    let mut samples = glide(2.5);
    for sample in &mut samples {
        lift(sample, 1, 0.2);
        turn(sample, core::f64::consts::PI * ((sample.time - 1.0) / 0.2).clamp(0.0, 1.0));
    }
    samples
}

#[test]
fn a_three_turn_stays_on_one_foot() {
    let (turned, stays) =
        (Criterion::Turns { foot: Side::Left, to: Way::Backward }, Criterion::OneFoot { foot: Side::Left });
    let glides = |seconds| Criterion::Glides { foot: Side::Left, way: Way::Backward, seconds };
    let samples = three_turn();
    assert!(meets(turned.clone(), &samples) && meets(stays.clone(), &samples));
    assert!(meets(glides(1.2), &samples));
    assert!(!meets(Criterion::Turns { foot: Side::Left, to: Way::Forward }, &samples));
    assert!(!meets(Criterion::Glides { foot: Side::Left, way: Way::Forward, seconds: 1.0 }, &samples));
    assert!(!meets(Criterion::Glides { foot: Side::Right, way: Way::Backward, seconds: 1.0 }, &samples));

    let mut down = three_turn();
    down[200].feet[1].pressed = true;
    assert!(!meets(stays.clone(), &down) && !meets(glides(1.2), &down), "the free foot touched");
    let mut up = three_turn();
    lift(&mut up[130], 0, 0.006);
    assert!(!meets(stays, &up), "the standing foot left");
    assert!(!meets(turned, &glide(2.5)), "no turn");
}

/// Backwards on the left inside edge, 0.4 s in the air turning `turns` times to the left, down on the right foot.
fn jump(turns: f64) -> Vec<PerformanceSample> {
    let mut samples = glide(2.5);
    for sample in &mut samples {
        turn(sample, core::f64::consts::PI);
        let t = sample.time - 1.0;
        if t <= 0.0 {
            lift(sample, 1, 0.2);
            sample.feet[0].lean = Some(0.2);
        } else if t <= 0.4 {
            lift(sample, 0, 0.1);
            lift(sample, 1, 0.1);
            sample.root_position.y += 4.0 * 0.2 * (t / 0.4) * (1.0 - t / 0.4);
        } else {
            lift(sample, 0, 0.2);
        }
        turn(sample, turns * core::f64::consts::TAU * (t / 0.4).clamp(0.0, 1.0));
    }
    samples
}

#[test]
fn a_salchow_is_a_salchow() {
    let salchow = |air_time: f64, turns: f64| Criterion::Jumps {
        from: Side::Left,
        way: Way::Backward,
        inside: true,
        air_time,
        turns,
        to: Side::Right,
    };
    let samples = jump(2.0);
    let found = flights(&samples);
    assert_eq!(found.len(), 1);
    assert!((found[0].seconds - 0.4).abs() < 0.02 && (found[0].turns - 2.0).abs() < 0.1, "{found:?}");
    assert!((found[0].height - 0.2).abs() < 0.01, "{found:?}");
    assert!(meets(salchow(0.35, 1.75), &samples), "{:?}", salchow(0.35, 1.75).check(&samples));
    assert!(!meets(salchow(0.45, 1.75), &samples) && !meets(salchow(0.35, 2.2), &samples));

    let changed = |change: fn(&mut PerformanceSample)| {
        let mut samples = jump(2.0);
        samples.iter_mut().for_each(change);
        samples
    };
    let outside = changed(|s| s.feet[0].lean = s.feet[0].lean.map(|l| -l));
    assert!(!meets(salchow(0.35, 1.75), &outside), "the outside edge is another jump");
    let exchanged = changed(|s| s.feet.swap(0, 1));
    assert!(!meets(salchow(0.35, 1.75), &exchanged), "so is the other foot");
    let forwards = changed(|s| s.com_velocity = -s.com_velocity);
    assert!(!meets(salchow(0.35, 1.75), &forwards), "and the other way");
    assert!(!meets(salchow(0.35, 1.75), &glide(2.5)), "gliding is none");
}

/// Standing, from 1 s on in the air for `seconds`, then standing again.
fn leap(seconds: f64) -> Vec<PerformanceSample> {
    let mut samples = glide(3.0);
    for sample in &mut samples {
        let t = sample.time - 1.0;
        sample.com_velocity = DVec3::ZERO;
        if (0.0..seconds).contains(&t) {
            sample.com_velocity.y = 9.81 * (0.5 * seconds - t);
            lift(sample, 0, 0.2);
            lift(sample, 1, 0.5 * 9.81 * t * (seconds - t));
        }
    }
    samples
}

#[test]
fn a_leap_is_as_high_as_its_time_in_the_air() {
    // Half of the time up, half down: h = g T^2 / 8.
    let (seconds, up) = (0.4, 9.81 * 0.4 * 0.4 / 8.0);
    let samples = leap(seconds);
    let leaps = |rise: f64, clear: f64| Criterion::Leaps { rise, clear };
    assert!(meets(leaps(up - 0.01, up - 0.01), &samples), "{:?}", leaps(up - 0.01, up - 0.01).check(&samples));
    assert!(!meets(leaps(up + 0.01, 0.0), &samples) && !meets(leaps(0.0, up + 0.01), &samples));
    assert!(!meets(leaps(0.01, 0.0), &glide(3.0)), "who glides leaps nowhere");

    let rests = |seconds: f64| Criterion::ComesToRest { seconds, below: 0.1 };
    assert!(meets(rests(1.0), &samples));
    assert!(!meets(rests(1.8), &samples), "it was in the air then");
    assert!(!meets(rests(1.0), &glide(3.0)), "who glides does not rest");
    let mut on_one = samples;
    on_one.iter_mut().for_each(|s| lift(s, 1, 0.1));
    assert!(!meets(rests(1.0), &on_one));
}
