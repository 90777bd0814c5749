//! Contacts of key poses, and gaits of several speeds: feet that stand do not slide.

use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::asset::{StateReader, StateWriter};
use bevy_athlete::cli::gait::{GaitTask, gait_report, record_gait};
use bevy_athlete::cli::load_trained_skill;
use bevy_athlete::control::terms::{ObservationLayout, ObservationTerm};
use bevy_athlete::control::tracking::{TrackedMotion, Tracker, TrackerOptions};
use bevy_athlete::model::{CharacterModel, KeyPoses, ModelPose, SharedModel, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator};
use bevy_athlete::skill::{Director, Disturbance};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

const GAITS: [(&str, &str, &[&str]); 2] = [
    ("foot_human", "walking/walk", &["stand", "march", "slow", "brisk", "fast"]),
    ("runner", "running/run", &["stand", "march", "walk", "jog", "run", "fast_run"]),
];

fn key_poses(folder: &str, name: &str) -> KeyPoses {
    let file = Path::new("assets/skills").join(folder).join(format!("{name}.keyposes.ron"));
    KeyPoses::load(file).unwrap()
}

fn cycles(folder: &str, names: &[&str], model: &CharacterModel) -> Vec<MotionClip> {
    names.iter().map(|name| key_poses(folder, name).to_clip(model).unwrap()).collect()
}

/// Centre of a contact point, m.
fn place(model: &CharacterModel, pose: &ModelPose, point: &str) -> DVec3 {
    let p = model.contact_points.iter().find(|p| p.name == point).unwrap();
    let mut links = Vec::new();
    pose.link_transforms(model, &mut links);
    links[p.link].position + links[p.link].rotation * p.position
}

#[test]
fn points_in_contact_lie_still_on_the_ground() {
    for (body, folder, names) in GAITS {
        let model = preset(body).unwrap();
        for name in names.iter().skip(1) {
            let poses = key_poses(folder, name);
            if poses.mass_on_path {
                // A run is in the air for a part of the time: its height is that of the flight, and a long leg is what gives way.
                continue;
            }
            let free = KeyPoses { contacts: Vec::new(), ..poses.clone() };
            // Three strides: contacts reach over the ends of each.
            let clip = |poses: &KeyPoses| {
                let clip = KeyPoses { repeat: 3, frame_rate: 120.0, ..poses.clone() }.to_clip(&model).unwrap();
                clip.to_model(&model).unwrap()
            };
            let (pinned, free) = (clip(&poses), clip(&free));
            let half: f64 = poses.seconds.iter().sum();
            let time = |pose: f64| {
                let n = poses.seconds.len() as f64;
                let (whole, k) = ((pose / n).floor(), pose.rem_euclid(n) as usize);
                whole * half + poses.seconds[..k].iter().sum::<f64>() + poses.seconds[k] * pose.fract()
            };
            let (mut slid, mut slides, mut off): (f64, f64, f64) = (0.0, 0.0, 0.0);
            for (point, (from, to)) in &poses.contacts[0].points {
                let radius = model.contact_points.iter().find(|p| p.name == *point).unwrap().radius;
                let spread = |clip: &bevy_athlete::model::ModelClip| {
                    // The middle one of the three strides.
                    let at = |k: usize| {
                        let t = 2.0 * half + time(*from) + (time(*to) - time(*from)) * k as f64 / 20.0;
                        place(&model, &clip.sample(t), point)
                    };
                    let first = at(10);
                    (0..=20)
                        .map(|k| ((at(k) - first).length(), (at(k).y - radius).abs()))
                        .fold((0.0f64, 0.0f64), |a, b| (a.0.max(b.0), a.1.max(b.1)))
                };
                let (a, b) = (spread(&pinned), spread(&free));
                (slid, slides, off) = (slid.max(a.0), slides.max(b.0), off.max(a.1));
            }
            assert!(slid < 0.025 && off < 0.012, "{body}, {name}: a point slid by {slid} m, {off} m off the ground");
            assert!(slides > 2.0 * slid, "{body}, {name}: without contacts {slides} m, with them {slid} m");
        }
    }
}

