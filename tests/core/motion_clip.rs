//! What is made from a clip is what it says.
//!
//! - A saved clip comes back bit for bit: a rounding that looks harmless in one file makes a replay drift.
//! - Sampling hits the poses, lies between them and clamps; velocities are those of a motion with a known rate.
//!   A sign or frame error (world against child) hides in a motion about one axis, so the known motion turns about two.
//! - Repetition carries place and heading on without a step at the seam; mirroring twice is the identity.
//! - Layout for a character: by link index, the same samples, hinges keep their axis.

use crate::motion_support::{link_places, tiny_model, wild_clip};
use bevy_athlete::asset::clip::{ClipError, MotionClip, Pose};
use bevy_athlete::math::RandomStream;
use bevy_athlete::model::JointKind;
use glam::{DQuat, DVec3};

fn angle(a: DQuat, b: DQuat) -> f64 {
    (a.conjugate() * b).to_scaled_axis().length()
}

#[test]
fn a_saved_clip_comes_back_bit_for_bit() {
    let clip = wild_clip(&mut RandomStream::new(1, 1), 20);
    let text = clip.to_ron().unwrap();
    assert_eq!(MotionClip::from_ron(&text).unwrap(), clip);
    assert!(text.lines().count() < 60, "one pose to a line:\n{text}");
    let path = std::env::temp_dir().join(format!("bevy_athlete_{}.clip.ron", std::process::id()));
    clip.save(&path).unwrap();
    assert_eq!(MotionClip::load(&path).unwrap(), clip);
    std::fs::remove_file(&path).unwrap();
    let missing = MotionClip::load(&path).unwrap_err();
    assert!(missing.to_string().contains("clip.ron"), "{missing}");
}

#[test]
fn a_rounded_clip_is_shorter_and_the_same_to_a_microradian() {
    let clip = wild_clip(&mut RandomStream::new(1, 3), 20);
    let text = clip.clone().rounded().to_ron().unwrap();
    assert!(text.len() < clip.to_ron().unwrap().len() * 6 / 10);
    let read = MotionClip::from_ron(&text).unwrap();
    for (a, b) in clip.poses.iter().zip(&read.poses) {
        assert!(a.root_position.distance(b.root_position) < 1e-6);
        assert!(a.joints.iter().zip(&b.joints).all(|(a, b)| angle(*a, *b) < 3e-6));
    }
    assert_eq!(MotionClip::from_ron(&read.clone().rounded().to_ron().unwrap()).unwrap().rounded(), read.rounded());
}

#[test]
fn invalid_clips_are_refused_by_place() {
    let good = wild_clip(&mut RandomStream::new(1, 2), 3);
    type Spoil = fn(&mut MotionClip);
    let spoiled: [(Spoil, &str); 8] = [
        (|c| c.poses.clear(), "no poses"),
        (|c| c.frame_rate = f64::NAN, "frame rate"),
        (|c| c.frame_rate = 0.0, "frame rate"),
        (|c| c.joints[1] = c.joints[0].clone(), "thigh_left"),
        (|c| c.poses[2].joints.truncate(4), "pose 2"),
        (|c| c.poses[1].joints[4].w += 0.5, "chest"),
        (|c| c.poses[1].root_position.y = f64::INFINITY, "root position"),
        (|c| c.poses[0].root_rotation = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), "root rotation"),
    ];
    for (spoil, needle) in spoiled {
        let mut clip = good.clone();
        spoil(&mut clip);
        let message = clip.validate().expect_err(needle).to_string();
        println!("{message}");
        assert!(message.contains(needle), "`{message}` should mention `{needle}`");
        assert!(clip.to_ron().is_err() && clip.to_model(&tiny_model()).is_err());
        // Sampling an unchecked clip does not panic either.
        clip.sample(0.05);
    }
}

#[test]
fn samples_hit_the_poses_and_clamp() {
    let clip = wild_clip(&mut RandomStream::new(2, 1), 10);
    assert!((clip.duration() - 9.0 / 30.0).abs() < 1e-15);
    assert_eq!(clip.sample(-1.0), clip.poses[0]);
    assert_eq!(clip.sample(f64::NAN), clip.poses[0]);
    assert_eq!(clip.sample(99.0).root_position, clip.poses[9].root_position);
    let mut worst: f64 = 0.0;
    for k in 0..9 {
        for s in [0.0, 0.25, 0.5, 0.9] {
            let pose = clip.sample((f64::from(k) + s) / 30.0);
            let (a, b) = (&clip.poses[k as usize], &clip.poses[k as usize + 1]);
            worst = worst.max(pose.root_position.distance(a.root_position.lerp(b.root_position, s)));
            for j in 0..5 {
                // The arc is divided in the ratio s: the share of the turn from a to b.
                let turn = (a.joints[j].conjugate() * b.joints[j]).to_scaled_axis();
                let turn = if turn.length() > std::f64::consts::PI { continue } else { turn };
                worst = worst.max(angle(pose.joints[j], a.joints[j] * DQuat::from_scaled_axis(turn * s)));
            }
        }
    }
    println!("largest difference {worst:.1e}, allowed 1e-7");
    assert!(worst < 1e-7);
}

