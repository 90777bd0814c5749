//! The convex hull of what touches, seen from above.

use glam::DVec2;

/// Most corners that are kept.
pub const MOST_CORNERS: usize = 64;

/// A convex polygon, counter-clockwise. Places are (x, -z), m: to the right and ahead of a body that faces -Z.
#[derive(Clone, Copy, Debug)]
pub struct Hull {
    corners: [DVec2; MOST_CORNERS],
    count: usize,
}

impl Default for Hull {
    fn default() -> Self {
        Self { corners: [DVec2::ZERO; MOST_CORNERS], count: 0 }
    }
}

impl Hull {
    /// The hull of these points, by the monotone chain (Andrew 1979); the first 64 count. Allocates nothing.
    pub fn of(points: impl Iterator<Item = DVec2>) -> Self {
        let mut sorted = [DVec2::ZERO; MOST_CORNERS];
        let mut count = 0;
        for p in points.take(MOST_CORNERS) {
            sorted[count] = p;
            count += 1;
        }
        let sorted = &mut sorted[..count];
        sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        let mut hull = Self::default();
        if count < 3 {
            hull.corners[..count].copy_from_slice(sorted);
            hull.count = count;
            return hull;
        }
        // Lower chain, then upper.
        let mut chain = [DVec2::ZERO; 2 * MOST_CORNERS];
        let mut length = 0;
        let mut from = 0;
        for pass in 0..2 {
            for k in 0..count {
                let p = if pass == 0 { sorted[k] } else { sorted[count - 1 - k] };
                while length >= from + 2
                    && (chain[length - 1] - chain[length - 2]).perp_dot(p - chain[length - 1]) <= 0.0
                {
                    length -= 1;
                }
                chain[length] = p;
                length += 1;
            }
            // The last of a chain is the first of the next.
            length -= 1;
            from = length;
        }
        hull.count = length.clamp(1, MOST_CORNERS);
        hull.corners[..hull.count].copy_from_slice(&chain[..hull.count]);
        hull
    }

    /// Its corners.
    pub fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// The middle of its area; of its corners where it has none. `None` for an empty hull.
    pub fn middle(&self) -> Option<DVec2> {
        let corners = self.corners();
        let first = *corners.first()?;
        let (mut area, mut sum) = (0.0, DVec2::ZERO);
        for pair in corners.windows(2) {
            let (a, b) = (pair[0] - first, pair[1] - first);
            let twice = a.perp_dot(b);
            area += twice;
            sum += (a + b) * (twice / 3.0);
        }
        let mean = corners.iter().sum::<DVec2>() / corners.len() as f64;
        Some(if area > 1e-8 { first + sum / area } else { mean })
    }

    /// The point of the hull, shrunk about its middle by the part `margin`, that is nearest to `place`.
    pub fn nearest(&self, place: DVec2, margin: f64) -> Option<DVec2> {
        let middle = self.middle()?;
        let corners = self.corners();
        let at = |k: usize| middle + (corners[k % corners.len()] - middle) * (1.0 - margin);
        let inside =
            corners.len() > 2 && (0..corners.len()).all(|k| (at(k + 1) - at(k)).perp_dot(place - at(k)) >= 0.0);
        if inside {
            return Some(place);
        }
        let on_edge = |k: usize| {
            let (a, b) = (at(k), at(k + 1));
            let along = b - a;
            let part = ((place - a).dot(along) / along.length_squared().max(1e-18)).clamp(0.0, 1.0);
            a + along * part
        };
        let distance = |p: &DVec2| (*p - place).length_squared();
        (0..corners.len()).map(on_edge).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}
