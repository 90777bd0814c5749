//! The wished change of momentum.

use super::hull::Hull;
use super::settings::BalanceSettings;
use glam::{DMat3, DVec2, DVec3};

/// What the body is like as a whole.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Whole {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, world frame, m, and its velocity, m/s.
    pub com: DVec3,
    pub velocity: DVec3,
    /// Angular momentum about it, kg m^2/s.
    pub spin: DVec3,
    /// Composite inertia about it, kg m^2.
    pub inertia: DMat3,
    /// By how much the trunk would have to turn to be upright, rotation vector in world axes, rad.
    pub lean: DVec3,
    /// Acceleration of free fall, m/s^2.
    pub gravity: DVec3,
}

/// A wished force on the body and moment about its centre of mass: those of the ground.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wish {
    pub force: DVec3,
    pub moment: DVec3,
}

/// Force and moment of the ground that take the centre of mass to `target` (m, moving at `pace`, m/s, and `push`, m/s^2) and the trunk
/// upright: PD laws for linear and angular momentum.
pub(super) fn wished(whole: &Whole, settings: &BalanceSettings, target: DVec3, pace: DVec3, push: DVec3) -> Wish {
    let damping = 2.0 * settings.linear.sqrt() * settings.linear_damping;
    let acceleration = settings.linear * (target - whole.com) + damping * (pace - whole.velocity) + push;
    let mut force = whole.mass * (acceleration - whole.gravity);
    // The ground does not pull, and a body that is thrown lands too hard.
    let weight = whole.mass * whole.gravity.length();
    force.y = force.y.clamp(0.2 * weight, 2.0 * weight);
    Wish { force, moment: whole.inertia * (settings.upright * whole.lean) - settings.angular * whole.spin }
}

/// The same with no more level force than a centroidal moment pivot gives (Herr, Popovic 2008: where the force, drawn through the centre
/// of mass, meets the ground) that lies outside the hull by at most `hip`, m: beyond the hull it takes angular momentum to give it.
pub(super) fn within_reach(wish: Wish, whole: &Whole, hull: &Hull, ground: f64, hip: f64) -> Wish {
    let height = whole.com.y - ground;
    let level = DVec2::new(whole.com.x, -whole.com.z);
    let asked = level - DVec2::new(wish.force.x, -wish.force.z) * (height / wish.force.y);
    let Some(edge) = hull.nearest(asked, 0.0) else { return wish };
    let beyond = asked - edge;
    if beyond.length() <= hip || height <= 0.0 {
        return wish;
    }
    let force = (level - edge - beyond * (hip / beyond.length())) * (wish.force.y / height);
    Wish { force: DVec3::new(force.x, wish.force.y, -force.y), ..wish }
}

/// The same with the centre of pressure that it asks for kept inside the hull, on the ground at height `ground`, and the force inside
/// the friction cone (level ground).
pub(super) fn with_pressure_inside(
    wish: Wish,
    whole: &Whole,
    settings: &BalanceSettings,
    hull: &Hull,
    ground: f64,
) -> Wish {
    let mut force = wish.force;
    let level = DVec2::new(force.x, force.z);
    let most = settings.friction * force.y;
    if level.length() > most {
        let scaled = level * (most / level.length());
        (force.x, force.z) = (scaled.x, scaled.y);
    }
    // (p - c) x f = the moment, solved for the two horizontal places.
    let drop = ground - whole.com.y;
    let x = (wish.moment.z + drop * force.x) / force.y;
    let z = (drop * force.z - wish.moment.x) / force.y;
    let asked = DVec2::new(whole.com.x + x, -(whole.com.z + z));
    let Some(p) = hull.nearest(asked, settings.margin) else { return Wish::default() };
    let arm = DVec3::new(p.x - whole.com.x, drop, -p.y - whole.com.z);
    let mut moment = arm.cross(force);
    moment.y = wish.moment.y;
    Wish { force, moment }
}
