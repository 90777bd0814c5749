//! Positions of landmarks become the pose they were taken from.
//!
//! - Landmarks of random poses, in another scale, place and heading, with 1 cm of noise on every coordinate: the written key
//!   pose has its joints within 2 cm of the true ones. Checked on the file that is written, in positions: a check of angles
//!   would call a twist that no landmark shows an error.
//! - What is missing is named, and only that; too little is refused.
//! - Left called right is noticed, and a body as it is is not accused of it.

use bevy_athlete::asset::joint_positions::{JointPositions, Landmark, PositionFrame, PositionNote, PositionOptions};
use bevy_athlete::asset::landmark_layout::{Axes, LandmarkLayout};
use bevy_athlete::math::RandomStream;
use bevy_athlete::model::{
    BodyLandmarks, CharacterModel, ImportedPoses, JointKind, LinkTransform, ModelPose, PositionImportError,
    PositionImportOptions, PositionWarning, SidedPart, import_positions, preset,
};
use glam::{DQuat, DVec3};

/// A pose a person could take: every joint within its range, near straight more often than not; any heading, leaning up to
/// about 40 degrees.
fn plausible(random: &mut RandomStream, model: &CharacterModel) -> ModelPose {
    let mut pose = ModelPose::zero(model);
    for (link, q) in model.links.iter().zip(&mut pose.joints).skip(1) {
        let limits = link.limits.unwrap();
        let range = limits.high - limits.low;
        let middle = (limits.high + limits.low) * 0.25;
        let mut r = DVec3::ZERO;
        for k in 0..3 {
            r[k] = (middle[k] + 0.17 * range[k] * random.normal()).clamp(limits.low[k], limits.high[k]);
        }
        if let JointKind::Hinge { axis } = link.joint {
            r = axis * r.dot(axis);
        }
        *q = DQuat::from_scaled_axis(r);
    }
    let lean = DVec3::new(random.normal(), 0.0, random.normal()) * 0.25;
    pose.root_rotation = DQuat::from_rotation_y(random.range(-3.1, 3.1)) * DQuat::from_scaled_axis(lean);
    pose.root_position = DVec3::new(random.normal(), 1.0 + random.normal(), random.normal());
    pose
}

fn places(model: &CharacterModel, pose: &ModelPose) -> Vec<LinkTransform> {
    let mut out = Vec::new();
    pose.link_transforms(model, &mut out);
    out
}

/// The landmarks of a pose, `scale` units in a metre, with noise (m) on every coordinate.
fn landmarks(
    layout: &LandmarkLayout,
    model: &CharacterModel,
    pose: &ModelPose,
    scale: f64,
    noise: f64,
    random: &mut RandomStream,
) -> Vec<Landmark> {
    let body = BodyLandmarks::new(layout, model).unwrap();
    let places = places(model, pose);
    body.points
        .iter()
        .map(|point| {
            let noise = DVec3::new(random.normal(), random.normal(), random.normal()) * noise;
            point.map_or(Landmark::default(), |p| {
                let link = &places[p.link];
                Landmark::at((link.position + link.rotation * p.position + noise) * scale)
            })
        })
        .collect()
}

fn one_frame(layout: &LandmarkLayout, landmarks: Vec<Landmark>) -> JointPositions {
    JointPositions::new(layout.clone(), vec![PositionFrame { time: 0.0, landmarks }])
}

fn import(model: &CharacterModel, positions: &JointPositions) -> ImportedPoses {
    import_positions(model, positions, &PositionImportOptions::default()).unwrap()
}

/// Distances of the joints of the written key pose from the true ones; place and heading are not in the file, so they are
/// taken out.
fn errors(model: &CharacterModel, imported: &ImportedPoses, index: usize, truth: &ModelPose) -> Vec<f64> {
    let clip = imported.key_poses.to_clip(model).unwrap().to_model(model).unwrap();
    let time: f64 = imported.key_poses.seconds[..index].iter().sum();
    let written = clip.sample(time);
    let turn = written.root_rotation * imported.fits[index].root_rotation.conjugate();
    assert!(turn.x.abs() < 1e-3 && turn.z.abs() < 1e-3, "only the heading changes: {turn}");
    let (found, truth) = (places(model, &written), places(model, truth));
    let middle = |places: &[LinkTransform]| places.iter().map(|l| l.position).sum::<DVec3>() / places.len() as f64;
    let (a, b) = (middle(&found), middle(&truth));
    found.iter().zip(&truth).map(|(f, t)| (f.position - a).distance(turn * (t.position - b))).collect()
}

