//! Where the character's own frame lies in the world.

use crate::control::ReconstructedControl;
use crate::engine::AthleteRefusal;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

/// A place on the ground and a direction: what the place in the world at spawn means to an athlete.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct Placement {
    /// Origin of the character's frame, world frame, m.
    pub position: DVec3,
    /// Rotation about +Y from the character's frame to the world.
    pub heading: DQuat,
}

impl Default for Placement {
    fn default() -> Self {
        Self { position: DVec3::ZERO, heading: DQuat::IDENTITY }
    }
}

impl Placement {
    /// Largest deviation of a scale from one that counts as rounding.
    const SCALE_TOLERANCE: f32 = 1e-4;

    /// Position and yaw of a transform; tilt is left out. Refuses what is not finite and any scale but one.
    pub fn from_transform(transform: &Transform) -> Result<Self, AthleteRefusal> {
        let Transform { translation, rotation, scale } = *transform;
        if !(translation.is_finite() && rotation.is_finite() && (rotation.length_squared() - 1.0).abs() < 1e-2) {
            return Err(AthleteRefusal::Transform { translation, rotation });
        }
        // Written so that a NaN is refused too.
        if !((scale - Vec3::ONE).abs().max_element() < Self::SCALE_TOLERANCE && scale.is_finite()) {
            return Err(AthleteRefusal::Scale { scale });
        }
        // The twist about Y of the rotation; a rotation upside down has none and faces -Z.
        let (y, w) = (f64::from(rotation.y), f64::from(rotation.w));
        let length = y.hypot(w);
        let heading = if length < 1e-6 { DQuat::IDENTITY } else { DQuat::from_xyzw(0.0, y / length, 0.0, w / length) };
        Ok(Self { position: translation.as_dvec3(), heading })
    }

    /// A point of the character's frame, in the world, m.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.position + self.heading * point
    }

    /// The control with its clip moved to this place. The clip of the identity placement keeps its bits.
    pub fn move_control(&self, control: &ReconstructedControl) -> ReconstructedControl {
        let mut moved = control.clone();
        if *self != Self::default() {
            for pose in &mut moved.clip.poses {
                pose.root_position = self.point(pose.root_position);
                pose.root_rotation = (self.heading * pose.root_rotation).normalize();
            }
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_position_and_yaw_of_a_transform_count() {
        let yaw = Quat::from_rotation_y(1.2);
        let placed = Placement::from_transform(&Transform::from_xyz(1.0, 2.0, 3.0).with_rotation(yaw)).unwrap();
        assert_eq!(placed.position, DVec3::new(1.0, 2.0, 3.0));
        assert!(placed.heading.angle_between(DQuat::from_rotation_y(1.2)) < 1e-6);
        let tilted = yaw * Quat::from_rotation_x(0.4);
        let placed = Placement::from_transform(&Transform::from_rotation(tilted)).unwrap();
        assert!(placed.heading.angle_between(DQuat::from_rotation_y(1.2)) < 1e-6);
    }

    #[test]
    fn scales_and_numbers_that_are_none_are_refused() {
        for scale in [Vec3::ZERO, Vec3::splat(2.0), Vec3::new(1.0, 1.0, -1.0), Vec3::splat(f32::NAN)] {
            let refused = Placement::from_transform(&Transform::from_scale(scale));
            assert!(matches!(refused, Err(AthleteRefusal::Scale { .. })), "{scale}");
        }
        let nowhere = Transform::from_xyz(f32::NAN, 0.0, 0.0);
        assert!(matches!(Placement::from_transform(&nowhere), Err(AthleteRefusal::Transform { .. })));
        let no_rotation = Transform::from_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
        assert!(matches!(Placement::from_transform(&no_rotation), Err(AthleteRefusal::Transform { .. })));
    }
}
