//! What a body stands on, reaches with and falls on: feet, roles of contact points, the trunk.
//!
//! A character file may say all of it. What it leaves out is found from tree and geometry, never from names of links:
//!
//! - **Feet**: the blades named `left` and `right`, a foot each. Without those, every link with a contact point that reaches
//!   within 2 cm of the lowest one in the zero pose (or, where points have the role `Foot`, every link with such a point)
//!   belongs to a foot. The foot is the part of the body below its ankle: the highest joint above that link that lies
//!   lower than a fifth of the root's height; if there is none, the link and what hangs on it. The foot is on the side its
//!   ankle is on, or on none if that is within 1 cm of the middle.
//! - **Roles**: `Foot` for blades and for points on the links of feet, `Body` for others.
//! - **Trunk**: the way up starts at the hips, the last link that all feet hang on. It follows the only child that no foot
//!   hangs on; where it divides (into head and arms) or ends, the trunk is reached.

use super::{CharacterModel, ContactKind, Foot, FootKind};
use crate::asset::{PointRole, Side};
use glam::DVec3;

/// Points this much above the lowest touch the ground in the zero pose too, m.
const TOUCHING: f64 = 0.02;
/// Largest height of an ankle above the lowest point as a part of the root's.
const ANKLE: f64 = 0.2;
/// Distance from the middle plane within which a part is on no side, m.
const MIDDLE: f64 = 0.01;

impl CharacterModel {
    /// All feet, in the order of the file; where the file names none, by the order of their links.
    pub fn feet(&self) -> &[Foot] {
        &self.feet
    }

    /// The first foot of a side.
    pub fn foot(&self, side: Side) -> Option<&Foot> {
        self.feet.iter().find(|f| f.side == Some(side))
    }

    /// Indices of the contact points with this role, ascending.
    pub fn points(&self, role: PointRole) -> impl Iterator<Item = usize> + '_ {
        self.contact_points.iter().enumerate().filter(move |(_, p)| p.role == role).map(|(i, _)| i)
    }

    /// Indices of the contact points on the links of a foot, ascending.
    pub fn foot_points<'a>(&'a self, foot: &'a Foot) -> impl Iterator<Item = usize> + 'a {
        self.contact_points.iter().enumerate().filter(|(_, p)| foot.links.contains(&p.link)).map(|(i, _)| i)
    }

    /// Index of the link that carries head and arms.
    pub fn trunk(&self) -> usize {
        self.trunk
    }

    /// For each link, whether it is of the trunk in a wider sense: on the way from the root to [`CharacterModel::trunk`], or
    /// a part in the middle of the body that hangs there and leads to no foot and no hand, such as a head.
    pub fn trunk_links(&self) -> Vec<bool> {
        let places = self.rest_positions();
        // What lies off the middle, or ends in a foot or a hand, is a limb.
        let mut limb: Vec<bool> = places.iter().map(|p| p.x.abs() > MIDDLE).collect();
        self.feet.iter().flat_map(|f| &f.links).for_each(|&l| limb[l] = true);
        self.points(PointRole::Hand).for_each(|p| limb[self.contact_points[p].link] = true);
        for i in (1..self.links.len()).rev() {
            if let (true, Some(parent)) = (limb[i], self.links[i].parent) {
                limb[parent] = true;
            }
        }
        let mut wide = vec![false; self.links.len()];
        let mut at = Some(self.trunk);
        while let Some(i) = at {
            wide[i] = true;
            at = self.links[i].parent;
        }
        for i in 1..self.links.len() {
            wide[i] |= !limb[i] && self.links[i].parent.is_some_and(|p| wide[p]);
        }
        wide
    }

    /// Whether link `below` hangs on link `above`, or is it.
    fn hangs_on(&self, below: usize, above: usize) -> bool {
        let mut at = Some(below);
        while let Some(i) = at {
            if i == above {
                return true;
            }
            at = self.links[i].parent;
        }
        false
    }

    /// Fills in feet, roles and trunk by the rules of this file, for a model that was put together in code. Feet that it
    /// has already, and the role `Hand`, stay.
    pub fn find_parts(&mut self) {
        if self.feet.is_empty() {
            self.feet = found_feet(self);
        }
        for (p, role) in default_roles(self).into_iter().enumerate() {
            if self.contact_points[p].role != PointRole::Hand {
                self.contact_points[p].role = role;
            }
        }
        self.trunk = found_trunk(self);
    }
}

/// `Foot` on feet and blades, `Body` elsewhere.
pub(super) fn default_roles(model: &CharacterModel) -> Vec<PointRole> {
    let on_foot = |link: usize| model.feet.iter().any(|f| f.links.contains(&link));
    let role = |p: &super::ContactPoint| match p.kind {
        ContactKind::Point if !on_foot(p.link) => PointRole::Body,
        _ => PointRole::Foot,
    };
    model.contact_points.iter().map(role).collect()
}

