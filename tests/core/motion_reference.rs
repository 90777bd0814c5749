//! The published reference motions, where they are at hand (they are no part of this project: the tests say so and
//! pass where the folder is missing).
//!
//! Every clip loads by itself, with the map that its joints call for, and lasts as long as its file says. On the
//! skater's own clips every joint lies within 1 mm of the file's forward kinematics: the clips come from the same
//! skeleton, so a looser bound would hide a misplaced joint. Where feet are expected on the ground, they are near it.

use crate::motion_support::{link_places, model};
use bevy_athlete::asset::bvh::Bvh;
use bevy_athlete::asset::joint_map::JointMap;
use bevy_athlete::model::{CharacterModel, ContactKind, ContactPoint, import_bvh};
use glam::DVec3;
use std::path::PathBuf;

/// The folder of reference data beside the checkout, or one level further up.
fn reference() -> Option<PathBuf> {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let found =
        [here.join("../shared/reference"), here.join("../../shared/reference")].into_iter().find(|p| p.is_dir());
    if found.is_none() {
        println!("skipped: no ../shared/reference/motions");
    }
    found
}

fn ours(p: DVec3) -> DVec3 {
    DVec3::new(p.z, p.y, -p.x)
}

fn contact(name: &str, link: usize, position: DVec3, radius: f64) -> ContactPoint {
    ContactPoint {
        name: name.into(),
        link,
        position,
        radius,
        friction: 1.0,
        kind: ContactKind::Point,
        role: bevy_athlete::model::PointRole::Body,
    }
}

/// The skater from the published table: joint places in the pelvis frame, blades welded to the heels.
fn skater(folder: &std::path::Path) -> CharacterModel {
    let table = std::fs::read_to_string(folder.join("skater_mass_table.csv")).unwrap();
    let mut places: Vec<(String, usize, DVec3)> = Vec::new();
    for row in table.lines().skip(1).map(|l| l.split(',').collect::<Vec<_>>()) {
        if row[2] == "weld" {
            continue;
        }
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        let name = row[0].trim_start_matches("h_").replace("heel", "foot");
        let parent = row[1].trim_start_matches("h_").replace("heel", "foot");
        let parent = places.iter().position(|p| p.0 == parent).unwrap_or(0);
        places.push((name, parent, ours(DVec3::new(number(3), number(4), number(5)))));
    }
    let links: Vec<_> = places
        .iter()
        .enumerate()
        .map(|(k, (name, parent, p))| match k {
            0 => (name.as_str(), None, [0.0; 3]),
            _ => (name.as_str(), Some(*parent), (*p - places[*parent].2).to_array()),
        })
        .collect();
    let mut skater = model("skater", &links);
    skater.contact_points.clear();
    for foot in ["foot_left", "foot_right"] {
        let link = skater.link_index(foot).unwrap();
        for x in [0.0216 - 0.104, 0.0216 + 0.104] {
            let end = ours(DVec3::new(x, -0.054 - 0.0486, 0.0));
            skater.contact_points.push(contact(foot, link, end, 0.0));
        }
    }
    skater
}

/// A stand-in for the runner: 13 joints, 1.7 m, feet of 24 cm.
fn runner() -> CharacterModel {
    let mut runner = model(
        "runner",
        &[
            ("pelvis", None, [0.0; 3]),
            ("thigh_left", Some(0), [-0.09, -0.05, 0.0]),
            ("shin_left", Some(1), [0.0, -0.42, 0.0]),
            ("foot_left", Some(2), [0.0, -0.42, 0.0]),
            ("thigh_right", Some(0), [0.09, -0.05, 0.0]),
            ("shin_right", Some(4), [0.0, -0.42, 0.0]),
            ("foot_right", Some(5), [0.0, -0.42, 0.0]),
            ("abdomen", Some(0), [0.0, 0.1, 0.0]),
            ("chest", Some(7), [0.0, 0.15, 0.0]),
            ("head", Some(8), [0.0, 0.28, 0.0]),
            ("upper_arm_left", Some(8), [-0.19, 0.22, 0.0]),
            ("forearm_left", Some(10), [0.0, -0.3, 0.0]),
            ("upper_arm_right", Some(8), [0.19, 0.22, 0.0]),
            ("forearm_right", Some(12), [0.0, -0.27, 0.0]),
        ],
    );
    runner.contact_points.clear();
    for foot in ["foot_left", "foot_right"] {
        let link = runner.link_index(foot).unwrap();
        for z in [0.05, -0.15] {
            runner.contact_points.push(contact(foot, link, DVec3::new(0.0, -0.05, z), 0.02));
        }
    }
    runner
}

