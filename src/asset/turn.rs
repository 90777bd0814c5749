//! Rotations between poses, without the platform's trigonometry: the same bits on every machine.

use crate::math::half_angle_over_sine;
use glam::{DQuat, DVec3};

/// `sin(x)` for `x` in [0, pi/2]: the Taylor series to the 19th power, error below 3e-16.
fn sine(x: f64) -> f64 {
    let x2 = x * x;
    let mut sum = 1.0;
    for k in (1..10).rev() {
        let n = 2.0 * f64::from(k);
        sum = 1.0 - x2 / (n * (n + 1.0)) * sum;
    }
    x * sum
}

/// Spherical interpolation along the shorter arc (Shoemake, 1985, "Animating Rotation with Quaternion Curves"):
/// `q = a sin((1 - s) h) / sin(h) + b sin(s h) / sin(h)` with `cos(h) = a . b`, `s` in [0, 1].
///
/// Rotations closer than 1e-8 rad are mixed linearly. At exactly half a turn apart either arc may come out.
pub(crate) fn slerp(a: DQuat, b: DQuat, s: f64) -> DQuat {
    let dot = a.dot(b);
    let (b, dot) = if dot < 0.0 { (-b, -dot) } else { (b, dot) };
    let dot = dot.min(1.0);
    let sine_h = (1.0 - dot * dot).sqrt();
    if sine_h < 1e-8 {
        return unit(a * (1.0 - s) + b * s);
    }
    let h = half_angle_over_sine(dot) * sine_h;
    unit(a * (sine((1.0 - s) * h) / sine_h) + b * (sine(s * h) / sine_h))
}

/// The rotation vector of a unit quaternion, rad: angle in [0, pi], error below 1e-8. Zero for the zero quaternion.
pub(crate) fn rotation_vector(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    q.xyz_vector() * (2.0 * half_angle_over_sine(q.w.min(1.0)))
}

/// The rotation by a rotation vector of a length up to pi, rad: the inverse of [`rotation_vector`].
pub(crate) fn rotation_by(r: DVec3) -> DQuat {
    let half = 0.5 * r.length();
    if half < 1e-12 {
        return unit(DQuat::from_xyzw(0.5 * r.x, 0.5 * r.y, 0.5 * r.z, 1.0));
    }
    let v = r * (0.5 * sine(half) / half);
    unit(DQuat::from_xyzw(v.x, v.y, v.z, sine(std::f64::consts::FRAC_PI_2 - half)))
}

/// The part of a rotation that turns about the unit axis (the twist of the swing-twist decomposition). Identity where
/// the rotation is half a turn about an axis across.
pub(crate) fn twist(q: DQuat, axis: DVec3) -> DQuat {
    let v = axis * q.xyz_vector().dot(axis);
    unit(DQuat::from_xyzw(v.x, v.y, v.z, q.w))
}

/// Scaled to unit length; identity where there is no length.
pub(crate) fn unit(q: DQuat) -> DQuat {
    let length = q.length_squared().sqrt();
    if length > 1e-12 && length.is_finite() { q * (1.0 / length) } else { DQuat::IDENTITY }
}

trait VectorPart {
    fn xyz_vector(self) -> DVec3;
}
impl VectorPart for DQuat {
    fn xyz_vector(self) -> DVec3 {
        DVec3::new(self.x, self.y, self.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the library's own (which uses the platform's trigonometry).
    #[test]
    fn slerp_and_rotation_vector_agree_with_trigonometry() {
        let mut worst: f64 = 0.0;
        for i in 0..200 {
            let k = f64::from(i);
            let a = DQuat::from_euler(glam::EulerRot::XYZ, k, 0.7 * k, 1.3 * k);
            let turn = DVec3::new((0.3 * k).sin(), (0.9 * k).cos(), (1.7 * k).sin()).normalize() * (k * 0.0155);
            let b = a * DQuat::from_scaled_axis(turn);
            let s = k / 199.0;
            let expected = a * DQuat::from_scaled_axis(turn * s);
            worst = worst.max((slerp(a, b, s).conjugate() * expected).to_scaled_axis().length());
            worst = worst.max((rotation_vector(a.inverse() * b) - turn).length());
            worst =
                worst.max((rotation_by(turn).conjugate() * DQuat::from_scaled_axis(turn)).to_scaled_axis().length());
        }
        println!("largest difference {worst:.1e} rad, allowed 3e-8");
        assert!(worst < 3e-8);
        assert_eq!(slerp(DQuat::IDENTITY, DQuat::from_rotation_x(1.0), 0.0), DQuat::IDENTITY);
    }
}
