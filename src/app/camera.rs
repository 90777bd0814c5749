//! The camera: drag to turn, wheel to zoom. It circles the athlete, follows behind it, or goes where it is driven.

use crate::engine::{Athlete, AthleteBody, AthleteGhost};
use crate::ui::AthletePanels;
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll};
use bevy::prelude::*;
use std::f32::consts::{PI, TAU};

/// How the camera moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CameraMode {
    /// With the athlete; the mouse sets the direction.
    #[default]
    Orbit,
    /// Behind the athlete, as it travels.
    Follow,
    /// Where the keys drive it.
    Free,
}

/// A camera that looks at the athlete from a direction and a distance that the mouse changes.
#[derive(Component, Clone, Debug)]
pub struct OrbitCamera {
    /// Direction from the target to the camera about +Y, rad: 0 is behind an athlete that faces -Z.
    pub azimuth: f32,
    /// Elevation above the horizon, rad.
    pub elevation: f32,
    /// Distance from the target, m.
    pub distance: f32,
    /// What it looks at, world frame, m.
    pub target: Vec3,
    /// False until it has seen the athlete; then it glides instead of jumping.
    pub found: bool,
    /// How it moves.
    pub mode: CameraMode,
}

impl Default for OrbitCamera {
    fn default() -> Self {
        Self {
            azimuth: 2.5,
            elevation: 0.16,
            distance: 4.6,
            target: Vec3::new(0.0, 0.8, 0.0),
            found: false,
            mode: CameraMode::Orbit,
        }
    }
}

impl OrbitCamera {
    /// Where the camera stands.
    pub fn transform(&self) -> Transform {
        let (up, level) = self.elevation.sin_cos();
        let direction = Vec3::new(self.azimuth.sin() * level, up, self.azimuth.cos() * level);
        Transform::from_translation(self.target + direction * self.distance).looking_at(self.target, Vec3::Y)
    }
}

/// Mouse to angles and distance.
pub(super) fn orbit(
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
    mut cameras: Query<&mut OrbitCamera>,
) {
    for mut camera in &mut cameras {
        if buttons.pressed(MouseButton::Left) && motion.delta != Vec2::ZERO {
            camera.azimuth -= motion.delta.x * 0.006;
            camera.elevation = (camera.elevation + motion.delta.y * 0.005).clamp(0.02, 1.45);
        }
        if scroll.delta.y != 0.0 {
            let notches = scroll.delta.y.clamp(-4.0, 4.0);
            camera.distance = (camera.distance * (-0.12 * notches).exp()).clamp(1.5, 60.0);
        }
    }
}

/// Speed above which the direction of travel is where the camera goes behind, m/s.
const TRAVELS: f32 = 0.6;
/// Speed of the free camera, m/s.
const DRIVE: f32 = 5.0;

/// Athletes that are simulated, and their ghosts.
type Simulated = (With<Athlete>, With<AthleteBody>);

/// Keeps the athlete in the picture that the panels have selected, or the first; and a ghost beside it too.
pub(super) fn follow(
    time: Res<Time<Real>>,
    panels: Option<Res<AthletePanels>>,
    athletes: Query<(&Transform, &AthleteBody, Option<&AthleteGhost>), Simulated>,
    mut cameras: Query<(&mut OrbitCamera, &mut Transform), Without<Athlete>>,
) {
    let selected = panels.and_then(|panels| panels.selected).and_then(|entity| athletes.get(entity).ok());
    let athlete = selected.or_else(|| athletes.iter().next());
    for (mut camera, mut transform) in &mut cameras {
        if let Some((athlete, body, ghost)) = athlete
            && camera.mode != CameraMode::Free
        {
            let beside = ghost.map_or(Vec3::ZERO, |g| g.offset * 0.42);
            let height = athlete.translation.y.max(0.3) * 0.25 + 0.58;
            let wanted = athlete.translation.with_y(height) + beside;
            let far = camera.target.distance(wanted) > 5.0;
            let share = |rate: f32| 1.0 - (-rate * time.delta_secs()).exp();
            let near = if camera.found && !far { share(9.0) } else { 1.0 };
            camera.found = true;
            camera.target = camera.target.lerp(wanted, near);
            let velocity = body.root_velocity().as_vec3();
            if camera.mode == CameraMode::Follow && velocity.with_y(0.0).length() > TRAVELS {
                let behind = (-velocity.x).atan2(-velocity.z);
                let turn = (behind - camera.azimuth + PI).rem_euclid(TAU) - PI;
                camera.azimuth += turn * share(1.6);
            }
        }
        *transform = camera.transform();
    }
}

/// W, A, S, D, Q and E drive the free camera.
pub(super) fn drive(time: Res<Time<Real>>, keys: Res<ButtonInput<KeyCode>>, mut cameras: Query<&mut OrbitCamera>) {
    let axis = |more: KeyCode, less: KeyCode| f32::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)));
    let wish = Vec3::new(
        axis(KeyCode::KeyD, KeyCode::KeyA),
        axis(KeyCode::KeyE, KeyCode::KeyQ),
        axis(KeyCode::KeyS, KeyCode::KeyW),
    );
    if wish == Vec3::ZERO {
        return;
    }
    for mut camera in &mut cameras {
        if camera.mode == CameraMode::Free {
            let step = Quat::from_rotation_y(camera.azimuth) * wish * DRIVE * time.delta_secs();
            camera.target += step;
            camera.target.y = camera.target.y.clamp(0.1, 30.0);
        }
    }
}