/// A stand-in for the human with many-segment feet: one trunk joint, an ankle link of another name, heels below it.
fn foot_human() -> CharacterModel {
    let mut human = model(
        "foot_human",
        &[
            ("pelvis", None, [0.0; 3]),
            ("chest", Some(0), [0.0, 0.2, 0.0]),
            ("head", Some(1), [0.0, 0.25, 0.0]),
            ("upper_arm_left", Some(1), [-0.17, 0.2, 0.0]),
            ("forearm_left", Some(3), [0.0, -0.26, 0.0]),
            ("upper_arm_right", Some(1), [0.17, 0.2, 0.0]),
            ("forearm_right", Some(5), [0.0, -0.26, 0.0]),
            ("thigh_left", Some(0), [-0.08, -0.05, 0.0]),
            ("shin_left", Some(7), [0.0, -0.37, 0.0]),
            ("medial_metatarsal_left", Some(8), [0.0, -0.37, 0.0]),
            ("heel_left", Some(9), [0.0, 0.0, 0.03]),
            ("thigh_right", Some(0), [0.08, -0.05, 0.0]),
            ("shin_right", Some(11), [0.0, -0.37, 0.0]),
            ("medial_metatarsal_right", Some(12), [0.0, -0.37, 0.0]),
            ("heel_right", Some(13), [0.0, 0.0, 0.03]),
        ],
    );
    human.contact_points.clear();
    for side in ["left", "right"] {
        for (name, z) in [("heel", 0.0), ("medial_metatarsal", -0.12)] {
            let link = human.link_index(&format!("{name}_{side}")).unwrap();
            human.contact_points.push(contact(name, link, DVec3::new(0.0, -0.06, z), 0.01));
        }
    }
    human
}

/// The links of both feet, by whatever name.
fn feet(model: &CharacterModel) -> [&'static str; 2] {
    let many = model.link_index("foot_left").is_none();
    if many { ["medial_metatarsal_left", "medial_metatarsal_right"] } else { ["foot_left", "foot_right"] }
}

const CLIPS: [(&str, usize, f64, &str); 11] = [
    ("mocap_backflip", 29, 28.0 * 0.0625, "mocap"),
    ("mocap_getup_facedown", 183, 182.0 * 0.016666, "mocap"),
    ("mocap_jump", 107, 106.0 * 0.016666, "mocap"),
    ("mocap_roll", 121, 120.0 * 0.016666, "mocap"),
    ("mocap_run", 25, 24.0 * 0.033332, "mocap"),
    ("mocap_walk", 39, 38.0 * 0.033332, "mocap"),
    ("skate_gliding", 80, 79.0 * 0.0333333, "skate"),
    ("skate_jump", 73, 72.0 * 0.0333333, "skate"),
    ("skate_jump_backward_entry", 60, 59.0 * 0.0333333, "skate"),
    ("skate_speed_stroking", 294, 293.0 * 0.0333333, "skate"),
    ("skate_spin_mocap_cm", 151, 150.0 * 0.0333333, "spin"),
];

