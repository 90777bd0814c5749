//! A small skater built in code, for tests that need a character but no file.
#![allow(dead_code)]

use bevy_athlete::model::{
    Blade, CharacterModel, ContactKind, ContactPoint, Gains, JointKind, LeanLaw, Link, LinkTransform, Shape,
};
use glam::{DMat3, DQuat, DVec3};

struct Part {
    name: &'static str,
    parent: &'static str,
    offset: [f64; 3],
    mass: f64,
    shape: Shape,
}

fn bone(length: f64, radius: f64) -> Shape {
    Shape::Capsule { a: DVec3::ZERO, b: DVec3::Y * -length, radius }
}

fn block(center: [f64; 3], half: [f64; 3]) -> Shape {
    Shape::Box { center: center.into(), half_extents: half.into(), rotation: DQuat::IDENTITY }
}

/// A character of 16 links, one hinge, two blades.
pub fn puppet() -> CharacterModel {
    let mut parts = vec![Part {
        name: "pelvis",
        parent: "",
        offset: [0.0; 3],
        mass: 8.0,
        shape: block([0.0; 3], [0.12, 0.07, 0.06]),
    }];
    let mut add = |name, parent, offset, mass, shape| parts.push(Part { name, parent, offset, mass, shape });
    add("torso", "pelvis", [0.0, 0.07, 0.0], 14.0, block([0.0, 0.2, 0.0], [0.14, 0.19, 0.075]));
    let skull = Shape::Sphere { center: DVec3::Y * 0.13, radius: 0.1 };
    add("head & <\"neck\">", "torso", [0.0, 0.42, 0.0], 4.0, skull);
    for (side, upper, fore, hand) in
        [(-1.0, "upper_arm_left", "forearm_left", "hand_left"), (1.0, "upper_arm_right", "forearm_right", "hand_right")]
    {
        add(upper, "torso", [side * 0.18, 0.36, 0.0], 1.6, bone(0.26, 0.04));
        add(fore, upper, [0.0, -0.26, 0.0], 0.8, bone(0.21, 0.033));
        add(hand, fore, [0.0, -0.22, 0.0], 0.3, block([0.0, -0.06, 0.0], [0.02, 0.06, 0.035]));
    }
    for (side, thigh, shin, foot) in
        [(-1.0, "thigh_left", "shin_left", "foot_left"), (1.0, "thigh_right", "shin_right", "foot_right")]
    {
        add(thigh, "pelvis", [side * 0.09, -0.05, 0.0], 6.5, bone(0.37, 0.065));
        add(shin, thigh, [0.0, -0.37, 0.0], 2.0, bone(0.37, 0.048));
        add(foot, shin, [0.0, -0.37, 0.0], 1.2, block([0.0, -0.05, -0.04], [0.045, 0.035, 0.12]));
    }
    let mut model = CharacterModel {
        name: "puppet".into(),
        step_rate: 1200.0,
        links: Vec::new(),
        contact_points: Vec::new(),
        blades: Vec::new(),
        grips: Vec::new(),
        collision_pairs: Vec::new(),
        feet: Vec::new(),
        trunk: 0,
    };
    for part in parts {
        let parent = model.link_index(part.parent);
        let (com, half) = match part.shape {
            Shape::Box { center, half_extents, .. } => (center, half_extents),
            Shape::Capsule { a, b, radius } => ((a + b) / 2.0, DVec3::new(radius, (b - a).length() / 2.0, radius)),
            Shape::Sphere { center, radius } => (center, DVec3::splat(radius)),
        };
        let sq = half * half;
        let diagonal = part.mass / 3.0 * DVec3::new(sq.y + sq.z, sq.z + sq.x, sq.x + sq.y);
        // A little product of inertia, so that the order of the six numbers matters.
        let inertia = DMat3::from_diagonal(diagonal)
            + DMat3::from_cols_array(&[0.0, 1e-4, 2e-4, 1e-4, 0.0, -3e-4, 2e-4, -3e-4, 0.0]) * part.mass / 10.0;
        let joint = match part.name {
            "pelvis" => JointKind::Free,
            "shin_left" | "shin_right" => JointKind::Hinge { axis: DVec3::X },
            _ => JointKind::Ball,
        };
        model.links.push(Link {
            name: part.name.into(),
            parent,
            joint,
            offset: part.offset.into(),
            mass: part.mass,
            com,
            inertia,
            gains: if parent.is_some() { Gains { kp: 600.0, kd: 49.0 } } else { Gains { kp: 0.0, kd: 0.0 } },
            max_torque: f64::INFINITY,
            limits: None,
            armature: 0.0,
            spring: None,
            shapes: vec![part.shape],
        });
    }
    for (b, side) in ["left", "right"].into_iter().enumerate() {
        let link = model.link_index(&format!("foot_{side}")).unwrap();
        let toe = model.contact_points.len();
        for (end, z, kind) in [("toe", -0.15, ContactKind::BladeToe(b)), ("heel", 0.06, ContactKind::BladeHeel(b))] {
            model.contact_points.push(ContactPoint {
                name: format!("{side}_{end}"),
                link,
                position: DVec3::new(0.0, -0.13, z),
                radius: 0.0,
                friction: 1.0,
                kind,
                role: bevy_athlete::model::PointRole::Body,
            });
        }
        for (corner, x) in [("outer", -0.03), ("inner", 0.03)] {
            model.contact_points.push(ContactPoint {
                name: format!("{side}_{corner}"),
                link,
                position: DVec3::new(x, -0.12, 0.0),
                radius: 0.01,
                friction: 0.8,
                kind: ContactKind::Point,
                role: bevy_athlete::model::PointRole::Body,
            });
        }
        model.blades.push(Blade {
            name: side.into(),
            link,
            toe,
            heel: toe + 1,
            inside: DVec3::X * if b == 0 { 1.0 } else { -1.0 },
            lean_law: LeanLaw::Rocker { radius: 2.2 },
            bite: None,
        });
    }
    model
}

/// Where all links are for a root place and joint rotations; `joint` gives the rotation of a link by name.
pub fn place(model: &CharacterModel, root: DVec3, turn: DQuat, joint: impl Fn(&str) -> DQuat) -> Vec<LinkTransform> {
    let mut out: Vec<LinkTransform> = Vec::new();
    for link in &model.links {
        out.push(match link.parent {
            None => LinkTransform { position: root, rotation: turn },
            Some(p) => LinkTransform {
                position: out[p].position + out[p].rotation * link.offset,
                rotation: out[p].rotation * joint(&link.name),
            },
        });
    }
    out
}
