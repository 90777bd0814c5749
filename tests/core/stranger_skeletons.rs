//! A stranger's motion file goes in without a map.
//!
//! - One motion of each preset is written as the skeletons of seven tools and databases, of a Z-up one and of one without
//!   names (`support/bvh_writer.rs`): other names, units, axes, rest poses, rotation orders. It has to come back within 5 mm
//!   and 1 degree at every link that the skeleton has. Comparing positions alone would not notice a limb that is turned
//!   about its bone; comparing rotations alone would not notice a wrong unit.
//! - The map that was found is written to text, read back, and makes the same clip.
//! - The picture of a map shows both skeletons as they are: bones of one direction, arms level in a T-pose, what drives nothing marked.
//! - What cannot be right is refused, or warned of by the joint's name; headers that lie are named and read.

use crate::bvh_writer::{Convention, conventions, write_bvh};
use crate::motion_support::link_places;
use bevy_athlete::asset::bvh::{Bvh, BvhWarning, FrameTimeUnit};
use bevy_athlete::asset::clip::{MotionClip, Pose};
use bevy_athlete::asset::joint_map::{Fit, JointMap};
use bevy_athlete::cli::map_picture;
use bevy_athlete::model::{
    CharacterModel, FindMapError, ImportError, KeyPoses, MapWarning, MotionRefusal, MotionWarning, PRESET_NAMES,
    RestPose, check_motion, check_size, find_map, import_bvh, preset,
};
use glam::{DQuat, DVec3};
use std::path::Path;

/// Key poses of a shipped skill on a preset: joints by their names on that body, and toes that bend.
fn motion(model: &CharacterModel) -> MotionClip {
    let skater = preset("skater").unwrap();
    let path = "assets/skills/skating/stroking/stroking.keyposes.ron";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let clip = KeyPoses::load(path).unwrap().to_clip(&skater).unwrap();
    let theirs = |name: &str| {
        let other = [("upper_arm", "bicep"), ("medial_metatarsal", "foot"), ("chest", "spine")];
        let renamed = other.iter().find_map(|(a, b)| name.starts_with(a).then(|| name.replace(a, b)));
        let names = [name.to_owned(), renamed.unwrap_or_default()];
        clip.joints.iter().position(|j| names.contains(j))
    };
    let driven = |name: &str| theirs(name).is_some() || name.starts_with("toe") || name.starts_with("medial_phal");
    let joints: Vec<String> = model.links[1..].iter().map(|l| l.name.clone()).filter(|n| driven(n)).collect();
    let poses = clip.poses.iter().enumerate();
    let poses = poses.map(|(k, pose)| Pose {
        root_position: pose.root_position,
        root_rotation: pose.root_rotation,
        joints: joints
            .iter()
            .map(|name| match theirs(name) {
                Some(at) => pose.joints[at],
                // Toes lie flat most of the time.
                None => DQuat::from_rotation_x((0.06 * k as f64).sin().max(0.7) - 0.7),
            })
            .collect(),
    });
    let poses = poses.collect();
    MotionClip { name: "stroking".into(), frame_rate: clip.frame_rate, joints, poses }
}

/// Largest distance (m) and angle (degrees) between two clips at the links that both drive, with the link.
fn difference(a: &MotionClip, b: &MotionClip, model: &CharacterModel) -> (f64, f64, String) {
    let (a_places, b_places) = (link_places(a, model), link_places(b, model));
    assert_eq!(a_places.len(), b_places.len());
    let (mut metres, mut degrees, mut at) = (0.0_f64, 0.0_f64, String::new());
    for (link, own) in model.links.iter().enumerate() {
        if link > 0 && !(a.joints.contains(&own.name) && b.joints.contains(&own.name)) {
            continue;
        }
        for (x, y) in a_places.iter().zip(&b_places) {
            metres = metres.max(x[link].position.distance(y[link].position));
            let angle = 2.0 * x[link].rotation.dot(y[link].rotation).abs().min(1.0).acos().to_degrees();
            if angle > degrees {
                (degrees, at) = (angle, own.name.clone());
            }
        }
    }
    (metres, degrees, at)
}

fn grounded(clip: &MotionClip, map: &JointMap, model: &CharacterModel) -> MotionClip {
    let soles: Vec<&str> = map.soles.iter().map(String::as_str).collect();
    clip.grounded_at(model, &soles, map.sole_fraction).unwrap().0
}

