//! Where and how fast trials begin: more often ahead of the places, and at the speeds, where trials fail.

use crate::math::RandomStream;

/// Ticks in a bin.
const BIN: usize = 4;
/// How many bins before a failure share the blame.
const LOOK_BACK: usize = 4;
/// Slices of the range of speeds.
const SPEEDS: usize = 5;
/// How fast old counts fade, per update.
const FADE: f64 = 0.97;

/// Draws starting ticks and speeds; counts where trials fail.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct StartSampler {
    last: usize,
    visits: Vec<f64>,
    failures: Vec<f64>,
    cumulative: Vec<f64>,
    cyclic: bool,
    /// Part of the starts that is even over the motion and the speeds.
    #[serde(default = "evenly")]
    even: f64,
    /// Part of the trials that begin as one began that soon failed.
    #[serde(default)]
    again: f64,
}

fn evenly() -> f64 {
    1.0
}

/// Visits and failures of one worker, by bin; the speeds of a place are neighbours.
#[derive(Clone, Debug)]
pub(crate) struct StartCounts {
    visits: Vec<f64>,
    failures: Vec<f64>,
}

impl StartCounts {
    /// A tick was passed at `tick`, in a trial at that part (0 to 1) of the range of speeds.
    pub fn visit(&mut self, tick: usize, speed: f64, failed: bool) {
        let slice = ((speed * SPEEDS as f64) as usize).min(SPEEDS - 1);
        let bin = ((tick / BIN) * SPEEDS + slice).min(self.visits.len() - 1);
        self.visits[bin] += 1.0;
        self.failures[bin] += f64::from(u8::from(failed));
    }
}

impl StartSampler {
    /// An even sampler for a motion whose last tick is `last`.
    pub fn even(last: usize, cyclic: bool) -> Self {
        Self::new(last, cyclic, evenly())
    }

    /// A sampler of whose starts the part `even` stays even.
    pub(crate) fn new(last: usize, cyclic: bool, even: f64) -> Self {
        let zeros = vec![0.0; last.max(1).div_ceil(BIN) * SPEEDS];
        let visits = vec![1.0; zeros.len()];
        let mut sampler = Self { last, visits, failures: zeros.clone(), cumulative: zeros, cyclic, even, again: 0.0 };
        sampler.refresh();
        sampler
    }

    /// How likely a trial lasts from the start of the motion to its end, by what was counted (0 to 1).
    fn lasting(&self) -> f64 {
        let sum = |counts: &[f64]| counts.iter().sum::<f64>();
        let places = self.visits.chunks(SPEEDS).zip(self.failures.chunks(SPEEDS));
        places
            .map(|(visits, failures)| (1.0 - sum(failures) / sum(visits).max(1.0)).max(0.0).powi(BIN as i32))
            .product()
    }

    /// Grows from 0 to 1 while a motion is learnt: 1 once one trial of four would last from its start to its end.
    pub(crate) fn ripeness(&self) -> f64 {
        (4.0 * self.lasting()).min(1.0)
    }

    /// Part of the trials that repeat a start that failed.
    pub(crate) fn again(&self) -> f64 {
        self.again
    }

    /// Which part of the trials repeats starts that failed.
    pub(crate) fn set_again(&mut self, again: f64) {
        self.again = again;
    }

    /// Which part of the starts stays even.
    pub(crate) fn set_even(&mut self, even: f64) {
        self.even = even;
        self.refresh();
    }

    /// Whether this sampler is for the same motion as another.
    pub(crate) fn fits(&self, other: &Self) -> bool {
        let lengths = |s: &Self| [s.visits.len(), s.failures.len(), s.cumulative.len(), s.last, usize::from(s.cyclic)];
        lengths(self) == lengths(other)
    }

    pub(crate) fn counts(&self) -> StartCounts {
        StartCounts { visits: vec![0.0; self.visits.len()], failures: vec![0.0; self.visits.len()] }
    }

    pub(crate) fn add(&mut self, counts: &[StartCounts]) {
        for (k, visits) in self.visits.iter_mut().enumerate() {
            *visits = *visits * FADE + counts.iter().map(|c| c.visits[k]).sum::<f64>();
        }
        for (k, failures) in self.failures.iter_mut().enumerate() {
            *failures = *failures * FADE + counts.iter().map(|c| c.failures[k]).sum::<f64>();
        }
        self.refresh();
    }

