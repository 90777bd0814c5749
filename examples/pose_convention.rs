//! Draws `docs/img/pose_convention.png`: what the components of a rotation vector in a file of key poses do to some joints.
//!
//! ```sh
//! cargo run --release --no-default-features --features storyboard --example pose_convention docs/img/pose_convention.png
//! ```
//!
//! Solid is the skater with one joint turned, translucent the zero pose. The camera stands behind on the right.

use bevy_athlete::model::{CharacterModel, LinkTransform, ModelPose, skater};
use bevy_athlete::storyboard::{Ground, Heading, Storyboard, StoryboardFrame, StoryboardOptions};
use glam::{DQuat, DVec3};
use std::error::Error;

/// A joint and what its components do, x, y, z: degrees and words.
type Row = (&'static str, &'static [&'static str], [(f64, &'static str); 3]);

/// The trunk bends in two joints.
const JOINTS: [Row; 5] = [
    ("hip", &["thigh_right"], [(60.0, "forwards"), (40.0, "turns left"), (40.0, "to the right")]),
    ("knee", &["shin_right"], [(-80.0, "bends"), (30.0, "turns left"), (20.0, "to the right")]),
    ("ankle", &["foot_right"], [(35.0, "toes up"), (35.0, "toes left"), (35.0, "sole right")]),
    ("shoulder", &["bicep_right"], [(80.0, "forwards"), (50.0, "turns left"), (80.0, "to the right")]),
    ("trunk", &["abdomen", "spine"], [(-30.0, "forwards"), (25.0, "turns left"), (25.0, "tilts left")]),
];

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args().nth(1).ok_or("give the picture's path")?;
    let model = skater();
    let mut frames = Vec::new();
    for component in 0..3 {
        for (joint, links, effects) in JOINTS {
            let (degrees, effect) = effects[component];
            let mut rest = ModelPose::zero(&model);
            // A straight arm that turns about its own length looks the same.
            if joint == "shoulder" && component == 1 {
                turn(&model, &mut rest, &["forearm_right"], 0, 90.0);
            }
            let mut pose = rest.clone();
            turn(&model, &mut pose, links, component, degrees);
            let (sign, axis) = (if degrees < 0.0 { '-' } else { '+' }, ['x', 'y', 'z'][component]);
            let mut frame = StoryboardFrame::new(frames.len() as f64, standing(&model, &pose));
            frame.ghost = Some(standing(&model, &rest));
            frame.caption = format!("{joint} {sign}{axis}: {effect}");
            frames.push(frame);
        }
    }
    let options = StoryboardOptions {
        width: 1600,
        height: 1290,
        frames: frames.len(),
        columns: JOINTS.len(),
        azimuth: -0.85,
        elevation: 0.22,
        heading: Heading::World,
        ground: Ground::Ice,
        path_band: false,
        times: false,
        axes: true,
        title: "Rotation vectors of key poses: X right, Y up, Z backwards".into(),
        ..Default::default()
    };
    Ok(Storyboard::new(options).write(&model, &frames, out)?)
}

fn turn(model: &CharacterModel, pose: &mut ModelPose, links: &[&str], component: usize, degrees: f64) {
    let axis = [DVec3::X, DVec3::Y, DVec3::Z][component];
    for index in links.iter().filter_map(|link| model.link_index(link)) {
        pose.joints[index] = DQuat::from_axis_angle(axis, degrees.to_radians());
    }
}

/// The links of a pose whose root is as high as that of the zero pose on the ground.
fn standing(model: &CharacterModel, pose: &ModelPose) -> Vec<LinkTransform> {
    let mut links = Vec::new();
    ModelPose::zero(model).link_transforms(model, &mut links);
    let heights = model.contact_points.iter().map(|p| (links[p.link].position + p.position).y - p.radius);
    let lowest = heights.fold(f64::INFINITY, f64::min);
    pose.link_transforms(model, &mut links);
    links.iter_mut().for_each(|link| link.position.y -= lowest);
    links
}