#[test]
fn contacts_that_cannot_be_are_refused_by_place() {
    let model = preset("runner").unwrap();
    let text = |points: &str| {
        format!(
            "(name: \"c\", character: \"runner\", speed: 1, seconds: [0.5, 0.5], poses: [(), ()], contacts: [(points: {points})])"
        )
    };
    for (points, word) in [
        ("{}", "at least one"),
        ("{\"nose\": (0, 1)}", "heel_inner_left"),
        ("{\"hand_left\": (1, 0)}", "in order"),
        ("{\"hand_left\": (0, 3)}", "0 to 1"),
        ("{\"hand_left\": (0, NaN)}", "0 to 1"),
        ("{\"hand_left\": (0, 1)}, at: (0, inf, 1)", "metres"),
    ] {
        let refusal = KeyPoses::from_ron(&text(points), "c").unwrap().to_clip(&model).unwrap_err().to_string();
        assert!(refusal.contains("contact 0") && refusal.contains(word), "{points}: {refusal}");
    }
    // A hand on a box that is higher than the poses have it.
    let poses = KeyPoses::from_ron(&text("{\"hand_left\": (0, 1)}, at: (-0.4, 0.6, 0.5)"), "c").unwrap();
    let clip = poses.to_clip(&model).unwrap().to_model(&model).unwrap();
    let hand = place(&model, &clip.sample(0.25), "hand_left");
    assert!((hand - DVec3::new(-0.4, 0.63, -0.5)).length() < 0.02, "{hand}");
}

/// The gait of a body, and its speeds.
fn gait(body: &str, folder: &str, names: &[&str]) -> (SharedModel, TrackedMotion) {
    let model = preset(body).unwrap();
    let motion = TrackedMotion::gait(&cycles(folder, names, &model), &model, 30.0).unwrap();
    (model, motion)
}

#[test]
fn a_gait_has_the_speeds_of_its_cycles_and_goes_at_the_pace_that_is_asked() {
    for (body, folder, names) in GAITS {
        let (model, motion) = gait(body, folder, names);
        // When the left foot comes down, in cycles, and a point of its ball.
        let (strike, ball) = if body == "runner" { (0.8, "ball_inner_left") } else { (0.0, "metatarsal1_head_left") };
        let speeds: Vec<f64> = motion.levels().iter().map(|l| l.speed).collect();
        assert!(speeds[0] < 1e-3 && speeds.windows(2).all(|w| w[0] < w[1]), "{body}: {speeds:?}");
        let layout = Arc::new(ObservationLayout::from_terms(&model, &ObservationTerm::STANDARD, 0));
        let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
        let mut tracker = Tracker::new(Arc::new(motion.clone()), TrackerOptions::default(), layout);
        let top = speeds[speeds.len() - 1];
        let mut pace = 0.15;
        while pace < top {
            tracker.begin(&mut sim, 0, 0, pace);
            tracker.set_speed(0, pace);
            let start = tracker.reference_root();
            // Where the ball of the left foot is while it stands at every speed, and how far it goes in a decision.
            let (count, mut stood, mut slid): (usize, Option<DVec3>, f64) = (300, None, 0.0);
            for _ in 0..count {
                tracker.advance(&sim);
                let phase = (tracker.tick(0) as f64 / 32.0 - strike).rem_euclid(1.0);
                let here = place(&model, &tracker.reference_pose(0), ball);
                if let Some(before) = stood {
                    slid = slid.max((here - before).length());
                }
                stood = (0.14..0.3).contains(&phase).then_some(here);
            }
            let gone = (tracker.reference_root() - start).lane(0);
            let seconds = count as f64 / 30.0;
            assert!((gone.length() / seconds - pace).abs() < 0.05, "{body} at {pace} m/s: {gone} in {seconds} s");
            // With the body it would go by pace / 30.
            assert!(slid < 0.004 + 0.65 * pace / 30.0, "{body} at {pace} m/s: a standing point went by {slid} m");
            pace += 0.37;
        }
    }
}

