//! Which link of a character is which part of its body, found as in a file: by names and by the tree's shape.

use super::skeleton::{Limb, Missing, Roles, Tree, find_roles};
use crate::model::CharacterModel;
use glam::DVec3;

/// Directions of a limb's bones in the character's zero pose, unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LimbBones {
    /// From the collar link to the upper one.
    pub(super) collar: DVec3,
    pub(super) upper: DVec3,
    pub(super) lower: DVec3,
    /// From the ankle to the toes, or along the hand.
    pub(super) end: DVec3,
}

/// Bones of both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bones {
    pub(super) legs: [LimbBones; 2],
    pub(super) arms: [LimbBones; 2],
}

/// The links of a character by their parts.
pub(super) struct Links {
    pub(super) roles: Roles,
    /// Links below the ankle that are toes, left and right; first the one that lies most straight ahead of the ankle.
    pub(super) toes: [Vec<usize>; 2],
    pub(super) bones: Bones,
    /// Length of the left leg from hip over knee to ankle, m.
    pub(super) leg_length: f64,
}

impl Links {
    pub(super) fn new(model: &CharacterModel) -> Result<Self, Missing> {
        let parents: Vec<Option<usize>> = model.links.iter().map(|l| l.parent).collect();
        let leaf = |i: usize| !parents.contains(&Some(i));
        let tree = Tree {
            names: model.links.iter().map(|l| l.name.clone()).collect(),
            lengths: model.links.iter().map(|l| l.offset.length()).collect(),
            // A link without children ends about as far beyond its centre of mass as that is from the joint.
            ends: (0..parents.len()).map(|i| if leaf(i) { 2.0 * model.links[i].com.length() } else { 0.0 }).collect(),
            parents,
        };
        let mut roles = find_roles(&tree)?;
        let rest = model.rest_positions();
        // Left is -X, whatever the links are called.
        let swapped = |limbs: &[Limb; 2]| rest[limbs[0].upper].x > rest[limbs[1].upper].x;
        if swapped(&roles.legs) {
            roles.legs.swap(0, 1);
        }
        if let Some(arms) = roles.arms.as_mut().filter(|arms| swapped(arms)) {
            arms.swap(0, 1);
        }
        let bone = |from: usize, to: Option<usize>| {
            let bone = to.map_or(model.links[from].com, |to| rest[to] - rest[from]);
            bone.try_normalize().unwrap_or(DVec3::NEG_Y)
        };
        let below = |link: usize, of: usize| {
            std::iter::successors(Some(link), |&l| model.links[l].parent).skip(1).any(|l| l == of)
        };
        let toes = [0, 1].map(|side| {
            let Some(foot) = roles.legs[side].end else { return Vec::new() };
            let toe = |l: &usize| {
                let name = super::joint_name::read_name(&model.links[*l].name);
                below(*l, foot) && name.part == Some(super::joint_name::Part::Toe)
            };
            let mut toes: Vec<usize> = (foot + 1..model.links.len()).filter(toe).collect();
            let aside = |l: &usize| (rest[*l].x - rest[foot].x).abs();
            toes.sort_by(|a, b| aside(a).total_cmp(&aside(b)));
            toes
        });
        let limb = |limb: &Limb, toes: Option<&Vec<usize>>| LimbBones {
            collar: limb.collar.map_or(DVec3::NEG_Y, |c| bone(c, Some(limb.upper))),
            upper: bone(limb.upper, Some(limb.lower)),
            lower: bone(limb.lower, limb.end),
            end: match (limb.end, toes) {
                (Some(end), Some(toes)) if !toes.is_empty() => bone(end, Some(toes[0])),
                (Some(end), Some(_)) => front(model, end),
                (Some(end), None) => bone(end, None),
                (None, _) => DVec3::NEG_Y,
            },
        };
        let legs = [0, 1].map(|side| limb(&roles.legs[side], Some(&toes[side])));
        let arms = match &roles.arms {
            Some(arms) => [0, 1].map(|side| limb(&arms[side], None)),
            None => legs,
        };
        let leg = &roles.legs[0];
        let leg_length =
            rest[leg.upper].distance(rest[leg.lower]) + leg.end.map_or(0.0, |end| rest[leg.lower].distance(rest[end]));
        Ok(Self { roles, toes, bones: Bones { legs, arms }, leg_length })
    }
}

/// From the ankle to the ball of a foot without a toe link: two thirds of the way to its foremost contact point.
fn front(model: &CharacterModel, foot: usize) -> DVec3 {
    let foremost = model
        .contact_points
        .iter()
        .filter(|c| c.link == foot)
        .min_by(|a, b| a.position.z.total_cmp(&b.position.z))
        .map(|c| DVec3::new(0.0, c.position.y, c.position.z * 2.0 / 3.0));
    foremost.filter(|p| p.z < -0.01).and_then(DVec3::try_normalize).unwrap_or(DVec3::new(0.0, -0.5, -0.75).normalize())
}
