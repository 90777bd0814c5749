//! From a character file to the frozen model: welds merged, links in depth-first order, collision pairs listed.

use super::body_parts::{default_roles, found_feet, found_trunk, sole_ends};
use super::mass::MassProperties;
use super::overlap::overlap;
use super::soles::put_on_soles;
use super::{
    Blade, CharacterModel, ContactKind, ContactPoint, Foot, FootKind, Gains, Grip, JointKind, JointLimits, JointSpring,
    LeanLaw, Link, Shape,
};
use crate::asset::{
    Character, CharacterError, FootEntry, FootKindEntry, JointEntry, LeanLawEntry, LimitsEntry, LinkEntry, PointRole,
    ShapeEntry, SpringEntry,
};
use glam::{DQuat, DVec3};
use std::collections::HashMap;

impl CharacterModel {
    /// Validates the character and builds its model.
    ///
    /// A welded link becomes part of its parent. Soles go under feet. Two links may collide when both have shapes, no joint connects them, the
    /// file does not exclude them and their shapes do not already overlap in the zero pose.
    pub fn build(character: &Character) -> Result<Self, CharacterError> {
        character.validate()?;
        let tree = Tree::new(character);
        let links = build_links(character, &tree);
        let mut contact_points: Vec<ContactPoint> = Vec::new();
        for point in &character.contact_points {
            let (link, shift) = tree.place(&point.link);
            contact_points.push(ContactPoint {
                name: point.name.clone(),
                link,
                position: point.position + shift,
                radius: point.radius,
                friction: point.friction,
                kind: ContactKind::Point,
                role: point.role.unwrap_or(PointRole::Body),
            });
        }
        let mut blades = Vec::new();
        for (index, entry) in character.blades.iter().enumerate() {
            let (link, shift) = tree.place(&entry.link);
            let toe = contact_points.len();
            let ends = [(entry.toe, ContactKind::BladeToe(index)), (entry.heel, ContactKind::BladeHeel(index))];
            for (name, (position, kind)) in entry.end_names().into_iter().zip(ends) {
                let position = position + shift;
                let role = PointRole::Foot;
                contact_points.push(ContactPoint { name, link, position, radius: 0.0, friction: 1.0, kind, role });
            }
            blades.push(Blade {
                name: entry.name.clone(),
                link,
                toe,
                heel: toe + 1,
                inside: entry.inside.normalize(),
                lean_law: lean_law(entry.lean_law),
                bite: entry.bite,
            });
        }
        let grips = character.grips.iter().map(|grip| {
            let (link, shift) = tree.place(&grip.link);
            let max_force = grip.max_force.unwrap_or(Grip::DEFAULT_FORCE);
            Grip { name: grip.name.clone(), link, position: grip.position + shift, max_force }
        });
        let grips = grips.collect();
        let excluded = character.no_collision.iter().map(|(a, b)| (tree.place(a).0, tree.place(b).0)).collect();
        let mut model = CharacterModel {
            name: character.name.clone(),
            step_rate: character.step_rate,
            links,
            contact_points,
            blades,
            grips,
            collision_pairs: Vec::new(),
            feet: Vec::new(),
            trunk: 0,
        };
        name_parts(&mut model, character, &tree);
        put_on_soles(&mut model, &character.feet);
        model.collision_pairs = collision_pairs(&model, excluded);
        Ok(model)
    }
}

/// Where every entry of the file ends up.
struct Tree<'a> {
    /// Position of each entry by its name.
    by_name: HashMap<&'a str, usize>,
    /// For each entry, the entry whose moving link carries it: itself, or for a weld the nearest ancestor that moves.
    host: Vec<usize>,
    /// For each entry, the shift from its frame to its host's, m.
    shift: Vec<DVec3>,
    /// Moving entries, depth-first, children in file order.
    order: Vec<usize>,
    /// For each entry that moves, its index in `order`.
    rank: Vec<usize>,
}