/// Feet of a file that names none.
pub(super) fn found_feet(model: &CharacterModel) -> Vec<Foot> {
    let sided = [Side::Left, Side::Right].map(|side| model.blades.iter().position(|b| b.name == side.name()));
    if sided.iter().any(Option::is_some) {
        let foot = |(blade, side): (Option<usize>, Side)| {
            let blade = blade?;
            let own = &model.blades[blade];
            let links = (own.link..model.links.len()).filter(|&l| model.hangs_on(l, own.link)).collect();
            Some(Foot { side: Some(side), kind: FootKind::Blade(blade), links, toe: own.toe, heel: own.heel })
        };
        return sided.into_iter().zip([Side::Left, Side::Right]).filter_map(foot).collect();
    }

    let places = model.rest_positions();
    let bottom = |p: &super::ContactPoint| places[p.link].y + p.position.y - p.radius;
    let floor = model.contact_points.iter().map(bottom).fold(f64::INFINITY, f64::min);
    let named = model.contact_points.iter().any(|p| p.role == PointRole::Foot && p.kind == ContactKind::Point);
    let touching = |p: &&super::ContactPoint| match named {
        true => p.role == PointRole::Foot,
        false => p.role != PointRole::Hand && bottom(p) < floor + TOUCHING,
    };
    let ankle = |link: usize| {
        let (mut at, mut found) = (link, link);
        while let Some(parent) = model.links[at].parent {
            if places[at].y - floor < ANKLE * (places[0].y - floor) {
                found = at;
            }
            at = parent;
        }
        found
    };
    let mut ankles: Vec<usize> = model.contact_points.iter().filter(touching).map(|p| ankle(p.link)).collect();
    ankles.sort_unstable();
    ankles.dedup();
    // What hangs below another ankle is part of that foot.
    let all = ankles.clone();
    ankles.retain(|&a| !all.iter().any(|&b| b != a && model.hangs_on(a, b)));
    let foot = |ankle: usize| {
        let links: Vec<usize> = (ankle..model.links.len()).filter(|&l| model.hangs_on(l, ankle)).collect();
        let blade = model.blades.iter().position(|b| links.contains(&b.link));
        let (kind, [toe, heel]) = match blade {
            Some(k) => (FootKind::Blade(k), [model.blades[k].toe, model.blades[k].heel]),
            None => (FootKind::Sole, sole_ends(model, &links)?),
        };
        let side = match places[ankle].x {
            x if x < -MIDDLE => Some(Side::Left),
            x if x > MIDDLE => Some(Side::Right),
            _ => None,
        };
        Some(Foot { side, kind, links, toe, heel })
    };
    ankles.into_iter().filter_map(foot).collect()
}

/// The foremost and the rearmost of the lowest contact points on these links; `None` if they have none.
pub(super) fn sole_ends(model: &CharacterModel, links: &[usize]) -> Option<[usize; 2]> {
    let places = model.rest_positions();
    let own = || model.contact_points.iter().enumerate().filter(|(_, p)| links.contains(&p.link));
    let place = |p: &super::ContactPoint| places[p.link] + p.position - DVec3::Y * p.radius;
    let floor = own().map(|(_, p)| place(p).y).fold(f64::INFINITY, f64::min);
    let low = || own().filter(|(_, p)| place(p).y < floor + TOUCHING).map(|(i, p)| (i, place(p).z));
    // Of equals the first.
    let front = low().reduce(|best, p| if p.1 < best.1 { p } else { best })?;
    let rear = low().reduce(|best, p| if p.1 > best.1 { p } else { best })?;
    Some([front.0, rear.0])
}

/// The trunk of a file that names none.
pub(super) fn found_trunk(model: &CharacterModel) -> usize {
    let carries_foot = |link: usize| model.feet.iter().flat_map(|f| &f.links).any(|&l| model.hangs_on(l, link));
    let children = |link: usize| (1..model.links.len()).filter(move |&i| model.links[i].parent == Some(link));
    // The hips: as long as one child carries all feet, they are further down.
    let mut at = 0;
    if model.feet.len() > 1 {
        let all =
            |link: usize| model.feet.iter().all(|f| f.links.iter().any(|&l| model.hangs_on(l, link) && l != link));
        while let Some(child) = children(at).find(|&c| all(c)) {
            at = child;
        }
    }
    loop {
        let mut up = children(at).filter(|&c| !carries_foot(c));
        match (up.next(), up.next()) {
            (Some(only), None) => at = only,
            _ => return at,
        }
    }
}
