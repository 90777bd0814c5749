//! What surfaces are made of.

/// A material: what a surface does besides rubbing.
///
/// The crate's own are constants. Others get a number of their own from [`Material::OWN`] on; a course file gives its materials
/// theirs in the order in which it names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Material {
    /// Tells materials apart, such as for sounds and tracks.
    pub id: u16,
    /// Blades act as knife edges on it.
    pub carves: bool,
    /// Hands can hold on to it: edges and rails.
    pub grippable: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self::GROUND
    }
}

impl Material {
    /// Ordinary ground.
    pub const GROUND: Self = Self { id: 0, carves: false, grippable: false };
    /// Ice: blades act as knife edges.
    pub const ICE: Self = Self { id: 1, carves: true, grippable: false };
    /// A wall or an obstacle.
    pub const WALL: Self = Self { id: 2, carves: false, grippable: false };
    /// A rail or the edge of a ledge: hands can hold on to it.
    pub const RAIL: Self = Self { id: 3, carves: false, grippable: true };
    /// First number that the crate's own materials leave free.
    pub const OWN: u16 = 16;

    /// Names of the crate's own materials.
    pub const NAMES: [&'static str; 4] = ["ground", "ice", "wall", "rail"];

    /// The crate's own material of this name.
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::GROUND, Self::ICE, Self::WALL, Self::RAIL];
        Self::NAMES.iter().position(|n| *n == name).map(|k| all[k])
    }

    /// The name of one of the crate's own materials.
    pub fn name(self) -> Option<&'static str> {
        Self::NAMES.get(usize::from(self.id)).copied()
    }
}
