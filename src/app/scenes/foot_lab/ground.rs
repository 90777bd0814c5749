//! The ground of the lab: a floor that tilts, a ball each, a lump that comes up under a foot.

use super::LabHuman;
use super::settings::{FootLab, LabGround};
use crate::contact::{Geometry, Solid, Surface};
use crate::engine::{AthleteBody, AthleteWorld, LinkPoses, Placement};
use crate::model::CharacterModel;
use bevy::math::{DQuat, DVec2, DVec3};
use bevy::prelude::*;

/// How fast the floor tilts, rad/s.
const TILT_RATE: f64 = 0.12;
/// How fast a lump comes up or goes down, m/s.
const RAISE_RATE: f64 = 0.02;
/// How far from the middle each human stands, m.
pub(super) const ASIDE: f32 = 0.7;
/// Radius of the balls that they stand on, m.
pub(super) const BALL: f32 = 0.6;
/// Half of the length of a foot, m.
const HALF_FOOT: f64 = 0.12;

/// The floor to be seen.
#[derive(Component)]
pub(super) struct Floor;

/// The lump to be seen under this human.
#[derive(Component)]
pub(super) struct LumpOf(pub Entity);

/// Upwards from a floor that is turned so about x and z (rad).
fn normal(turned: DVec2) -> DVec3 {
    DQuat::from_scaled_axis(DVec3::new(turned.x, 0.0, turned.y)) * DVec3::Y
}

/// The place of a floor through the origin with this normal at x and z, m.
fn on_floor(n: DVec3, at: DVec2) -> DVec3 {
    DVec3::new(at.x, -(n.x * at.x + n.z * at.y) / n.y, at.y)
}

/// Middle of the sphere that a lump is the top of, m.
fn lump_center(lab: &FootLab, at: DVec2) -> DVec3 {
    let n = normal(lab.now);
    on_floor(n, at) + n * (lab.raised - lab.lump.radius())
}

/// Moves the ground under whoever stands on it.
pub(super) fn move_ground(
    time: Res<Time>,
    mut lab: ResMut<FootLab>,
    mut world: ResMut<AthleteWorld>,
    mut humans: Query<(&mut LabHuman, &AthleteBody, &LinkPoses)>,
) {
    let lab = lab.bypass_change_detection();
    world.solids.clear();
    if lab.ground == LabGround::Ball {
        for x in [-ASIDE, ASIDE] {
            let center = DVec3::new(f64::from(x), f64::from(BALL), 0.0);
            let ball = Geometry::Sphere { center, radius: f64::from(BALL) };
            world.solids.push(Solid::fixed(ball, Surface::GROUND));
        }
        // Whoever falls off it lies somewhere.
        let floor = Geometry::Plane { point: DVec3::ZERO, normal: DVec3::Y };
        world.solids.push(Solid::fixed(floor, Surface::GROUND));
        return;
    }
    let dt = time.delta_secs_f64().max(1e-9);
    let wanted = DVec2::new(-f64::from(lab.slope.y), -f64::from(lab.slope.x)) * 1f64.to_radians();
    let step = (wanted - lab.now).clamp_length_max(TILT_RATE * dt);
    lab.now += step;
    let spin = DVec3::new(step.x, 0.0, step.y) / dt;
    let n = normal(lab.now);
    let mut floor = Solid::fixed(Geometry::Plane { point: DVec3::ZERO, normal: n }, Surface::GROUND);
    floor.angular_velocity = spin;
    world.solids.push(floor);

    let before = lab.raised;
    lab.raised += (f64::from(lab.height) - before).clamp(-RAISE_RATE * dt, RAISE_RATE * dt);
    for (mut human, body, poses) in &mut humans {
        if before == 0.0 {
            human.lump = sole_middle(body.model(), poses, lab.under);
        }
        let Some(at) = human.lump.filter(|_| lab.raised > 0.0) else { continue };
        let ball = Geometry::Sphere { center: lump_center(lab, at), radius: lab.lump.radius() };
        let mut lump = Solid::fixed(ball, Surface::GROUND);
        (lump.angular_velocity, lump.linear_velocity) = (spin, n * ((lab.raised - before) / dt));
        world.solids.push(lump);
    }
}

/// Where the middle of a sole is at present, seen from above: x and z, m.
fn sole_middle(model: &CharacterModel, poses: &LinkPoses, foot: usize) -> Option<DVec2> {
    let points: Vec<usize> = model.foot_points(model.feet().get(foot)?).collect();
    let mut sum = DVec3::ZERO;
    for &k in &points {
        let point = &model.contact_points[k];
        let link = poses.current.get(point.link)?;
        sum += link.position + link.rotation * point.position;
    }
    (!points.is_empty()).then(|| DVec2::new(sum.x, sum.z) / points.len() as f64)
}

/// Who begins anew begins on the floor as it is.
pub(super) fn keep_places(lab: Res<FootLab>, mut bodies: Query<&mut AthleteBody, With<LabHuman>>) {
    if lab.ground == LabGround::Ball {
        return;
    }
    let n = normal(lab.now);
    for mut body in &mut bodies {
        let placement = *body.placement();
        let at = DVec2::new(placement.position.x, placement.position.z);
        // No corner of a sole in the slope.
        let above = n.x.hypot(n.z) * HALF_FOOT;
        let position = on_floor(n, at) + DVec3::Y * above;
        if position != placement.position {
            body.set_placement(Placement { position, ..placement });
        }
    }
}

/// Puts what is seen where it is felt.
pub(super) fn place_ground(
    lab: Res<FootLab>,
    humans: Query<&LabHuman>,
    mut floors: Query<&mut Transform, (With<Floor>, Without<LumpOf>)>,
    mut lumps: Query<(&mut Transform, &mut Visibility, &LumpOf)>,
) {
    for mut floor in &mut floors {
        let turn = DQuat::from_scaled_axis(DVec3::new(lab.now.x, 0.0, lab.now.y)).as_quat();
        *floor = Transform::from_translation(turn * Vec3::new(0.0, -0.04, 0.0)).with_rotation(turn);
    }
    for (mut place, mut visibility, of) in &mut lumps {
        let at = humans.get(of.0).ok().and_then(|human| human.lump).filter(|_| lab.raised > 0.0);
        *visibility = if at.is_some() { Visibility::Inherited } else { Visibility::Hidden };
        if let Some(at) = at {
            let center = lump_center(&lab, at).as_vec3();
            *place = Transform::from_translation(center).with_scale(Vec3::splat(lab.lump.radius() as f32));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::settings::Lump;
    use super::*;

    #[test]
    fn places_lie_on_the_floor_and_a_lump_reaches_as_high_as_it_is_raised() {
        for (turned, at) in [(DVec2::ZERO, DVec2::new(0.3, -0.2)), (DVec2::new(0.2, -0.1), DVec2::new(-0.7, 0.1))] {
            let n = normal(turned);
            let place = on_floor(n, at);
            assert!(place.dot(n).abs() < 1e-12 && (place.x, place.z) == (at.x, at.y));
            for lump in [Lump::Bump, Lump::Ball] {
                let lab = FootLab { now: turned, raised: 0.03, lump, ..FootLab::default() };
                let top = lump_center(&lab, at) + n * lump.radius();
                assert!((top.dot(n) - 0.03).abs() < 1e-12);
            }
        }
    }
}
