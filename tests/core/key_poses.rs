//! Contract: a clip made from key poses is what the file says.
//!
//! It passes through every pose at its time, never swings beyond the two poses it is between, repeats and mirrors exactly,
//! travels at the speed given, and has its lowest contact point on the ground unless a height is given. What cannot be
//! used is refused with the pose and the field. A curve that overshoots bends knees backwards and puts blades through the
//! ice, a little, between the poses that were looked at.
//!
//! Has caught: a repetition of repetitions that asked for more memory than there is; heights given in some poses and
//! silently ignored; a last pose lost to the rounding of the sum of times.

use crate::common::*;
use bevy_athlete::asset::clip::{ClipError, MotionClip, Pose};
use bevy_athlete::math::RandomStream;
use bevy_athlete::model::{CharacterModel, KeyPose, KeyPoseError, KeyPoses, ModelPose, preset, runner, skater};
use glam::{DQuat, DVec3};

/// Three poses at times that fall on frames.
const TEXT: &str = r#"(
    name: "hand", character: "skater", speed: 2.0, seconds: [0.25, 0.5, 0.3], frame_rate: 40,
    poses: [
        (lateral: -0.05, root: (-14, -4, 0), joints: {"thigh_left": (46, 2, 3), "shin_left": (-56, 0, 0)}),
        (lateral: 0.03, root: (-16, -2, 0), joints: {"thigh_left": (36, 0, 4), "bicep_right": (-10, 0, 58)}),
        (joints: {"thigh_right": (-14, -16, 14), "head": (20, 0, 0)}),
    ],
)"#;

fn poses() -> KeyPoses {
    KeyPoses::from_ron(TEXT, "hand.keyposes.ron").unwrap()
}

fn radians(v: (f64, f64, f64)) -> DVec3 {
    DVec3::new(v.0, v.1, v.2) * (std::f64::consts::PI / 180.0)
}

/// Angle between two rotations, rad.
fn apart(a: DQuat, b: DQuat) -> f64 {
    2.0 * (a.conjugate() * b).xyz().length()
}

/// Every rotation of a pose: the root's, then the joints'.
fn rotations(pose: &Pose) -> Vec<DQuat> {
    std::iter::once(pose.root_rotation).chain(pose.joints.iter().copied()).collect()
}

/// What a key pose says, in the order of [`rotations`], as rotation vectors, rad.
fn vectors(pose: &KeyPose, clip: &MotionClip) -> Vec<DVec3> {
    let joints = clip.joints.iter().map(|j| pose.joints.get(j).map_or(DVec3::ZERO, |v| radians(*v)));
    std::iter::once(radians(pose.root)).chain(joints).collect()
}

/// Key poses at random, up to 60 degrees in each component, at times that fall on frames.
fn random_poses(random: &mut RandomStream, model: &CharacterModel, count: usize) -> KeyPoses {
    let mut made = KeyPoses { seconds: Vec::new(), poses: Vec::new(), ..poses() };
    let draw = |random: &mut RandomStream| {
        let mut component = || random.range(-60.0, 60.0);
        (component(), component(), component())
    };
    for _ in 0..count {
        made.seconds.push((2 + random.below(18)) as f64 / 40.0);
        let names = model.links.iter().skip(1).map(|link| link.name.clone());
        let joints: Vec<String> = names.filter(|_| random.uniform() < 0.7).collect();
        made.poses.push(KeyPose {
            lateral: random.range(-0.3, 0.3),
            height: Some(random.range(0.5, 1.5)),
            root: draw(random),
            joints: joints.into_iter().map(|name| (name, draw(random))).collect(),
            ..KeyPose::default()
        });
    }
    made
}