#[test]
fn one_motion_comes_back_from_every_skeleton() {
    let mut wrong = Vec::new();
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let clip = motion(&model);
        for convention in conventions() {
            let text = write_bvh(&convention, &clip, &model);
            let bvh = Bvh::parse(&text).expect(convention.name);
            let found = match find_map(&bvh, &model) {
                Ok(found) => found,
                Err(error) => {
                    wrong.push(format!("{} on {name}: {error}", convention.name));
                    continue;
                }
            };
            let back = import_bvh(&bvh, &found.map, &model).expect(convention.name);
            let missing: Vec<&String> = clip.joints.iter().filter(|j| !back.joints.contains(j)).collect();
            let own = grounded(&clip, &found.map, &model);
            let (metres, degrees, at) = difference(&own.moved_to_origin(), &back.moved_to_origin(), &model);
            println!("{} on {name}: {:.2} mm, {degrees:.3} degrees ({at})", convention.name, 1e3 * metres);
            if metres > 0.005 || degrees > 1.0 || !missing.is_empty() {
                wrong.push(format!(
                    "{} on {name}: {:.1} mm, {degrees:.2} degrees at {at}, missing {missing:?}, {:?}\n{}",
                    convention.name,
                    1e3 * metres,
                    found.warnings,
                    found.table()
                ));
            }
            // As text, for a person to edit, it is the same map.
            let again = JointMap::from_ron(&found.map.to_ron(&[found.table()]).unwrap()).unwrap();
            let (metres, degrees, _) = difference(&back, &import_bvh(&bvh, &again, &model).unwrap(), &model);
            assert!(metres < 1e-5 && degrees < 1e-3, "{}: {metres} m, {degrees} degrees", convention.name);
            assert_eq!(check_motion(&back, &model), Ok(vec![]), "{} on {name}", convention.name);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn convention(name: &str) -> Convention {
    conventions().into_iter().find(|c| c.name == name).unwrap()
}

fn runner_as(name: &str) -> (String, std::sync::Arc<CharacterModel>) {
    let model = preset("runner").unwrap();
    (write_bvh(&convention(name), &motion(&model), &model), model)
}

/// The source stands beside the character and every limb of one has the direction of the other's; a wrong scale, a turn that only one of
/// them made, or a stick on another joint would show.
#[test]
fn the_picture_of_a_map_has_both_skeletons_alike() {
    for (name, zero) in [("mixamo", true), ("cmu", true), ("lafan1", false)] {
        let (text, model) = runner_as(name);
        let bvh = Bvh::parse(&text).unwrap();
        let found = find_map(&bvh, &model).unwrap();
        let picture = map_picture(&bvh, &found, &model, 5, 0.9).unwrap();
        assert_eq!(picture.frames.len(), 5 + usize::from(zero), "{name}");
        let (own, all) = (model.links.len(), picture.model.links.len());
        assert_eq!(all, 1 + own + bvh.joints().len());
        assert_eq!(picture.model.mass(), model.mass());
        // The last joint of each row gives the link its place.
        let stick = |link: &str| {
            let row = found.rows.iter().find(|row| row.link == link).unwrap();
            1 + own + bvh.joint_index(row.joints.last().unwrap()).unwrap()
        };
        let body = |link: &str| 1 + model.link_index(link).unwrap();
        for (k, frame) in picture.frames.iter().enumerate() {
            let at = |link: usize| frame.links[link].position;
            let apart = at(body("pelvis")).distance(at(stick("pelvis")));
            assert!((1.0..2.0).contains(&apart), "{name}, cell {k}: {apart} m apart");
            for (upper, lower) in [
                ("thigh_left", "shin_left"),
                ("thigh_right", "shin_right"),
                ("upper_arm_left", "forearm_left"),
                ("upper_arm_right", "forearm_right"),
            ] {
                let theirs = (at(stick(lower)) - at(stick(upper))).normalize();
                let ours = (at(body(lower)) - at(body(upper))).normalize();
                assert!(theirs.angle_between(ours) < 0.02, "{name}, cell {k}, {upper}: {theirs} and {ours}");
                if k == 0 && zero && name == "mixamo" && upper.starts_with("upper_arm") {
                    assert!(theirs.y.abs() < 0.02, "arms are level in a T-pose: {theirs}");
                }
            }
        }
        let fingers = picture.frames[0].marked.iter().filter(|(link, _)| *link > own);
        let fingers: Vec<&str> = fingers.map(|(link, _)| picture.model.links[*link].name.as_str()).collect();
        let unmapped = |name: &&str| found.unmapped.iter().any(|(joint, _)| joint == name);
        assert!(fingers.iter().all(unmapped), "{name}: {fingers:?}");
        assert!(name != "mixamo" || fingers.contains(&"mixamorig:LeftHandIndex1"), "{fingers:?}");
        assert!(!picture.frames[0].marked.contains(&(body("thigh_left"), 0)));
    }
}

#[test]
fn what_was_taken_for_what_is_told() {
    let (text, model) = runner_as("cmu");
    let found = find_map(&Bvh::parse(&text).unwrap(), &model).unwrap();
    assert_eq!((found.rest, found.unit.as_str()), (RestPose::T, "inches / 0.45"));
    let row = |link: &str| found.rows.iter().find(|r| r.link == link).unwrap().joints.join(" ");
    assert_eq!(row("upper_arm_left"), "LeftShoulder LeftArm");
    assert_eq!(row("thigh_right"), "RightHipJoint RightUpLeg");
    assert_eq!(row("head"), "Neck Neck1 Head");
    assert!(found.unmapped.contains(&("LeftFingerBase".into(), "fingers")), "{:?}", found.unmapped);
    let table = found.table();
    assert!(["RightForeArm", "T-pose", "+Y up", "LeftFingerBase"].iter().all(|w| table.contains(w)), "{table}");

    let (text, model) = runner_as("lafan1");
    let found = find_map(&Bvh::parse(&text).unwrap(), &model).unwrap();
    assert_eq!((found.rest, found.unit.as_str()), (RestPose::None, "cm"));
    let (text, model) = runner_as("z_up");
    let found = find_map(&Bvh::parse(&text).unwrap(), &model).unwrap();
    assert_eq!((found.rest, found.map.up, found.map.facing), (RestPose::A, DVec3::Z, DVec3::NEG_Y));
    assert!(found.unmapped.contains(&("Reference".into(), "above the hips")), "{:?}", found.unmapped);
    // Names that say no sides: toes and knees do.
    let (text, model) = runner_as("nameless");
    let found = find_map(&Bvh::parse(&text).unwrap(), &model).unwrap();
    assert!(
        matches!(&found.warnings[..], [MapWarning::SidesByShape { left }] if left == "b6x"),
        "{:?}",
        found.warnings
    );
    // A mirrored file: what is called left lies on the right of the toes.
    let (text, model) = runner_as("xsens");
    let text = text.replace("Left", "Port").replace("Right", "Left").replace("Port", "Right");
    let found = find_map(&Bvh::parse(&text).unwrap(), &model).unwrap();
    assert!(
        matches!(&found.warnings[..], [MapWarning::SidesDisagree { left }] if left == "LeftHip"),
        "{:?}",
        found.warnings
    );
    assert_eq!(found.rows.iter().find(|r| r.link == "shin_left").unwrap().joints, ["RightKnee"]);
}

#[test]
fn a_map_that_was_found_for_one_body_serves_the_others() {
    let (text, runner) = runner_as("mixamo");
    let bvh = Bvh::parse(&text).unwrap();
    let map = find_map(&bvh, &runner).unwrap().map;
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let clip = import_bvh(&bvh, &map, &model).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(check_motion(&clip, &model), Ok(vec![]), "{name}");
    }
}

#[test]
fn files_without_a_body_are_refused_by_what_is_missing() {
    let model = preset("runner").unwrap();
    let snake: String = (0..50).map(|i| format!("JOINT s{i} {{ OFFSET 0 1 0 CHANNELS 1 Xrotation ")).collect();
    let values = vec!["0"; 50].join(" ");
    let snake = snake.replacen("JOINT", "HIERARCHY ROOT", 1)
        + &"} ".repeat(50)
        + " MOTION Frames: 1 Frame Time: 0.1\n"
        + &values;
    let error = find_map(&Bvh::parse(&snake).unwrap(), &model).unwrap_err();
    assert!(matches!(&error, FindMapError::NotInFile { joints, .. } if joints.len() == 50), "{error}");
    let message = error.to_string();
    assert!(
        ["two legs", "s39", "and 10 more", "docs/book/motions.md"].iter().all(|w| message.contains(w)),
        "{message}"
    );
}

/// A joint that is forgotten is not reported one at a time.
#[test]
fn all_that_is_unmapped_is_named_at_once() {
    let (text, model) = runner_as("mixamo");
    let bvh = Bvh::parse(&text).unwrap();
    let mut map = find_map(&bvh, &model).unwrap().map;
    map.ignored.clear();
    match import_bvh(&bvh, &map, &model) {
        Err(ImportError::UnmappedJoints { joints, .. }) => {
            assert!(joints.len() >= 4 && joints.contains(&"mixamorig:LeftHandIndex1".to_owned()), "{joints:?}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_cannot_be_right_is_refused_or_named() {
    // Legs and arms that hang where the file has them splayed and out: they cross.
    let (text, model) = runner_as("cmu");
    let bvh = Bvh::parse(&text).unwrap();
    let mut map = find_map(&bvh, &model).unwrap().map;
    for entry in &mut map.links {
        (entry.up, entry.facing) = (None, None);
    }
    let warnings = check_motion(&import_bvh(&bvh, &map, &model).unwrap(), &model).unwrap();
    let named = |joint: &str| {
        warnings.iter().any(|w| match w {
            MotionWarning::Crossed { joint: j, .. }
            | MotionWarning::InTrunk { joint: j, .. }
            | MotionWarning::OutOfRange { joint: j, .. } => j == joint,
            _ => false,
        })
    };
    assert!(named("forearm_left") || named("upper_arm_left"), "{warnings:?}");
    assert!(named("forearm_right") || named("upper_arm_right"), "{warnings:?}");

    // On its head.
    let mut map = find_map(&bvh, &model).unwrap().map;
    (map.up, map.facing) = (-map.up, map.facing);
    for entry in &mut map.links {
        entry.up.get_or_insert(DVec3::Y);
        entry.facing.get_or_insert(DVec3::Z);
    }
    (map.root.up, map.root.facing) = (Some(DVec3::Y), Some(DVec3::Z));
    let refused = check_motion(&import_bvh(&bvh, &map, &model).unwrap(), &model).unwrap_err();
    assert!(matches!(&refused, MotionRefusal::UpsideDown { head, .. } if head == "head"), "{refused}");

    // Centimetres taken for metres: refused where lengths are taken as they are.
    let (text, model) = runner_as("xsens");
    let bvh = Bvh::parse(&text).unwrap();
    let mut map = find_map(&bvh, &model).unwrap().map;
    map.unit = 1.0;
    assert!(matches!(check_size(&bvh, &map), Ok(Some(MotionWarning::Size { leg })) if leg > 80.0));
    map.fit = Fit::None;
    assert!(matches!(check_size(&bvh, &map), Err(MotionRefusal::Size { leg }) if leg > 80.0));
    map.unit = 0.01;
    assert_eq!(check_size(&bvh, &map), Ok(None));
}

#[test]
fn headers_that_lie_are_named_and_read() {
    let (text, _) = runner_as("xsens");
    let whole = Bvh::parse(&text).unwrap();
    assert_eq!(whole.warnings(), []);
    let frames = whole.frame_count();
    for declared in [frames - 1, frames + 1] {
        let bvh = Bvh::parse(&text.replace(&format!("Frames: {frames}"), &format!("Frames: {declared}"))).unwrap();
        assert_eq!(bvh.warnings(), [BvhWarning::FrameCount { declared, found: frames }]);
        assert_eq!(bvh.frame(frames - 1), whole.frame(frames - 1));
        let message = bvh.warnings()[0].to_string();
        assert!(
            message.contains(&format!("counts {declared}")) && message.contains(&format!("holds {frames}")),
            "{message}"
        );
    }
    let line = text.lines().find(|l| l.starts_with("Frame Time")).unwrap();
    for (written, seconds, unit) in [
        ("33.333333", 1.0 / 30.0, FrameTimeUnit::Milliseconds),
        ("8.3333333", 1.0 / 120.0, FrameTimeUnit::Milliseconds),
        ("40", 0.04, FrameTimeUnit::Milliseconds),
        ("30", 1.0 / 30.0, FrameTimeUnit::Rate),
        ("120", 1.0 / 120.0, FrameTimeUnit::Rate),
        ("59.94", 1.0 / 59.94, FrameTimeUnit::Rate),
    ] {
        let bvh = Bvh::parse(&text.replace(line, &format!("Frame Time: {written}"))).unwrap();
        assert!((bvh.frame_time() - seconds).abs() < 1e-6, "{written}: {}", bvh.frame_time());
        assert!(matches!(bvh.warnings(), [BvhWarning::FrameTime { taken, .. }] if *taken == unit), "{written}");
    }
    assert!(Bvh::parse(&text.replace(line, "Frame Time: 5000")).is_err());
}

/// Names in the spellings of other tools, on one skeleton.
#[test]
fn sides_in_any_spelling() {
    let model = preset("runner").unwrap();
    let clip = motion(&model);
    for sides in [["Left", "Right"], ["left_", "right_"], ["L_", "R_"], ["lft", "rgt"], ["l", "r"]] {
        let spelled = Convention { sides, ..convention("xsens") };
        let bvh = Bvh::parse(&write_bvh(&spelled, &clip, &model)).unwrap();
        let found = find_map(&bvh, &model).unwrap();
        assert_eq!(found.warnings, [], "{sides:?}");
        let left = found.rows.iter().find(|r| r.link == "shin_left").unwrap();
        assert_eq!(left.joints, [format!("{}Knee", sides[0])]);
    }
}
