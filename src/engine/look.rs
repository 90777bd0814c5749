//! Colours of an athlete.

use bevy::prelude::*;

/// How the links of an athlete look: the left side, the right side, the middle, and steel for blades.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct AthleteLook {
    /// Links whose name ends in `_left` (or starts with `left_`).
    pub left: Color,
    /// Links whose name ends in `_right` (or starts with `right_`).
    pub right: Color,
    /// All others.
    pub middle: Color,
    /// The blades.
    pub steel: Color,
    /// Whether its links throw shadows.
    pub shadows: bool,
}

impl Default for AthleteLook {
    fn default() -> Self {
        Self {
            left: Color::srgb(0.13, 0.44, 0.71),
            right: Color::srgb(0.90, 0.35, 0.24),
            middle: Color::srgb(0.94, 0.90, 0.84),
            steel: Color::srgb(0.72, 0.76, 0.80),
            shadows: true,
        }
    }
}

/// The side of the body, for its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Left,
    Right,
    Middle,
    Steel,
}

impl Part {
    /// By the name of a link.
    pub fn of_link(name: &str) -> Self {
        if name.ends_with("_left") || name.starts_with("left_") || name.ends_with("_l") {
            Self::Left
        } else if name.ends_with("_right") || name.starts_with("right_") || name.ends_with("_r") {
            Self::Right
        } else {
            Self::Middle
        }
    }

    /// The material of this part.
    pub fn material(self, look: &AthleteLook) -> StandardMaterial {
        let base_color = match self {
            Self::Left => look.left,
            Self::Right => look.right,
            Self::Middle => look.middle,
            Self::Steel => {
                let (metallic, perceptual_roughness) = (0.6, 0.3);
                return StandardMaterial {
                    base_color: look.steel,
                    metallic,
                    perceptual_roughness,
                    ..Default::default()
                };
            }
        };
        StandardMaterial { base_color, perceptual_roughness: 0.62, reflectance: 0.35, ..Default::default() }
    }
}