/// What many random poses gave, m: RMS over all joints, RMS of the worst pose, and all errors in ascending order.
struct Residuals {
    rms: f64,
    worst_pose: f64,
    sorted: Vec<f64>,
}

impl Residuals {
    /// The error that so many per cent of the joints stay below.
    fn percentile(&self, percent: usize) -> f64 {
        self.sorted[(self.sorted.len() - 1) * percent / 100]
    }
}

/// `noise` is the standard deviation of each coordinate, m.
fn accuracy(character: &str, layout: &str, poses: usize, noise: f64) -> Residuals {
    let (model, layout) = (preset(character).unwrap(), LandmarkLayout::built_in(layout).unwrap());
    let mut random = RandomStream::new(17, 1);
    let (mut all, mut worst_pose) = (Vec::new(), 0.0_f64);
    let mut accused = 0;
    let begin = std::time::Instant::now();
    for _ in 0..poses {
        let truth = plausible(&mut random, &model);
        let scale = random.range(0.7, 1.5) * if random.uniform() < 0.5 { 1000.0 } else { 1.0 };
        let positions = one_frame(&layout, landmarks(&layout, &model, &truth, scale, noise, &mut random));
        let imported = import(&model, &positions);
        let errors = errors(&model, &imported, 0, &truth);
        worst_pose = worst_pose.max((errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt());
        all.extend(errors);
        accused += imported.warnings.iter().filter(|w| matches!(w, PositionWarning::Sides { .. })).count();
    }
    let milliseconds = begin.elapsed().as_secs_f64() * 1e3 / poses as f64;
    let rms = (all.iter().map(|e| e * e).sum::<f64>() / all.len() as f64).sqrt();
    all.sort_by(f64::total_cmp);
    let out = Residuals { rms, worst_pose, sorted: all };
    println!(
        "{character} from {}, noise {:.2} cm a coordinate, {poses} poses: joints {:.2} cm off (RMS), median {:.2}, 95 % \
         below {:.2}, worst {:.2}; worst pose {:.2} (RMS); sides doubted {accused} times; {milliseconds:.1} ms a pose",
        layout.name,
        100.0 * noise,
        100.0 * rms,
        100.0 * out.percentile(50),
        100.0 * out.percentile(95),
        100.0 * out.percentile(100),
        100.0 * worst_pose,
    );
    assert!(accused * 50 <= poses, "a body as it is, called exchanged {accused} times");
    out
}

#[test]
fn joints_are_recovered_within_two_centimetres() {
    for (character, layout) in [
        ("skater", "smpl24"),
        ("skater", "mediapipe33"),
        ("runner", "smpl24"),
        ("foot_human", "smpl24"),
        ("two_segment_human", "mediapipe33"),
    ] {
        let exact = accuracy(character, layout, 40, 0.0);
        assert!(exact.rms < 0.012 && exact.percentile(95) < 0.02, "{character} from {layout} without noise");
        // 1 cm away in all, and 1 cm on every coordinate, which is 1.7 cm in all.
        let near = accuracy(character, layout, 100, 0.01 / f64::sqrt(3.0));
        assert!(near.rms < 0.015 && near.percentile(80) < 0.02, "{character} from {layout}, 1 cm");
        let far = accuracy(character, layout, 100, 0.01);
        assert!(far.rms < 0.0173, "{character} from {layout}: no better than the landmarks themselves");
        // SMPL has landmarks on the trunk: then it is so in every single pose.
        if (character, layout) == ("skater", "smpl24") {
            assert!(near.percentile(95) < 0.02 && far.worst_pose < 0.02);
        }
    }
}

/// A pose that no side is in doubt about: knees and elbows bent, a step.
fn step(model: &CharacterModel) -> ModelPose {
    let mut pose = ModelPose::zero(model);
    for (link, x, z) in [
        ("thigh_left", 50.0, 0.0),
        ("shin_left", -60.0, 0.0),
        ("thigh_right", -15.0, 5.0),
        ("shin_right", -35.0, 0.0),
        ("bicep_left", 30.0, -20.0),
        ("forearm_left", 60.0, 0.0),
        ("forearm_right", 40.0, 0.0),
    ] {
        let r = DVec3::new(x, 0.0, z) * std::f64::consts::PI / 180.0;
        pose.joints[model.link_index(link).unwrap()] = DQuat::from_scaled_axis(r);
    }
    pose.root_position.y = 1.0;
    pose
}

/// The landmarks of `step`, with 5 mm of noise.
fn step_landmarks(layout: &LandmarkLayout, model: &CharacterModel) -> Vec<Landmark> {
    landmarks(layout, model, &step(model), 1.0, 0.005, &mut RandomStream::new(5, 5))
}

#[test]
fn what_is_not_seen_is_named() {
    let (model, layout) = (preset("skater").unwrap(), LandmarkLayout::built_in("mediapipe33").unwrap());
    let mut seen = step_landmarks(&layout, &model);
    assert!(import(&model, &one_frame(&layout, seen.clone())).warnings.is_empty());
    // A hidden forearm: one landmark missing, the others seen badly.
    for name in ["left_elbow", "left_wrist", "left_pinky", "left_index", "left_thumb"] {
        seen[layout.index(name).unwrap()].visibility = 0.2;
    }
    seen[layout.index("left_elbow").unwrap()] = Landmark::default();
    let imported = import(&model, &one_frame(&layout, seen.clone()));
    let [PositionWarning::Unseen { frames, landmarks, undetermined }] = &imported.warnings[..] else {
        panic!("{:?}", imported.warnings)
    };
    assert!(frames == &[0] && landmarks.len() == 5 && landmarks[0] == "left_elbow", "{landmarks:?}");
    let about = |name: &str| undetermined.iter().any(|u| u.starts_with(name));
    assert!(about("bicep_left") && about("forearm_left"), "{undetermined:?}");
    assert!(!about("bicep_right") && !about("thigh") && !about("shin"), "{undetermined:?}");
    let message = imported.warnings[0].to_string();
    assert!(message.contains("left_elbow") && message.contains("near straight: "), "{message}");

    // All of it counts where the caller says so.
    for landmark in &mut seen {
        landmark.position = landmark.position.or(Some(DVec3::ZERO));
    }
    seen[layout.index("left_elbow").unwrap()] = step_landmarks(&layout, &model)[layout.index("left_elbow").unwrap()];
    let options = PositionImportOptions { min_visibility: 0.1, ..Default::default() };
    assert!(import_positions(&model, &one_frame(&layout, seen), &options).unwrap().warnings.is_empty());
}

#[test]
fn too_little_is_refused_by_name() {
    let (model, layout) = (preset("skater").unwrap(), LandmarkLayout::built_in("smpl24").unwrap());
    let refused = |frame: Vec<Landmark>| {
        let result = import_positions(&model, &one_frame(&layout, frame), &PositionImportOptions::default());
        result.map(|_| ()).unwrap_err()
    };
    let mut hidden = step_landmarks(&layout, &model);
    for name in ["left_hip", "right_shoulder"] {
        hidden[layout.index(name).unwrap()] = Landmark::default();
    }
    let error = refused(hidden.clone());
    assert!(
        matches!(&error, PositionImportError::TooFew { frame: 0, unseen, .. } if unseen == "left_hip, right_shoulder")
    );
    assert!(
        error.to_string().contains("at least three of left_hip, right_hip, left_shoulder, right_shoulder"),
        "{error}"
    );
    // One of the four may be missing.
    hidden[layout.index("left_hip").unwrap()] = step_landmarks(&layout, &model)[layout.index("left_hip").unwrap()];
    import(&model, &one_frame(&layout, hidden));

    let here = vec![Landmark::at(DVec3::new(3.0, 1.0, 2.0)); 24];
    assert!(matches!(refused(here), PositionImportError::OnePlace { frame: 0 }));
    let mut wild = step_landmarks(&layout, &model);
    wild[7] = Landmark::at(DVec3::new(f64::NAN, 0.0, 0.0));
    let message = refused(wild).to_string();
    assert!(message.contains("frame 0, landmark `left_ankle`") && message.contains("NaN"), "{message}");
    let options = PositionImportOptions { frames: Some(vec![1]), ..Default::default() };
    let frame = one_frame(&layout, step_landmarks(&layout, &model));
    let message = import_positions(&model, &frame, &options).unwrap_err().to_string();
    assert!(message.contains("frames is 1; valid: 0 to 0"), "{message}");
}

#[test]
fn exchanged_sides_are_noticed_and_put_right() {
    for (character, layout) in [("skater", "smpl24"), ("skater", "mediapipe33"), ("runner", "mediapipe33")] {
        let (model, layout) = (preset(character).unwrap(), LandmarkLayout::built_in(layout).unwrap());
        let good = if character == "skater" {
            step_landmarks(&layout, &model)
        } else {
            // Other names of the same joints.
            let truth = plausible(&mut RandomStream::new(2, 2), &model);
            landmarks(&layout, &model, &truth, 1.0, 0.005, &mut RandomStream::new(5, 5))
        };
        let plain = import(&model, &one_frame(&layout, good.clone()));
        assert!(plain.warnings.is_empty(), "{:?}", plain.warnings);
        // What hangs on the hips, the rest, and everything.
        let leg = |name: &str| ["hip", "knee", "ankle", "foot", "heel"].iter().any(|part| name.contains(part));
        let names: Vec<&str> = layout.landmarks.iter().map(|l| l.name.as_str()).collect();
        for part in SidedPart::ALL {
            let moves = |i: usize| match part {
                SidedPart::Body => true,
                SidedPart::Legs => leg(names[i]),
                SidedPart::Arms => !leg(names[i]),
            };
            let order = (0..good.len()).map(|i| if moves(i) { layout.partner(i) } else { i });
            let wrong = one_frame(&layout, order.map(|i| good[i]).collect());
            let imported = import(&model, &wrong);
            let sides = imported.warnings.iter().find_map(|w| match w {
                PositionWarning::Sides { part, .. } => Some(*part),
                _ => None,
            });
            assert_eq!(sides, Some(part), "{character}, {}: {:?}", layout.name, imported.warnings);
            let options = PositionImportOptions { exchange: Some(part), ..Default::default() };
            let right = import_positions(&model, &wrong, &options).unwrap();
            assert!(right.warnings.is_empty() && right.fits == plain.fits, "{:?}", right.warnings);
        }
    }
}

#[test]
fn a_stray_landmark_is_named_and_bends_nothing_else() {
    let (model, layout) = (preset("skater").unwrap(), LandmarkLayout::built_in("smpl24").unwrap());
    let mut frame = step_landmarks(&layout, &model);
    let wrist = layout.index("right_wrist").unwrap();
    frame[wrist].position = frame[wrist].position.map(|p| p + DVec3::new(0.0, 0.0, -1.0));
    let imported = import(&model, &one_frame(&layout, frame));
    let stray: Vec<&str> = imported
        .warnings
        .iter()
        .filter_map(|w| match w {
            PositionWarning::Stray { landmark, .. } => Some(landmark.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(stray, ["right_wrist"], "{:?}", imported.warnings);
    let errors = errors(&model, &imported, 0, &step(&model));
    for (link, error) in
        model.links.iter().zip(errors).filter(|(l, _)| !["forearm_right", "hand_right"].contains(&&*l.name))
    {
        assert!(error < 0.05, "{} is {error:.3} m off", link.name);
    }
}

/// A skater who goes straight on while turning: the file has the speed, the turns beyond half of one, and heights.
#[test]
fn a_way_becomes_speed_turns_and_heights() {
    let (model, layout) = (preset("skater").unwrap(), LandmarkLayout::built_in("smpl24").unwrap());
    let mut random = RandomStream::new(3, 3);
    let way = DQuat::from_rotation_y(0.7) * DVec3::NEG_Z;
    let frame = |k: usize, random: &mut RandomStream| {
        let mut pose = step(&model);
        pose.root_rotation = DQuat::from_rotation_y(0.7 + 1.2 * k as f64);
        pose.root_position = way * 0.4 * k as f64 + DVec3::Y * (1.0 + 0.05 * k as f64);
        PositionFrame { time: 0.2 * k as f64, landmarks: landmarks(&layout, &model, &pose, 1.0, 0.003, random) }
    };
    let frames = (0..6).map(|k| frame(k, &mut random)).collect();
    let positions = JointPositions::new(layout.clone(), frames);
    let options = PositionImportOptions { travel: true, ..Default::default() };
    let keys = import_positions(&model, &positions, &options).unwrap().key_poses;
    assert!((keys.speed - 2.0).abs() < 0.1, "{} m/s", keys.speed);
    for (k, pose) in keys.poses.iter().enumerate() {
        let wanted = (1.2 * k as f64).to_degrees();
        assert!((pose.turn - wanted).abs() < 6.0, "pose {k} turns by {} instead of {wanted}", pose.turn);
        let rise = pose.height.unwrap() - keys.poses[0].height.unwrap();
        assert!((rise - 0.05 * k as f64).abs() < 0.03 && pose.lateral.abs() < 0.05, "pose {k}: {rise} m, {pose:?}");
    }
    // Without the way the poses stand on the ground, one after the other.
    let keys = import(&model, &positions).key_poses;
    assert!(keys.speed == 0.0 && keys.poses.iter().all(|p| p.height.is_none() && p.lateral == 0.0));
    assert_eq!(keys.poses[0].turn, 0.0);
}

/// The frames in which estimators write: the same body, whichever the axes and the unit.
#[test]
fn axes_and_units_make_no_difference() {
    let (model, layout) = (preset("skater").unwrap(), LandmarkLayout::built_in("smpl24").unwrap());
    let frame = step_landmarks(&layout, &model);
    let of = |name: &str, axes: Axes, unit: f64| {
        let joint = |l: &Landmark| (axes.from_ours(l.position.unwrap()) * unit).to_array();
        let joints: Vec<[f64; 3]> = frame.iter().map(joint).collect();
        let text = serde_json::json!({ "axes": name, "joints": joints }).to_string();
        import(&model, &JointPositions::from_json(&text, &PositionOptions::default()).unwrap())
    };
    let plain = of("y_up", Axes::YUp, 1.0);
    for (name, axes) in Axes::NAMES {
        let other = of(name, axes, 1000.0);
        assert!((other.fits[0].scale / plain.fits[0].scale - 1000.0).abs() < 1.0);
        for (a, b) in plain.fits[0].joints.iter().zip(&other.fits[0].joints) {
            assert!((*a - *b).length() < 1e-3, "{name}: {a} {b}");
        }
    }
}

#[test]
fn files_are_read_in_all_their_forms_and_refused_by_place() {
    let none = PositionOptions::default();
    let joint = |k: usize| format!("[{k}, {}, 0.5]", 2 * k);
    let list: Vec<String> = (0..24).map(joint).collect();
    let list = format!("[{}]", list.join(", "));
    let read = |text: &str| JointPositions::from_json(text, &none).unwrap();
    let one = read(&list);
    assert_eq!((one.layout.name.as_str(), one.frames.len(), one.frames[0].time), ("smpl24", 1, 0.0));
    assert_eq!(one.frames[0].landmarks[3].position, Some(DVec3::new(-3.0, 6.0, -0.5)), "y_up faces +Z");
    assert_eq!(read(&format!("[{list}, {list}]")).frames[1].time, 1.0 / 30.0);
    let timed =
        read(&format!("{{\"frames\": [{{\"time\": 1.5, \"joints\": {list}}}, {{\"time\": 2, \"joints\": {list}}}]}}"));
    assert_eq!((timed.frames[0].time, timed.frames[1].time), (1.5, 2.0));
    let named = read(
        "{\"layout\": \"mediapipe33\", \"joints\": {\"nose\": {\"x\": 1, \"y\": 2, \"z\": 3, \"visibility\": 0.5}}}",
    );
    let nose = named.frames[0].landmarks[0];
    assert_eq!((nose.position, nose.visibility), (Some(DVec3::new(1.0, -2.0, -3.0)), 0.5), "y_down");
    assert_eq!(named.frames[0].landmarks[1].position, None);
    let holes = list.replacen("[3, 6, 0.5]", "null", 1).replacen("[4, 8, 0.5]", "[null, null, null]", 1);
    let holes = read(&holes);
    assert!(holes.frames[0].landmarks[3].position.is_none() && holes.frames[0].landmarks[4].position.is_none());

    let refused = |text: &str, words: &[&str]| {
        let message = JointPositions::from_json(text, &none).unwrap_err().to_string();
        assert!(words.iter().all(|w| message.contains(w)), "{words:?}: {message}");
    };
    refused(&list.replacen("[3, 6, 0.5]", "[NaN, 6, 0.5]", 1), &["line 1", "NaN", "null"]);
    refused(&list.replacen("[3, 6, 0.5]", "[1e30, 6, 0.5]", 1), &["frame 0", "spine1", "1e7"]);
    refused(&list.replacen("[3, 6, 0.5]", "[3, 6]", 1), &["frame 0", "spine1", "a list of 2", "[x, y, z]"]);
    refused(&list.replacen("[3, 6, 0.5]", "\"here\"", 1), &["frame 0", "spine1", "here"]);
    refused(&list.replacen("[3, 6, 0.5], ", "", 1), &["23 landmarks", "smpl24, mediapipe33"]);
    refused(&format!("[{list}, [[1, 2, 3]]]"), &["frame 1 has 1 landmarks", "24"]);
    refused(&format!("{{\"layout\": \"coco\", \"joints\": {list}}}"), &["layout", "coco", "smpl24"]);
    refused(&format!("{{\"axes\": \"up\", \"joints\": {list}}}"), &["axes", "y_down"]);
    refused(&format!("{{\"fps\": 0, \"frames\": [{list}]}}"), &["fps", "0.1 to 1000"]);
    refused("{\"layout\": \"smpl24\", \"joints\": {\"tail\": [1, 2, 3]}}", &["tail", "unknown", "left_hip"]);
    refused("[]", &["0 landmarks"]);
    refused("{\"frames\": []}", &["0 frames", "1 to"]);
    refused("3", &["file: 3"]);
    let back = format!("{{\"frames\": [{{\"time\": 1, \"joints\": {list}}}, {{\"time\": 1, \"joints\": {list}}}]}}");
    refused(&back, &["frame 1, time", "later"]);
}

/// What tools write, made here: result objects, all but the hands, frames without a person, a byte-order mark. None of it may
/// need a converter, and none may be read as something else.
#[test]
fn results_of_the_common_estimators_are_read() {
    let none = PositionOptions::default();
    let read = |text: &str| JointPositions::from_json(text, &none).unwrap_or_else(|e| panic!("{e}: {text}"));
    let model = preset("skater").unwrap();
    // In the axes of the layout, as a tool gives them.
    let own = |layout: &str| {
        let layout = LandmarkLayout::built_in(layout).unwrap();
        let points = step_landmarks(&layout, &model).into_iter().map(|l| {
            let p = layout.axes.from_ours(l.position.unwrap_or_default());
            serde_json::json!({"x": p.x, "y": p.y, "z": p.z, "visibility": 0.9, "presence": 0.9})
        });
        points.collect::<Vec<_>>()
    };
    let (space, smpl) = (own("mediapipe33"), own("smpl24"));
    let picture: Vec<_> = space
        .iter()
        .map(|p| {
            let part = |k: &str| 0.5 + 0.4 * p[k].as_f64().unwrap();
            serde_json::json!({"x": part("x"), "y": part("y"), "z": 0.1 * p["z"].as_f64().unwrap(), "visibility": 0.9})
        })
        .collect();
    let plain = read(&serde_json::json!(space).to_string());
    for result in [
        serde_json::json!([{"landmarks": [picture], "worldLandmarks": [space]}]),
        serde_json::json!({"landmarks": [picture], "worldLandmarks": [space]}),
        serde_json::json!([{"poseLandmarks": picture, "poseWorldLandmarks": space}]),
        serde_json::json!({"pose_world_landmarks": {"landmark": space}}),
        serde_json::json!([{"keypoints": picture, "keypoints3D": space}]),
    ] {
        assert_eq!(read(&result.to_string()).frames, plain.frames, "{result}");
    }
    let refused = |value: serde_json::Value, words: &[&str]| {
        let message = JointPositions::from_json(&value.to_string(), &none).unwrap_err().to_string();
        assert!(words.iter().all(|w| message.contains(w)), "{words:?}: {message}");
    };
    refused(serde_json::json!([{"landmarks": [picture]}]), &["frame 0", "`landmarks`", "`worldLandmarks`"]);
    refused(serde_json::json!(picture), &["places in a picture", "worldLandmarks"]);
    refused(serde_json::json!([picture, picture]), &["between 0 and 1"]);
    let flat: Vec<_> = smpl.iter().map(|p| serde_json::json!([p["x"], p["y"], 0])).collect();
    refused(serde_json::json!(flat), &["z", "0 throughout"]);
    // Metres that happen to lie so are taken when the axes are named.
    JointPositions::from_json(&serde_json::json!({"axes": "y_down", "joints": picture}).to_string(), &none).unwrap();

    let bare = read(&serde_json::json!(smpl[..22]).to_string());
    assert_eq!(bare.layout.name, "smpl22");
    let marked = format!("\u{feff}{}", serde_json::json!(smpl));
    assert_eq!(read(&marked), read(&serde_json::json!(smpl).to_string()));

    // A frame without a person is a gap, and one at an end is held.
    let moved: Vec<_> =
        smpl.iter().map(|p| serde_json::json!([p["x"].as_f64().unwrap() + 0.2, p["y"], p["z"]])).collect();
    for nobody in [serde_json::json!(null), serde_json::json!([])] {
        let gap = read(&serde_json::json!([nobody, smpl, nobody, nobody, moved]).to_string());
        assert_eq!(gap.notes(), [PositionNote::Gap { frames: vec![0, 2, 3] }]);
        let x = |frame: usize| gap.frames[frame].landmarks[0].position.unwrap().x;
        assert!((x(2) - x(1) + 0.2 / 3.0).abs() < 1e-12 && x(0) == x(1), "{} {} {}", x(0), x(1), x(2));
    }
    refused(serde_json::json!([null, null]), &["nobody"]);
}

/// A figure on its head or along another axis is turned, and told; where the axes were named it is told only.
#[test]
fn y_down_and_z_up_are_found_out() {
    let none = PositionOptions::default();
    let model = preset("skater").unwrap();
    let layout = LandmarkLayout::built_in("smpl24").unwrap();
    let ours = step_landmarks(&layout, &model);
    for (name, axes) in Axes::NAMES {
        let points = ours.iter().map(|l| axes.from_ours(l.position.unwrap_or_default()).to_array());
        let points: Vec<[f64; 3]> = points.collect();
        let told = JointPositions::from_json(&serde_json::json!(points).to_string(), &none).unwrap();
        let up = told.frames[0].landmarks[15].position.unwrap() - told.frames[0].landmarks[0].position.unwrap();
        assert!(up.y > 0.3, "{name}: {up}");
        match told.notes() {
            [] => assert_eq!(name, "y_up"),
            [PositionNote::Turned { from: "y_up", to }] => assert_eq!(*to, name),
            other => panic!("{name}: {other:?}"),
        }
        let named = serde_json::json!({"axes": "y_up", "joints": points}).to_string();
        let told = JointPositions::from_json(&named, &none).unwrap();
        assert_eq!(told.notes().is_empty(), name == "y_up", "{:?}", told.notes());
        assert_eq!(told.frames[0].landmarks[0].position, Some(Axes::YUp.to_ours(points[0].into())));
    }
}
