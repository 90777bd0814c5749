//! Boxes, capsules and spheres as triangles.

use crate::model::{CharacterModel, LinkTransform, Shape};
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

/// Triangles around a capsule.
const SEGMENTS: usize = 20;
/// Rings of a half sphere.
const RINGS: usize = 6;
/// Radius that a blade is drawn with, m.
const BLADE_RADIUS: f64 = 0.006;

/// A corner of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// Position, m.
    pub position: DVec3,
    /// Unit normal, outward.
    pub normal: DVec3,
}

/// Which side of the body a link belongs to: its hue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
    Middle,
    Steel,
    Scenery,
    Marked,
}

impl Side {
    /// By the link's name: `left` or `right` in it, or `l` or `r` as its first or last word.
    pub fn of(name: &str) -> Side {
        let name = name.to_ascii_lowercase();
        let mut words = name.split(['_', '.', '-', ' ']);
        let edge = [words.next(), words.next_back()];
        if name.contains("left") || edge.contains(&Some("l")) {
            Side::Left
        } else if name.contains("right") || edge.contains(&Some("r")) {
            Side::Right
        } else {
            Side::Middle
        }
    }
}

/// A solid ready to be drawn: triangles in the world frame.
pub(crate) struct Solid {
    /// Three vertices a triangle.
    pub vertices: Vec<Vertex>,
    /// What it belongs to.
    pub side: Side,
    /// Number that tells solids apart where outlines are drawn, from 1.
    pub id: u16,
}

/// All solids of a figure: the shapes of its links and its blades.
pub(crate) fn figure(model: &CharacterModel, links: &[LinkTransform]) -> Vec<Solid> {
    let mut solids = Vec::new();
    for (i, (link, place)) in model.links.iter().zip(links).enumerate() {
        let side = Side::of(&link.name);
        for shape in &link.shapes {
            solids.push(Solid { vertices: triangles(shape, place), side, id: i as u16 + 1 });
        }
    }
    for blade in &model.blades {
        let (Some(toe), Some(heel)) = (model.contact_points.get(blade.toe), model.contact_points.get(blade.heel))
        else {
            continue;
        };
        let lift = DVec3::Y * BLADE_RADIUS;
        let shape = Shape::Capsule { a: toe.position + lift, b: heel.position + lift, radius: BLADE_RADIUS };
        if let Some(place) = links.get(blade.link) {
            let id = (model.links.len() + blade.link) as u16 + 1;
            solids.push(Solid { vertices: triangles(&shape, place), side: Side::Steel, id });
        }
    }
    solids
}

/// Marks shapes of a figure that [`figure`] made, given by link and number on it.
pub(crate) fn mark(solids: &mut [Solid], model: &CharacterModel, marked: &[(usize, usize)]) {
    for &(link, shape) in marked.iter().filter(|(l, s)| model.links.get(*l).is_some_and(|l| *s < l.shapes.len())) {
        let before: usize = model.links[..link].iter().map(|l| l.shapes.len()).sum();
        if let Some(solid) = solids.get_mut(before + shape) {
            solid.side = Side::Marked;
        }
    }
}

/// Solids that stand in the world.
pub(crate) fn scenery(shapes: &[Shape]) -> Vec<Solid> {
    let world = LinkTransform { position: DVec3::ZERO, rotation: DQuat::IDENTITY };
    let solid = |(i, s)| Solid { vertices: triangles(s, &world), side: Side::Scenery, id: u16::MAX - i as u16 };
    shapes.iter().take(1000).enumerate().map(solid).collect()
}

/// A shape as triangles in the world frame.
pub(crate) fn triangles(shape: &Shape, place: &LinkTransform) -> Vec<Vertex> {
    let mut out = Vec::new();
    match *shape {
        Shape::Box { center, half_extents, rotation } => cuboid(&mut out, center, half_extents, rotation),
        Shape::Capsule { a, b, radius } => capsule(&mut out, a, b, radius),
        Shape::Sphere { center, radius } => capsule(&mut out, center, center, radius),
    }
    for v in &mut out {
        *v = Vertex { position: place.position + place.rotation * v.position, normal: place.rotation * v.normal };
    }
    out
}

fn quad(out: &mut Vec<Vertex>, corners: [Vertex; 4]) {
    let [a, b, c, d] = corners;
    out.extend([a, b, c, a, c, d]);
}

fn cuboid(out: &mut Vec<Vertex>, center: DVec3, half: DVec3, rotation: DQuat) {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for (i, axis) in axes.iter().enumerate() {
        let (u, v) = (axes[(i + 1) % 3], axes[(i + 2) % 3]);
        for sign in [-1.0, 1.0] {
            let corner = |p: f64, q: f64| Vertex {
                position: center + rotation * (half * (*axis * sign + u * p + v * q)),
                normal: rotation * (*axis * sign),
            };
            quad(out, [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        }
    }
}

/// A capsule from pole to pole: half sphere, cylinder, half sphere. With both ends in one place it is a sphere.
fn capsule(out: &mut Vec<Vertex>, a: DVec3, b: DVec3, radius: f64) {
    let axis = (b - a).try_normalize().unwrap_or(DVec3::Y);
    let u = axis.any_orthonormal_vector();
    let v = axis.cross(u);
    // A ring: the point of the axis it is around and its latitude (-pi/2 at the pole behind a, pi/2 beyond b).
    let mut rings: Vec<(DVec3, f64)> = Vec::with_capacity(2 * RINGS + 2);
    for (end, start) in [(a, -PI / 2.0), (b, 0.0)] {
        for k in 0..=RINGS {
            rings.push((end, start + PI / 2.0 * k as f64 / RINGS as f64));
        }
    }
    let vertex = |(around, latitude): (DVec3, f64), k: usize| {
        let longitude = TAU * k as f64 / SEGMENTS as f64;
        let level = u * longitude.cos() + v * longitude.sin();
        let normal = level * latitude.cos() + axis * latitude.sin();
        Vertex { position: around + normal * radius, normal }
    };
    for pair in rings.windows(2) {
        for k in 0..SEGMENTS {
            quad(out, [vertex(pair[0], k), vertex(pair[0], k + 1), vertex(pair[1], k + 1), vertex(pair[1], k)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_by_name() {
        for (name, side) in [
            ("h_thigh_left", Side::Left),
            ("LeftArm", Side::Left),
            ("r_foot", Side::Right),
            ("foot_r", Side::Right),
            ("right_hand", Side::Right),
            ("pelvis", Side::Middle),
            ("girl", Side::Middle),
        ] {
            assert_eq!(Side::of(name), side, "{name}");
        }
    }

    #[test]
    fn normals_are_unit_and_outward() {
        let world = LinkTransform { position: DVec3::ZERO, rotation: DQuat::IDENTITY };
        let shape = Shape::Capsule { a: DVec3::ZERO, b: DVec3::new(0.1, 0.4, 0.0), radius: 0.05 };
        for v in triangles(&shape, &world) {
            assert!((v.normal.length() - 1.0).abs() < 1e-12);
            assert!((v.position - DVec3::new(0.05, 0.2, 0.0)).dot(v.normal) > 0.0);
        }
    }
}
