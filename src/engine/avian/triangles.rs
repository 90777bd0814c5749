//! The nearest point of a set of triangles, and on which side of them a point lies.

use crate::math::half_angle_over_sine;
use bevy::math::DVec3;

/// Points nearer to each other than this are one, m: an edge or corner that several triangles share.
const SAME: f64 = 1e-6;

/// Where on a triangle its nearest point lies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Feature {
    /// In the inside of the face.
    Face,
    /// On an edge.
    Edge,
    /// At the corner of this number.
    Corner(usize),
}

/// The point of a triangle that is nearest to `p`. Ericson 2005, "Real-Time Collision Detection", section 5.1.5: `d1` to
/// `d6` are the projections of the ways from the corners to `p` on the two edges at `a`; their signs name the region.
fn closest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> (DVec3, Feature) {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Feature::Corner(0));
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Feature::Corner(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), Feature::Edge);
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Feature::Corner(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), Feature::Edge);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return (b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), Feature::Edge);
    }
    let scale = 1.0 / (va + vb + vc);
    (a + ab * (vb * scale) + ac * (vc * scale), Feature::Face)
}

/// The angle of a triangle at a corner, rad.
fn corner_angle(triangle: [DVec3; 3], corner: usize) -> f64 {
    let [at, next, last] = [0, 1, 2].map(|k| triangle[(corner + k) % 3]);
    let cosine = (next - at).normalize_or_zero().dot((last - at).normalize_or_zero()).clamp(-1.0, 1.0);
    let half = ((1.0 + cosine) * 0.5).sqrt();
    2.0 * half_angle_over_sine(half) * (1.0 - half * half).max(0.0).sqrt()
}

/// The nearest of the triangles that it is told of.
///
/// Triangles are solid behind their front, the side from which their corners go round counter-clockwise. At an edge or a
/// corner the side is told by the mean of the normals that meet there, weighted with the angles (Baerentzen and Aanaes 2005,
/// "Signed Distance Computation Using the Angle Weighted Pseudonormal").
#[derive(Clone, Copy, Debug)]
pub(super) struct NearestFace {
    point: DVec3,
    squared: f64,
    closest: DVec3,
    /// Sum of the normals that meet at `closest`.
    normal: DVec3,
    /// All normals that meet there are the same.
    flat: bool,
}

impl NearestFace {
    /// None yet, as seen from `point`.
    pub fn new(point: DVec3) -> Self {
        Self { point, squared: f64::INFINITY, closest: point, normal: DVec3::ZERO, flat: true }
    }

    /// Takes a triangle into account; one without an area is passed over. Returns false if it was not the nearest or if its
    /// nearest point is inside it: then no other triangle can share that point.
    pub fn add(&mut self, triangle: [DVec3; 3]) -> bool {
        let [a, b, c] = triangle;
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { return false };
        let (closest, feature) = closest_on_triangle(self.point, triangle);
        let weight = match feature {
            Feature::Face => 1.0,
            Feature::Edge => core::f64::consts::PI,
            Feature::Corner(k) => corner_angle(triangle, k),
        };
        // In the inside of a face the plane is better conditioned than the difference of two near points.
        let squared = match feature {
            Feature::Face => (self.point - a).dot(normal).powi(2),
            _ => (self.point - closest).length_squared(),
        };
        if squared.is_finite() && (closest - self.closest).length_squared() < SAME * SAME && self.squared.is_finite() {
            let first = self.normal.normalize_or_zero();
            self.flat &= (first - normal).length_squared() < 1e-14;
            self.normal += normal * weight;
            self.squared = self.squared.min(squared);
        } else if squared < self.squared {
            let shared = !matches!(feature, Feature::Face);
            *self = Self { point: self.point, squared, closest, normal: normal * weight, flat: true };
            return shared;
        }
        false
    }

    /// Where it is nearest.
    pub fn closest(&self) -> DVec3 {
        self.closest
    }

    /// Signed distance and outward unit normal; `None` without a triangle.
    pub fn distance(&self) -> Option<(f64, DVec3)> {
        if !self.squared.is_finite() {
            return None;
        }
        let mean = self.normal.try_normalize()?;
        let way = self.point - self.closest;
        if self.flat && way.cross(mean).length_squared() < SAME * SAME {
            return Some((way.dot(mean), mean));
        }
        // Beside flat ground: beyond its border, where nothing is solid.
        let sign = if way.dot(mean) < 0.0 && !self.flat { -1.0 } else { 1.0 };
        let distance = self.squared.sqrt();
        Some((sign * distance, if distance > SAME { way * (sign / distance) } else { mean }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cube of half edge 0.5 as twelve triangles, counter-clockwise from outside.
    fn cube() -> Vec<[DVec3; 3]> {
        let mut triangles = Vec::new();
        for axis in 0..3 {
            for side in [-0.5, 0.5] {
                let corner = |u: f64, v: f64| {
                    let mut p = DVec3::ZERO;
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
                    p
                };
                let mut quad = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
                if side < 0.0 {
                    quad.reverse();
                }
                triangles.push([quad[0], quad[1], quad[2]]);
                triangles.push([quad[0], quad[2], quad[3]]);
            }
        }
        triangles
    }

    #[test]
    fn a_cube_of_triangles_has_the_distances_of_a_cube() {
        let cube = cube();
        let mut worst: f64 = 0.0;
        for k in 0..4000 {
            let p = DVec3::new(f64::from(k % 17), f64::from(k % 13), f64::from(k % 11)) * 0.11 - DVec3::splat(0.83);
            let q = p.abs() - DVec3::splat(0.5);
            let expected = q.max(DVec3::ZERO).length() + q.max_element().min(0.0);
            let mut nearest = NearestFace::new(p);
            for triangle in &cube {
                nearest.add(*triangle);
            }
            let (distance, normal) = nearest.distance().unwrap();
            worst = worst.max((distance - expected).abs());
            assert!((normal.length() - 1.0).abs() < 1e-12, "{p}: normal {normal}");
        }
        println!("largest difference {worst:.1e} m, allowed 1e-12");
        assert!(worst < 1e-12);
    }

    #[test]
    fn on_flat_ground_edges_and_corners_are_not_felt() {
        // A square of four triangles about its middle; the point stands exactly over the middle and over an edge.
        let corners = [DVec3::X, -DVec3::Z, -DVec3::X, DVec3::Z];
        for at in [DVec3::ZERO, DVec3::X * 0.25, DVec3::new(0.2, 0.0, -0.1)] {
            for height in [0.3, 2e-4, 1e-7, -2e-4] {
                let mut nearest = NearestFace::new(at + DVec3::Y * height);
                for k in 0..4 {
                    nearest.add([DVec3::ZERO, corners[k], corners[(k + 1) % 4]]);
                }
                assert_eq!(nearest.distance(), Some((height, DVec3::Y)), "at {at}, {height} m");
            }
        }
    }
}
