//! Axes from the zero pose of a file, where it is one in which a person could stand: T, A or hanging arms.
//!
//! With every rotation at zero, the axes of all joints are those of the file's world. Trunk and head then stand upright, so
//! their links' axes are the world's; a limb's link has the shortest turn that takes its bone from where it hangs on the
//! character to where it points in the file; a foot stands flat and points where the toes do.

use super::links::{Bones, LimbBones};
use super::skeleton::Limb;
use super::source::{Source, nearest_axis};
use super::{Axes, LimbAxes, RestPose};
use crate::asset::joint_map::basis;
use glam::{DQuat, DVec3};

/// Cosine from which a direction counts as one of the file's axes (15 degrees).
const ALONG_AXIS: f64 = 0.966;
/// Steepest foot that still counts as flat, sine of its slope.
const STEEP_FOOT: f64 = 0.85;

/// Up and facing of the zero pose in the file's world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Upright {
    pub(super) up: DVec3,
    pub(super) facing: DVec3,
}

/// Up, left and facing of the zero pose; `None` where no person could stand so.
pub(super) fn upright(source: &Source) -> Option<Upright> {
    let (roles, at) = (&source.roles, &source.zero);
    let [left, right] = &roles.legs;
    let leg = |limb: &Limb| {
        let thigh = (at[limb.lower] - at[limb.upper]).try_normalize()?;
        let shin = limb.end.map_or(Some(thigh), |end| (at[end] - at[limb.lower]).try_normalize())?;
        (thigh.dot(shin) > 0.5).then_some((thigh + shin).normalize())
    };
    let (l, r) = (leg(left)?, leg(right)?);
    let hips = (at[left.upper] + at[right.upper]) / 2.0;
    let trunk = (at[source.top()] - hips).try_normalize()?;
    let down = (l + r).try_normalize()?;
    // Splayed by less than a right angle, and below the trunk.
    if l.dot(r) < 0.0 || trunk.dot(down) > -0.7 {
        return None;
    }
    let (axis, cosine) = nearest_axis(trunk - down);
    let up = if cosine > ALONG_AXIS { axis } else { (trunk - down).normalize() };
    let mut across = at[left.upper] - at[right.upper];
    if let Some([l, r]) = &roles.arms {
        across += at[l.upper] - at[r.upper];
    }
    let across = across.reject_from_normalized(up).try_normalize()?;
    let (axis, cosine) = nearest_axis(across);
    let across = if cosine > ALONG_AXIS && axis.dot(up).abs() < 1e-9 { axis } else { across };
    Some(Upright { up, facing: across.cross(up).normalize() })
}

/// From ankle to toes in the zero pose, unit length.
fn toe_direction(source: &Source, leg: &Limb) -> Option<DVec3> {
    let end = leg.end?;
    let next = leg.toe.or_else(|| source.child(end));
    let sites = &source.bvh.joints()[end].end_sites;
    let to = match next {
        Some(toe) => source.zero[toe] - source.zero[end],
        None => *sites.iter().max_by(|a, b| a.length().total_cmp(&b.length()))?,
    };
    let shin = (source.zero[end] - source.zero[leg.lower]).normalize_or_zero();
    // An end site straight below the shin is a stub that tells nothing of the foot.
    to.try_normalize().filter(|to| next.is_some() || to.dot(shin) < 0.95)
}

/// The shortest turn from one direction to another; half a turn goes about `axis`.
fn arc(from: DVec3, to: DVec3, axis: DVec3) -> DQuat {
    if from.dot(to) < -0.999_9 {
        return DQuat::from_axis_angle(axis, std::f64::consts::PI);
    }
    DQuat::from_rotation_arc(from, to)
}

/// Axes of all parts.
pub(super) fn axes(source: &Source, bones: &Bones, upright: Upright) -> Axes {
    let world = basis(upright.up, upright.facing);
    let limb = |limb: &Limb, own: &LimbBones, arm: bool| {
        let at = &source.zero;
        let bone = |from: usize, to: Option<usize>| {
            let to = to.map(|to| at[to] - at[from]).or_else(|| source.bone(from, None));
            to.and_then(DVec3::try_normalize)
        };
        let turn = |start: DQuat, own: DVec3, to: Option<DVec3>| match to {
            Some(to) => arc(start * own, to, upright.facing) * start,
            None => start,
        };
        let upper = turn(world, own.upper, bone(limb.upper, Some(limb.lower)));
        let lower = turn(upper, own.lower, bone(limb.lower, limb.end));
        let end = if arm { lower } else { foot(source, limb, own, upright, world) };
        LimbAxes { collar: world, upper, lower, end, toe: end }
    };
    let roles = &source.roles;
    Axes {
        pelvis: world,
        trunk: vec![world; roles.trunk.len()],
        neck: vec![world; roles.neck.len()],
        legs: [0, 1].map(|side| limb(&roles.legs[side], &bones.legs[side], false)),
        arms: roles.arms.as_ref().map(|arms| [0, 1].map(|side| limb(&arms[side], &bones.arms[side], true))),
    }
}

/// A flat foot is turned about the vertical only; one that hangs is pitched as well.
fn foot(source: &Source, leg: &Limb, own: &LimbBones, upright: Upright, world: DQuat) -> DQuat {
    let Some(toes) = toe_direction(source, leg) else { return world };
    let in_body = world.conjugate() * toes;
    let yaw = |v: DVec3| (-v.x).atan2(-v.z);
    let flat = |v: DVec3| v.y.abs() < STEEP_FOOT;
    if flat(in_body) {
        let turn = yaw(in_body) - if flat(own.end) { yaw(own.end) } else { 0.0 };
        return DQuat::from_axis_angle(upright.up, turn) * world;
    }
    arc(world * own.end, toes, upright.facing) * world
}

/// What kind of rest pose it is, by the mean angle of the upper arms from straight down.
pub(super) fn kind(source: &Source, upright: Upright) -> RestPose {
    let Some(arms) = &source.roles.arms else { return RestPose::Hanging };
    let angle = |arm: &Limb| {
        let bone = (source.zero[arm.lower] - source.zero[arm.upper]).normalize_or_zero();
        bone.dot(-upright.up).clamp(-1.0, 1.0).acos().to_degrees()
    };
    match (angle(&arms[0]) + angle(&arms[1])) / 2.0 {
        a if a < 20.0 => RestPose::Hanging,
        a if a < 70.0 => RestPose::A,
        _ => RestPose::T,
    }
}
