//! Axes from the motion, where the zero pose is none in which a person could stand: files whose joints each have axes of
//! their own, one of them along the bone, so that a body at zero is a bundle of sticks.
//!
//! What is known of a joint's axes is where its bone points. How the link is turned about it the motion tells: knees bend
//! backwards and elbows forwards, and over a clip a joint is turned little about its bone against the one it hangs on. Axes
//! of such files are at right angles to the body's, so it is enough to know which of them is meant; where they are not, the
//! direction found is taken as it is.

use super::links::{Bones, LimbBones};
use super::skeleton::Limb;
use super::source::{Source, nearest_axis};
use super::{Axes, LimbAxes};
use crate::asset::joint_map::basis;
use glam::{DQuat, DVec3};

/// Cosine from which a bone lies along an axis (3 degrees).
const ALONG_BONE: f64 = 0.9986;
/// Cosine from which it is meant to (18 degrees).
const NEARLY_ALONG: f64 = 0.95;
/// Steepest slope from the ankle to the ball of a foot that stands flat, rad.
const MOST_SLOPE: f64 = 1.0;
/// Weight of how a joint bends against how it is turned about its bone.
const BEND_WEIGHT: f64 = 4.0;

/// The 24 rotations that take axes to axes.
fn quarter_turns() -> Vec<DQuat> {
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let mut out = Vec::with_capacity(24);
    for up in axes {
        for facing in axes {
            if up.dot(facing).abs() < 0.5 {
                out.push(basis(up, facing));
            }
        }
    }
    out
}

/// Links' axes in the world, frame by frame.
type Turns = Vec<DQuat>;

struct Finder<'a, 'b> {
    source: &'a Source<'b>,
    candidates: Vec<DQuat>,
}

/// Axes of all parts. `None` where hips and spine tell no direction.
pub(super) fn axes(source: &Source, bones: &Bones) -> Option<Axes> {
    let finder = Finder { source, candidates: quarter_turns() };
    let roles = &source.roles;
    let pelvis = finder.pelvis()?;
    let mut turns = finder.turns(roles.pelvis, pelvis);
    let hips = turns.clone();
    let mut follow = |joints: &[usize]| {
        let mut out = Vec::new();
        for &joint in joints {
            let axes = finder.like(joint, &turns, |_| true);
            turns = finder.turns(joint, axes);
            out.push(axes);
        }
        out
    };
    let trunk = follow(&roles.trunk);
    let chest = finder.turns(*roles.trunk.last()?, *trunk.last()?);
    let neck = follow(&roles.neck);
    let legs = [0, 1].map(|side| finder.limb(&roles.legs[side], &bones.legs[side], &hips, false));
    let arms =
        roles.arms.as_ref().map(|arms| [0, 1].map(|side| finder.limb(&arms[side], &bones.arms[side], &chest, true)));
    Some(Axes { pelvis, trunk, neck, legs, arms })
}

impl Finder<'_, '_> {
    /// A link's axes in the world when it has these in the joint's.
    fn turns(&self, joint: usize, axes: DQuat) -> Turns {
        self.source.frames.iter().map(|f| f[joint].rotation * axes).collect()
    }

    /// The pelvis: the spine goes up, the left hip is on the left.
    fn pelvis(&self) -> Option<DQuat> {
        let (roles, frames) = (&self.source.roles, &self.source.frames);
        let [left, right] = [&roles.legs[0], &roles.legs[1]].map(|l| l.upper);
        let mean = |of: &dyn Fn(&[crate::asset::bvh::BvhTransform]) -> DVec3| {
            let sum: DVec3 =
                frames.iter().map(|f| f[roles.pelvis].rotation.conjugate() * of(f).normalize_or_zero()).sum();
            sum.try_normalize()
        };
        let chest = *roles.trunk.last()?;
        let top = if chest == roles.pelvis { self.source.top() } else { chest };
        let up = mean(&|f| f[top].position - (f[left].position + f[right].position) / 2.0)?;
        let across = mean(&|f| f[left].position - f[right].position)?;
        let fit = |r: DQuat| (r * DVec3::Y).dot(up) + (r * DVec3::NEG_X).dot(across);
        let best = self.candidates.iter().copied().max_by(|a, b| fit(*a).total_cmp(&fit(*b)))?;
        if fit(best) > 1.7 {
            return Some(best);
        }
        let across = across.normalize();
        let up = up.reject_from_normalized(across).try_normalize()?;
        Some(basis(up, across.cross(up)))
    }

    /// Of the quarter turns that are allowed, the one that keeps the link nearest to another.
    fn like(&self, joint: usize, other: &Turns, allowed: impl Fn(DQuat) -> bool) -> DQuat {
        let fit = |r: DQuat| -> f64 {
            let near = |(f, o): (&Vec<crate::asset::bvh::BvhTransform>, &DQuat)| (f[joint].rotation * r).dot(*o).abs();
            self.source.frames.iter().zip(other).map(near).sum()
        };
        let allowed = self.candidates.iter().copied().filter(|r| allowed(*r));
        allowed.max_by(|a, b| fit(*a).total_cmp(&fit(*b))).unwrap_or(DQuat::IDENTITY)
    }

