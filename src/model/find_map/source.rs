//! The skeleton of a file as the search for a map sees it: its tree, its zero pose, and some of its frames.

use super::skeleton::{Missing, Roles, Tree, find_roles};
use crate::asset::bvh::{Bvh, BvhTransform};
use glam::DVec3;

/// Frames that are looked at, spread evenly over the clip.
const MOST_FRAMES: usize = 240;

/// A file with the parts of its body.
pub(super) struct Source<'a> {
    pub(super) bvh: &'a Bvh,
    pub(super) roles: Roles,
    /// Each joint in its parent's axes, file units.
    pub(super) offsets: Vec<DVec3>,
    /// Places of all joints in frames spread over the clip.
    pub(super) frames: Vec<Vec<BvhTransform>>,
    /// Places of all joints with every rotation zero, from the root.
    pub(super) zero: Vec<DVec3>,
}

impl<'a> Source<'a> {
    pub(super) fn new(bvh: &'a Bvh) -> Result<Self, Missing> {
        let joints = bvh.joints();
        // Position channels take the place of the offset, in some files of all of them.
        let offsets: Vec<DVec3> = (0..joints.len())
            .map(|j| if joints[j].parent.is_some() { bvh.local_transform(j, 0).position } else { DVec3::ZERO })
            .collect();
        let tree = Tree {
            names: joints.iter().map(|j| j.name.clone()).collect(),
            parents: joints.iter().map(|j| j.parent).collect(),
            lengths: offsets.iter().map(|o| o.length()).collect(),
            ends: joints.iter().map(|j| j.end_sites.iter().map(|e| e.length()).fold(0.0, f64::max)).collect(),
        };
        let roles = find_roles(&tree)?;
        let count = bvh.frame_count().min(MOST_FRAMES);
        let frame = |k: usize| if count < 2 { 0 } else { k * (bvh.frame_count() - 1) / (count - 1) };
        let frames = (0..count).map(|k| bvh.world_transforms(frame(k))).collect();
        let mut zero: Vec<DVec3> = Vec::with_capacity(joints.len());
        for (joint, offset) in joints.iter().zip(&offsets) {
            zero.push(joint.parent.map_or(DVec3::ZERO, |p| zero[p] + *offset));
        }
        Ok(Self { bvh, roles, offsets, frames, zero })
    }

    /// Length of a leg from hip over knee to ankle, file units.
    pub(super) fn leg_length(&self) -> f64 {
        let leg = &self.roles.legs[0];
        let bones = |from: usize, to: usize| self.frames[0][from].position.distance(self.frames[0][to].position);
        bones(leg.upper, leg.lower) + leg.end.map_or(0.0, |end| bones(leg.lower, end))
    }

    /// Where the bone of a joint ends in the joint's own axes: at the joint `next`, or at an end site, file units. Averaged
    /// over the clip, since joints between the two may turn a little.
    pub(super) fn bone(&self, joint: usize, next: Option<usize>) -> Option<DVec3> {
        let bone = match next {
            Some(next) => {
                let sum: DVec3 = self
                    .frames
                    .iter()
                    .map(|f| f[joint].rotation.conjugate() * (f[next].position - f[joint].position))
                    .sum();
                sum / self.frames.len() as f64
            }
            None => {
                let ends = &self.bvh.joints()[joint].end_sites;
                *ends.iter().max_by(|a, b| a.length().total_cmp(&b.length()))?
            }
        };
        bone.try_normalize()
    }

    /// The joint after the last one of a limb, or after a toe: the child that is farthest away.
    pub(super) fn child(&self, joint: usize) -> Option<usize> {
        let joints = self.bvh.joints();
        (joint + 1..joints.len())
            .filter(|&j| joints[j].parent == Some(joint) && self.offsets[j].length() > 1e-9)
            .max_by(|a, b| self.offsets[*a].length().total_cmp(&self.offsets[*b].length()))
    }

    /// The uppermost joint: head, neck or chest.
    pub(super) fn top(&self) -> usize {
        let roles = &self.roles;
        let last = roles.neck.last().or(roles.trunk.last()).copied().unwrap_or(roles.pelvis);
        // A head that lies in its neck, or a chest in the pelvis, tells no direction: the shoulders do.
        match &roles.arms {
            Some([left, _]) if roles.neck.is_empty() => left.upper,
            _ => last,
        }
    }
}

/// The nearest of the six axes, with the cosine to it.
pub(super) fn nearest_axis(v: DVec3) -> (DVec3, f64) {
    let a = v.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        DVec3::X * v.x.signum()
    } else if a.y >= a.z {
        DVec3::Y * v.y.signum()
    } else {
        DVec3::Z * v.z.signum()
    };
    (axis, axis.dot(v.normalize_or_zero()))
}
