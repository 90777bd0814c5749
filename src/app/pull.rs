//! Pulling at a link: the right mouse button, or a finger that comes down on a limb, takes hold; a spring of limited force
//! follows the pointer.

use crate::engine::{Athlete, AthleteBody, AthleteForce, AthleteForces, LinkId, LinkPoses};
use crate::model::Shape;
use bevy::ecs::system::SystemParam;
use bevy::input::touch::Touch;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

/// Stiffness of the spring, N/m, and its damping, N s/m.
const SPRING: (f64, f64) = (900.0, 90.0);
/// Most that it pulls, N.
const MOST: f64 = 450.0;
/// How far from a link's middle line the mouse still takes hold, m, and a finger, which hides what it points at.
const REACH: (f32, f32) = (0.12, 0.16);

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

/// What the pointer holds, and what it pulls with.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(super) struct PointerPull {
    hold: Option<Hold>,
    /// Start and end of the arrow, world frame, m.
    pub arrow: Option<(Vec3, Vec3)>,
    /// The force, N.
    pub force: f64,
}

/// Whether nothing is held: then a drag turns the camera.
pub(super) fn holds_nothing(held: Res<PointerPull>) -> bool {
    held.hold.is_none()
}

pub(super) struct PullPlugin;

impl Plugin for PullPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PointerPull>()
            .add_systems(FixedUpdate, pull)
            .add_systems(Update, draw.run_if(resource_exists::<GizmoConfigStore>));
    }
}

/// The mouse with its right button, or a finger alone.
#[derive(SystemParam)]
pub(crate) struct Pointer<'w, 's> {
    buttons: Res<'w, ButtonInput<MouseButton>>,
    touches: Res<'w, Touches>,
    windows: Query<'w, 's, &'static Window>,
    cameras: Query<'w, 's, (&'static Camera, &'static GlobalTransform), With<Camera3d>>,
}

impl Pointer<'_, '_> {
    fn finger(&self) -> Option<&Touch> {
        let mut fingers = self.touches.iter();
        fingers.next().filter(|_| fingers.next().is_none())
    }

    fn comes_down(&self) -> bool {
        let finger = self.finger().is_some_and(|finger| self.touches.just_pressed(finger.id()));
        finger || self.buttons.just_pressed(MouseButton::Right)
    }

    fn is_down(&self) -> bool {
        self.finger().is_some() || self.buttons.pressed(MouseButton::Right)
    }

    fn reach(&self) -> f32 {
        if self.finger().is_some() { REACH.1 } else { REACH.0 }
    }

    /// Where it is in the window, logical pixels.
    pub(crate) fn place(&self) -> Option<Vec2> {
        self.finger().map(Touch::position).or_else(|| self.windows.iter().next()?.cursor_position())
    }

    /// The line of sight through it, and the camera's place.
    pub(crate) fn ray(&self) -> Option<(Ray3d, &GlobalTransform)> {
        let (camera, place) = self.cameras.iter().next()?;
        Some((camera.viewport_to_world(place, self.place()?).ok()?, place))
    }
}

/// Whether a panel, a button or a stick is at a place.
pub(crate) fn on_panel(context: &egui::Context, at: Vec2) -> bool {
    context.layer_id_at(egui::pos2(at.x, at.y)).is_some_and(|layer| layer.order != egui::Order::Background)
}

/// Takes hold of the link under the pointer, or lets go.
pub(super) fn take_hold(
    pointer: Pointer,
    athletes: Query<(Entity, &AthleteBody, &LinkPoses), With<Athlete>>,
    mut contexts: EguiContexts,
    mut held: ResMut<PointerPull>,
) -> Result {
    if !pointer.comes_down() {
        return Ok(());
    }
    // A finger is where it was not before: whether a panel is there is asked now.
    let context = contexts.ctx_mut()?;
    if pointer.place().is_none_or(|at| on_panel(context, at)) {
        return Ok(());
    }
    let Some((ray, place)) = pointer.ray() else { return Ok(()) };
    let mut nearest: Option<(f32, Hold)> = None;
    for (athlete, body, poses) in &athletes {
        for (link, (description, pose)) in body.model().links.iter().zip(&poses.interpolated).enumerate() {
            let (a, b) = middle_line(&description.shapes, description.com);
            let ends = [a, b].map(|p| (pose.position + pose.rotation * p).as_vec3());
            let (along, on_line) = closest(ray.origin, ray.direction.as_vec3(), ends[0], ends[1]);
            let apart = (ray.origin + ray.direction * along).distance(on_line);
            if along > 0.1 && apart < pointer.reach() && nearest.is_none_or(|(d, _)| along < d) {
                let position = pose.rotation.inverse() * (on_line.as_dvec3() - pose.position);
                let depth = (on_line - place.translation()).dot(place.forward().as_vec3());
                nearest = Some((along, Hold { athlete, link, position, depth }));
            }
        }
    }
    held.hold = nearest.map(|(_, hold)| hold);
    Ok(())
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
    pointer: Pointer,
    mut athletes: Query<(&mut AthleteBody, &LinkPoses, &mut AthleteForces)>,
    mut held: ResMut<PointerPull>,
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
    if !pointer.is_down() {
        held.hold = None;
    }
    let Some(hold) = held.hold else { return };
    let Some((ray, place)) = pointer.ray() else { return };
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
    let force = AthleteForce { link: LinkId::at(hold.link), position: hold.position, force, seconds: None };
    forces.push(force);
    *last = Some((hold.athlete, force));
    held.force = force.force.length();
    held.arrow = Some((point.as_vec3(), wanted.as_vec3()));
}

fn draw(held: Res<PointerPull>, mut gizmos: Gizmos) {
    if let Some((from, to)) = held.arrow {
        let color = Color::srgb(0.95, 0.20, 0.35);
        gizmos.arrow(from, to, color);
        gizmos.sphere(from, 0.025, color);
    }
}
