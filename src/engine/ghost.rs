//! The reference, drawn translucent beside the athlete.

use bevy::prelude::*;

/// Shows the reference pose of the control that plays beside the athlete. Add it before the athlete's body is there (at
/// spawn); without a control nothing is shown.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct AthleteGhost {
    /// Offset from where the reference is, in the frame of the placement (-Z ahead, +X right), m.
    pub offset: Vec3,
    /// Colour and opacity.
    pub color: Color,
}

impl Default for AthleteGhost {
    fn default() -> Self {
        Self { offset: Vec3::new(1.1, 0.0, 0.0), color: Color::srgba(0.10, 0.62, 0.95, 0.38) }
    }
}

impl AthleteGhost {
    pub(super) fn material(&self) -> StandardMaterial {
        StandardMaterial {
            base_color: self.color,
            alpha_mode: AlphaMode::Blend,
            perceptual_roughness: 0.9,
            reflectance: 0.1,
            ..Default::default()
        }
    }
}
