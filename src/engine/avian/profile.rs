//! Solids of revolution: cylinders and cones.

use bevy::math::{DVec2, DVec3};

/// A convex outline turned about the Y axis: (radius, height) from the top of the axis down to its bottom, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    points: [DVec2; 4],
    count: usize,
}

impl Profile {
    /// A cylinder about Y.
    pub fn cylinder(half_height: f64, radius: f64) -> Self {
        let point = DVec2::new;
        Self {
            points: [
                point(0.0, half_height),
                point(radius, half_height),
                point(radius, -half_height),
                point(0.0, -half_height),
            ],
            count: 4,
        }
    }

    /// A cone about Y, its tip up.
    pub fn cone(half_height: f64, radius: f64) -> Self {
        let point = DVec2::new;
        let bottom = point(0.0, -half_height);
        Self { points: [point(0.0, half_height), point(radius, -half_height), bottom, bottom], count: 3 }
    }

    /// Signed distance and outward unit normal.
    pub fn distance(&self, p: DVec3) -> (f64, DVec3) {
        let radius = (p.x * p.x + p.z * p.z).sqrt();
        let outward = if radius > 1e-9 { DVec2::new(p.x, p.z) / radius } else { DVec2::X };
        let flat = DVec2::new(radius, p.y);
        let (mut inside, mut best) = (true, (f64::INFINITY, DVec2::Y));
        for pair in self.points[..self.count].windows(2) {
            let (a, along) = (pair[0], pair[1] - pair[0]);
            let Some(direction) = along.try_normalize() else { continue };
            // Going down the outline, the outside is to the left hand.
            let normal = DVec2::new(-direction.y, direction.x);
            let height = normal.dot(flat - a);
            inside &= height <= 0.0;
            let s = direction.dot(flat - a).clamp(0.0, along.length());
            let way = flat - (a + direction * s);
            let distance = way.length();
            if distance < best.0 {
                // On the segment's own line the normal is better conditioned than the way.
                let beside = distance > height.abs() + 1e-9;
                best = (distance, if beside { way / distance } else { normal });
            }
        }
        let (distance, n) = best;
        (if inside { -distance } else { distance }, DVec3::new(n.x * outward.x, n.y, n.x * outward.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cylinders_and_cones_have_their_distances() {
        let cylinder = Profile::cylinder(0.5, 0.2);
        for (p, distance, normal) in [
            (DVec3::new(0.0, 0.7, 0.1), 0.2, DVec3::Y),
            (DVec3::new(0.0, -0.6, 0.0), 0.1, DVec3::NEG_Y),
            (DVec3::new(0.5, 0.1, 0.0), 0.3, DVec3::X),
            (DVec3::new(0.0, 0.1, -0.15), -0.05, DVec3::NEG_Z),
            (DVec3::new(0.5, 0.9, 0.0), 0.5, DVec3::new(0.6, 0.8, 0.0)),
        ] {
            let (d, n) = cylinder.distance(p);
            assert!((d - distance).abs() < 1e-12 && (n - normal).length() < 1e-9, "{p}: {d}, {n}");
        }
        // The side of this cone has the normal (0.8, 0.6).
        let cone = Profile::cone(0.4, 0.6);
        let on_side = DVec3::new(0.3, 0.0, 0.0);
        let n = DVec3::new(0.8, 0.6, 0.0);
        for depth in [0.1, -0.05, 1e-12] {
            let (d, normal) = cone.distance(on_side + n * depth);
            assert!((d - depth).abs() < 1e-12 && (normal - n).length() < 1e-9, "{d}, {normal}");
        }
        assert_eq!(cone.distance(DVec3::new(0.1, -0.5, 0.0)).1, DVec3::NEG_Y);
    }
}
