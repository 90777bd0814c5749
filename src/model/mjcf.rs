//! Characters as MuJoCo models (MJCF), so that another simulator can check and time the same body.
//!
//! | here | there |
//! | --- | --- |
//! | link | `body`, same name, in the same (depth-first) order |
//! | [`JointKind::Free`], [`JointKind::Ball`], [`JointKind::Hinge`] | `freejoint`, `joint type="ball"`, `joint type="hinge"`, named after the link |
//! | mass, centre of mass, inertia | `inertial` with `fullinertia`, taken as it is (nothing balanced, bounded or fused) |
//! | contact point | `site` at its centre, and a sphere `geom` that only collides with the floor |
//! | shape | `geom` that collides with nothing, for the viewer |
//! | armature | the joint's `armature` |
//! | spring | the joint's `stiffness`, `damping` and, for a hinge, `springref`; a ball joint's is slack in the zero pose there |
//! | servo gains | `custom` numbers `athlete_kp`, `athlete_kd`: one a link; MuJoCo itself ignores them |
//!
//! MuJoCo orders velocities otherwise than this crate: a free joint's are linear (world axes) and then angular (body
//! axes), a ball joint's are angular in the child's axes. Quaternions are `w x y z`.
//!
//! A blade's knife edge has no counterpart: blade ends become small spheres with ordinary friction. Joint limits are not
//! exported (a ball joint's limit there is a cone).

use crate::model::{CharacterModel, ContactKind, JointKind, JointSpring, Shape};
use glam::{DMat3, DQuat, DVec3};
use std::fmt::{Display, Write};

/// Radius of the sphere that stands for a blade end, m. Its centre is raised by as much, so that it touches where the
/// blade does.
const BLADE_END_RADIUS: f64 = 0.002;

/// The character as the text of an MJCF file, standing on a floor in its zero pose.
///
/// Numbers are written so that reading them gives the same bits.
pub fn export_mjcf(model: &CharacterModel) -> String {
    let mut out = String::new();
    let mut line = |depth: usize, text: &str| {
        out.extend(std::iter::repeat_n("  ", depth));
        out.push_str(text);
        out.push('\n');
    };
    line(0, &format!("<mujoco model=\"{}\">", escape(&model.name)));
    line(
        1,
        "<compiler angle=\"radian\" autolimits=\"false\" inertiafromgeom=\"false\" balanceinertia=\"false\" \
         boundmass=\"0\" boundinertia=\"0\" settotalmass=\"-1\" fusestatic=\"false\"/>",
    );
    let timestep = number(1.0 / model.step_rate);
    line(1, &format!("<option timestep=\"{timestep}\" gravity=\"0 -9.81 0\"/>"));
    line(1, "<custom>");
    for (name, gain) in [
        ("athlete_kp", model.links.iter().map(|l| l.gains.kp).collect::<Vec<_>>()),
        ("athlete_kd", { model.links.iter().map(|l| l.gains.kd).collect() }),
    ] {
        line(2, &format!("<numeric name=\"{name}\" size=\"{}\" data=\"{}\"/>", gain.len(), numbers(gain)));
    }
    line(1, "</custom>");
    line(1, "<worldbody>");
    // The plane's normal is its local Z: turned onto Y.
    line(
        2,
        "<geom name=\"floor\" type=\"plane\" size=\"0 0 1\" quat=\"0.7071067811865476 -0.7071067811865476 0 0\" \
         contype=\"1\" conaffinity=\"2\" condim=\"3\" friction=\"0 0 0\"/>",
    );
    // A stack of the open bodies; depth-first order means that a link's parent is always among them.
    let mut open: Vec<usize> = Vec::new();
    for (i, link) in model.links.iter().enumerate() {
        while open.last().copied() != link.parent {
            if open.pop().is_none() {
                break;
            }
            line(2 + open.len(), "</body>");
        }
        let depth = 2 + open.len();
        let position = match link.parent {
            None => DVec3::Y * model.rest_root_height(),
            Some(_) => link.offset,
        };
        line(depth, &format!("<body name=\"{}\" pos=\"{}\">", escape(&link.name), vector(position)));
        for element in body_elements(model, i) {
            line(depth + 1, &element);
        }
        open.push(i);
    }
    while open.pop().is_some() {
        line(2 + open.len(), "</body>");
    }
    line(1, "</worldbody>");
    line(0, "</mujoco>");
    out
}

