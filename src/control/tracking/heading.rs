//! A direction in the ground plane, as cosine and sine: no trigonometric function is needed to turn or compare.

use crate::math::{Quat, Real, Vec3};

/// A turn about the vertical by the angle theta (positive to the left, seen from above counter-clockwise): cosine and
/// sine.
#[derive(Clone, Copy, Debug)]
pub struct Heading<R> {
    /// cos(theta).
    pub c: R,
    /// sin(theta).
    pub s: R,
}

impl<R: Real> Heading<R> {
    /// No turn: facing -Z.
    pub fn ahead() -> Self {
        Self { c: R::one(), s: R::zero() }
    }
    /// The heading of an orientation: where its -Z axis points over the ground. Of a body that faces straight up or down
    /// the result is not meaningful, but finite.
    #[inline(always)]
    pub fn of(rotation: Quat<R>) -> Self {
        let back = rotation.rotate(Vec3::new(R::zero(), R::zero(), R::one()));
        Self { c: back.z, s: back.x }.normalized()
    }
    /// Length of the part over the ground of an orientation's -Z axis, 0 to 1: at 0 it has no heading.
    #[inline(always)]
    pub fn certainty(rotation: Quat<R>) -> R {
        let back = rotation.rotate(Vec3::new(R::zero(), R::zero(), R::one()));
        back.x.mul_add(back.x, back.z * back.z).sqrt()
    }
    /// The heading of a direction over the ground.
    pub fn towards(direction: glam::DVec3) -> Self {
        Self { c: R::splat(-direction.z), s: R::splat(-direction.x) }.normalized()
    }
    /// The angle of the turn, rad, from -pi to pi.
    pub fn angle(self) -> R {
        self.to_quat().to_rotation_vector().y
    }
    /// Unit length again.
    #[inline(always)]
    pub fn normalized(self) -> Self {
        let length = self.c.mul_add(self.c, self.s * self.s).sqrt().max(R::splat(1e-6));
        let inverse = length.recip();
        Self { c: self.c * inverse, s: self.s * inverse }
    }
    /// From this heading's axes to world axes.
    #[inline(always)]
    pub fn to_world(self, v: Vec3<R>) -> Vec3<R> {
        Vec3::new(self.c * v.x + self.s * v.z, v.y, self.c * v.z - self.s * v.x)
    }
    /// From world axes to this heading's axes.
    #[inline(always)]
    pub fn to_local(self, v: Vec3<R>) -> Vec3<R> {
        Vec3::new(self.c * v.x - self.s * v.z, v.y, self.c * v.z + self.s * v.x)
    }
    /// Both turns, one after the other.
    #[inline(always)]
    pub fn turned(self, by: Self) -> Self {
        Self { c: self.c * by.c - self.s * by.s, s: self.s * by.c + self.c * by.s }
    }
    /// The turn from `other` to this heading.
    #[inline(always)]
    pub fn relative_to(self, other: Self) -> Self {
        self.turned(Self { c: other.c, s: -other.s })
    }
    /// The same turn as a quaternion, by half-angle formulas.
    #[inline(always)]
    pub fn to_quat(self) -> Quat<R> {
        let half = R::splat(0.5);
        let root = |x: R| (x.max(R::zero()) * half).sqrt().max(R::splat(1e-9));
        let (near, far) = (root(R::one() + self.c), root(R::one() - self.c));
        let far = R::select(self.s.lt(R::zero()), -far, far);
        let back = self.c.lt(R::zero());
        let w = R::select(back, self.s * half / far, near);
        let y = R::select(back, far, self.s * half / near);
        Quat { v: Vec3::new(R::zero(), y, R::zero()), w }
    }
}
