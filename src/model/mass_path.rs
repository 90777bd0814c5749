//! The centre of mass of a posed figure: put on a path, and through the air on its parabola.

use super::{CharacterModel, ModelPose};
use crate::asset::clip::Pose;
use glam::{DQuat, DVec3};

/// Gravity of flights in key poses, and what a body weight is reckoned by, m/s^2: the default of simulations.
pub const GRAVITY: f64 = 9.81;

/// A time between take-off and landing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flight {
    /// When the figure takes off and when it lands, s.
    pub seconds: (f64, f64),
    /// Height of the centre of mass at these times, m.
    pub heights: (f64, f64),
}

impl Flight {
    /// Height (m) of the centre of mass at the time `t` (s): the parabola of free fall through both ends; `None` on
    /// the ground.
    pub fn height(&self, t: f64) -> Option<f64> {
        let ((start, end), (from, to)) = (self.seconds, self.heights);
        if t <= start || t >= end {
            return None;
        }
        let fall = 0.5 * GRAVITY * (t - start) * (end - t);
        Some(from + (to - from) * (t - start) / (end - start) + fall)
    }
}

/// Centre of mass of a pose whose joints are in the order of the links after the root, world axes, m.
pub(crate) fn center_of_mass(model: &CharacterModel, pose: &Pose) -> DVec3 {
    let mut whole = ModelPose::zero(model);
    whole.root_position = pose.root_position;
    whole.root_rotation = pose.root_rotation;
    whole.joints[1..].copy_from_slice(&pose.joints);
    let mut places = Vec::new();
    whole.link_transforms(model, &mut places);
    let weighed = model.links.iter().zip(&places).map(|(link, at)| (at.position + at.rotation * link.com) * link.mass);
    weighed.sum::<DVec3>() / model.mass()
}

/// The rotation about the vertical by `degrees`, positive to the left, however many whole turns.
pub(crate) fn turned(degrees: f64) -> DQuat {
    DQuat::from_rotation_y(degrees.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flight_is_free_fall_between_its_ends() {
        let flight = Flight { seconds: (1.0, 1.5), heights: (0.9, 0.8) };
        assert_eq!(flight.height(1.0), None);
        assert_eq!(flight.height(1.5), None);
        let near = |t: f64| flight.height(t).unwrap();
        assert!((near(1.0 + 1e-9) - 0.9).abs() < 1e-6 && (near(1.5 - 1e-9) - 0.8).abs() < 1e-6);
        let h = 1e-3;
        for t in [1.1, 1.25, 1.4] {
            let acceleration = (near(t + h) - 2.0 * near(t) + near(t - h)) / (h * h);
            assert!((acceleration + GRAVITY).abs() < 1e-6, "{acceleration} m/s^2");
        }
    }
}
