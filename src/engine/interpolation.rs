//! Poses between fixed ticks, and the athlete's `Transform`: that of its root link.

use crate::engine::poses::to_transform;
use crate::engine::{AthleteBody, AthleteSettings, AthleteTime, LinkPoses};
use crate::model::LinkTransform;
use bevy::prelude::*;

/// Where the parents of athletes are, in the order of the athletes.
pub(super) type Parents = Vec<(Entity, GlobalTransform)>;

/// Athletes that are children of something.
type ChildAthletes<'w, 's> = Query<'w, 's, (Entity, &'static ChildOf), With<AthleteBody>>;
type Shown = (Entity, &'static mut LinkPoses, &'static mut Transform, &'static AthleteSettings);

/// Poses for this frame, and the athlete's transform.
pub(super) fn interpolate_poses(
    fixed: Res<Time<Fixed>>,
    time: Res<AthleteTime>,
    children: ChildAthletes,
    mut parents: Local<Parents>,
    mut params: ParamSet<(TransformHelper, Query<Shown, With<AthleteBody>>)>,
) {
    let (overstep, tick) = (fixed.overstep_fraction_f64(), time.delta());
    find_parents(&children, &params.p0(), &mut parents);
    params.p1().par_iter_mut().for_each(|(entity, mut poses, mut transform, settings)| {
        poses.interpolate(settings.interpolate.then_some(overstep), tick);
        if let Some(root) = poses.interpolated.first() {
            place(entity, root, &parents, &mut transform);
        }
    });
}

/// A parent that has moved since takes nobody with it: the athlete is where its body is.
pub(super) fn stay_in_world(
    children: ChildAthletes,
    mut parents: Local<Parents>,
    mut params: ParamSet<(
        TransformHelper,
        Query<(Entity, &LinkPoses, &mut Transform), (With<AthleteBody>, With<ChildOf>)>,
    )>,
) {
    if children.is_empty() {
        return;
    }
    find_parents(&children, &params.p0(), &mut parents);
    for (entity, poses, mut transform) in &mut params.p1() {
        if let Some(root) = poses.interpolated.first() {
            place(entity, root, &parents, &mut transform);
        }
    }
}

fn find_parents(children: &ChildAthletes, places: &TransformHelper, parents: &mut Parents) {
    parents.clear();
    let place = |child: &ChildOf| places.compute_global_transform(child.parent()).unwrap_or_default();
    parents.extend(children.iter().map(|(entity, child)| (entity, place(child))));
    parents.sort_unstable_by_key(|(entity, _)| *entity);
}

/// Writes the root's place into the transform, which counts from the parent where there is one.
fn place(athlete: Entity, root: &LinkTransform, parents: &[(Entity, GlobalTransform)], transform: &mut Mut<Transform>) {
    let in_world = to_transform(root);
    let local = match parents.binary_search_by_key(&athlete, |(entity, _)| *entity) {
        Ok(k) => GlobalTransform::from(in_world).reparented_to(&parents[k].1),
        Err(_) => in_world,
    };
    // A parent of no size has no inside: the child stays where it was.
    if local.is_finite() && **transform != local {
        **transform = local;
    }
}