#[test]
fn every_clip_loads_and_the_feet_are_near_the_ground() {
    let Some(folder) = reference() else { return };
    let skater = skater(&folder);
    println!("clip, character: seconds, poses | lowest sole, mean and highest of the lower sole, m, before grounding");
    for (name, frames, duration, map_name) in CLIPS {
        let bvh = Bvh::load(folder.join(format!("motions/{name}.bvh"))).unwrap();
        assert_eq!(bvh.frame_count(), frames, "{name}");
        assert!((bvh.duration() - duration).abs() < 1e-9, "{name}: {} s", bvh.duration());
        let map = JointMap::detect(&bvh).expect(name);
        assert_eq!(map.name, map_name, "{name}");
        for character in [&runner(), &skater, &foot_human()] {
            let raw = import_bvh(&bvh, &JointMap { soles: Vec::new(), ..map.clone() }, character).unwrap();
            let heights = raw.sole_heights(character, &feet(character)).unwrap();
            println!(
                "{name}, {}: {:.4} s, {} poses | lowest {:+.4} ({} at {:.2} s), mean {:+.4}, highest {:+.4}",
                character.name,
                raw.duration(),
                raw.poses.len(),
                heights.lowest,
                heights.lowest_link,
                heights.lowest_time,
                heights.mean,
                heights.highest
            );
            let clip = import_bvh(&bvh, &map, character).unwrap();
            assert!((clip.duration() - duration).abs() < 1e-9);
            if !map.soles.is_empty() {
                let grounded = clip.sole_heights(character, &feet(character)).unwrap();
                assert!(grounded.quantile(map.sole_fraction).abs() < 1e-9, "{name}: {}", grounded.lowest);
                println!("    on the ground: lowest {:+.4}, mean {:+.4}", grounded.lowest, grounded.mean);
            }
            // The source's own ground is right for its own body to 2 cm, for another body to 25 cm.
            let own = map.name == "skate" && character.name == "skater";
            assert!(heights.lowest.abs() < if own { 0.02 } else { 0.25 }, "{name}: {}", heights.lowest);
            report_posture(&clip, character);
        }
    }
}

/// Facing at the start, and whether elbows and knees bend the way a body's do, on average over the clip.
fn report_posture(clip: &bevy_athlete::asset::clip::MotionClip, model: &CharacterModel) {
    let facing = clip.poses[0].root_rotation * DVec3::NEG_Z;
    let mut line = format!("    starts facing ({:+.2}, {:+.2}, {:+.2}); mean bend", facing.x, facing.y, facing.z);
    for (link, forward) in
        [("shin_left", false), ("shin_right", false), ("forearm_left", true), ("forearm_right", true)]
    {
        let joint = clip.joints.iter().position(|j| j == link).unwrap();
        // Where the lower limb points in the upper limb's axes: -z is ahead.
        let ahead =
            clip.poses.iter().map(|p| -(p.joints[joint] * DVec3::NEG_Y).z).sum::<f64>() / clip.poses.len() as f64;
        line += &format!(" {link} {ahead:+.2}");
        assert!(
            if forward { ahead > -0.02 } else { ahead < 0.02 },
            "{}: {link} bends the wrong way: {ahead}",
            clip.name
        );
    }
    let places = link_places(clip, model);
    let head = model.link_index("head").unwrap();
    let mean: f64 = places.iter().map(|p| p[head].position.y).sum::<f64>() / places.len() as f64;
    println!("{line}; mean height of the head's joint {mean:.2} m");
}

#[test]
fn the_skaters_joints_lie_where_the_files_put_them() {
    let Some(folder) = reference() else { return };
    let skater = skater(&folder);
    for (name, ..) in CLIPS.iter().filter(|c| c.3 == "skate") {
        let bvh = Bvh::load(folder.join(format!("motions/{name}.bvh"))).unwrap();
        let map = JointMap::detect(&bvh).unwrap();
        let clip = import_bvh(&bvh, &map, &skater).unwrap();
        let mut worst: f64 = 0.0;
        for (frame, places) in link_places(&clip, &skater).iter().enumerate() {
            for (joint, source) in bvh.joints().iter().zip(bvh.world_transforms(frame)) {
                let link = joint.name.trim_start_matches("h_").replace("heel", "foot");
                let place = places[skater.link_index(&link).unwrap()].position;
                worst = worst.max(place.distance(ours(source.position)));
            }
        }
        println!("{name}: largest distance {:.6} mm, allowed 1 mm", worst * 1e3);
        assert!(worst < 1e-3);
    }
}

