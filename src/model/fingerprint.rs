//! A number that tells bodies apart by what they are, not by what they are called.
//!
//! The hash is FNV-1a, 64 bit (Fowler, Noll, Vo 1991), over every field of the frozen model in the order of its declaration:
//! h <- (h xor byte) * 0x100000001b3. It is the same on every machine and tells contents apart; it is no seal against a forger.

use super::{
    Blade, CharacterModel, ContactKind, ContactPoint, Foot, FootKind, Gains, Grip, JointKind, JointLimits, JointSpring,
    LeanLaw, Link, PointRole, Shape, Side,
};
use glam::{DMat3, DQuat, DVec3};

/// Bits of a mantissa that count. Rotations of shapes and what follows from them are computed by the machine's own sine, so the
/// last bits of a number say nothing about the body.
const MANTISSA: i32 = 40;
/// What a body had none of before there was such a thing counts only where it is there, after a number of its own: older fingerprints stay.
const ARMATURE: u64 = 0x6172_6d61;
const SPRING: u64 = 0x7370_7267;

impl CharacterModel {
    /// A number that is equal for two bodies when all of their numbers are: links and their names, joints, masses, inertias, servo
    /// gains, limits, contact points, blades, grips, shapes, pairs that collide, feet, trunk, steps per second. The character's own name does
    /// not count. Numbers are compared to 12 digits (below 1 to 1e-12 in their unit).
    pub fn fingerprint(&self) -> u64 {
        // Every type is taken apart field by field, so that a new field does not compile until it is decided here whether it counts.
        let CharacterModel { name: _, step_rate, links, contact_points, blades, grips, collision_pairs, feet, trunk } =
            self;
        let mut hash = Hash::new();
        hash.number(*step_rate);
        hash.list(links, Hash::link);
        hash.list(contact_points, Hash::contact_point);
        hash.list(blades, Hash::blade);
        hash.list(grips, Hash::grip);
        hash.list(collision_pairs, |hash, (a, b)| {
            hash.count(*a);
            hash.count(*b);
        });
        hash.list(feet, Hash::foot);
        hash.count(*trunk);
        hash.0
    }
}

struct Hash(u64);

impl Hash {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn whole(&mut self, value: u64) {
        for byte in value.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn count(&mut self, value: usize) {
        self.whole(value as u64);
    }

    /// Which of several kinds of thing follows.
    fn kind(&mut self, kind: u64) {
        self.whole(kind);
    }

    fn text(&mut self, text: &str) {
        self.count(text.len());
        for byte in text.bytes() {
            self.whole(u64::from(byte));
        }
    }

    fn number(&mut self, value: f64) {
        if !value.is_finite() {
            self.whole(value.to_bits());
            return;
        }
        // To the nearest of 2^40 numbers in each octave, and below 1 to the nearest multiple of 2^-40. Powers of two are exact.
        let exponent = (((value.to_bits() >> 52) & 0x7ff) as i32 - 1023).max(0);
        let unit = power_of_two(exponent - MANTISSA);
        // Plus zero, so that both zeros are one.
        self.whole(((value / unit).round() * unit + 0.0).to_bits());
    }

    fn vector(&mut self, value: DVec3) {
        value.to_array().into_iter().for_each(|v| self.number(v));
    }

    fn matrix(&mut self, value: DMat3) {
        value.to_cols_array().into_iter().for_each(|v| self.number(v));
    }

    fn rotation(&mut self, value: DQuat) {
        value.to_array().into_iter().for_each(|v| self.number(v));
    }

    fn list<T>(&mut self, items: &[T], each: impl Fn(&mut Self, &T)) {
        self.count(items.len());
        items.iter().for_each(|item| each(self, item));
    }

    fn option<T>(&mut self, value: &Option<T>, some: impl FnOnce(&mut Self, &T)) {
        self.kind(u64::from(value.is_some()));
        if let Some(value) = value {
            some(self, value);
        }
    }

    fn link(&mut self, link: &Link) {
        let Link {
            name,
            parent,
            joint,
            offset,
            mass,
            com,
            inertia,
            gains,
            max_torque,
            limits,
            armature,
            spring,
            shapes,
        } = link;
        self.text(name);
        self.option(parent, |hash, parent| hash.count(*parent));
        match joint {
            JointKind::Free => self.kind(0),
            JointKind::Ball => self.kind(1),
            JointKind::Hinge { axis } => {
                self.kind(2);
                self.vector(*axis);
            }
        }
        self.vector(*offset);
        self.number(*mass);
        self.vector(*com);
        self.matrix(*inertia);
        let Gains { kp, kd } = gains;
        self.number(*kp);
        self.number(*kd);
        self.number(*max_torque);
        self.option(limits, |hash, JointLimits { low, high }| {
            hash.vector(*low);
            hash.vector(*high);
        });
        if *armature != 0.0 {
            self.kind(ARMATURE);
            self.number(*armature);
        }
        if let Some(JointSpring { stiffness, damping, rest }) = spring {
            self.kind(SPRING);
            self.number(*stiffness);
            self.number(*damping);
            self.vector(*rest);
        }
        self.list(shapes, Self::shape);
    }

    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Box { center, half_extents, rotation } => {
                self.kind(0);
                self.vector(*center);
                self.vector(*half_extents);
                self.rotation(*rotation);
            }
            Shape::Capsule { a, b, radius } => {
                self.kind(1);
                self.vector(*a);
                self.vector(*b);
                self.number(*radius);
            }
            Shape::Sphere { center, radius } => {
                self.kind(2);
                self.vector(*center);
                self.number(*radius);
            }
        }
    }

    fn contact_point(&mut self, point: &ContactPoint) {
        let ContactPoint { name, link, position, radius, friction, kind, role } = point;
        self.text(name);
        self.count(*link);
        self.vector(*position);
        self.number(*radius);
        self.number(*friction);
        match kind {
            ContactKind::Point => self.kind(0),
            ContactKind::BladeToe(blade) => {
                self.kind(1);
                self.count(*blade);
            }
            ContactKind::BladeHeel(blade) => {
                self.kind(2);
                self.count(*blade);
            }
        }
        self.kind(match role {
            PointRole::Foot => 0,
            PointRole::Hand => 1,
            PointRole::Body => 2,
        });
    }

    fn foot(&mut self, foot: &Foot) {
        let Foot { side, kind, links, toe, heel } = foot;
        self.option(side, |hash, side| hash.kind(u64::from(*side == Side::Right)));
        match kind {
            FootKind::Sole => self.kind(0),
            FootKind::Blade(blade) => {
                self.kind(1);
                self.count(*blade);
            }
        }
        self.list(links, |hash, link| hash.count(*link));
        self.count(*toe);
        self.count(*heel);
    }

    fn blade(&mut self, blade: &Blade) {
        let Blade { name, link, toe, heel, inside, lean_law, bite } = blade;
        self.text(name);
        self.count(*link);
        self.count(*toe);
        self.count(*heel);
        self.vector(*inside);
        match lean_law {
            LeanLaw::DeadZone { dead_zone, gain } => {
                self.kind(0);
                self.number(*dead_zone);
                self.number(*gain);
            }
            LeanLaw::Rocker { radius } => {
                self.kind(1);
                self.number(*radius);
            }
        }
        self.option(bite, |hash, bite| hash.number(*bite));
    }

    fn grip(&mut self, grip: &Grip) {
        let Grip { name, link, position, max_force } = grip;
        self.text(name);
        self.count(*link);
        self.vector(*position);
        self.number(*max_force);
    }
}

/// Two to a power between -1022 and 1023.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}
