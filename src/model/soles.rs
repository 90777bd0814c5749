//! Shoes: a sole under what a foot stands on.
//!
//! A sole follows the foot: every link that stands in the zero pose carries the part of it that lies below. The contact points that touch
//! the ground there move to the underside, down by the thickness; the rectangle around them grows by the margins, and they with it, so
//! that the outermost lie at its edge. A slab below each link, from the bare foot to the underside, is drawn and weighs: the slabs share
//! the sole's mass by their volumes. So a sole bends at the foot's joints and nowhere else, and is as hard as a bare foot.

use super::mass::MassProperties;
use super::{CharacterModel, ContactKind, Shape};
use crate::asset::{FootEntry, SoleEntry};
use glam::{DQuat, DVec3};

/// Points this much above the lowest of their foot stand on the ground in the zero pose too, m.
const STANDING: f64 = 0.002;

/// A contact point that a sole covers.
struct Covered {
    /// Its index in the model.
    point: usize,
    link: usize,
    /// Its centre in the zero pose, character frame, m.
    place: DVec3,
    radius: f64,
}

/// Corners of the smallest box around some points, character frame, m.
fn bounds<'a>(points: impl Iterator<Item = &'a Covered>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p.place - p.radius), high.max(p.place + p.radius))
    })
}

/// Puts the soles of a validated file's feet under the model's, which are in the same order.
pub(super) fn put_on_soles(model: &mut CharacterModel, feet: &[FootEntry]) {
    for (foot, entry) in feet.iter().enumerate() {
        if let Some(sole) = &entry.sole {
            let mut covered = standing(model, foot);
            move_to_underside(model, &mut covered, sole);
            add_slabs(model, &covered, sole);
        }
    }
}

/// The contact points that a foot stands on, by link.
fn standing(model: &CharacterModel, foot: usize) -> Vec<Covered> {
    let rest = model.rest_positions();
    let own = model.foot_points(&model.feet[foot]).filter_map(|point| {
        let p = &model.contact_points[point];
        let ordinary = p.kind == ContactKind::Point;
        ordinary.then(|| Covered { point, link: p.link, place: rest[p.link] + p.position, radius: p.radius })
    });
    let mut own: Vec<Covered> = own.collect();
    let floor = bounds(own.iter()).0.y;
    own.retain(|p| p.place.y - p.radius < floor + STANDING);
    own.sort_by_key(|p| p.link);
    own
}

/// Moves covered points down and outwards, and gives them the sole's friction.
fn move_to_underside(model: &mut CharacterModel, covered: &mut [Covered], sole: &SoleEntry) {
    let rest = model.rest_positions();
    let (low, high) = bounds(covered.iter());
    let (front, rear) = (DVec3::new(sole.side, 0.0, sole.front), DVec3::new(sole.side, 0.0, sole.rear));
    let (to_low, to_high) = (low - front, high + rear);
    for p in covered {
        for axis in [0, 2] {
            // The same part of the way across the larger rectangle; the sphere keeps its size.
            let (width, to_width) =
                (high[axis] - low[axis] - 2.0 * p.radius, to_high[axis] - to_low[axis] - 2.0 * p.radius);
            let part = if width > 1e-9 { (p.place[axis] - low[axis] - p.radius) / width } else { 0.5 };
            p.place[axis] = to_low[axis] + p.radius + part * to_width;
        }
        p.place.y -= sole.thickness;
        let point = &mut model.contact_points[p.point];
        point.position = p.place - rest[p.link];
        point.friction = sole.friction;
    }
}

/// Adds the slabs below the links, and their mass.
fn add_slabs(model: &mut CharacterModel, covered: &[Covered], sole: &SoleEntry) {
    let rest = model.rest_positions();
    let mut slabs: Vec<(usize, DVec3, DVec3)> = Vec::new();
    for own in covered.chunk_by(|a, b| a.link == b.link) {
        let (low, high) = bounds(own.iter());
        let high = DVec3::new(high.x, low.y + sole.thickness, high.z);
        slabs.push((own[0].link, (low + high) * 0.5 - rest[own[0].link], (high - low) * 0.5));
    }
    let volume = |half: &DVec3| half.x * half.y * half.z;
    let whole: f64 = slabs.iter().map(|(_, _, half)| volume(half)).sum();
    for (index, center, half_extents) in slabs {
        let shape = Shape::Box { center, half_extents, rotation: DQuat::IDENTITY };
        let own = MassProperties::of_shapes(&[shape], sole.mass * volume(&half_extents) / whole);
        let link = &mut model.links[index];
        let total = MassProperties { mass: link.mass, com: link.com, inertia: link.inertia }.plus(&own);
        (link.mass, link.com, link.inertia) = (total.mass, total.com, total.inertia);
        link.shapes.push(shape);
    }
}
