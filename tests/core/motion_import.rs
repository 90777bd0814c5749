//! Motion input keeps its promises, from the text of a BVH file to the links of a character.
//!
//! - Every rotation order against matrix products written out here by hand: a parser that assumed one order, or
//!   multiplied from the wrong side, would pass a test with a single order or with small angles.
//! - The mapped character's joints lie where the forward kinematics of the file puts them (below 1 mm), under two
//!   skeletons of different axes, units and root conventions: comparing quaternions alone would not notice a wrong
//!   axis change that is applied to rotations and positions alike.
//! - Mutated files (BVH, clip, map) never panic, and whatever is accepted can be imported and sampled.

use crate::motion_support::{TINY, TINY_MAP, link_places, model, tiny_model};
use bevy_athlete::asset::bvh::{Bvh, BvhError, BvhLimits};
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::asset::joint_map::{JointMap, MapError};
use bevy_athlete::math::RandomStream;
use bevy_athlete::model::{ImportError, import_bvh};
use glam::{DMat3, DQuat, DVec3};

fn turn(axis: char, degrees: f64) -> DMat3 {
    let (s, c) = degrees.to_radians().sin_cos();
    let rows = match axis {
        'X' => [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]],
        'Y' => [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]],
        _ => [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
    };
    DMat3::from_cols_array_2d(&rows).transpose()
}

#[test]
fn all_six_rotation_orders_are_matrix_products_in_channel_order() {
    let angles = [37.0, -112.0, 61.0];
    let mut worst: f64 = 0.0;
    for order in ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"] {
        let names: Vec<String> = order.chars().map(|c| format!("{c}rotation")).collect();
        let text = format!(
            "HIERARCHY\nROOT a\n{{ OFFSET 1 2 3 CHANNELS 3 {0}\nJOINT b\n{{\nOFFSET 0 1 0\nCHANNELS 6 Zposition Yposition Xposition {0}\nEnd Site {{ OFFSET 0 0 1 }} }} }}\nMOTION\nFrames: 1\nFrame Time: 0.1\n{1} {2} {3} 6 5 4 {3} {1} {2}\n",
            names.join(" "),
            angles[0],
            angles[1],
            angles[2]
        );
        let bvh = Bvh::parse(&text).expect(order);
        let axes: Vec<char> = order.chars().collect();
        let product = |a: [f64; 3]| turn(axes[0], a[0]) * turn(axes[1], a[1]) * turn(axes[2], a[2]);
        let root = product(angles);
        let child = root * product([angles[2], angles[0], angles[1]]);
        let world = bvh.world_transforms(0);
        let place = DVec3::new(1.0, 2.0, 3.0) + root * DVec3::new(4.0, 5.0, 6.0);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            worst = worst.max((world[0].rotation * axis - root * axis).length());
            worst = worst.max((world[1].rotation * axis - child * axis).length());
        }
        worst = worst.max((world[1].position - place).length());
    }
    println!("six orders: largest difference {worst:.1e}, allowed 1e-12");
    assert!(worst < 1e-12);
}

#[test]
fn layout_of_the_text_does_not_matter() {
    let plain = Bvh::parse(TINY).unwrap();
    let variants = [
        TINY.replace('\n', "\r\n"),
        TINY.replace(' ', "\t"),
        TINY.replace('\n', "\n\n  \t "),
        format!("\u{feff}\n  {TINY}\n\n"),
        TINY.replace("Frames:", "Frames :").replace("Frame Time:", "FRAME TIME :"),
        TINY.replace('{', "\n{\n").replace("JOINT", "joint").replace("End Site", "End site toes"),
    ];
    for text in &variants {
        assert_eq!(Bvh::parse(text).as_ref(), Ok(&plain), "{text:?}");
    }
    // Names with blanks, brace on the same line.
    let spaced = TINY.replace("ROOT Hips\n{", "ROOT My Hips {");
    assert_eq!(Bvh::parse(&spaced).unwrap().joints()[0].name, "My Hips");
}

