//! Surfaces: a material and how it rubs.

pub use crate::asset::Material;

/// Material and friction of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// What it is made of.
    pub material: Material,
    /// Coulomb coefficient.
    pub friction: f64,
}

impl Surface {
    /// Ice with the friction of the skating paper, 0.02.
    pub const ICE: Self = Self { material: Material::ICE, friction: 0.02 };
    /// Ground with friction 0.8.
    pub const GROUND: Self = Self { material: Material::GROUND, friction: 0.8 };
    /// A wall or an obstacle with friction 0.8.
    pub const WALL: Self = Self { material: Material::WALL, friction: 0.8 };
    /// A rail with friction 0.8.
    pub const RAIL: Self = Self { material: Material::RAIL, friction: 0.8 };
}
