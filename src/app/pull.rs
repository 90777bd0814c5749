//! Pulling at a link with the mouse: the right button takes hold, a spring of limited force follows the pointer.

use crate::engine::{Athlete, AthleteBody, AthleteForce, AthleteForces, LinkPoses};
use crate::model::Shape;
use bevy::math::DVec3;
use bevy::prelude::*;

/// Stiffness of the spring, N/m, and its damping, N s/m.
const SPRING: (f64, f64) = (900.0, 90.0);
/// Most that it pulls, N.
const MOST: f64 = 450.0;
/// How far from a link's middle line the pointer still takes hold, m.
const REACH: f32 = 0.12;

/// A hold on a link.
#[derive(Clone, Copy, Debug)]
struct Hold {
    athlete: Entity,
    link: usize,
    /// Where, link frame, m.
    position: DVec3,
    /// Distance from the camera along its view, m.
    depth: f32,
}

/// What the mouse holds, and what it pulls with.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(super) struct MousePull {
    hold: Option<Hold>,
    /// Start and end of the arrow, world frame, m.
    pub arrow: Option<(Vec3, Vec3)>,
    /// The force, N.
    pub force: f64,
}

pub(super) struct PullPlugin;

impl Plugin for PullPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<MousePull>()
            .add_systems(FixedUpdate, pull)
            .add_systems(Update, draw.run_if(resource_exists::<GizmoConfigStore>));
    }
}

/// Takes hold of the link under the pointer, or lets go. To run where the pointer is not over a panel.
pub(super) fn take_hold(
    buttons: Res<ButtonInput<MouseButton>>,
    windows: Query<&Window>,
    cameras: Query<(&Camera, &GlobalTransform), With<Camera3d>>,
    athletes: Query<(Entity, &AthleteBody, &LinkPoses), With<Athlete>>,
    mut held: ResMut<MousePull>,
) {
    if !buttons.just_pressed(MouseButton::Right) {
        return;
    }
    let (Some(window), Some((camera, place))) = (windows.iter().next(), cameras.iter().next()) else { return };
    let Some(ray) = window.cursor_position().and_then(|at| camera.viewport_to_world(place, at).ok()) else { return };
    let mut nearest: Option<(f32, Hold)> = None;
    for (athlete, body, poses) in &athletes {
        for (link, (description, pose)) in body.model().links.iter().zip(&poses.interpolated).enumerate() {
            let (a, b) = middle_line(&description.shapes, description.com);
            let ends = [a, b].map(|p| (pose.position + pose.rotation * p).as_vec3());
            let (along, on_line) = closest(ray.origin, ray.direction.as_vec3(), ends[0], ends[1]);
            let apart = (ray.origin + ray.direction * along).distance(on_line);
            if along > 0.1 && apart < REACH && nearest.is_none_or(|(d, _)| along < d) {
                let position = pose.rotation.inverse() * (on_line.as_dvec3() - pose.position);
                let depth = (on_line - place.translation()).dot(place.forward().as_vec3());
                nearest = Some((along, Hold { athlete, link, position, depth }));
            }
        }
    }
    held.hold = nearest.map(|(_, hold)| hold);
}

/// Ends of the middle line of a link's first shape, link frame, m.
fn middle_line(shapes: &[Shape], com: DVec3) -> (DVec3, DVec3) {
    match shapes.first() {
        Some(Shape::Capsule { a, b, .. }) => (*a, *b),
        Some(Shape::Box { center, half_extents, rotation }) => {
            let h = *half_extents;
            let axis = if h.x >= h.y && h.x >= h.z {
                DVec3::X * h.x
            } else if h.y >= h.z {
                DVec3::Y * h.y
            } else {
                DVec3::Z * h.z
            };
            (*center - *rotation * axis, *center + *rotation * axis)
        }
        Some(Shape::Sphere { center, .. }) => (*center, *center),
        _ => (com, com),
    }
}

/// How far along a ray, and where on a segment, the two are nearest.
fn closest(origin: Vec3, direction: Vec3, a: Vec3, b: Vec3) -> (f32, Vec3) {
    let (u, w) = (b - a, origin - a);
    let (uu, ud, uw, dw) = (u.dot(u), u.dot(direction), u.dot(w), direction.dot(w));
    let denominator = uu - ud * ud;
    let s = if denominator > 1e-9 { (uw - ud * dw) / denominator } else { 0.5 };
    let on_segment = a + u * s.clamp(0.0, 1.0);
    ((on_segment - origin).dot(direction), on_segment)
}

/// Pulls in every fixed tick.
fn pull(
    buttons: Res<ButtonInput<MouseButton>>,
    windows: Query<&Window>,
    cameras: Query<(&Camera, &GlobalTransform), With<Camera3d>>,
    mut athletes: Query<(&mut AthleteBody, &LinkPoses, &mut AthleteForces)>,
    mut held: ResMut<MousePull>,
    mut last: Local<Option<(Entity, AthleteForce)>>,
) {
    // The force of the tick before is replaced.
    if let Some((athlete, before)) = last.take()
        && let Ok((_, _, mut forces)) = athletes.get_mut(athlete)
    {
        forces.retain(|force| *force != before);
    }
    held.arrow = None;
    held.force = 0.0;
    if !buttons.pressed(MouseButton::Right) {
        held.hold = None;
    }
    let Some(hold) = held.hold else { return };
    let (Some(window), Some((camera, place))) = (windows.iter().next(), cameras.iter().next()) else { return };
    let Some(ray) = window.cursor_position().and_then(|at| camera.viewport_to_world(place, at).ok()) else { return };
    let Ok((mut body, poses, mut forces)) = athletes.get_mut(hold.athlete) else {
        held.hold = None;
        return;
    };
    let Some(pose) = poses.current.get(hold.link) else { return };
    let point = pose.position + pose.rotation * hold.position;
    let along = hold.depth / ray.direction.dot(place.forward().as_vec3()).max(0.1);
    let wanted = (ray.origin + ray.direction * along).as_dvec3();
    let velocity = {
        let simulator = body.simulator_mut();
        let link = simulator.kinematics()[hold.link];
        let (angular, linear) = (link.velocity.angular.lane(0), link.velocity.linear.lane(0));
        linear + angular.cross(pose.rotation * hold.position)
    };
    let force = ((wanted - point) * SPRING.0 - velocity * SPRING.1).clamp_length_max(MOST);
    let force = AthleteForce { link: hold.link, position: hold.position, force, seconds: None };
    forces.push(force);
    *last = Some((hold.athlete, force));
    held.force = force.force.length();
    held.arrow = Some((point.as_vec3(), wanted.as_vec3()));
}

fn draw(held: Res<MousePull>, mut gizmos: Gizmos) {
    if let Some((from, to)) = held.arrow {
        let color = Color::srgb(0.95, 0.20, 0.35);
        gizmos.arrow(from, to, color);
        gizmos.sphere(from, 0.025, color);
    }
}