#[test]
fn errors_name_line_joint_and_what_would_be_valid() {
    let cases = [
        (TINY.replace("OFFSET 0 -40 0", "OFFSET 0 nan 0"), "joint `LeftShin`"),
        (TINY.replace("Frames: 3", "Frames: 4").replace("50 90 20 30", "50 90 20"), "counts 4 frames"),
        (TINY.replace("Frames: 3", "Frames: -1"), "number of frames"),
        (TINY.replace("Frames: 3", "Frames: 0"), "at least one"),
        (TINY.replace("Frames: 3", "Frames: 99999999999"), "at most"),
        (TINY.replace("Frame Time: 0.05", "Frame Time: 0"), "0.00001 to 2"),
        (TINY.replace("JOINT RightShin", "JOINT LeftShin"), "unique"),
        (TINY.replace("Yrotation", "Wrotation"), "Wrotation"),
        (TINY.replace("3 Xrotation Yrotation Zrotation", "3 Xrotation Xrotation Zrotation"), "twice"),
        (TINY.replace("CHANNELS 3 Xrotation", "CHANNELS 7 Xrotation"), "0 to 6"),
        (TINY.replace("HIERARCHY", "HIERARCHIE"), "HIERARCHY"),
        (TINY[..TINY.len() / 3].to_owned(), "ends where"),
        (String::new(), "HIERARCHY"),
    ];
    for (text, needle) in cases {
        let message = Bvh::parse(&text).expect_err(needle).to_string();
        println!("{message}");
        assert!(message.contains(needle), "`{message}` should mention `{needle}`");
    }
    let short = TINY.replace("50 90 20 30", "50 90 20");
    match Bvh::parse(&short) {
        Err(BvhError::ValueCount { line, needed, found, .. }) => {
            assert_eq!(found + 1, needed);
            assert!(short.lines().nth(line - 1).unwrap().starts_with("50 90 20"), "line {line}");
        }
        other => panic!("{other:?}"),
    }
    let small = BvhLimits { joints: 2, ..BvhLimits::default() };
    assert!(matches!(Bvh::parse_with_limits(TINY, small), Err(BvhError::TooLarge { what: "joints", .. })));
}

/// Joints of the tiny file's skeleton against the links it drives: units, axes, and two root conventions.
#[test]
fn the_character_stands_where_the_file_stands() {
    let bvh = Bvh::parse(TINY).unwrap();
    let map = JointMap::from_ron(TINY_MAP).unwrap();
    let model = tiny_model();
    let anchored = TINY_MAP.replace(
        "anchor: Joint",
        "anchor: Between(joints: (\"LeftThigh\", \"RightThigh\"), links: (\"thigh_left\", \"thigh_right\"))",
    );
    let mut worst: f64 = 0.0;
    for map in [map, JointMap::from_ron(&anchored).unwrap()] {
        let clip = import_bvh(&bvh, &map, &model).unwrap();
        assert_eq!(clip.joints, ["thigh_left", "shin_left", "thigh_right", "shin_right", "chest"]);
        for (frame, places) in link_places(&clip, &model).iter().enumerate() {
            let source = bvh.world_transforms(frame);
            for (joint, link) in crate::motion_support::TINY_PAIRS {
                let p = source[bvh.joint_index(joint).unwrap()].position * 0.01;
                let expected = DVec3::new(p.z, p.y, -p.x);
                worst = worst.max(places[model.link_index(link).unwrap()].position.distance(expected));
            }
        }
    }
    println!("largest distance {worst:.1e} m, allowed 1e-9 m");
    assert!(worst < 1e-9);
}

/// A root on the ground with the hips as its child gives the same clip as a root at the hips.
#[test]
fn a_root_on_the_ground_is_the_same_motion() {
    let map = JointMap::from_ron(TINY_MAP).unwrap();
    let model = tiny_model();
    let plain = import_bvh(&Bvh::parse(TINY).unwrap(), &map, &model).unwrap();
    let grounded = crate::motion_support::with_ground_root();
    let ground_map = TINY_MAP.replace("ignored: [", "ignored: [\"Reference\", \"Back\", ");
    let ground_map = JointMap::from_ron(&ground_map).unwrap();
    let moved = import_bvh(&Bvh::parse(&grounded).unwrap(), &ground_map, &model).unwrap();
    for (a, b) in plain.poses.iter().zip(&moved.poses) {
        assert!(a.root_position.distance(b.root_position) < 1e-12);
        assert!(a.root_rotation.angle_between(b.root_rotation) < 1e-7);
    }
    // Without the word that the extra joint is ignored, it is reported by name.
    let refused = import_bvh(&Bvh::parse(&grounded).unwrap(), &map, &model).unwrap_err();
    assert!(
        matches!(&refused, ImportError::UnmappedJoints { joints, .. } if joints == &["Reference", "Back"]),
        "{refused}"
    );
}