#[test]
fn a_gait_changes_its_pace_no_faster_than_asked_and_its_reference_never_jumps() {
    let (model, motion) = gait("foot_human", "walking/walk", GAITS[0].2);
    let layout = Arc::new(ObservationLayout::from_terms(&model, &ObservationTerm::STANDARD, 0));
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let options = TrackerOptions { acceleration: 1.2, ..TrackerOptions::default() };
    let mut tracker = Tracker::new(Arc::new(motion), options, layout.clone());
    tracker.begin(&mut sim, 0, 5, 0.0);
    // It waits for the end of a step, though it stands.
    tracker.set_speed(0, 0.0);
    (0..20).for_each(|_| tracker.advance(&sim));
    let mut before = tracker.reference_root().lane(0);
    let (mut fastest, mut speed_before): (f64, f64) = (0.0, 0.0);
    for k in 0..240 {
        tracker.set_speed(0, if k < 120 { 1.7 } else { 0.0 });
        tracker.advance(&sim);
        let here = tracker.reference_root().lane(0);
        let speed = ((here - before) * DVec3::new(1.0, 0.0, 1.0)).length() * 30.0;
        fastest = fastest.max(speed);
        // 1.2 m/s^2 is 0.04 m/s in a decision; the root sways within a step, too.
        assert!((speed - speed_before).abs() < 0.25, "decision {k}: {speed_before} to {speed} m/s");
        (before, speed_before) = (here, speed);
        let ends = &tracker.reference_pose_at(0, 0.999_999).root_position;
        let mut ahead = tracker.clone();
        ahead.advance(&sim);
        assert!((ahead.reference_root().lane(0) - *ends).length() < 0.015, "decision {k}: shown between two decisions");
    }
    assert!(fastest > 1.6 && speed_before < 0.02, "{fastest} m/s, then {speed_before}");

    // What is written is where it goes on from.
    tracker.set_speed(0, 1.1);
    (0..7).for_each(|_| tracker.advance(&sim));
    let mut out = StateWriter::default();
    tracker.write_state(0, &mut out);
    let mut other = Tracker::new(tracker.motion().clone(), options, layout);
    other.read_state(0, &mut StateReader::new(&out.finish())).unwrap();
    for _ in 0..50 {
        assert_eq!(tracker.reference_pose(0), other.reference_pose(0));
        tracker.advance(&sim);
        other.advance(&sim);
    }
}

/// A tracker of a gait that goes at a speed.
fn going(body: &str, folder: &str, names: &[&str], speed: f64) -> (Simulator<f64>, Tracker<f64>) {
    let (model, motion) = gait(body, folder, names);
    let layout = Arc::new(ObservationLayout::from_terms(&model, &ObservationTerm::STANDARD, 0));
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
    let mut tracker = Tracker::new(Arc::new(motion), TrackerOptions::default(), layout);
    tracker.begin(&mut sim, 0, 5, speed);
    tracker.set_speed(0, speed);
    (sim, tracker)
}

#[test]
fn a_gait_leans_into_a_turn_as_its_speed_and_the_turn_ask_for() {
    for (body, folder, names) in GAITS {
        let (sim, mut tracker) = going(body, folder, names, 1.2);
        let sideways = |tracker: &Tracker<f64>| {
            let up = tracker.reference_rotation().lane(0) * DVec3::Y;
            let ahead = tracker.heading(0).to_world(bevy_athlete::math::Vec3::<f64>::splat(DVec3::NEG_Z)).lane(0);
            up.dot(ahead.cross(DVec3::Y)).atan2(up.y)
        };
        // Over whole cycles, in which the trunk sways to both sides alike.
        let mean = |tracker: &mut Tracker<f64>, rate: f64| {
            let mut sum = 0.0;
            for k in 0..360 {
                tracker.advance(&sim);
                tracker.steer(rate / 30.0);
                sum += if k >= 60 { sideways(tracker) / 300.0 } else { 0.0 };
            }
            sum
        };
        let straight = mean(&mut tracker, 0.0);
        for rate in [0.8, -0.8] {
            let lean = mean(&mut tracker, rate);
            let wanted = -(1.2 * rate / 9.81_f64).atan();
            assert!((lean - straight - wanted).abs() < 0.01, "{body} at {rate} rad/s: {lean} rad, wanted {wanted}");
        }
    }
}