#[test]
fn clips_pass_through_the_poses_and_never_beyond() {
    let model = skater();
    let mut random = RandomStream::new(31, 1);
    let (mut through, mut beyond, mut frames) = (0.0_f64, 0.0_f64, 0);
    for case in 0..60 {
        let mut keys = random_poses(&mut random, &model, 1 + case % 6);
        keys.repeat = 1 + case % 3;
        let clip = keys.to_clip(&model).unwrap();
        let cycle: f64 = keys.seconds.iter().sum();
        let expected = (cycle * keys.repeat as f64 * 40.0).round() as usize + 1;
        assert_eq!(clip.poses.len(), expected);

        // Every repetition; what follows the last pose is the first again, or itself where nothing repeats.
        let mut frame = 0;
        for n in 0..keys.repeat * keys.poses.len() {
            let (k, last) = (n % keys.poses.len(), n + 1 == keys.repeat * keys.poses.len());
            let next = if last && keys.repeat == 1 { k } else { (k + 1) % keys.poses.len() };
            let length = (keys.seconds[k] * 40.0).round() as usize;
            let (from, to) = (&keys.poses[k], &keys.poses[next]);
            let (a, b) = (vectors(from, &clip), vectors(to, &clip));
            for (q, v) in rotations(&clip.poses[frame]).iter().zip(&a) {
                through = through.max(apart(*q, DQuat::from_scaled_axis(*v)));
            }
            let at = clip.poses[frame].root_position;
            through = through.max((at.x - from.lateral).abs()).max((at.y - from.height.unwrap()).abs());
            for pose in &clip.poses[frame..=frame + length] {
                frames += 1;
                for ((q, a), b) in rotations(pose).iter().zip(&a).zip(&b) {
                    let v = q.to_scaled_axis();
                    beyond = beyond.max((a.min(*b) - v).max_element()).max((v - a.max(*b)).max_element());
                }
                let (low, high) = (from.lateral.min(to.lateral), from.lateral.max(to.lateral));
                beyond = beyond.max(low - pose.root_position.x).max(pose.root_position.x - high);
            }
            frame += length;
        }
    }
    println!(
        "60 motions, {frames} frames: {through:.1e} rad or m from the poses at their times, {beyond:.1e} beyond two \
         neighbours (allowed 1e-9)"
    );
    assert!(through < 1e-9 && beyond < 1e-9);
}

#[test]
fn mirrored_and_repeated_motions_repeat_exactly() {
    let model = skater();
    let keys = KeyPoses { mirrored: true, repeat: 3, ..poses() };
    let clip = keys.to_clip(&model).unwrap();
    let half = 42;
    assert_eq!(clip.poses.len(), 6 * half + 1);
    let joint = |name: &str| clip.joints.iter().position(|j| j == name).unwrap();
    let other = |name: &str| match (name.strip_suffix("_left"), name.strip_suffix("_right")) {
        (Some(stem), _) => format!("{stem}_right"),
        (_, Some(stem)) => format!("{stem}_left"),
        _ => name.to_owned(),
    };
    // Seen in a mirror that swaps left and right.
    let mirror = |q: DQuat| DQuat::from_xyzw(q.x, -q.y, -q.z, q.w);
    let (mut cycle, mut side, mut moved) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (k, pose) in clip.poses.iter().enumerate() {
        let later = |frames: usize| clip.poses.get(k + frames);
        if let Some(seen) = later(half) {
            for (name, q) in clip.joints.iter().zip(&seen.joints) {
                side = side.max(apart(mirror(*q), pose.joints[joint(&other(name))]));
            }
            side = side.max(apart(mirror(seen.root_rotation), pose.root_rotation));
            side = side.max((seen.root_position.x + pose.root_position.x).abs());
            side = side.max((seen.root_position.y - pose.root_position.y).abs());
            moved = moved.max((pose.root_position.z - seen.root_position.z - 2.0 * 1.05).abs());
        }
        if let Some(again) = later(2 * half) {
            for (a, b) in rotations(pose).into_iter().zip(rotations(again)) {
                cycle = cycle.max(apart(a, b));
            }
        }
    }
    println!(
        "half a cycle later mirrored to {side:.1e}, a cycle later the same to {cycle:.1e}, path off by {moved:.1e}"
    );
    assert!(side < 1e-9 && cycle < 1e-9 && moved < 1e-9);
    // A mirrored motion ends in its first pose, even once.
    let once = KeyPoses { mirrored: true, ..poses() }.to_clip(&model).unwrap();
    let (first, last) = (&once.poses[0], &once.poses[2 * half]);
    assert!(rotations(first).into_iter().zip(rotations(last)).all(|(a, b)| apart(a, b) < 1e-9));
    // A plain one holds its last.
    let plain = poses().to_clip(&model).unwrap();
    assert_eq!(plain.poses.len(), half + 1);
    assert_eq!(plain.poses[30].joints, plain.poses[half].joints);
    assert!(apart(plain.poses[0].root_rotation, plain.poses[half].root_rotation) > 0.1);
}

