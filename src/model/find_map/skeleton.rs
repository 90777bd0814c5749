//! Which joint of a tree is which part of a body, by names and by shape.
//!
//! Legs and arms are chains. Where names say which joints are of the left leg, that is the chain; where they do not, two
//! branches of one joint with equal bones are a pair of limbs, and the pair with the longer bones are the legs. Within a
//! chain, upper, lower and end joint are those that fit best: what their names say, two long bones of about one length, one
//! after the other. So `RightShoulder` is an upper arm where `RightCollar` comes before it and `RightElbow` after it, and a
//! collar bone where `RightArm` and `RightForeArm` follow.

use super::joint_name::{JointName, Part, read_name};
use crate::model::Side;

/// A tree of named joints: that of a file, or the links of a character.
pub(crate) struct Tree {
    /// Names.
    pub(crate) names: Vec<String>,
    /// Parents, before their children.
    pub(crate) parents: Vec<Option<usize>>,
    /// Distance of each joint from its parent.
    pub(crate) lengths: Vec<f64>,
    /// Length of what each joint carries beyond its last child, an end site for example.
    pub(crate) ends: Vec<f64>,
}

/// An arm or a leg.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Limb {
    /// Collar bone: the last joint between the trunk and the upper one.
    pub(crate) collar: Option<usize>,
    /// Hip or shoulder.
    pub(crate) upper: usize,
    /// Knee or elbow.
    pub(crate) lower: usize,
    /// Ankle or wrist.
    pub(crate) end: Option<usize>,
    /// Toes.
    pub(crate) toe: Option<usize>,
}

/// The parts of a body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Roles {
    /// The joint that both legs hang on.
    pub(crate) pelvis: usize,
    /// Above it, upwards; the last one carries the arms.
    pub(crate) trunk: Vec<usize>,
    /// Above the trunk, upwards; the last one is the head.
    pub(crate) neck: Vec<usize>,
    /// Left and right.
    pub(crate) legs: [Limb; 2],
    /// Left and right, where there are arms.
    pub(crate) arms: Option<[Limb; 2]>,
    /// Whether the names told left from right; else the first of each pair is called left for now.
    pub(crate) sides_by_name: bool,
}

/// What was looked for in vain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Missing {
    /// No two legs of thigh and shin.
    Legs,
    /// Nothing between legs and arms.
    Trunk,
}

/// How far the lengths of a left and a right bone may differ, as a part of the longer.
const PAIR_TOLERANCE: f64 = 0.2;
/// Shortest limb, as a part of the longest path in the tree.
const SHORTEST_LIMB: f64 = 0.2;

impl Tree {
    fn children(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        (joint + 1..self.parents.len()).filter(move |&j| self.parents[j] == Some(joint))
    }

    /// Longest way from each joint down to an end.
    fn reaches(&self) -> Vec<f64> {
        let mut reach = self.ends.clone();
        for joint in (0..reach.len()).rev() {
            if let Some(parent) = self.parents[joint] {
                reach[parent] = reach[parent].max(self.lengths[joint] + reach[joint]);
            }
        }
        reach
    }

    fn ancestors(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(joint), |&j| self.parents[j])
    }

    /// The last joint that is on the way from the root to both.
    fn common(&self, a: usize, b: usize) -> usize {
        let of_b: Vec<usize> = self.ancestors(b).collect();
        self.ancestors(a).find(|j| of_b.contains(j)).unwrap_or(0)
    }

    /// The joints after `above` down to `joint`, both on one path.
    fn path(&self, above: usize, joint: usize) -> Vec<usize> {
        let mut path: Vec<usize> = self.ancestors(joint).take_while(|&j| j != above).collect();
        path.reverse();
        path
    }

    /// Length of the way down from a joint to a later one of its chain.
    fn distance(&self, above: usize, joint: usize) -> f64 {
        self.path(above, joint).iter().map(|&j| self.lengths[j]).sum()
    }
}