#[test]
fn a_gait_stands_with_both_feet_down_and_turns_on_the_spot_by_steps() {
    for (body, folder, names) in GAITS {
        for stops in [40, 43, 51] {
            let (sim, mut tracker) = going(body, folder, names, 1.0);
            let mut phases = Vec::new();
            for k in 0..150 {
                tracker.set_speed(0, if k < stops { 1.0 } else { 0.0 });
                tracker.advance(&sim);
                phases.push(tracker.tick(0));
            }
            assert!(phases[100..].iter().all(|p| *p == phases[149]), "{body}: the phase waits: {:?}", &phases[100..]);
            // There a step on the spot has both feet down.
            let step = &tracker.motion().levels()[1];
            assert!(step.speed < 0.3, "{body}: {} m/s", step.speed);
            let model = preset(body).unwrap();
            let (mut spot, layout) = (
                Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model)),
                Arc::new(ObservationLayout::from_terms(&model, &ObservationTerm::STANDARD, 0)),
            );
            let mut there = Tracker::new(tracker.motion().clone(), TrackerOptions::default(), layout);
            there.begin(&mut spot, 0, phases[149], step.speed);
            let pose = there.reference_pose(0);
            for name in ["left", "right"] {
                let lowest = model
                    .contact_points
                    .iter()
                    .filter(|p| p.name.ends_with(name) && p.role == bevy_athlete::model::PointRole::Foot)
                    .map(|p| place(&model, &pose, &p.name).y - p.radius)
                    .fold(f64::INFINITY, f64::min);
                assert!(lowest < 0.015, "{body}: the {name} foot is {lowest} m up");
            }

            // Told to turn, it takes steps, and goes nowhere.
            let (start, before) = (tracker.reference_root().lane(0), tracker.heading(0));
            let mut moved = false;
            for _ in 0..60 {
                tracker.steer(0.02);
                tracker.advance(&sim);
                moved |= tracker.tick(0) != phases[149];
            }
            let turned = tracker.heading(0).relative_to(before);
            assert!(moved && (turned.s.atan2(turned.c) - 1.2).abs() < 0.01, "{body}: it turns by {turned:?}");
            assert!((tracker.reference_root().lane(0) - start).length() < 0.3, "{body} stays where it is");
        }
    }
}

#[test]
fn clips_are_joined_one_after_the_other() {
    let model = preset("foot_human").unwrap();
    let cycles = cycles("walking/walk", GAITS[0].2, &model);
    let (joined, parts) = MotionClip::joined("walk", &cycles, 60.0).unwrap();
    assert_eq!(parts.len(), cycles.len());
    for ((from, to), cycle) in parts.iter().zip(&cycles) {
        assert!((to - from - cycle.duration()).abs() <= 0.5 / 60.0 + 1e-9);
        let part = joined.cut(*from, *to).unwrap();
        for s in [0.0, 0.3, 1.0] {
            let (a, b) = (part.sample(s * part.duration()), cycle.sample(s * cycle.duration()));
            assert!(a.root_position.distance(b.root_position) < 2e-3);
            assert!(a.joints.iter().zip(&b.joints).all(|(a, b)| a.angle_between(*b) < 0.03));
        }
    }
    let other = preset("runner").unwrap();
    let stranger = key_poses("running/run", "walk").to_clip(&other).unwrap();
    let refusal = MotionClip::joined("walk", &[cycles[0].clone(), stranger], 60.0).unwrap_err().to_string();
    assert!(refusal.contains("no joint") && refusal.contains("which the first clip has"), "{refusal}");
}

#[test]
fn the_ground_carries_the_weight_of_a_measured_walk() {
    let model = preset("foot_human").unwrap();
    let skill = load_trained_skill("walk", &model).unwrap();
    let rate = skill.definition.simulation_rate(&model);
    let mut director = Director::single(Arc::new(skill), rate).unwrap();
    let disturbance = Disturbance { joint: 0.02, joint_velocity: 0.1, velocity: 0.05 };
    let task = GaitTask { speed: 1.2, settle: 4.0, seconds: 24.0, disturbance, seed: 3 };
    let recording = record_gait(&mut director, &model, &task).unwrap();
    // Over strides the velocity comes back to what it was: the mean force is the weight, and none of it pushes to a side.
    let count = recording.samples.len() as f64;
    let mean = recording.samples.iter().map(|s| s.feet[0].force + s.feet[1].force).sum::<DVec3>() / count;
    assert!((mean.y - 1.0).abs() < 0.02 && mean.x.abs() < 0.02 && mean.z.abs() < 0.02, "{mean} body weights");
    let report = gait_report(&recording).unwrap();
    let half = report.vertical_force.mean[1..].iter().sum::<f64>() / 50.0;
    assert!((half - 0.5).abs() < 0.02, "each foot carries half of it: {half}");
    assert!(
        (report.speed - 1.2).abs() < 0.2 && (0.5..0.75).contains(&report.stance),
        "{} {}",
        report.speed,
        report.stance
    );
    let path = &report.pressure_path.mean;
    assert!(path.iter().all(|p| (0.0..=1.0).contains(p)) && path[40] > path[5], "from heel to toe: {path:?}");
    let error = record_gait(&mut director, &preset("skater").unwrap(), &task).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("stands on a blade"), "{error}");
}