impl<'a> Tree<'a> {
    /// The tree of a validated character.
    fn new(character: &'a Character) -> Self {
        let entries = &character.links;
        let by_name: HashMap<&str, usize> = entries.iter().enumerate().map(|(i, l)| (l.name.as_str(), i)).collect();
        let parent = |i: usize| entries[i].parent.as_ref().map(|p| by_name[p.as_str()]);
        let mut host: Vec<usize> = (0..entries.len()).collect();
        let mut shift = vec![DVec3::ZERO; entries.len()];
        for i in 0..entries.len() {
            while entries[host[i]].joint == JointEntry::Weld {
                let Some(above) = parent(host[i]) else { break };
                host[i] = above;
            }
            shift[i] = entries[i].position - entries[host[i]].position;
        }

        // Depth-first with a stack: the children are pushed in reverse, so that they come off in file order.
        let mut children = vec![Vec::new(); entries.len()];
        let mut stack = Vec::new();
        for i in 0..entries.len() {
            match parent(i) {
                Some(above) if host[i] == i => children[host[above]].push(i),
                Some(_) => {}
                None => stack.push(i),
            }
        }
        let (mut order, mut rank) = (Vec::new(), vec![0; entries.len()]);
        while let Some(i) = stack.pop() {
            rank[i] = order.len();
            order.push(i);
            stack.extend(children[i].iter().rev());
        }
        Self { by_name, host, shift, order, rank }
    }

    /// The model's link that carries the named entry, and the shift from the entry's frame to that link's, m.
    fn place(&self, name: &str) -> (usize, DVec3) {
        let entry = self.by_name[name];
        (self.rank[self.host[entry]], self.shift[entry])
    }
}

/// Feet, roles and trunk: what the file says, the rest by the rules of `body_parts.rs`.
fn name_parts(model: &mut CharacterModel, character: &Character, tree: &Tree) {
    model.feet = match character.feet.as_slice() {
        [] => found_feet(model),
        named => named.iter().filter_map(|entry| foot(model, entry, tree)).collect(),
    };
    let roles = default_roles(model);
    for (p, role) in roles.into_iter().enumerate() {
        // The points of the file come first, then the ends of blades.
        let said = character.contact_points.get(p).and_then(|entry| entry.role);
        model.contact_points[p].role = said.unwrap_or(role);
    }
    model.trunk = match &character.trunk {
        Some(name) => tree.place(name).0,
        None => found_trunk(model),
    };
}

/// A foot of a validated file, which has a contact point on its links.
fn foot(model: &CharacterModel, entry: &FootEntry, tree: &Tree) -> Option<Foot> {
    let mut links: Vec<usize> = entry.links.iter().map(|name| tree.place(name).0).collect();
    links.sort_unstable();
    links.dedup();
    let (kind, [toe, heel]) = match &entry.kind {
        FootKindEntry::Sole => (FootKind::Sole, sole_ends(model, &links)?),
        FootKindEntry::Blade(name) => {
            let index = model.blades.iter().position(|b| b.name == *name)?;
            (FootKind::Blade(index), [model.blades[index].toe, model.blades[index].heel])
        }
    };
    let named = |end: &Option<String>, default: usize| {
        let point = end.as_ref().and_then(|name| model.contact_points.iter().position(|p| p.name == *name));
        point.unwrap_or(default)
    };
    Some(Foot { side: entry.side, kind, links, toe: named(&entry.toe, toe), heel: named(&entry.heel, heel) })
}

/// The moving links, welded ones added to their hosts.
fn build_links(character: &Character, tree: &Tree) -> Vec<Link> {
    let entries = &character.links;
    let mut links: Vec<Link> = Vec::with_capacity(tree.order.len());
    for &own in &tree.order {
        let entry = &entries[own];
        let (mut shapes, mut total) = (Vec::new(), MassProperties::NOTHING);
        for (i, part) in entries.iter().enumerate().filter(|(i, _)| tree.host[*i] == own) {
            let solids: Vec<Shape> = part.shapes.iter().map(shape).collect();
            let properties = mass_properties(part, &solids);
            total = total.plus(&properties.shifted(tree.shift[i]));
            shapes.extend(solids.into_iter().map(|s| s.shifted(tree.shift[i])));
        }
        let parent = entry.parent.as_ref().map(|name| tree.place(name).0);
        let joint = match entry.joint {
            JointEntry::Ball => JointKind::Ball,
            JointEntry::Hinge { axis } => JointKind::Hinge { axis: axis.normalize() },
            // A weld is never in the order, so what is left is the root.
            JointEntry::Free | JointEntry::Weld => JointKind::Free,
        };
        let gains = entry.gains.unwrap_or(character.gains);
        // No servo holds the root: nothing outside the body could bear its torque.
        let driven = joint != JointKind::Free;
        let gains = if driven { Gains { kp: gains.kp, kd: gains.kd } } else { Gains { kp: 0.0, kd: 0.0 } };
        links.push(Link {
            name: entry.name.clone(),
            parent,
            joint,
            offset: parent.map_or(DVec3::ZERO, |p| entry.position - entries[tree.order[p]].position),
            mass: total.mass,
            com: total.com,
            inertia: total.inertia,
            gains,
            max_torque: if driven { entry.max_torque.unwrap_or(f64::INFINITY) } else { 0.0 },
            limits: entry.limits.map(limits),
            armature: if driven { entry.armature.unwrap_or(0.0) } else { 0.0 },
            spring: entry.spring.map(|s| spring(s, joint)),
            shapes,
        });
    }
    links
}

