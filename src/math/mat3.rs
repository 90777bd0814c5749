//! 3 x 3 matrices over lanes: general and symmetric.

use crate::math::{Real, Vec3};
use core::ops::{Add, AddAssign, Mul, Sub};
use glam::DMat3;

/// A general 3 x 3 matrix, stored by columns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mat3<R> {
    /// First column.
    pub x: Vec3<R>,
    /// Second column.
    pub y: Vec3<R>,
    /// Third column.
    pub z: Vec3<R>,
}

impl<R: Real> Mat3<R> {
    /// A matrix from its columns.
    #[inline(always)]
    pub fn from_columns(x: Vec3<R>, y: Vec3<R>, z: Vec3<R>) -> Self {
        Self { x, y, z }
    }
    /// The zero matrix.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::from_columns(Vec3::zero(), Vec3::zero(), Vec3::zero())
    }
    /// The unit matrix.
    #[inline(always)]
    pub fn identity() -> Self {
        Self::diagonal(R::one())
    }
    /// `s` times the unit matrix.
    #[inline(always)]
    pub fn diagonal(s: R) -> Self {
        let o = R::zero();
        Self::from_columns(Vec3::new(s, o, o), Vec3::new(o, s, o), Vec3::new(o, o, s))
    }
    /// The same matrix in every lane.
    #[inline]
    pub fn splat(m: DMat3) -> Self {
        Self::from_columns(Vec3::splat(m.x_axis), Vec3::splat(m.y_axis), Vec3::splat(m.z_axis))
    }
    /// The matrix of lane `index`.
    pub fn lane(self, index: usize) -> DMat3 {
        DMat3::from_cols(self.x.lane(index), self.y.lane(index), self.z.lane(index))
    }
    /// The cross-product matrix: `skew(a) b = a x b`.
    #[inline(always)]
    pub fn skew(a: Vec3<R>) -> Self {
        let o = R::zero();
        Self::from_columns(Vec3::new(o, a.z, -a.y), Vec3::new(-a.z, o, a.x), Vec3::new(a.y, -a.x, o))
    }
    /// Matrix times vector.
    #[inline(always)]
    pub fn mul_vec(&self, v: Vec3<R>) -> Vec3<R> {
        self.z.mul_add(v.z, self.y.mul_add(v.y, self.x * v.x))
    }
    /// Transposed matrix times vector.
    #[inline(always)]
    pub fn tr_mul_vec(&self, v: Vec3<R>) -> Vec3<R> {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
    /// `self v + c`.
    #[inline(always)]
    pub fn mul_vec_add(&self, v: Vec3<R>, c: Vec3<R>) -> Vec3<R> {
        self.z.mul_add(v.z, self.y.mul_add(v.y, self.x.mul_add(v.x, c)))
    }
    /// `c - self v`.
    #[inline(always)]
    pub fn mul_vec_sub_from(&self, v: Vec3<R>, c: Vec3<R>) -> Vec3<R> {
        self.z.neg_mul_add(v.z, self.y.neg_mul_add(v.y, self.x.neg_mul_add(v.x, c)))
    }
    /// `self^T v + c`.
    #[inline(always)]
    pub fn tr_mul_vec_add(&self, v: Vec3<R>, c: Vec3<R>) -> Vec3<R> {
        Vec3::new(self.x.dot_add(v, c.x), self.y.dot_add(v, c.y), self.z.dot_add(v, c.z))
    }
    /// Matrix product.
    #[inline(always)]
    pub fn mul_mat(&self, b: &Self) -> Self {
        Self::from_columns(self.mul_vec(b.x), self.mul_vec(b.y), self.mul_vec(b.z))
    }
    /// Transposed matrix.
    #[inline(always)]
    pub fn transpose(&self) -> Self {
        Self::from_columns(
            Vec3::new(self.x.x, self.y.x, self.z.x),
            Vec3::new(self.x.y, self.y.y, self.z.y),
            Vec3::new(self.x.z, self.y.z, self.z.z),
        )
    }
    /// `skew(a) * self`: the vector product of `a` with every column.
    #[inline(always)]
    pub fn cross_columns(a: Vec3<R>, m: &Self) -> Self {
        Self::from_columns(a.cross(m.x), a.cross(m.y), a.cross(m.z))
    }
    /// `a b^T`.
    #[inline(always)]
    pub fn outer(a: Vec3<R>, b: Vec3<R>) -> Self {
        Self::from_columns(a * b.x, a * b.y, a * b.z)
    }
    /// `self + skew(a)`.
    #[inline(always)]
    pub fn add_skew(&self, a: Vec3<R>) -> Self {
        let Self { x, y, z } = *self;
        Self::from_columns(
            Vec3::new(x.x, x.y + a.z, x.z - a.y),
            Vec3::new(y.x - a.z, y.y, y.z + a.x),
            Vec3::new(z.x + a.y, z.y - a.x, z.z),
        )
    }
    /// `self + skew(a) m`.
    #[inline(always)]
    pub fn add_cross_columns(&self, a: Vec3<R>, m: &Sym3<R>) -> Self {
        let m = m.to_mat3();
        Self::from_columns(a.cross_add(m.x, self.x), a.cross_add(m.y, self.y), a.cross_add(m.z, self.z))
    }
    /// `self + m skew(a)`.
    #[inline(always)]
    pub fn add_mul_skew(&self, m: &Self, a: Vec3<R>) -> Self {
        Self::from_columns(
            m.z.neg_mul_add(a.y, m.y.mul_add(a.z, self.x)),
            m.x.neg_mul_add(a.z, m.z.mul_add(a.x, self.y)),
            m.y.neg_mul_add(a.x, m.x.mul_add(a.y, self.z)),
        )
    }
    /// `self - a b`.
    #[inline(always)]
    pub fn sub_product(&self, a: &Self, b: &Self) -> Self {
        Self::from_columns(
            a.mul_vec_sub_from(b.x, self.x),
            a.mul_vec_sub_from(b.y, self.y),
            a.mul_vec_sub_from(b.z, self.z),
        )
    }
    /// Every entry times `s`.
    #[inline(always)]
    pub fn scale(&self, s: R) -> Self {
        Self::from_columns(self.x * s, self.y * s, self.z * s)
    }
}

