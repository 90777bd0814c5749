//! Mass, centre and inertia of solids of uniform density, and their sums.

use super::Shape;
use core::f64::consts::PI;
use glam::{DMat3, DQuat, DVec3};

/// Mass properties of a body, in some link frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct MassProperties {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub com: DVec3,
    /// Inertia about the centre of mass, kg m^2.
    pub inertia: DMat3,
}

impl MassProperties {
    /// No body at all.
    pub const NOTHING: Self = Self { mass: 0.0, com: DVec3::ZERO, inertia: DMat3::ZERO };

    /// From stated values; the inertia as xx, yy, zz, xy, xz, yz, kg m^2.
    pub fn new(mass: f64, com: DVec3, [xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Self {
        let columns = [DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz)];
        Self { mass, com, inertia: DMat3::from_cols(columns[0], columns[1], columns[2]) }
    }

    /// Solids of one density that together hold `mass` kg; where two overlap, the overlap counts twice. All zero without
    /// solids.
    pub fn of_shapes(shapes: &[Shape], mass: f64) -> Self {
        let at_unit_density = shapes.iter().map(of_solid).fold(Self::NOTHING, |sum, solid| sum.plus(&solid));
        if at_unit_density.mass <= 0.0 {
            return Self { mass, ..Self::NOTHING };
        }
        let density = mass / at_unit_density.mass;
        Self { mass, com: at_unit_density.com, inertia: at_unit_density.inertia * density }
    }

    /// The same body in a frame whose origin lies `-shift` away, m.
    pub fn shifted(mut self, shift: DVec3) -> Self {
        self.com += shift;
        self
    }

    /// Both bodies as one rigid body.
    ///
    /// `I = I_a + I_b + m_a S(c_a - c) + m_b S(c_b - c)` with `S(d) = |d|^2 1 - d d^T`, the theorem of parallel axes.
    /// Without mass on either side, the sum is zero.
    pub fn plus(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass <= 0.0 {
            return Self::NOTHING;
        }
        let com = (self.com * self.mass + other.com * other.mass) / mass;
        let inertia = self.inertia + other.inertia;
        let inertia = inertia + steiner(self.com - com) * self.mass + steiner(other.com - com) * other.mass;
        Self { mass, com, inertia }
    }
}

/// `|d|^2 1 - d d^T`.
fn steiner(d: DVec3) -> DMat3 {
    DMat3::from_diagonal(DVec3::splat(d.length_squared())) - DMat3::from_cols(d * d.x, d * d.y, d * d.z)
}

/// One solid of density 1 kg/m^3.
fn of_solid(shape: &Shape) -> MassProperties {
    match *shape {
        Shape::Box { center, half_extents, rotation } => {
            let mass = 8.0 * half_extents.x * half_extents.y * half_extents.z;
            let h = half_extents * half_extents;
            let diagonal = DVec3::new(h.y + h.z, h.x + h.z, h.x + h.y) * (mass / 3.0);
            MassProperties { mass, com: center, inertia: rotated(diagonal, rotation) }
        }
        Shape::Sphere { center, radius } => {
            let mass = 4.0 / 3.0 * PI * radius.powi(3);
            let inertia = DMat3::from_diagonal(DVec3::splat(0.4 * mass * radius * radius));
            MassProperties { mass, com: center, inertia }
        }
        // A cylinder of length l and two half balls: each half ball's centre lies 3r/8 beyond the cylinder's end, and its
        // inertia across the axis about that centre is (2/5 - 9/64) m r^2.
        Shape::Capsule { a, b, radius: r } => {
            let l = (b - a).length();
            let (cylinder, balls) = (PI * r * r * l, 4.0 / 3.0 * PI * r.powi(3));
            let along = 0.5 * cylinder * r * r + 0.4 * balls * r * r;
            let reach = 0.5 * l + 0.375 * r;
            let across =
                cylinder * (l * l / 12.0 + 0.25 * r * r) + balls * ((0.4 - 9.0 / 64.0) * r * r + reach * reach);
            let axis = (b - a).normalize_or(DVec3::Y);
            let rotation = DQuat::from_rotation_arc(DVec3::Y, axis);
            let inertia = rotated(DVec3::new(across, along, across), rotation);
            MassProperties { mass: cylinder + balls, com: (a + b) * 0.5, inertia }
        }
    }
}

/// A diagonal inertia turned by a rotation.
fn rotated(diagonal: DVec3, rotation: DQuat) -> DMat3 {
    let r = DMat3::from_quat(rotation);
    let turned = r * DMat3::from_diagonal(diagonal) * r.transpose();
    // Exactly symmetric, whatever the rounding.
    (turned + turned.transpose()) * 0.5
}

impl Shape {
    /// The same solid moved by a vector, m.
    pub fn shifted(self, by: DVec3) -> Self {
        match self {
            Shape::Box { center, half_extents, rotation } => Shape::Box { center: center + by, half_extents, rotation },
            Shape::Capsule { a, b, radius } => Shape::Capsule { a: a + by, b: b + by, radius },
            Shape::Sphere { center, radius } => Shape::Sphere { center: center + by, radius },
        }
    }
}