/// The run repeated six times keeps its stride and meets itself at the seam.
#[test]
fn the_run_repeats() {
    let Some(folder) = reference() else { return };
    let bvh = Bvh::load(folder.join("motions/mocap_run.bvh")).unwrap();
    let runner = runner();
    let cycle = import_bvh(&bvh, &JointMap::detect(&bvh).unwrap(), &runner).unwrap();
    // The clip is one step and its mirror image: its last pose looks aside by 5 degrees, which is no turn.
    let long = cycle.repeated_straight(6, 0.2).unwrap();
    let stride = |k: usize| (long.poses[24 * (k + 1)].root_position - long.poses[24 * k].root_position).length();
    println!("stride {:.3} m in {:.3} s, total {:.2} s", stride(0), cycle.duration(), long.duration());
    assert!((stride(0) - stride(5)).abs() < 0.01);
    let aside = long.poses[144].root_position - long.poses[0].root_position;
    assert!(aside.x.abs() < 0.01 * aside.z.abs(), "{aside}");
    let (a, b) = (cycle.sole_heights(&runner, &[]).unwrap(), long.sole_heights(&runner, &[]).unwrap());
    assert!((a.quantile(0.5) - b.quantile(0.5)).abs() < 0.02, "{} {}", a.quantile(0.5), b.quantile(0.5));
}

/// Limbs of the character point where the source's limbs point, and left is left: with joint axes along the bones
/// (the spin), a swapped axis would still give a clip that loads.
#[test]
fn limbs_point_where_the_sources_limbs_point() {
    let Some(folder) = reference() else { return };
    let skater = skater(&folder);
    let mocap = [
        ("left_hip", "left_knee", "left_ankle", "left_shoulder", "left_elbow", "left_wrist"),
        ("right_hip", "right_knee", "right_ankle", "right_shoulder", "right_elbow", "right_wrist"),
    ];
    let spin = [
        ("LeftHip", "LeftKnee", "LeftAnkle", "LeftShoulder", "LeftElbow", "LeftWrist"),
        ("RightHip", "RightKnee", "RightAnkle", "RightShoulder", "RightElbow", "RightWrist"),
    ];
    for (name, _, _, map_name) in CLIPS.iter().filter(|c| c.3 != "skate") {
        let bvh = Bvh::load(folder.join(format!("motions/{name}.bvh"))).unwrap();
        let map = JointMap::detect(&bvh).unwrap();
        let clip = import_bvh(&bvh, &map, &skater).unwrap();
        let sides = if *map_name == "mocap" { mocap } else { spin };
        let (mut limbs, mut hips): (f64, f64) = (0.0, 0.0);
        for (frame, places) in link_places(&clip, &skater).iter().enumerate() {
            let world = bvh.world_transforms(frame);
            let source = |joint: &str| map.world_rotation() * world[bvh.joint_index(joint).unwrap()].position;
            let own = |link: &str| places[skater.link_index(link).unwrap()].position;
            for (side, (hip, knee, ankle, shoulder, elbow, wrist)) in ["left", "right"].iter().zip(sides) {
                for (joints, links) in [
                    ((hip, knee), ("thigh", "shin")),
                    ((knee, ankle), ("shin", "foot")),
                    ((shoulder, elbow), ("bicep", "forearm")),
                    ((elbow, wrist), ("forearm", "hand")),
                ] {
                    let expected = source(joints.1) - source(joints.0);
                    let found = own(&format!("{}_{side}", links.1)) - own(&format!("{}_{side}", links.0));
                    limbs = limbs.max(found.angle_between(expected));
                }
            }
            let expected = source(sides[1].0) - source(sides[0].0);
            hips = hips.max((own("thigh_right") - own("thigh_left")).angle_between(expected));
        }
        println!("{name}: limbs within {:.4} degrees, hip line {:.1}", limbs.to_degrees(), hips.to_degrees());
        assert!(limbs.to_degrees() < 0.1 && hips.to_degrees() < 10.0);
    }
}