/// A body that yaws at 2 rad/s while it leans, and a joint that turns at (0.5, 0, 0) in its own axes after a fixed turn.
#[test]
fn velocities_are_those_of_the_motion() {
    let lean = DQuat::from_rotation_x(0.6);
    let bent = DQuat::from_rotation_z(0.8);
    let poses = (0..61).map(|k| {
        let t = f64::from(k) / 60.0;
        Pose {
            root_position: DVec3::new(t * t, 1.0, -3.0 * t),
            root_rotation: DQuat::from_rotation_y(2.0 * t) * lean,
            joints: vec![bent * DQuat::from_rotation_x(0.5 * t)],
        }
    });
    let clip =
        MotionClip { name: "turn".into(), frame_rate: 60.0, joints: vec!["chest".into()], poses: poses.collect() };
    let model = tiny_model();
    let fitted = clip.to_model(&model).unwrap();
    let mut worst: f64 = 0.0;
    for t in [0.0, 0.1, 0.5, 0.777, 1.0] {
        let v = clip.sample_velocity(t);
        let f = fitted.sample_velocity(t);
        worst = worst.max((v.root_angular - DVec3::new(0.0, 2.0, 0.0)).length());
        worst = worst.max((v.joints[0] - DVec3::new(0.5, 0.0, 0.0)).length());
        assert!((v.root_linear - DVec3::new(2.0 * t, 0.0, -3.0)).length() < 0.02, "{}", v.root_linear);
        assert_eq!((v.root_linear, v.root_angular, v.joints[0]), (f.root_linear, f.root_angular, f.joints[5]));
    }
    println!("largest difference {worst:.1e} rad/s, allowed 1e-6");
    assert!(worst < 1e-6);
    // Half the speed halves the velocity.
    let slow = clip.time_scaled(2.0).unwrap();
    assert!((slow.duration() - 2.0).abs() < 1e-12);
    assert!((slow.sample_velocity(1.0).root_angular.y - 1.0).abs() < 1e-6);
}

#[test]
fn resampling_keeps_the_ends_and_the_motion() {
    let clip = wild_clip(&mut RandomStream::new(3, 1), 12);
    let fine = clip.resample(120.0).unwrap();
    assert_eq!(fine.poses.len(), 45);
    assert!((fine.duration() - clip.duration()).abs() < 1e-12);
    for (k, pose) in clip.poses.iter().enumerate() {
        assert!(angle(fine.poses[4 * k].joints[2], pose.joints[2]) < 1e-7);
    }
    // A rate that does not divide the duration: the ends stay.
    let odd = clip.resample(37.0).unwrap();
    assert!((odd.duration() - clip.duration()).abs() < 1e-12);
    assert!(odd.poses[odd.poses.len() - 1].root_position.distance(clip.poses[11].root_position) < 1e-12);
    assert!(matches!(clip.resample(0.0), Err(ClipError::Option { option: "rate", .. })));
    assert!(matches!(clip.resample(f64::NAN), Err(ClipError::Option { .. })));
}

/// A step cycle that walks 0.8 m and turns 30 degrees, whose end does not quite meet its start.
fn step_cycle(gap: f64) -> MotionClip {
    let poses = (0..=24).map(|k| {
        let s = f64::from(k) / 24.0;
        let swing = (s * std::f64::consts::TAU).sin();
        Pose {
            root_position: DVec3::new(1.0 + 0.1 * s, 0.9 + 0.02 * swing + gap * s, -2.0 - 0.8 * s),
            root_rotation: DQuat::from_rotation_y(0.4 + s * 30f64.to_radians()) * DQuat::from_rotation_x(0.1 + gap * s),
            joints: vec![DQuat::from_rotation_x(0.5 * swing + gap * s), DQuat::from_rotation_x(-0.5 * swing)],
        }
    });
    let joints = vec!["thigh_left".into(), "thigh_right".into()];
    MotionClip { name: "step".into(), frame_rate: 30.0, joints, poses: poses.collect() }
}

#[test]
fn repetition_carries_place_and_heading_on() {
    let cycle = step_cycle(0.0);
    let long = cycle.repeated(6, 0.0).unwrap();
    assert_eq!(long.poses.len(), 6 * 24 + 1);
    assert!((long.duration() - 6.0 * cycle.duration()).abs() < 1e-12);
    assert!(long.poses[..24] == cycle.poses[..24], "the first cycle is the clip, bit for bit");
    // Six turns of 30 degrees: half a circle.
    let end = long.poses[144].root_rotation * long.poses[0].root_rotation.conjugate();
    assert!(angle(end, DQuat::from_rotation_y(std::f64::consts::PI)) < 1e-9);
    // Every cycle is the first one moved rigidly: the step length is the same, the height is the same.
    for k in 0..120 {
        let (a, b) = (&long.poses[k], &long.poses[k + 24]);
        let (a2, b2) = (&long.poses[k + 1], &long.poses[k + 25]);
        let step = a.root_position.distance(a2.root_position) - b.root_position.distance(b2.root_position);
        assert!(step.abs() < 1e-12 && (a.root_position.y - b.root_position.y).abs() < 1e-12, "frame {k}");
    }
}