/// A source whose joints have axes of their own along the bones, in a T-pose, poses the character like one without.
#[test]
fn rest_offsets_and_joint_axes() {
    let model = model("arm", &[("pelvis", None, [0.0; 3]), ("upper_arm_left", Some(0), [-0.2, 0.5, 0.0])]);
    let text = "HIERARCHY ROOT hip { OFFSET 0 0 0 CHANNELS 3 Xposition Yposition Zposition\nJOINT arm\n{ OFFSET 0 0 0 CHANNELS 1 Zrotation End Site { OFFSET -1 0 0 } } }\nMOTION\nFrames: 2 Frame Time: 1\n0 0 0 0\n0 0 0 90\n";
    let bvh = Bvh::parse(text).unwrap();
    let by_angles = r#"(name: "t", unit: 1.0, up: (0.0, 1.0, 0.0), facing: (0.0, 0.0, -1.0), root: (link: "pelvis", joints: ["hip"]),
        links: [(link: "upper_arm_left", joints: ["arm"], rest_degrees: (0.0, 0.0, -90.0))])"#;
    let by_axes = by_angles.replace("rest_degrees: (0.0, 0.0, -90.0)", "up: (1.0, 0.0, 0.0), facing: (0.0, 0.0, -1.0)");
    for text in [by_angles, &by_axes] {
        let clip = import_bvh(&bvh, &JointMap::from_ron(text).unwrap(), &model).unwrap();
        // The hanging arm (-Y of the link) points sideways in the T-pose, and down after a quarter turn.
        let down = |frame: usize| clip.poses[frame].joints[0] * DVec3::NEG_Y;
        assert!(down(0).distance(DVec3::NEG_X) < 1e-12, "{}", down(0));
        assert!(down(1).distance(DVec3::NEG_Y) < 1e-12, "{}", down(1));
    }
}

#[test]
fn fitting_spreads_sizes_and_soles_touch_the_ground() {
    let bvh = Bvh::parse(TINY).unwrap();
    let links =
        "(joints: (\"LeftThigh\", \"LeftShin\", \"LeftFoot\"), links: (\"thigh_left\", \"shin_left\", \"shin_left\"))";
    // The character has no feet: a leg of 0.4 m against the source's 0.8 m.
    let text = TINY_MAP.replace("fit: None", &format!("fit: Legs{links}, stride: 2.0, soles: [\"shin_left\"]"));
    let map = JointMap::from_ron(&text).unwrap();
    let model = tiny_model();
    let clip = import_bvh(&bvh, &map, &model).unwrap();
    let heights = clip.sole_heights(&model, &["shin_left"]).unwrap();
    assert!(heights.lowest.abs() < 1e-12, "{heights:?}");
    let plain = import_bvh(&bvh, &JointMap::from_ron(TINY_MAP).unwrap(), &model).unwrap();
    let ratio = clip.poses[2].root_position.z / plain.poses[2].root_position.z;
    assert!((ratio - 2.0 * 0.4 / 0.8).abs() < 1e-9, "{ratio}");
}