/// Mass, centre and inertia of one entry: what the file states, the rest from the shapes.
fn mass_properties(entry: &LinkEntry, solids: &[Shape]) -> MassProperties {
    let mut properties = MassProperties::of_shapes(solids, entry.mass);
    if let Some(com) = entry.com {
        properties.com = com;
    }
    if let Some(inertia) = entry.inertia {
        properties = MassProperties::new(entry.mass, properties.com, inertia);
    }
    properties
}

/// Degrees to radians.
fn limits(entry: LimitsEntry) -> JointLimits {
    let [x, y, z] = [entry.x, entry.y, entry.z].map(|(low, high)| (low.to_radians(), high.to_radians()));
    JointLimits { low: DVec3::new(x.0, y.0, z.0), high: DVec3::new(x.1, y.1, z.1) }
}

/// Degrees to radians, and of a hinge what lies along its axis.
fn spring(entry: SpringEntry, joint: JointKind) -> JointSpring {
    let rest = DVec3::from_array(entry.rest.to_array().map(f64::to_radians));
    let rest = match joint {
        JointKind::Hinge { axis } => axis * axis.dot(rest),
        JointKind::Ball | JointKind::Free => rest,
    };
    JointSpring { stiffness: entry.stiffness, damping: entry.damping, rest }
}

fn lean_law(entry: LeanLawEntry) -> LeanLaw {
    match entry {
        LeanLawEntry::DeadZone { dead_zone, gain } => LeanLaw::DeadZone { dead_zone: dead_zone.to_radians(), gain },
        LeanLawEntry::Rocker { radius } => LeanLaw::Rocker { radius },
    }
}

fn shape(entry: &ShapeEntry) -> Shape {
    match *entry {
        ShapeEntry::Box { center, size, rotation } => {
            let turn = DVec3::from_array(rotation.to_array().map(f64::to_radians));
            Shape::Box { center, half_extents: size * 0.5, rotation: DQuat::from_scaled_axis(turn) }
        }
        ShapeEntry::Capsule { a, b, radius } => Shape::Capsule { a, b, radius },
        ShapeEntry::Sphere { center, radius } => Shape::Sphere { center, radius },
    }
}

/// All pairs of links with shapes that no joint connects, that are not excluded and do not overlap at rest (such as two
/// thighs under one pelvis or neighbouring toes): pushing those apart would fight the joints for ever.
fn collision_pairs(model: &CharacterModel, excluded: Vec<(usize, usize)>) -> Vec<(usize, usize)> {
    let links = &model.links;
    let rest = model.rest_positions();
    let mut pairs = Vec::new();
    for b in 0..links.len() {
        for a in 0..b {
            let joined = links[b].parent == Some(a);
            if joined || excluded.contains(&(a, b)) || excluded.contains(&(b, a)) {
                continue;
            }
            let shift = rest[b] - rest[a];
            let touch = |s: &Shape| links[b].shapes.iter().any(|t| overlap(s, &t.shifted(shift)));
            let solid = !links[a].shapes.is_empty() && !links[b].shapes.is_empty();
            if solid && !links[a].shapes.iter().any(touch) {
                pairs.push((a, b));
            }
        }
    }
    pairs.sort_unstable();
    pairs
}