/// The elements inside a link's body, children apart.
fn body_elements(model: &CharacterModel, index: usize) -> Vec<String> {
    let link = &model.links[index];
    let name = escape(&link.name);
    let armature = number(link.armature);
    let spring = link.spring.unwrap_or(JointSpring { stiffness: 0.0, damping: 0.0, rest: DVec3::ZERO });
    let (stiffness, damping) = (number(spring.stiffness), number(spring.damping));
    let mut out = vec![match link.joint {
        JointKind::Free => format!("<freejoint name=\"{name}\"/>"),
        JointKind::Ball => {
            format!(
                "<joint name=\"{name}\" type=\"ball\" pos=\"0 0 0\" damping=\"{damping}\" armature=\"{armature}\" stiffness=\"{stiffness}\"/>"
            )
        }
        JointKind::Hinge { axis } => format!(
            "<joint name=\"{name}\" type=\"hinge\" pos=\"0 0 0\" axis=\"{}\" damping=\"{damping}\" armature=\"{armature}\" \
             stiffness=\"{stiffness}\" springref=\"{}\"/>",
            vector(axis),
            number(axis.dot(spring.rest))
        ),
    }];
    out.push(format!(
        "<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>",
        vector(link.com),
        number(link.mass),
        full_inertia(link.inertia)
    ));
    for shape in &link.shapes {
        out.push(visual(shape));
    }
    for point in model.contact_points.iter().filter(|c| c.link == index) {
        let (radius, center) = match point.kind {
            ContactKind::Point => (point.radius, point.position),
            ContactKind::BladeToe(_) | ContactKind::BladeHeel(_) => {
                let radius = point.radius.max(BLADE_END_RADIUS);
                (radius, point.position + DVec3::Y * (radius - point.radius))
            }
        };
        let name = escape(&point.name);
        out.push(format!("<site name=\"{name}\" pos=\"{}\" size=\"{}\"/>", vector(point.position), number(radius)));
        out.push(format!(
            "<geom name=\"{name}\" type=\"sphere\" pos=\"{}\" size=\"{}\" contype=\"2\" conaffinity=\"1\" condim=\"3\" \
             friction=\"{} 0 0\" group=\"3\"/>",
            vector(center),
            number(radius.max(1e-6)),
            number(point.friction)
        ));
    }
    out
}

/// A geom that collides with nothing.
fn visual(shape: &Shape) -> String {
    let geom = match *shape {
        Shape::Box { center, half_extents, rotation } => format!(
            "type=\"box\" pos=\"{}\" size=\"{}\" quat=\"{}\"",
            vector(center),
            vector(half_extents),
            quaternion(rotation)
        ),
        Shape::Capsule { a, b, radius } if a.distance(b) > 1e-9 => {
            format!("type=\"capsule\" fromto=\"{} {}\" size=\"{}\"", vector(a), vector(b), number(radius))
        }
        Shape::Capsule { a: center, radius, .. } | Shape::Sphere { center, radius } => {
            format!("type=\"sphere\" pos=\"{}\" size=\"{}\"", vector(center), number(radius))
        }
    };
    format!("<geom {geom} contype=\"0\" conaffinity=\"0\" group=\"1\"/>")
}

/// Shortest text that reads back to the same bits.
fn number(value: f64) -> impl Display {
    // Adding zero turns -0 into 0.
    value + 0.0
}

fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    let mut out = String::new();
    for value in values {
        let gap = if out.is_empty() { "" } else { " " };
        let _ = write!(out, "{gap}{}", number(value));
    }
    out
}

fn vector(v: DVec3) -> String {
    numbers(v.to_array())
}

fn quaternion(q: DQuat) -> String {
    numbers([q.w, q.x, q.y, q.z])
}

/// `ixx iyy izz ixy ixz iyz`.
fn full_inertia(m: DMat3) -> String {
    numbers([m.x_axis.x, m.y_axis.y, m.z_axis.z, m.y_axis.x, m.z_axis.x, m.z_axis.y])
}

/// Text as an attribute value. Characters that XML forbids become `?`.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            '\t' | '\n' | '\r' => out.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('?'),
            c => out.push(c),
        }
    }
    out
}