    fn limb(&self, limb: &Limb, own: &LimbBones, hub: &Turns, arm: bool) -> LimbAxes {
        let source = self.source;
        let collar = limb.collar.map_or(DQuat::IDENTITY, |joint| {
            let axes = self.like(joint, hub, |_| true);
            along_bone(axes, own.collar, source.bone(joint, Some(limb.upper)))
        });
        let upper_bone = source.bone(limb.upper, Some(limb.lower)).unwrap_or(DVec3::NEG_Y);
        let lower_bone = source.bone(limb.lower, limb.end).unwrap_or(upper_bone);
        let bend = |joint: usize, other: usize, bone: DVec3, forwards: f64| {
            move |f: &[crate::asset::bvh::BvhTransform]| {
                (f[joint].rotation.conjugate() * (f[other].rotation * bone)) * forwards
            }
        };
        // A knee takes the shin backwards; seen from the shin, the thigh goes up and backwards.
        let (out, back) = if arm { (1.0, -1.0) } else { (-1.0, 1.0) };
        let upper = self.hinge(limb.upper, upper_bone, own.upper, hub, bend(limb.upper, limb.lower, lower_bone, out));
        let turns = self.turns(limb.upper, upper);
        let lower =
            self.hinge(limb.lower, lower_bone, own.lower, &turns, bend(limb.lower, limb.upper, upper_bone, back));
        let turns = self.turns(limb.lower, lower);
        let Some(joint) = limb.end else { return LimbAxes { collar, upper, lower, end: lower, toe: lower } };
        if arm {
            let bone = source.bone(joint, source.child(joint)).map_or(lower * DVec3::NEG_Y, |b| nearest_axis(b).0);
            let end = self.like(joint, &turns, |r| (r * DVec3::NEG_Y).dot(bone) > 0.9);
            return LimbAxes { collar, upper, lower, end, toe: end };
        }
        let end = self.foot(limb, joint, own, &turns);
        let toe = limb.toe.map_or(end, |toe| self.like(toe, &self.turns(joint, end), |_| true));
        LimbAxes { collar, upper, lower, end, toe }
    }

    /// A link whose bone is known, turned about it as the motion tells. `bend` gives what the joint beyond does, in the
    /// joint's axes: a vector on the side of the link's facing.
    fn hinge(
        &self,
        joint: usize,
        bone: DVec3,
        own: DVec3,
        hub: &Turns,
        bend: impl Fn(&[crate::asset::bvh::BvhTransform]) -> DVec3,
    ) -> DQuat {
        let mut facing = DVec3::ZERO;
        for (frame, hub) in self.source.frames.iter().zip(hub) {
            let rotation = frame[joint].rotation;
            // The hub's link, swung so that its bone points where this one does.
            let swung = DQuat::from_rotation_arc(*hub * own, rotation * bone) * *hub;
            let expected = rotation.conjugate() * (swung * DVec3::NEG_Z);
            facing += expected.reject_from_normalized(bone) + BEND_WEIGHT * bend(frame).reject_from_normalized(bone);
        }
        let (axis, cosine) = nearest_axis(bone);
        if cosine > NEARLY_ALONG {
            let (facing, _) = nearest_axis(facing.reject_from_normalized(axis));
            return along_bone(basis(-axis, facing), own, Some(bone));
        }
        // No axis along the bone: what was found, as it is.
        match facing.reject_from_normalized(bone).try_normalize() {
            Some(facing) => {
                let straight = basis(-bone, facing);
                straight * DQuat::from_rotation_arc(own, DVec3::NEG_Y)
            }
            None => self.like(joint, hub, |_| true),
        }
    }

    /// A foot: where an axis goes from the ankle to the ball, it slopes down when the foot stands flat.
    fn foot(&self, leg: &Limb, joint: usize, own: &LimbBones, shin: &Turns) -> DQuat {
        let next = leg.toe.or_else(|| self.source.child(joint));
        let Some(bone) = self.source.bone(joint, next) else { return self.like(joint, shin, |_| true) };
        let (axis, cosine) = nearest_axis(bone);
        if cosine < ALONG_BONE {
            return self.like(joint, shin, |_| true);
        }
        let level = self.like(joint, shin, |r| (r * DVec3::NEG_Z).dot(axis) > 0.9);
        let slope = self.slope(leg, joint, level).unwrap_or_else(|| (-own.end.y).atan2(-own.end.z));
        if !(0.0..MOST_SLOPE).contains(&slope) {
            return level;
        }
        let yaw = (-own.end.x).atan2(own.end.z.abs().max(1e-6));
        let along = DQuat::from_rotation_y(yaw) * DVec3::new(0.0, -slope.sin(), -slope.cos());
        level * DQuat::from_rotation_arc(along, DVec3::NEG_Z)
    }

    /// Slope from ankle to ball: toes lie flat most of the time, so it is the middle angle between foot and toes.
    fn slope(&self, leg: &Limb, joint: usize, level: DQuat) -> Option<f64> {
        let toe = leg.toe?;
        let bone = self.source.bone(toe, self.source.child(toe))?;
        let mut angles: Vec<f64> = self
            .source
            .frames
            .iter()
            .map(|f| {
                let toes = (f[joint].rotation * level).conjugate() * (f[toe].rotation * bone);
                toes.y.atan2(-toes.z)
            })
            .collect();
        angles.sort_by(f64::total_cmp);
        let middle = angles[angles.len() / 2];
        // In one line with the toes the foot is as flat as they are.
        (middle > -MOST_SLOPE).then_some(middle.max(0.0))
    }
}

/// The axes turned the last bit, so that the link's own bone lies along the joint's, where the joint has an axis along it.
fn along_bone(axes: DQuat, own: DVec3, bone: Option<DVec3>) -> DQuat {
    let Some(bone) = bone else { return axes };
    let here = axes * own;
    if nearest_axis(bone).1 > ALONG_BONE && here.dot(bone) > 0.6 {
        return (DQuat::from_rotation_arc(here, bone) * axes).normalize();
    }
    axes
}
