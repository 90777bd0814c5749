//! The orbit camera: drag to turn, wheel to zoom, it follows the skater.

use crate::engine::{Athlete, AthleteBody, AthleteGhost};
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll};
use bevy::prelude::*;

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
}

impl Default for OrbitCamera {
    fn default() -> Self {
        Self { azimuth: 2.5, elevation: 0.16, distance: 4.6, target: Vec3::new(0.0, 0.8, 0.0), found: false }
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
            camera.distance = (camera.distance * (-0.12 * notches).exp()).clamp(1.5, 30.0);
        }
    }
}

/// Athletes that are simulated, and their ghosts.
type Simulated = (With<Athlete>, With<AthleteBody>);

/// Keeps the athlete in the picture, and its ghost with it.
pub(super) fn follow(
    time: Res<Time<Real>>,
    athletes: Query<(&Transform, Option<&AthleteGhost>), Simulated>,
    mut cameras: Query<(&mut OrbitCamera, &mut Transform), Without<Athlete>>,
) {
    let Some((athlete, ghost)) = athletes.iter().next() else { return };
    let beside = ghost.map_or(Vec3::ZERO, |g| g.offset * 0.42);
    let wanted = Vec3::new(athlete.translation.x, athlete.translation.y.max(0.3) * 0.25 + 0.58, athlete.translation.z);
    for (mut camera, mut transform) in &mut cameras {
        let wanted = wanted + beside;
        let far = camera.target.distance(wanted) > 5.0;
        let share = if camera.found && !far { 1.0 - (-9.0 * time.delta_secs()).exp() } else { 1.0 };
        camera.found = true;
        camera.target = camera.target.lerp(wanted, share);
        *transform = camera.transform();
    }
}
