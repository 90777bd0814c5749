//! The next obstacle, read from heights ahead.

use serde::{Deserialize, Serialize};

/// What an obstacle is to a runner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "engine", derive(bevy::reflect::Reflect))]
pub enum ObstacleKind {
    /// Higher ground that ends again soon: a box, a wall, a rail.
    Over,
    /// Higher ground that goes on.
    Up,
    /// Lower ground that goes on.
    Down,
    /// Lower ground between two edges.
    Gap,
}

/// The next obstacle ahead. Heights count from the ground before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// What it is.
    pub kind: ObstacleKind,
    /// From the runner to its beginning, m.
    pub distance: f64,
    /// Highest ground over its length, m; of a way down or a gap the lowest, which is negative.
    pub height: f64,
    /// Length along the way, m; as far as was looked where it goes on.
    pub depth: f64,
    /// Height of the ground behind it, m.
    pub behind: f64,
}

/// Heights up to this to either side are no obstacle, m.
const LEVEL: f64 = 0.07;
/// Ground that goes on for longer than this is no obstacle to cross but another level, m.
const GOES_ON: f64 = 1.2;
/// Lower ground that goes on for longer than this is no gap, m.
const WIDEST_GAP: f64 = 3.2;

impl Obstacle {
    /// The first obstacle in a profile of heights: `heights[k]` (m, against the ground under the runner) at `distances[k]` (m ahead, ascending). `None` where
    /// all is level, or the lists are empty. The place of an edge is half way between the samples around it.
    pub fn ahead(distances: &[f64], heights: &[f64]) -> Option<Self> {
        let count = distances.len().min(heights.len());
        let (distances, heights) = (&distances[..count], &heights[..count]);
        let mut ground = 0.0;
        let mut first = None;
        for (k, h) in heights.iter().enumerate() {
            if (h - ground).abs() > LEVEL {
                first = Some(k);
                break;
            }
            // A slope is followed, a bump is not.
            ground += (h - ground).clamp(-0.02, 0.02);
        }
        let first = first?;
        let edge = |k: usize| if k == 0 { distances[0] } else { 0.5 * (distances[k - 1] + distances[k]) };
        let start = edge(first);
        let rises = heights[first] > ground;
        // It ends where the ground is nearer to that before it than to its own. What goes on for longer is another level, and whatever comes on that
        // is the next obstacle.
        let longest = if rises { GOES_ON } else { WIDEST_GAP };
        let mut extreme = heights[first] - ground;
        let mut end = None;
        for (k, height) in heights.iter().enumerate().skip(first + 1) {
            if edge(k) - start > longest {
                break;
            }
            let h = height - ground;
            let over = if rises { h < 0.5 * extreme } else { h > 0.5 * extreme };
            if over {
                end = Some(k);
                break;
            }
            extreme = if rises { extreme.max(h) } else { extreme.min(h) };
        }
        let depth = end.map_or(distances[count - 1], edge) - start;
        let behind = end.map_or(extreme, |k| heights[k] - ground);
        let kind = match (rises, end.is_some()) {
            (true, true) => ObstacleKind::Over,
            (true, false) => ObstacleKind::Up,
            (false, true) => ObstacleKind::Gap,
            (false, false) => ObstacleKind::Down,
        };
        Some(Self { kind, distance: start, height: extreme, depth, behind })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(ground: impl Fn(f64) -> f64) -> Option<Obstacle> {
        let distances: Vec<f64> = (0..160).map(|k| 0.05 * f64::from(k)).collect();
        let heights: Vec<f64> = distances.iter().map(|d| ground(*d)).collect();
        Obstacle::ahead(&distances, &heights)
    }

    #[test]
    fn boxes_steps_ways_down_and_gaps_are_told_apart() {
        let found = seen(|d| if (3.0..3.4).contains(&d) { 0.8 } else { 0.0 }).unwrap();
        assert_eq!(found.kind, ObstacleKind::Over);
        assert!((found.distance - 3.0).abs() < 0.05 && (found.depth - 0.4).abs() < 0.06 && found.height == 0.8);
        assert_eq!(found.behind, 0.0);

        let found = seen(|d| if d > 2.0 { 0.5 } else { 0.0 }).unwrap();
        assert_eq!((found.kind, found.height, found.behind), (ObstacleKind::Up, 0.5, 0.5));

        let found = seen(|d| if d > 4.0 { -1.2 } else { 0.0 }).unwrap();
        assert_eq!((found.kind, found.height), (ObstacleKind::Down, -1.2));

        let found = seen(|d| if (4.0..6.0).contains(&d) { -2.0 } else { 0.3 * f64::from(u8::from(d >= 6.0)) }).unwrap();
        assert_eq!(found.kind, ObstacleKind::Gap);
        assert!((found.depth - 2.0).abs() < 0.06 && (found.behind - 0.3).abs() < 1e-9);

        // A box behind which the ground is lower.
        let found = seen(|d| {
            if d < 2.0 {
                0.0
            } else if d < 2.5 {
                0.6
            } else {
                -0.4
            }
        })
        .unwrap();
        assert_eq!((found.kind, found.height, found.behind), (ObstacleKind::Over, 0.6, -0.4));
    }

    /// A box on a platform, and a gap behind a way down, are not part of what is before them.
    #[test]
    fn what_comes_on_another_level_is_the_next_obstacle() {
        let found = seen(|d| {
            if d < 2.0 {
                0.0
            } else if d < 6.5 {
                0.5
            } else {
                1.3
            }
        })
        .unwrap();
        assert_eq!((found.kind, found.height, found.behind), (ObstacleKind::Up, 0.5, 0.5));
        let found = seen(|d| {
            if d < 1.0 {
                0.0
            } else if (5.0..6.0).contains(&d) {
                -1e9
            } else {
                -0.4
            }
        })
        .unwrap();
        assert_eq!((found.kind, found.height, found.behind), (ObstacleKind::Down, -0.4, -0.4));
    }

    #[test]
    fn level_ground_slopes_and_bumps_are_no_obstacles() {
        assert_eq!(seen(|_| 0.0), None);
        assert_eq!(seen(|d| 0.09 * d), None);
        assert_eq!(seen(|d| 0.03 * (9.0 * d).sin()), None);
        assert_eq!(Obstacle::ahead(&[], &[]), None);
    }
}
