//! A small skeleton as BVH text, map and character, shared by the motion tests.
#![allow(dead_code)]

use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::math::RandomStream;
use bevy_athlete::model::{CharacterModel, ContactKind, ContactPoint, Gains, JointKind, Link, LinkTransform};
use glam::{DMat3, DQuat, DVec3};

/// Centimetres, facing +X, Y up; the trunk has two joints, the feet and the neck drive nothing.
pub const TINY: &str = "\
HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT LeftThigh
  {
    OFFSET 2 -6 -9
    CHANNELS 3 Xrotation Yrotation Zrotation
    JOINT LeftShin
    {
      OFFSET 0 -40 0
      CHANNELS 3 Yrotation Zrotation Xrotation
      JOINT LeftFoot
      {
        OFFSET 0 -40 0
        CHANNELS 0
        End Site
        {
          OFFSET 10 -5 0
        }
      }
    }
  }
  JOINT RightThigh
  {
    OFFSET 2 -6 9
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT RightShin
    {
      OFFSET 0 -40 0
      CHANNELS 1 Zrotation
      End Site
      {
        OFFSET 0 -40 0
      }
    }
  }
  JOINT Spine
  {
    OFFSET 0 10 0
    CHANNELS 3 Zrotation Yrotation Xrotation
    JOINT Chest
    {
      OFFSET 0 0 0
      CHANNELS 3 Xrotation Zrotation Yrotation
      End Site
      {
        OFFSET 0 30 0
      }
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.05
0 85 0 5 -10 15 20 5 -30 1 40 2 -15 8 3 -60 10 20 30 -5 4 6
25 86 10 12 40 -8 30 -25 10 14 50 -12 35 18 -23 -20 -10 5 3 15 24 -6
50 90 20 30 120 25 -40 15 20 -4 70 22 -55 -8 13 -95 4 -20 13 25 -14 16
";

/// Source joints and the links whose joints lie in the same place.
pub const TINY_PAIRS: [(&str, &str); 6] = [
    ("Hips", "pelvis"),
    ("LeftThigh", "thigh_left"),
    ("LeftShin", "shin_left"),
    ("RightThigh", "thigh_right"),
    ("RightShin", "shin_right"),
    ("Chest", "chest"),
];

/// The map from [`TINY`] to [`tiny_model`].
pub const TINY_MAP: &str = r#"JointMap(
    name: "tiny",
    unit: 0.01,
    up: (0.0, 1.0, 0.0),
    facing: (1.0, 0.0, 0.0),
    root: (link: "pelvis", joints: ["Hips"]),
    anchor: Joint,
    links: [
        (link: "thigh_left", joints: ["LeftThigh"]),
        (link: "shin_left", joints: ["LeftShin"]),
        (link: "thigh_right", joints: ["RightThigh"]),
        (link: "shin_right", joints: ["RightShin"]),
        (link: "chest", joints: ["Spine", "Chest"]),
        (link: "hat", joints: ["Chest"], optional: true),
    ],
    ignored: ["LeftFoot"],
    fit: None,
)"#;

/// [`TINY`] with a root that stays on the ground, turned a quarter, and the hips below it.
pub fn with_ground_root() -> String {
    let hips = TINY.replace("HIERARCHY\nROOT Hips", "JOINT Hips");
    let (tree, motion) = hips.split_once("MOTION").unwrap();
    let (head, rows) = motion.split_once("0.05\n").unwrap();
    // Turned by 90 degrees about Y and back: the hips' place and heading are given in the root's axes.
    let rows: Vec<String> = rows
        .lines()
        .map(|row| {
            let v: Vec<f64> = row.split_whitespace().map(|w| w.parse().unwrap()).collect();
            let rest: Vec<String> = v[3..].iter().map(f64::to_string).collect();
            // p = Ry(90) p' + (7, 0, 0), so p' = Ry(-90) (p - (7, 0, 0)) with Ry(-90)(x, y, z) = (-z, y, x).
            format!("90 {} {} {} -90 {}", -v[2], v[1], v[0] - 7.0, rest.join(" "))
        })
        .collect();
    // One joint cannot hold four rotations: the turn back goes to a joint between.
    let tree = tree.replacen(
        "JOINT Hips\n{\n  OFFSET 0 0 0\n  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation",
        "JOINT Back {\n OFFSET 0 0 0\n CHANNELS 4 Xposition Yposition Zposition Yrotation\nJOINT Hips\n{\n  OFFSET 0 0 0\n  CHANNELS 3 Zrotation Yrotation Xrotation",
        1,
    );
    format!(
        "HIERARCHY ROOT Reference {{ OFFSET 7 0 0 CHANNELS 1 Yrotation {tree} }} }}\nMOTION{head}0.05\n{}\n",
        rows.join("\n")
    )
}

/// A character of unit masses from names, parents and joint offsets (m, parent's frame); a contact sphere of 2 cm
/// at the end of each link named `shin` or `foot`.
pub fn model(name: &str, links: &[(&str, Option<usize>, [f64; 3])]) -> CharacterModel {
    let mut contact_points = Vec::new();
    let links: Vec<Link> = links
        .iter()
        .enumerate()
        .map(|(index, (name, parent, offset))| {
            if name.starts_with("shin") {
                contact_points.push(ContactPoint {
                    name: format!("{name}_end"),
                    link: index,
                    position: DVec3::new(0.0, -0.4, 0.0),
                    radius: 0.02,
                    friction: 1.0,
                    kind: ContactKind::Point,
                    role: bevy_athlete::model::PointRole::Body,
                });
            }
            Link {
                name: (*name).to_owned(),
                parent: *parent,
                joint: if parent.is_none() { JointKind::Free } else { JointKind::Ball },
                offset: DVec3::from_array(*offset),
                mass: 1.0,
                com: DVec3::ZERO,
                inertia: DMat3::IDENTITY,
                gains: Gains { kp: 0.0, kd: 0.0 },
                max_torque: f64::INFINITY,
                limits: None,
                armature: 0.0,
                spring: None,
                shapes: Vec::new(),
            }
        })
        .collect();
    CharacterModel {
        name: name.to_owned(),
        step_rate: 1200.0,
        links,
        contact_points,
        blades: Vec::new(),
        grips: Vec::new(),
        collision_pairs: Vec::new(),
        feet: Vec::new(),
        trunk: 0,
    }
}

/// The body of [`TINY`] in our axes and metres.
pub fn tiny_model() -> CharacterModel {
    model(
        "tiny",
        &[
            ("pelvis", None, [0.0; 3]),
            ("thigh_left", Some(0), [-0.09, -0.06, -0.02]),
            ("shin_left", Some(1), [0.0, -0.4, 0.0]),
            ("thigh_right", Some(0), [0.09, -0.06, -0.02]),
            ("shin_right", Some(3), [0.0, -0.4, 0.0]),
            ("chest", Some(0), [0.0, 0.1, 0.0]),
        ],
    )
}

/// Places of all links at every pose of a clip.
pub fn link_places(clip: &MotionClip, model: &CharacterModel) -> Vec<Vec<LinkTransform>> {
    let clip = clip.to_model(model).unwrap();
    let place = |pose: &bevy_athlete::model::ModelPose| {
        let mut out = Vec::new();
        pose.link_transforms(model, &mut out);
        out
    };
    clip.poses().iter().map(place).collect()
}

/// A random clip that turns, with a joint on either side and one in the middle.
pub fn wild_clip(random: &mut RandomStream, poses: usize) -> MotionClip {
    let joints: Vec<String> =
        ["thigh_left", "shin_left", "thigh_right", "shin_right", "chest"].map(String::from).into();
    let mut rotation = || {
        let v = DVec3::new(random.normal(), random.normal(), random.normal());
        DQuat::from_scaled_axis(v * 0.4)
    };
    let poses = (0..poses).map(|k| bevy_athlete::asset::clip::Pose {
        root_position: DVec3::new(0.1 * k as f64, 0.9 + 0.01 * k as f64, -0.3 * k as f64),
        root_rotation: rotation(),
        joints: joints.iter().map(|_| rotation()).collect(),
    });
    let poses = poses.collect();
    MotionClip { name: "wild".into(), frame_rate: 30.0, joints, poses }
}

/// One to four random edits: a byte changed, a piece removed, repeated, or a number replaced by an odd one.
pub fn mutate(text: &str, random: &mut RandomStream) -> String {
    const ODD: [&str; 14] = [
        "nan",
        "inf",
        "-1",
        "0",
        "1e308",
        "1e-308",
        "99999999999999999999",
        "{",
        "}",
        "(",
        "\"",
        "\u{0}",
        "\u{1F600}",
        ",",
    ];
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            break;
        }
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(12)).min(bytes.len());
        match random.below(6) {
            0 => bytes[at] = (random.bits() & 0xff) as u8,
            1 => {
                bytes.drain(at..end);
            }
            2 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            3 => {
                bytes.splice(at..end, ODD[random.below(ODD.len())].bytes());
            }
            4 => bytes[at] = b'0' + random.below(10) as u8,
            _ => {
                // Another digit in the place of a digit: often still a valid file.
                if let Some(offset) = bytes[at..].iter().position(u8::is_ascii_digit) {
                    bytes[at + offset] = b'0' + random.below(10) as u8;
                }
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