    fn refresh(&mut self) {
        let places = self.visits.len() / SPEEDS;
        let rate = |bin: usize| self.failures[bin] / self.visits[bin].max(1.0);
        let blame: Vec<f64> = (0..self.visits.len())
            .map(|bin| {
                let (place, slice) = (bin / SPEEDS, bin % SPEEDS);
                let after = place..place + LOOK_BACK;
                let within =
                    after.filter_map(|p| if self.cyclic { Some(p % places) } else { (p < places).then_some(p) });
                within.map(|p| rate(p * SPEEDS + slice)).sum()
            })
            .collect();
        let total: f64 = blame.iter().sum::<f64>().max(1e-9);
        let mut sum = 0.0;
        for (bin, cumulative) in self.cumulative.iter_mut().enumerate() {
            sum += self.even / blame.len() as f64 + (1.0 - self.even) * blame[bin] / total;
            *cumulative = sum;
        }
    }

    /// A starting tick, and which part (0 to 1) of the range of speeds.
    pub fn draw(&self, random: &mut RandomStream) -> (usize, f64) {
        let total = self.cumulative.last().copied().unwrap_or(1.0);
        let u = random.uniform() * total;
        let bin = self.cumulative.partition_point(|c| *c < u).min(self.cumulative.len() - 1);
        let tick = ((bin / SPEEDS) * BIN + random.below(BIN)).min(self.last.saturating_sub(1));
        (tick, ((bin % SPEEDS) as f64 + random.uniform()) / SPEEDS as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many of 10,000 starts lie in the first half of the motion, and how many in the lowest slice of the speeds.
    fn drawn(sampler: &StartSampler) -> (usize, usize) {
        let mut random = RandomStream::new(7, 1);
        let starts: Vec<_> = (0..10_000).map(|_| sampler.draw(&mut random)).collect();
        assert!(starts.iter().all(|(tick, part)| *tick < 80 && (0.0..1.0).contains(part)));
        let count = |test: &dyn Fn(&(usize, f64)) -> bool| starts.iter().filter(|s| test(s)).count();
        (count(&|s| s.0 < 40), count(&|s| s.1 < 1.0 / SPEEDS as f64))
    }

    #[test]
    fn starts_are_even_until_something_fails() {
        let (early, slow) = drawn(&StartSampler::new(80, false, 0.4));
        assert!((4_800..5_200).contains(&early), "{early}");
        assert!((1_800..2_200).contains(&slow), "{slow}");
    }

    #[test]
    fn more_trials_begin_ahead_of_failures_and_at_their_speed() {
        let mut sampler = StartSampler::new(80, false, 0.4);
        let mut counts = sampler.counts();
        for k in 0..8_000 {
            let (tick, part) = (k % 80, (k / 80) as f64 / 100.0);
            counts.visit(tick, part, tick == 60 && part < 0.1);
        }
        sampler.add(&[counts]);
        let (early, slow) = drawn(&sampler);
        // Four of ten starts are even; the others are at the slow speeds shortly before tick 60.
        assert!((1_800..2_200).contains(&early), "{early}");
        assert!((6_600..7_000).contains(&slow), "{slow}");
    }

    #[test]
    fn a_motion_is_lasted_through_as_its_ticks_are() {
        let mut sampler = StartSampler::even(80, false);
        assert_eq!(sampler.lasting(), 1.0);
        let mut counts = sampler.counts();
        // One of a thousand fails at each tick.
        for k in 0..80_000 {
            counts.visit(k % 80, 0.5, k / 80 == 7);
        }
        sampler.add(&[counts]);
        assert!((sampler.lasting() - 0.999_f64.powi(80)).abs() < 1e-3, "{}", sampler.lasting());
    }

    #[test]
    fn samplers_of_different_motions_do_not_fit() {
        let sampler = StartSampler::even(80, false);
        assert!(sampler.fits(&StartSampler::even(80, false)));
        assert!(!sampler.fits(&StartSampler::even(40, false)) && !sampler.fits(&StartSampler::even(80, true)));
    }
}