impl<R: Real> Add for Mat3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self::from_columns(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}
impl<R: Real> Sub for Mat3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self::from_columns(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}

/// A symmetric 3 x 3 matrix: six values.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sym3<R> {
    /// Diagonal entry (0, 0).
    pub xx: R,
    /// Diagonal entry (1, 1).
    pub yy: R,
    /// Diagonal entry (2, 2).
    pub zz: R,
    /// Entry (0, 1) = (1, 0).
    pub xy: R,
    /// Entry (0, 2) = (2, 0).
    pub xz: R,
    /// Entry (1, 2) = (2, 1).
    pub yz: R,
}

impl<R: Real> Sym3<R> {
    /// The zero matrix.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::diagonal(R::zero())
    }
    /// `s` times the unit matrix.
    #[inline(always)]
    pub fn diagonal(s: R) -> Self {
        let o = R::zero();
        Self { xx: s, yy: s, zz: s, xy: o, xz: o, yz: o }
    }
    /// The same matrix in every lane; the lower triangle of `m` is ignored.
    #[inline(always)]
    pub fn splat(m: DMat3) -> Self {
        Self {
            xx: R::splat(m.x_axis.x),
            yy: R::splat(m.y_axis.y),
            zz: R::splat(m.z_axis.z),
            xy: R::splat(m.y_axis.x),
            xz: R::splat(m.z_axis.x),
            yz: R::splat(m.z_axis.y),
        }
    }
    /// The symmetric part of a general matrix is assumed: the upper triangle is read.
    #[inline(always)]
    pub fn from_upper(m: &Mat3<R>) -> Self {
        Self { xx: m.x.x, yy: m.y.y, zz: m.z.z, xy: m.y.x, xz: m.z.x, yz: m.z.y }
    }
    /// As a general matrix.
    #[inline(always)]
    pub fn to_mat3(self) -> Mat3<R> {
        Mat3::from_columns(
            Vec3::new(self.xx, self.xy, self.xz),
            Vec3::new(self.xy, self.yy, self.yz),
            Vec3::new(self.xz, self.yz, self.zz),
        )
    }
    /// `m + m^T`.
    #[inline(always)]
    pub fn sum_with_transpose(m: &Mat3<R>) -> Self {
        Self {
            xx: m.x.x + m.x.x,
            yy: m.y.y + m.y.y,
            zz: m.z.z + m.z.z,
            xy: m.y.x + m.x.y,
            xz: m.z.x + m.x.z,
            yz: m.z.y + m.y.z,
        }
    }
    /// `a b^T`, known to be symmetric.
    #[inline(always)]
    pub fn outer(a: Vec3<R>, b: Vec3<R>) -> Self {
        Self { xx: a.x * b.x, yy: a.y * b.y, zz: a.z * b.z, xy: a.x * b.y, xz: a.x * b.z, yz: a.y * b.z }
    }
    /// `s (|a|^2 1 - a a^T)`: what a mass `s` at `a` adds to the rotational inertia about the origin.
    #[inline(always)]
    pub fn parallel_axis(s: R, a: Vec3<R>) -> Self {
        let (sx, sy, sz) = (a.x * s, a.y * s, a.z * s);
        let (xx, yy, zz) = (sx * a.x, sy * a.y, sz * a.z);
        Self { xx: yy + zz, yy: xx + zz, zz: xx + yy, xy: -(sx * a.y), xz: -(sx * a.z), yz: -(sy * a.z) }
    }
    /// `self + s (|a|^2 1 - a a^T)`.
    #[inline(always)]
    pub fn add_parallel_axis(&self, s: R, a: Vec3<R>) -> Self {
        let (sx, sy, sz) = (a.x * s, a.y * s, a.z * s);
        Self {
            xx: sy.mul_add(a.y, sz.mul_add(a.z, self.xx)),
            yy: sx.mul_add(a.x, sz.mul_add(a.z, self.yy)),
            zz: sx.mul_add(a.x, sy.mul_add(a.y, self.zz)),
            xy: sx.neg_mul_add(a.y, self.xy),
            xz: sx.neg_mul_add(a.z, self.xz),
            yz: sy.neg_mul_add(a.z, self.yz),
        }
    }
    /// `r * self * r^T`.
    #[inline(always)]
    pub fn rotated_by(&self, r: &Mat3<R>) -> Self {
        let a = r.mul_mat(&self.to_mat3());
        Self::product_upper(&a, &r.transpose())
    }
    /// `r * diag(d) * r^T`.
    #[inline(always)]
    pub fn rotated_diagonal(d: Vec3<R>, r: &Mat3<R>) -> Self {
        let (a, b, c) = (r.x * d.x, r.y * d.y, r.z * d.z);
        let entry = |ax: R, rx: R, bx: R, ry: R, cx: R, rz: R| cx.mul_add(rz, bx.mul_add(ry, ax * rx));
        Self {
            xx: entry(a.x, r.x.x, b.x, r.y.x, c.x, r.z.x),
            yy: entry(a.y, r.x.y, b.y, r.y.y, c.y, r.z.y),
            zz: entry(a.z, r.x.z, b.z, r.y.z, c.z, r.z.z),
            xy: entry(a.x, r.x.y, b.x, r.y.y, c.x, r.z.y),
            xz: entry(a.x, r.x.z, b.x, r.y.z, c.x, r.z.z),
            yz: entry(a.y, r.x.z, b.y, r.y.z, c.y, r.z.z),
        }
    }
    /// The upper triangle of `a * b`, for products known to be symmetric.
    #[inline(always)]
    pub fn product_upper(a: &Mat3<R>, b: &Mat3<R>) -> Self {
        let entry = |r0: R, r1: R, r2: R, c: Vec3<R>| r2.mul_add(c.z, r1.mul_add(c.y, r0 * c.x));
        Self {
            xx: entry(a.x.x, a.y.x, a.z.x, b.x),
            yy: entry(a.x.y, a.y.y, a.z.y, b.y),
            zz: entry(a.x.z, a.y.z, a.z.z, b.z),
            xy: entry(a.x.x, a.y.x, a.z.x, b.y),
            xz: entry(a.x.x, a.y.x, a.z.x, b.z),
            yz: entry(a.x.y, a.y.y, a.z.y, b.z),
        }
    }
    /// The upper triangle of `a^T * b`, for products known to be symmetric.
    #[inline(always)]
    pub fn tr_product_upper(a: &Mat3<R>, b: &Mat3<R>) -> Self {
        Self {
            xx: a.x.dot(b.x),
            yy: a.y.dot(b.y),
            zz: a.z.dot(b.z),
            xy: a.x.dot(b.y),
            xz: a.x.dot(b.z),
            yz: a.y.dot(b.z),
        }
    }
    /// Matrix times vector.
    #[inline(always)]
    pub fn mul_vec(&self, v: Vec3<R>) -> Vec3<R> {
        Vec3::new(
            self.xz.mul_add(v.z, self.xy.mul_add(v.y, self.xx * v.x)),
            self.yz.mul_add(v.z, self.yy.mul_add(v.y, self.xy * v.x)),
            self.zz.mul_add(v.z, self.yz.mul_add(v.y, self.xz * v.x)),
        )
    }
    /// `self v + c`.
    #[inline(always)]
    pub fn mul_vec_add(&self, v: Vec3<R>, c: Vec3<R>) -> Vec3<R> {
        Vec3::new(
            self.xz.mul_add(v.z, self.xy.mul_add(v.y, self.xx.mul_add(v.x, c.x))),
            self.yz.mul_add(v.z, self.yy.mul_add(v.y, self.xy.mul_add(v.x, c.y))),
            self.zz.mul_add(v.z, self.yz.mul_add(v.y, self.xz.mul_add(v.x, c.z))),
        )
    }
    /// `self + a b`, for products known to be symmetric.
    #[inline(always)]
    pub fn add_product(&self, a: &Mat3<R>, b: &Mat3<R>) -> Self {
        let entry = |c: R, r0: R, r1: R, r2: R, v: Vec3<R>| r2.mul_add(v.z, r1.mul_add(v.y, r0.mul_add(v.x, c)));
        Self {
            xx: entry(self.xx, a.x.x, a.y.x, a.z.x, b.x),
            yy: entry(self.yy, a.x.y, a.y.y, a.z.y, b.y),
            zz: entry(self.zz, a.x.z, a.y.z, a.z.z, b.z),
            xy: entry(self.xy, a.x.x, a.y.x, a.z.x, b.y),
            xz: entry(self.xz, a.x.x, a.y.x, a.z.x, b.z),
            yz: entry(self.yz, a.x.y, a.y.y, a.z.y, b.z),
        }
    }
    /// `self - a b`, where the sum of all such products is known to be symmetric.
    #[inline(always)]
    pub fn sub_product(&self, a: &Mat3<R>, b: &Mat3<R>) -> Self {
        let entry =
            |c: R, r0: R, r1: R, r2: R, v: Vec3<R>| r2.neg_mul_add(v.z, r1.neg_mul_add(v.y, r0.neg_mul_add(v.x, c)));
        Self {
            xx: entry(self.xx, a.x.x, a.y.x, a.z.x, b.x),
            yy: entry(self.yy, a.x.y, a.y.y, a.z.y, b.y),
            zz: entry(self.zz, a.x.z, a.y.z, a.z.z, b.z),
            xy: entry(self.xy, a.x.x, a.y.x, a.z.x, b.y),
            xz: entry(self.xz, a.x.x, a.y.x, a.z.x, b.z),
            yz: entry(self.yz, a.x.y, a.y.y, a.z.y, b.z),
        }
    }
    /// `self - a^T b`, for products known to be symmetric.
    #[inline(always)]
    pub fn sub_tr_product(&self, a: &Mat3<R>, b: &Mat3<R>) -> Self {
        let entry = |c: R, u: Vec3<R>, v: Vec3<R>| u.z.neg_mul_add(v.z, u.y.neg_mul_add(v.y, u.x.neg_mul_add(v.x, c)));
        Self {
            xx: entry(self.xx, a.x, b.x),
            yy: entry(self.yy, a.y, b.y),
            zz: entry(self.zz, a.z, b.z),
            xy: entry(self.xy, a.x, b.y),
            xz: entry(self.xz, a.x, b.z),
            yz: entry(self.yz, a.y, b.z),
        }
    }
    /// `self - a b^T`, for products known to be symmetric.
    #[inline(always)]
    pub fn sub_outer(&self, a: Vec3<R>, b: Vec3<R>) -> Self {
        Self {
            xx: a.x.neg_mul_add(b.x, self.xx),
            yy: a.y.neg_mul_add(b.y, self.yy),
            zz: a.z.neg_mul_add(b.z, self.zz),
            xy: a.x.neg_mul_add(b.y, self.xy),
            xz: a.x.neg_mul_add(b.z, self.xz),
            yz: a.y.neg_mul_add(b.z, self.yz),
        }
    }
    /// `self - h skew(d) + skew(d) g^T`, where the sum is known to be symmetric: an inertia seen from another point.
    #[inline(always)]
    pub fn add_skew_products(&self, d: Vec3<R>, h: &Mat3<R>, g: &Mat3<R>) -> Self {
        // Column j of -h skew(d) is h (e_j x d); row i of skew(d) g^T picks row i of d x (row of g).
        let entry = |c: R, h1: R, d1: R, h2: R, d2: R| h2.neg_mul_add(d2, h1.mul_add(d1, c));
        let left = Self {
            xx: entry(self.xx, h.z.x, d.y, h.y.x, d.z),
            yy: entry(self.yy, h.x.y, d.z, h.z.y, d.x),
            zz: entry(self.zz, h.y.z, d.x, h.x.z, d.y),
            xy: entry(self.xy, h.x.x, d.z, h.z.x, d.x),
            xz: entry(self.xz, h.y.x, d.x, h.x.x, d.y),
            yz: entry(self.yz, h.y.y, d.x, h.x.y, d.y),
        };
        Self {
            xx: entry(left.xx, g.z.x, d.y, g.y.x, d.z),
            yy: entry(left.yy, g.x.y, d.z, g.z.y, d.x),
            zz: entry(left.zz, g.y.z, d.x, g.x.z, d.y),
            xy: entry(left.xy, g.z.y, d.y, g.y.y, d.z),
            xz: entry(left.xz, g.z.z, d.y, g.y.z, d.z),
            yz: entry(left.yz, g.x.z, d.z, g.z.z, d.x),
        }
    }
    /// Symmetric times general matrix.
    #[inline(always)]
    pub fn mul_mat(&self, m: &Mat3<R>) -> Mat3<R> {
        Mat3::from_columns(self.mul_vec(m.x), self.mul_vec(m.y), self.mul_vec(m.z))
    }
    /// Inverse by cofactors. The caller guarantees a positive definite matrix; a singular one gives infinities.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let xx = self.yz.neg_mul_add(self.yz, self.yy * self.zz);
        let xy = self.xy.neg_mul_add(self.zz, self.xz * self.yz);
        let xz = self.xz.neg_mul_add(self.yy, self.xy * self.yz);
        let det = self.xz.mul_add(xz, self.xy.mul_add(xy, self.xx * xx));
        let s = det.recip();
        Self {
            xx: xx * s,
            xy: xy * s,
            xz: xz * s,
            yy: self.xz.neg_mul_add(self.xz, self.xx * self.zz) * s,
            yz: self.xx.neg_mul_add(self.yz, self.xy * self.xz) * s,
            zz: self.xy.neg_mul_add(self.xy, self.xx * self.yy) * s,
        }
    }
    /// Every entry times `s`.
    #[inline(always)]
    pub fn scale(&self, s: R) -> Self {
        Self { xx: self.xx * s, yy: self.yy * s, zz: self.zz * s, xy: self.xy * s, xz: self.xz * s, yz: self.yz * s }
    }
    /// `self + s 1`.
    #[inline(always)]
    pub fn add_diagonal(&self, s: R) -> Self {
        Self { xx: self.xx + s, yy: self.yy + s, zz: self.zz + s, ..*self }
    }
}

impl<R: Real> Add for Sym3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self {
            xx: self.xx + b.xx,
            yy: self.yy + b.yy,
            zz: self.zz + b.zz,
            xy: self.xy + b.xy,
            xz: self.xz + b.xz,
            yz: self.yz + b.yz,
        }
    }
}
impl<R: Real> Sub for Sym3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self {
            xx: self.xx - b.xx,
            yy: self.yy - b.yy,
            zz: self.zz - b.zz,
            xy: self.xy - b.xy,
            xz: self.xz - b.xz,
            yz: self.yz - b.yz,
        }
    }
}
impl<R: Real> AddAssign for Sym3<R> {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}
impl<R: Real> Mul<R> for Sym3<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: R) -> Self {
        self.scale(s)
    }
}
