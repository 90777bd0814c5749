//! How a parameter of a skill moves its reference: a higher obstacle lifts the flight over it, a farther one lengthens the run-up.

use crate::control::tracking::mirror::image;
use glam::DVec3;

/// A motion moved along one direction by how much a parameter differs from the value that the motion was made for, times a profile
/// over its ticks.
#[derive(Clone, Debug, PartialEq)]
pub struct Warp {
    /// Index of the parameter.
    parameter: usize,
    /// Its value in the motion as it is.
    neutral: f64,
    /// Unit vector in the clip's own world, times the factor.
    direction: DVec3,
    /// Factor at each tick, and its change in a second.
    profile: Vec<(f64, f64)>,
}

impl Warp {
    /// A warp of a motion with `ticks` ticks at `rate` ticks per second. `profile` are times (s, ascending) and factors, joined by smooth
    /// steps; before the first and after the last the factor stays.
    pub fn new(
        parameter: usize,
        neutral: f64,
        direction: DVec3,
        profile: &[(f64, f64)],
        ticks: usize,
        rate: f64,
    ) -> Self {
        let profile = (0..ticks).map(|k| smooth(profile, k as f64 / rate)).collect();
        Self { parameter, neutral, direction, profile }
    }

    /// By how much tick `index` is moved for these values of the parameters (m), and the velocity of that (m/s).
    pub fn offset(&self, index: usize, values: &[f64]) -> (DVec3, DVec3) {
        let by = values.get(self.parameter).map_or(0.0, |v| v - self.neutral);
        let (factor, change) = self.profile[index.min(self.profile.len() - 1)];
        (self.direction * (by * factor), self.direction * (by * change))
    }

    /// The warp of the mirrored motion.
    pub fn mirrored(&self) -> Self {
        Self { direction: image(self.direction), ..self.clone() }
    }
}

/// A curve through points, flat at each of them, and its slope: between two of them `3 s^2 - 2 s^3` of the way.
fn smooth(points: &[(f64, f64)], t: f64) -> (f64, f64) {
    let Some(&(first, before)) = points.first() else { return (0.0, 0.0) };
    if t <= first {
        return (before, 0.0);
    }
    for pair in points.windows(2) {
        let ((t0, a), (t1, b)) = (pair[0], pair[1]);
        if t < t1 {
            let (s, span) = ((t - t0) / (t1 - t0), t1 - t0);
            return (a + (b - a) * s * s * (3.0 - 2.0 * s), (b - a) * 6.0 * s * (1.0 - s) / span);
        }
    }
    (points[points.len() - 1].1, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warp_is_smooth_and_its_velocity_is_its_slope() {
        let rate = 1000.0;
        let warp = Warp::new(1, 0.5, DVec3::Y, &[(0.2, 0.0), (0.5, 1.0), (0.6, 1.0), (0.9, 0.0)], 1200, rate);
        let at = |k: usize| warp.offset(k, &[7.0, 0.6]);
        assert_eq!(at(0).0, DVec3::ZERO);
        assert!((at(550).0 - DVec3::Y * 0.1).length() < 1e-12);
        assert_eq!(at(5000).0, DVec3::ZERO, "beyond the end the last factor stays");
        for k in 1..1199 {
            let slope = (at(k + 1).0 - at(k - 1).0) * (0.5 * rate);
            assert!((slope - at(k).1).length() < 5e-3, "tick {k}: {slope} {}", at(k).1);
        }
        assert_eq!(warp.offset(550, &[]).0, DVec3::ZERO, "without parameters it does nothing");
    }
}