#[test]
fn blending_closes_the_seam() {
    let cycle = step_cycle(0.05);
    let jump = |clip: &MotionClip| {
        let speed = |k: usize| angle(clip.poses[k].joints[0], clip.poses[k + 1].joints[0]);
        speed(23) - speed(22)
    };
    let cut = cycle.repeated(3, 0.0).unwrap();
    let blended = cycle.repeated(3, 0.3).unwrap();
    println!("change of turn at the seam: cut {:.4} rad, blended {:.4} rad", jump(&cut), jump(&blended));
    assert!(jump(&blended).abs() < 0.02 && jump(&cut).abs() > 0.04);
    // The last pose meets the first but for place and heading; the first half of a cycle is untouched.
    let last = &blended.poses[72];
    assert!(angle(last.joints[0], cycle.poses[0].joints[0]) < 1e-7);
    assert!((last.root_position.y - cycle.poses[0].root_position.y).abs() < 1e-12);
    assert!(blended.poses[..15] == cycle.poses[..15]);
    assert!(cycle.repeated(0, 0.0).is_err() && cycle.repeated(2, f64::NAN).is_err());
}

#[test]
fn mirrored_twice_is_the_clip_and_once_is_its_image() {
    let clip = wild_clip(&mut RandomStream::new(4, 1), 6);
    let once = clip.mirrored().unwrap();
    assert_eq!(once.mirrored().unwrap(), clip);
    assert_ne!(once, clip);
    // The image of every joint lies mirrored in x (the tiny body is symmetric).
    let model = tiny_model();
    let swap = |name: &str| match name.strip_suffix("_left") {
        Some(stem) => format!("{stem}_right"),
        None => name.replace("_right", "_left"),
    };
    for (a, b) in link_places(&clip, &model).iter().zip(link_places(&once, &model)) {
        for (link, place) in a.iter().enumerate() {
            let partner = model.link_index(&swap(&model.links[link].name)).unwrap();
            let image = place.position * DVec3::new(-1.0, 1.0, 1.0);
            assert!(b[partner].position.distance(image) < 1e-12, "{}", model.links[link].name);
        }
    }
    let mut lone = clip.clone();
    lone.joints[2] = "hat".into();
    assert!(matches!(lone.mirrored(), Err(ClipError::NoPartner { joint, .. }) if joint == "thigh_left"));
}

#[test]
fn a_clip_for_a_character_goes_by_link_index() {
    let mut model = tiny_model();
    let clip = wild_clip(&mut RandomStream::new(5, 1), 6);
    let fitted = clip.to_model(&model).unwrap();
    let mut pose = fitted.sample(0.0);
    for t in [0.0, 0.05, 0.123, 1.0] {
        let plain = clip.sample(t);
        fitted.sample_into(t, &mut pose);
        assert_eq!(pose.joints[0], DQuat::IDENTITY);
        assert_eq!(pose.root_rotation, plain.root_rotation);
        for (name, rotation) in clip.joints.iter().zip(&plain.joints) {
            assert_eq!(pose.joints[model.link_index(name).unwrap()], *rotation);
        }
    }
    // A hinge keeps the turn about its axis only.
    model.links[2].joint = JointKind::Hinge { axis: DVec3::X };
    let hinged = clip.to_model(&model).unwrap();
    assert!(hinged.poses().iter().all(|p| p.joints[2].y == 0.0 && p.joints[2].z == 0.0));
    // Links that the clip does not name hold still; joints that are no links are refused by name.
    let mut fewer = clip.clone();
    fewer.joints.pop();
    fewer.poses.iter_mut().for_each(|p| p.joints.truncate(4));
    let fewer = fewer.to_model(&model).unwrap();
    assert!(!fewer.drives(5) && fewer.drives(1) && fewer.sample(0.1).joints[5] == DQuat::IDENTITY);
    let mut unknown = clip.clone();
    unknown.joints[3] = "tail".into();
    let message = unknown.to_model(&model).unwrap_err().to_string();
    assert!(message.contains("tail") && message.contains("shin_right"), "{message}");
}

#[test]
fn from_the_origin_facing_ahead() {
    let clip = step_cycle(0.0).moved_to_origin();
    let first = &clip.poses[0];
    assert!(first.root_position.distance(DVec3::new(0.0, 0.9, 0.0)) < 1e-12);
    let facing = first.root_rotation * DVec3::NEG_Z;
    assert!(facing.x.abs() < 1e-12 && facing.z < 0.0, "{facing}");
}