/// Height of the lowest contact point, m.
fn lowest(model: &CharacterModel, clip: &MotionClip, pose: &Pose) -> f64 {
    let mut whole = ModelPose::zero(model);
    whole.root_position = pose.root_position;
    whole.root_rotation = pose.root_rotation;
    for (name, q) in clip.joints.iter().zip(&pose.joints) {
        whole.joints[model.link_index(name).unwrap()] = *q;
    }
    let mut links = Vec::new();
    whole.link_transforms(model, &mut links);
    let height = |c: &bevy_athlete::model::ContactPoint| {
        (links[c.link].position + links[c.link].rotation * c.position).y - c.radius
    };
    model.contact_points.iter().map(height).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_lowest_point_is_on_the_ground_unless_a_height_is_given() {
    let mut random = RandomStream::new(31, 2);
    let mut worst = 0.0_f64;
    for model in [skater(), runner()] {
        let mut keys = random_poses(&mut random, &model, 8);
        let flying = keys.to_clip(&model).unwrap();
        keys.poses.iter_mut().for_each(|p| p.height = None);
        let grounded = keys.to_clip(&model).unwrap();
        for (a, b) in grounded.poses.iter().zip(&flying.poses) {
            worst = worst.max(lowest(&model, &grounded, a).abs());
            // The height is the only difference.
            assert_eq!(rotations(a), rotations(b));
            assert_eq!(a.root_position.with_y(0.0), b.root_position.with_y(0.0));
        }
        let off = flying.poses.iter().map(|p| lowest(&model, &flying, p)).fold(0.0, f64::max);
        assert!(off > 0.2, "{off}: heights that were given are kept");
    }
    println!("lowest contact point at most {worst:.1e} m from the ground, allowed 1e-9");
    assert!(worst < 1e-9);
}

#[test]
fn the_body_travels_as_told() {
    let clip = KeyPoses { speed: 3.0, acceleration: -0.5, repeat: 2, ..poses() }.to_clip(&skater()).unwrap();
    for (k, pose) in clip.poses.iter().enumerate() {
        let t = k as f64 / 40.0;
        assert!((pose.root_position.z + 3.0 * t - 0.25 * t * t).abs() < 1e-12, "{t} s");
    }
    assert_eq!((clip.name.as_str(), clip.frame_rate), ("hand", 40.0));
    // What is left out: 30 poses a second, once, unmirrored, straight.
    let short = r#"(name: "still", character: "runner", speed: 0, seconds: [1], poses: [()])"#;
    let still = KeyPoses::from_ron(short, "still.keyposes.ron").unwrap().to_clip(&runner()).unwrap();
    assert_eq!((still.frame_rate, still.poses.len()), (30.0, 31));
    let height = still.poses[7].root_position.y;
    assert!((height - runner().rest_root_height()).abs() < 1e-12, "{height}");
    assert!(rotations(&still.poses[30]).iter().all(|q| *q == DQuat::IDENTITY));
}

#[test]
fn what_cannot_be_used_is_refused_by_its_place() {
    let model = preset("skater").unwrap();
    let refused = |words: &[&str], edit: &dyn Fn(&mut KeyPoses)| {
        let mut keys = poses();
        edit(&mut keys);
        let error = keys.to_clip(&model).unwrap_err();
        assert!(matches!(error, KeyPoseError::Value { .. }), "{error}");
        let text = error.to_string();
        for word in ["hand"].iter().chain(words) {
            assert!(text.contains(word), "`{word}` is missing in: {text}");
        }
    };
    refused(&["poses", "0 poses", "1 to 1000"], &|k| k.poses.clear());
    refused(&["poses", "1001 poses"], &|k| k.poses = vec![KeyPose::default(); 1001]);
    refused(&["seconds", "2 times", "one for each pose"], &|k| k.seconds.truncate(2));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 10.5] {
        refused(&["seconds of pose 1", &bad.to_string(), "0.01 to 10"], &|k| k.seconds[1] = bad);
    }
    refused(&["repeat", "0", "1 to 1000"], &|k| k.repeat = 0);
    refused(&["repeat", "1001"], &|k| k.repeat = 1001);
    refused(&["repeat", "7350 s", "3600 s"], &|k| (k.repeat, k.seconds[0], k.seconds[1]) = (1000, 6.5, 0.55));
    refused(&["repeat", "s in all"], &|k| (k.repeat, k.mirrored, k.seconds[0]) = (900, true, 3.0));
    refused(&["frame_rate", "0", "1 to 240"], &|k| k.frame_rate = 0.0);
    refused(&["frame_rate", "NaN"], &|k| k.frame_rate = f64::NAN);
    refused(&["speed", "31", "-30 to 30"], &|k| k.speed = 31.0);
    refused(&["acceleration", "inf", "-30 to 30"], &|k| k.acceleration = f64::INFINITY);
    refused(&["pose 2, lateral", "-11", "-10 to 10"], &|k| k.poses[2].lateral = -11.0);
    refused(&["pose 0, height", "-0.1", "0 to 10"], &|k| k.poses.iter_mut().for_each(|p| p.height = Some(-0.1)));
    refused(&["pose 0, height", "none", "in every pose"], &|k| k.poses[1].height = Some(1.0));
    refused(&["pose 1, root", "at most 360"], &|k| k.poses[1].root.1 = 361.0);
    refused(&["pose 0, thigh_left", "NaN"], &|k| k.poses[0].joints.get_mut("thigh_left").unwrap().2 = f64::NAN);
    for name in ["tail", "pelvis", ""] {
        refused(&[&format!("pose 2, {name}"), "no such joint", "thigh_left"], &|k| {
            k.poses[2].joints.insert(name.into(), (0.0, 0.0, 0.0));
        });
    }

    // Text that is no such file, by file and place in it; a file that is not there.
    for (text, words) in [
        (TEXT.replace("speed: 2.0", "speed: fast"), ["hand.keyposes.ron", "2:"]),
        (TEXT.replace("speed: 2.0", "sped: 2.0"), ["hand.keyposes.ron", "sped"]),
        (TEXT.replace("lateral: 0.03", "sideways: 0.03"), ["5:", "sideways"]),
        (TEXT[..100].to_owned(), ["hand.keyposes.ron", "2:"]),
    ] {
        let error = KeyPoses::from_ron(&text, "hand.keyposes.ron").unwrap_err();
        assert!(matches!(error, KeyPoseError::Syntax { .. }));
        assert!(words.iter().all(|w| error.to_string().contains(w)), "{words:?}: {error}");
    }
    let error = KeyPoses::load("no/such.keyposes.ron").unwrap_err();
    assert!(matches!(error, KeyPoseError::Io { .. }) && error.to_string().contains("no/such.keyposes.ron"), "{error}");

    // A character with more joints than a clip can hold.
    let crowd = random_tree(1, 1100);
    let keys = KeyPoses { poses: vec![KeyPose::default()], seconds: vec![0.1], ..poses() };
    let error = keys.to_clip(&crowd).unwrap_err();
    assert!(matches!(error, KeyPoseError::Clip(ClipError::TooLarge { what: "joints", found: 1099, .. })), "{error}");
}
