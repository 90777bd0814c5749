//! A character as a table.

use crate::model::{CharacterModel, ContactKind, FootKind, JointKind, PointRole, Shape, Side};
use glam::DVec3;
use serde::Serialize;

/// A link, its joint and its servo.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkRow {
    /// Name.
    pub name: String,
    /// Name of the parent; `None` for the root.
    pub parent: Option<String>,
    /// `free`, `ball` or `hinge`.
    pub joint: &'static str,
    /// Degrees of freedom.
    pub dof: usize,
    /// Joint position in the zero pose, root at the origin, m.
    pub position: [f64; 3],
    /// Mass, kg.
    pub mass: f64,
    /// Joint range as low and high of the rotation vector's components, degrees; `None` is free.
    pub limits_deg: Option<[[f64; 2]; 3]>,
    /// Stiffness, N m/rad.
    pub kp: f64,
    /// Damping, N m s/rad.
    pub kd: f64,
    /// Largest servo torque, N m; `None` is unbounded.
    pub max_torque: Option<f64>,
    /// Inertia on the joint's own velocity, kg m^2.
    pub armature: f64,
    /// Passive spring at the joint: N m/rad, N m s/rad.
    pub spring: Option<[f64; 2]>,
    /// Contact points on the link.
    pub contact_points: usize,
}

/// A contact point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointRow {
    /// Name.
    pub name: String,
    /// Name of its link.
    pub link: String,
    /// Centre, link frame, m.
    pub position: [f64; 3],
    /// Radius, m.
    pub radius: f64,
    /// Factor on friction.
    pub friction: f64,
    /// `point` or `blade`.
    pub kind: &'static str,
    /// `foot`, `hand` or `body`.
    pub role: &'static str,
}

/// A foot, as the file says or as it was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FootRow {
    /// `left` or `right`; `None` for a foot in the middle.
    pub side: Option<&'static str>,
    /// Name of the blade it stands with; `None` for a sole.
    pub blade: Option<String>,
    /// Names of its links.
    pub links: Vec<String>,
    /// Name of the contact point at its front.
    pub toe: String,
    /// Name of the contact point at its rear.
    pub heel: String,
}

/// A character in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CharacterTable {
    /// Name.
    pub character: String,
    /// Mass, kg.
    pub mass: f64,
    /// Degrees of freedom, the root's six included.
    pub dof: usize,
    /// From the lowest contact point to the top of the highest shape in the zero pose, m.
    pub height: f64,
    /// Height of the root above the lowest contact point in the zero pose, m.
    pub root_height: f64,
    /// Steps per second it is made for.
    pub step_rate: f64,
    /// Links, root first.
    pub links: Vec<LinkRow>,
    /// Contact points.
    pub contact_points: Vec<PointRow>,
    /// Feet.
    pub feet: Vec<FootRow>,
    /// Name of the link that carries head and arms.
    pub trunk: String,
    /// Names of the blades.
    pub blades: Vec<String>,
    /// Names of the grips.
    pub grips: Vec<String>,
    /// Pairs of links that may collide.
    pub collision_pairs: usize,
}

/// Highest point of a shape over its link's origin in the zero pose, m.
fn top(shape: &Shape) -> f64 {
    match *shape {
        Shape::Box { center, half_extents, rotation } => {
            let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (rotation * axis).y.abs());
            center.y + DVec3::from_array(axes).dot(half_extents)
        }
        Shape::Capsule { a, b, radius } => a.y.max(b.y) + radius,
        Shape::Sphere { center, radius } => center.y + radius,
    }
}

/// The character in numbers.
pub fn character_table(model: &CharacterModel) -> CharacterTable {
    let places = model.rest_positions();
    let links = model.links.iter().enumerate().map(|(i, link)| LinkRow {
        name: link.name.clone(),
        parent: link.parent.map(|p| model.links[p].name.clone()),
        joint: match link.joint {
            JointKind::Free => "free",
            JointKind::Ball => "ball",
            JointKind::Hinge { .. } => "hinge",
        },
        dof: link.joint.dof(),
        position: places[i].to_array(),
        mass: link.mass,
        limits_deg: link.limits.map(|l| {
            let (low, high) = (l.low.to_array(), l.high.to_array());
            [0, 1, 2].map(|k| [low[k].to_degrees(), high[k].to_degrees()])
        }),
        kp: link.gains.kp,
        kd: link.gains.kd,
        max_torque: link.max_torque.is_finite().then_some(link.max_torque),
        armature: link.armature,
        spring: link.spring.map(|s| [s.stiffness, s.damping]),
        contact_points: model.contact_points.iter().filter(|c| c.link == i).count(),
    });
    let points = model.contact_points.iter().map(|point| PointRow {
        name: point.name.clone(),
        link: model.links[point.link].name.clone(),
        position: point.position.to_array(),
        radius: point.radius,
        friction: point.friction,
        kind: if point.kind == ContactKind::Point { "point" } else { "blade" },
        role: match point.role {
            PointRole::Foot => "foot",
            PointRole::Hand => "hand",
            PointRole::Body => "body",
        },
    });
    let feet = model.feet().iter().map(|foot| FootRow {
        side: foot.side.map(Side::name),
        blade: match foot.kind {
            FootKind::Blade(blade) => Some(model.blades[blade].name.clone()),
            FootKind::Sole => None,
        },
        links: foot.links.iter().map(|&l| model.links[l].name.clone()).collect(),
        toe: model.contact_points[foot.toe].name.clone(),
        heel: model.contact_points[foot.heel].name.clone(),
    });
    let tops = model.links.iter().zip(&places).flat_map(|(l, p)| l.shapes.iter().map(move |s| p.y + top(s)));
    CharacterTable {
        character: model.name.clone(),
        mass: model.mass(),
        dof: model.dof(),
        height: tops.fold(0.0, f64::max) + model.rest_root_height(),
        root_height: model.rest_root_height(),
        step_rate: model.step_rate,
        links: links.collect(),
        contact_points: points.collect(),
        feet: feet.collect(),
        trunk: model.links[model.trunk()].name.clone(),
        blades: model.blades.iter().map(|b| b.name.clone()).collect(),
        grips: model.grips.iter().map(|g| g.name.clone()).collect(),
        collision_pairs: model.collision_pairs.len(),
    }
}