struct Search<'a> {
    tree: &'a Tree,
    names: Vec<JointName>,
    reach: Vec<f64>,
}

/// Finds the parts of a body in a tree.
pub(crate) fn find_roles(tree: &Tree) -> Result<Roles, Missing> {
    let names = tree.names.iter().map(|n| read_name(n)).collect();
    let search = Search { tree, names, reach: tree.reaches() };
    search.roles()
}

impl Search<'_> {
    fn helper(&self, joint: usize) -> bool {
        self.names[joint].part == Some(Part::Helper)
    }

    fn roles(&self) -> Result<Roles, Missing> {
        let named = |of: fn(Part) -> bool| {
            let limb = |side| self.named_limb(side, of);
            Some([limb(Side::Left)?, limb(Side::Right)?])
        };
        let (by_name, arms_by_name) = (named(Part::of_leg), named(Part::of_arm));
        let sides_by_name = by_name.is_some();
        let pairs = if by_name.is_none() || arms_by_name.is_none() { self.pairs() } else { Vec::new() };
        let outside = |limb: &[Limb; 2], others: &Option<[Limb; 2]>| {
            others.as_ref().is_none_or(|others| limb.iter().all(|l| others.iter().all(|o| !self.nested(l, o))))
        };
        let legs =
            by_name.or_else(|| pairs.iter().find(|pair| outside(pair, &arms_by_name)).cloned()).ok_or(Missing::Legs)?;
        let legs_found = Some(legs.clone());
        let arms = arms_by_name.or_else(|| pairs.iter().find(|pair| outside(pair, &legs_found)).cloned());
        let pelvis = self.tree.common(legs[0].upper, legs[1].upper);
        let mut legs = legs;
        let mut arms = arms;

        // From the trunk's lower end to what carries the arms, or the neck.
        let neck_start = self.neck_start(pelvis, &legs, arms.as_ref());
        let top = match &arms {
            Some([left, right]) => self.tree.common(left.upper, right.upper),
            None => neck_start.and_then(|n| self.tree.parents[n]).ok_or(Missing::Trunk)?,
        };
        let low = self.tree.common(pelvis, top);
        let trunk: Vec<usize> = self.tree.path(low, top).into_iter().filter(|&j| !self.helper(j)).collect();
        if trunk.is_empty() {
            return Err(Missing::Trunk);
        }
        for (limbs, root) in [(Some(&mut legs), pelvis), (arms.as_mut(), top)] {
            for limb in limbs.into_iter().flatten() {
                let between = self.tree.path(root, limb.upper);
                limb.collar = between[..between.len() - 1].iter().rev().copied().find(|&j| !self.helper(j));
            }
        }
        let neck = neck_start.map(|start| self.neck(start)).unwrap_or_default();
        Ok(Roles { pelvis, trunk, neck, legs, arms, sides_by_name })
    }

    fn nested(&self, a: &Limb, b: &Limb) -> bool {
        self.tree.ancestors(a.upper).any(|j| j == b.upper) || self.tree.ancestors(b.upper).any(|j| j == a.upper)
    }

    /// The limb of a side whose joints are named so.
    fn named_limb(&self, side: Side, of: fn(Part) -> bool) -> Option<Limb> {
        let fits = |j: usize| {
            let name = self.names[j];
            name.side == Some(side) && name.part.is_some_and(of) && name.part != Some(Part::Finger)
        };
        let first = |j: &usize| fits(*j) && !self.tree.ancestors(*j).skip(1).any(fits);
        let start = (0..self.names.len()).filter(first).max_by(|a, b| self.reach[*a].total_cmp(&self.reach[*b]))?;
        let below = |j: usize| (j..self.names.len()).any(|k| fits(k) && self.tree.ancestors(k).any(|a| a == j));
        let mut chain = vec![start];
        let mut last = start;
        while let Some(next) = self.tree.children(last).filter(|&c| below(c)).max_by(|a, b| {
            // Straight on before twist bones; then the longer way.
            let key = |c: usize| (fits(c), self.reach[c]);
            let (a, b) = (key(*a), key(*b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        }) {
            if !self.helper(next) {
                chain.push(next);
            }
            last = next;
        }
        self.limb(&chain, true)
    }

    /// Pairs of branches with equal bones, those with the longest bones first.
    fn pairs(&self) -> Vec<[Limb; 2]> {
        // From where the body branches: a root may be far away from it.
        let branching = (0..self.names.len()).find(|&j| self.tree.children(j).count() > 1);
        let longest = branching.map_or(0.0, |j| self.reach[j]);
        let chain = |start: usize| {
            let next = |&j: &usize| {
                self.tree.children(j).max_by(|a, b| {
                    let way = |c: usize| self.tree.lengths[c] + self.reach[c];
                    way(*a).total_cmp(&way(*b))
                })
            };
            std::iter::successors(Some(start), next).filter(|&j| !self.helper(j)).collect::<Vec<usize>>()
        };
        let mut found: Vec<(f64, [Limb; 2])> = Vec::new();
        for joint in 0..self.names.len() {
            let branches: Vec<usize> = self.tree.children(joint).filter(|&c| !self.helper(c)).collect();
            for (i, &a) in branches.iter().enumerate() {
                for &b in &branches[i + 1..] {
                    let (left, right) = (chain(a), chain(b));
                    let alike = |x: f64, y: f64| (x - y).abs() <= PAIR_TOLERANCE * x.max(y) + 1e-9;
                    let bones = left.iter().zip(&right).skip(1).take(3);
                    let equal = left.len() >= 2
                        && left.len() == right.len()
                        && alike(self.reach[a], self.reach[b])
                        && bones.clone().all(|(&l, &r)| alike(self.tree.lengths[l], self.tree.lengths[r]));
                    if !equal || self.reach[a] < SHORTEST_LIMB * longest {
                        continue;
                    }
                    if let (Some(l), Some(r)) = (self.limb(&left, false), self.limb(&right, false)) {
                        let bones = self.tree.distance(l.upper, l.end.unwrap_or(l.lower));
                        found.push((bones, [l, r]));
                    }
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().map(|(_, pair)| pair).collect()
    }

    /// Upper, lower and end joint of a chain: the choice with the best score.
    fn limb(&self, chain: &[usize], named: bool) -> Option<Limb> {
        let whole = self.tree.distance(chain[0], *chain.last()?) + self.tree.ends[*chain.last()?];
        if whole <= 0.0 {
            return None;
        }
        let name = |j: usize, wanted: &[(Part, f64)]| {
            let part = if named { self.names[j].part } else { None };
            part.and_then(|p| wanted.iter().find(|(w, _)| *w == p)).map_or(0.0, |w| w.1)
        };
        let mut best: Option<(f64, Limb)> = None;
        for (i, &upper) in chain.iter().enumerate() {
            for (j, &lower) in chain.iter().enumerate().skip(i + 1) {
                for end in (j + 1..=chain.len()).map(|k| chain.get(k).copied()) {
                    let first = self.tree.distance(upper, lower);
                    let second = end.map_or(self.tree.ends[lower], |e| self.tree.distance(lower, e));
                    // An end that is not there is a bone of unknown length where the tree does not tell.
                    let unknown = end.is_none() && second <= 0.0;
                    let ratio = if unknown { 0.7 } else { (first.max(1e-9) / second.max(1e-9)).ln().abs() };
                    let mut score = 3.0 * (first + second) / whole - (1.5 * ratio).min(6.0);
                    // Bones follow one another.
                    let passed =
                        (j - i - 1) + end.and_then(|e| chain.iter().position(|&c| c == e)).map_or(0, |k| k - j - 1);
                    score -= 0.5 * passed as f64;
                    score += name(
                        upper,
                        &[
                            (Part::UpperLeg, 3.0),
                            (Part::UpperArm, 3.0),
                            (Part::Hip, 1.0),
                            (Part::Shoulder, 1.0),
                            (Part::Arm, 1.5),
                            (Part::Leg, 0.5),
                            (Part::Clavicle, -2.0),
                            (Part::LowerLeg, -3.0),
                            (Part::LowerArm, -3.0),
                            (Part::Foot, -3.0),
                            (Part::Hand, -3.0),
                        ],
                    );
                    score += name(
                        lower,
                        &[
                            (Part::LowerLeg, 3.0),
                            (Part::LowerArm, 3.0),
                            (Part::Leg, 1.5),
                            (Part::UpperLeg, -3.0),
                            (Part::UpperArm, -3.0),
                            (Part::Hip, -2.0),
                            (Part::Shoulder, -2.0),
                            (Part::Foot, -2.0),
                            (Part::Hand, -2.0),
                            (Part::Toe, -3.0),
                        ],
                    );
                    score += match end {
                        Some(e) => name(
                            e,
                            &[
                                (Part::Foot, 3.0),
                                (Part::Hand, 3.0),
                                (Part::Toe, -2.0),
                                (Part::LowerLeg, -3.0),
                                (Part::LowerArm, -3.0),
                                (Part::Leg, -2.0),
                            ],
                        ),
                        None => -1.0,
                    };
                    if best.as_ref().is_none_or(|(b, _)| score > *b) {
                        let at = end.and_then(|e| chain.iter().position(|&c| c == e));
                        let toe = at.and_then(|k| chain.get(k + 1).copied());
                        best = Some((score, Limb { collar: None, upper, lower, end, toe }));
                    }
                }
            }
        }
        best.map(|(_, limb)| limb)
    }

    /// The lowest joint that leads to the head and to no limb.
    fn neck_start(&self, pelvis: usize, legs: &[Limb; 2], arms: Option<&[Limb; 2]>) -> Option<usize> {
        let limbs = || legs.iter().chain(arms.into_iter().flatten()).map(|l| l.upper);
        let leads = |j: usize, to: usize| self.tree.ancestors(to).any(|a| a == j);
        let free = |j: usize| !limbs().any(|l| leads(j, l) || leads(l, j)) && !self.helper(j) && j != pelvis;
        let first = |j: usize| free(j) && self.tree.parents[j].is_none_or(|p| !free(p));
        let named = |j: usize| {
            (j..self.names.len()).any(|k| matches!(self.names[k].part, Some(Part::Neck | Part::Head)) && leads(j, k))
        };
        let starts: Vec<usize> = (0..self.names.len()).filter(|&j| first(j)).collect();
        if let Some(&start) = starts.iter().find(|&&j| named(j)) {
            // Without arms, a whole spine leads to the head: the neck begins where it is named.
            return (start..self.names.len())
                .find(|&k| matches!(self.names[k].part, Some(Part::Neck | Part::Head)) && leads(start, k));
        }
        // By shape: what goes on from where the arms branch off.
        let [left, right] = arms?;
        let top = self.tree.common(left.upper, right.upper);
        starts
            .into_iter()
            .filter(|&j| self.tree.parents[j] == Some(top) && self.names[j].side.is_none())
            .max_by(|a, b| self.reach[*a].total_cmp(&self.reach[*b]))
    }

    /// From the start of the neck to the head.
    fn neck(&self, start: usize) -> Vec<usize> {
        let mut chain = vec![start];
        let mut last = start;
        while let Some(next) = self
            .tree
            .children(last)
            .filter(|&c| !self.helper(c) && self.names[c].side.is_none())
            .max_by(|a, b| self.reach[*a].total_cmp(&self.reach[*b]))
        {
            chain.push(next);
            last = next;
        }
        match chain.iter().position(|&j| self.names[j].part == Some(Part::Head)) {
            Some(head) => chain.truncate(head + 1),
            // By shape: neck and head.
            None => chain.truncate(2),
        }
        chain
    }
}