#[test]
fn wrong_maps_are_refused_by_name() {
    let bvh = Bvh::parse(TINY).unwrap();
    let model = tiny_model();
    let cases = [
        (TINY_MAP.replace("\"LeftShin\"", "\"LeftKnee\""), "LeftShin"),
        (TINY_MAP.replace("ignored: [", "ignored: [\"LeftThigh\", "), "LeftThigh"),
        (TINY_MAP.replace("link: \"chest\"", "link: \"thorax\""), "thorax"),
        (
            TINY_MAP.replace("link: \"pelvis\"", "link: \"chest\"").replacen(
                "link: \"chest\", joints: [\"Spine\"",
                "link: \"pelvis\", joints: [\"Spine\"",
                1,
            ),
            "root",
        ),
        (TINY_MAP.replace("[\"Spine\", \"Chest\"]", "[\"Spine\", \"LeftShin\", \"Chest\"]"), "below"),
        (TINY_MAP.replace("unit: 0.01", "unit: 0.0"), "unit"),
        (TINY_MAP.replace("up: (0.0, 1.0, 0.0)", "up: (0.0, 2.0, 0.0)"), "right angles"),
        (TINY_MAP.replace("fit: None", "fit: None, soles: [\"toe\"]"), "toe"),
        (TINY_MAP.replace("fit: None", "fitting: None"), "line"),
    ];
    for (text, needle) in cases {
        let result = JointMap::from_ron(&text).map_err(ImportError::from);
        let message = result.and_then(|map| import_bvh(&bvh, &map, &model)).expect_err(needle).to_string();
        println!("{message}");
        assert!(message.contains(needle), "`{message}` should mention `{needle}`");
    }
}

#[test]
fn the_maps_that_come_with_the_crate_are_valid() {
    let names: Vec<String> = JointMap::built_in().map(|m| m.name).collect();
    assert_eq!(names, ["skate", "spin", "mocap"]);
    assert_eq!(JointMap::detect(&Bvh::parse(TINY).unwrap()), None);
}

/// 3000 mutations of a BVH file, a clip and a map. Accepted files go all the way to samples.
#[test]
fn mutated_files_never_panic() {
    let model = tiny_model();
    let bvh = Bvh::parse(TINY).unwrap();
    let map = JointMap::from_ron(TINY_MAP).unwrap();
    let clip_text = import_bvh(&bvh, &map, &model).unwrap().to_ron().unwrap();
    let mut random = RandomStream::new(20_120_802, 1);
    let mut accepted = [0; 3];
    for _ in 0..3000 {
        if let Ok(bvh) = Bvh::parse(&crate::motion_support::mutate(TINY, &mut random)) {
            accepted[0] += 1;
            exercise(&bvh, &map);
        }
        if let Ok(clip) = MotionClip::from_ron(&crate::motion_support::mutate(&clip_text, &mut random)) {
            accepted[1] += 1;
            exercise_clip(&clip);
        }
        if let Ok(map) = JointMap::from_ron(&crate::motion_support::mutate(TINY_MAP, &mut random)) {
            accepted[2] += 1;
            exercise(&bvh, &map);
        }
    }
    println!("of 3000 mutations each, accepted: {accepted:?} (BVH, clip, map)");
    assert!(accepted.iter().all(|&n| n > 20), "mutations that are always refused test only the first check");
    // Deeply nested text must not exhaust the stack.
    let deep = "(".repeat(100_000);
    assert!(matches!(JointMap::from_ron(&deep), Err(MapError::Syntax { .. })));
    assert!(MotionClip::from_ron(&deep).is_err());
    let deep: String = (0..1100).map(|i| format!("JOINT j{i} {{ OFFSET 0 0 0 CHANNELS 0 ")).collect();
    let deep = deep.replacen("JOINT", "HIERARCHY ROOT", 1);
    assert!(matches!(Bvh::parse(&deep), Err(BvhError::TooLarge { .. })));
}

fn exercise(bvh: &Bvh, map: &JointMap) {
    if let Ok(clip) = import_bvh(bvh, map, &tiny_model()) {
        exercise_clip(&clip);
    }
}

fn exercise_clip(clip: &MotionClip) {
    let Ok(fitted) = clip.to_model(&tiny_model()) else { return };
    for t in [-1.0, 0.0, 0.02, 0.1, 1e300, f64::NAN] {
        let q: DQuat = fitted.sample(t).joints[1];
        assert!((q.length() - 1.0).abs() < 1e-6, "{q}");
        assert!(fitted.sample_velocity(t).root_angular.is_finite());
        clip.sample_velocity(t);
    }
    let _ = clip.resample(60.0);
    let _ = clip.repeated(3, 0.05);
    let _ = clip.mirrored();
    let _ = clip.time_scaled(0.5);
    let _ = clip.moved_to_origin();
    let _ = clip.lowest_point(&tiny_model());
}
