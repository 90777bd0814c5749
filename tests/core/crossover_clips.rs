//! Contract: the crossovers that are shipped, written by hand and simulated, are crossovers.
//!
//! - The path turns to the left at an even rate; the skater faces along it, or away from it.
//! - Once in every cycle, and only once, the outer foot is set across the standing leg: in front of it and inside of it.
//! - A blade on the ice travels along its line; a free foot leaves the ice; knees bend forwards only.
//!
//! A pose edited by hand breaks these first: a foot that is turned by ten degrees scrapes over the ice, which no
//! simulation follows, and legs that no longer cross look like skating with one stiff leg.

use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::model::{CharacterModel, KeyPoses, LinkTransform, skater};
use glam::DVec3;
use std::path::PathBuf;

const CYCLE: f64 = 1.2;
const CYCLES: usize = 3;
/// Turn of the path, rad/s: 3 m/s and 0.26 1/m.
const TURN: f64 = 0.78;
/// A blade with both ends below this is on the ice, m.
const ON_ICE: f64 = 0.004;

/// What is looked at, at one time.
struct Moment {
    root: DVec3,
    facing: DVec3,
    /// Heel and toe of the left and the right blade.
    blades: [[DVec3; 2]; 2],
    knees: [f64; 2],
}

fn moments(model: &CharacterModel, clip: &MotionClip) -> Vec<Moment> {
    let clip = clip.to_model(model).unwrap();
    let mut places: Vec<LinkTransform> = Vec::new();
    let look = |pose: &bevy_athlete::model::ModelPose| {
        pose.link_transforms(model, &mut places);
        let blades = ["left", "right"].map(|name| {
            let blade = model.blades.iter().find(|b| b.name == name).unwrap();
            [blade.heel, blade.toe].map(|end| {
                let point = &model.contact_points[end];
                places[point.link].position + places[point.link].rotation * point.position
            })
        });
        let knees = ["shin_left", "shin_right"]
            .map(|name| pose.joints[model.link_index(name).unwrap()].to_scaled_axis().x.to_degrees());
        let facing = pose.root_rotation * DVec3::NEG_Z;
        Moment { root: pose.root_position, facing: level(facing).normalize(), blades, knees }
    };
    clip.poses().iter().map(look).collect()
}

fn level(v: DVec3) -> DVec3 {
    DVec3::new(v.x, 0.0, v.z)
}

/// Signed angle from `a` to `b` about the vertical, counter-clockwise seen from above, rad.
fn turn(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).y.atan2(a.dot(b))
}

fn shipped() -> Vec<(String, bool, bool, MotionClip)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/skills/skating");
    let mut clips = Vec::new();
    for (skill, forwards) in [("forward_crossover", true), ("backward_crossover", false)] {
        let path = |ending: &str| folder.join(skill).join(format!("{skill}.{ending}"));
        let poses = KeyPoses::load(path("keyposes.ron")).unwrap().to_clip(&skater()).unwrap();
        clips.push((format!("{skill}, key poses"), forwards, false, poses));
        clips.push((format!("{skill}, simulated"), forwards, true, MotionClip::load(path("clip.ron")).unwrap()));
    }
    clips
}

#[test]
fn the_path_turns_evenly_to_the_left() {
    let model = skater();
    for (name, forwards, simulated, clip) in shipped() {
        assert!((clip.duration() - CYCLE * CYCLES as f64).abs() < 0.05, "{name}: {} s", clip.duration());
        let moments = moments(&model, &clip);
        // Chords over a third of a cycle: single steps of a simulated skater sway.
        let (span, half) = ((0.4 * clip.frame_rate) as usize, (0.5 * CYCLE * clip.frame_rate) as usize);
        let chords: Vec<DVec3> = moments.windows(span + 1).map(|w| level(w[span].root - w[0].root)).collect();
        let (even, mut worst) = (if simulated { 0.25 } else { 0.1 }, 0.0_f64);
        for pair in chords.windows(half + 1) {
            let rate = turn(pair[0], pair[half]) / (half as f64 / clip.frame_rate);
            worst = worst.max((rate / TURN - 1.0).abs());
            assert!(worst < even, "{name}: turns by {rate} rad/s");
        }
        println!("{name}: rate of turn within {:.0} %", 100.0 * worst);
        for (moment, chord) in moments.iter().zip(&chords) {
            let along = moment.facing.dot(chord.normalize());
            assert!(if forwards { along > 0.8 } else { along < -0.8 }, "{name}: {along}");
            assert!((chord.length() / (span as f64 / clip.frame_rate) - 3.0).abs() < 0.3, "{name}: {chord}");
        }
    }
}

#[test]
fn the_outer_foot_crosses_in_front_once_a_cycle() {
    let model = skater();
    for (name, forwards, _, clip) in shipped() {
        let moments = moments(&model, &clip);
        let (mut crossed, mut crossings, mut deepest) = (false, 0, 0.0_f64);
        for moment in &moments {
            let [left, right] = moment.blades.map(|[heel, toe]| level(heel + toe) / 2.0);
            let from_inner = if forwards { right - left } else { left - right };
            // Outwards is to the right of the way travelled.
            let way = if forwards { moment.facing } else { -moment.facing };
            let outwards = from_inner.dot(way.cross(DVec3::Y));
            if outwards < -0.12 && !crossed {
                (crossed, crossings) = (true, crossings + 1);
                let ahead = from_inner.dot(moment.facing);
                assert!(ahead > 0.05, "{name}: crossed, but {ahead} m in front");
            } else if outwards > 0.12 {
                crossed = false;
            }
            deepest = deepest.min(outwards);
        }
        assert_eq!(crossings, CYCLES, "{name}");
        assert!(deepest < -0.2, "{name}: {deepest}");
    }
}

#[test]
fn blades_travel_along_their_lines_and_knees_bend_forwards() {
    let model = skater();
    for (name, _, simulated, clip) in shipped() {
        let moments = moments(&model, &clip);
        for side in 0..2 {
            let (mut slips, mut highest) = (Vec::new(), 0.0_f64);
            for around in moments.windows(3) {
                let [heel, toe] = around[1].blades[side];
                highest = highest.max(heel.y.min(toe.y));
                assert!(heel.y.min(toe.y) > -0.002, "{name}: {heel} {toe} below the ice");
                if around.iter().all(|m| m.blades[side].iter().all(|end| end.y < ON_ICE)) {
                    let middle = |m: &Moment| level(m.blades[side][0] + m.blades[side][1]) / 2.0;
                    let (way, line) = (middle(&around[2]) - middle(&around[0]), level(toe - heel));
                    let slip = turn(line, way).to_degrees().abs();
                    slips.push(slip.min(180.0 - slip));
                }
                let knee = around[1].knees[side];
                assert!((-95.0..-10.0).contains(&knee), "{name}: knee at {knee}");
            }
            slips.sort_by(f64::total_cmp);
            let mean = slips.iter().sum::<f64>() / slips.len() as f64;
            let most = slips[slips.len() * 9 / 10];
            println!("{name}, {side}: slip {mean:.2}, nine tenths below {most:.2} degrees; lifted by {highest:.3} m");
            assert!(mean < 1.5 && most < 4.0, "{name}: slip {mean}, {most} degrees");
            let on_ice = slips.len() as f64 / moments.len() as f64;
            assert!((0.35..0.75).contains(&on_ice), "{name}: on the ice for {on_ice} of the time");
            assert!(highest > if simulated { 0.04 } else { 0.06 }, "{name}: the free foot is lifted by {highest} m");
        }
    }
}
