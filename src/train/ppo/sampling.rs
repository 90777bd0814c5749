//! Where and how fast episodes begin: more often ahead of the places, and at the speeds, where episodes fail.
//!
//! An episode of the training ends by limits that are narrower than what counts in the end, and by its exploration. So how often a
//! speed is drawn also follows from how often measured trials at that speed fail ([`StartSampler::weigh_speeds`]).

use crate::math::RandomStream;

/// Ticks in a bin.
const BIN: usize = 4;
/// How many bins before a failure share the blame.
const LOOK_BACK: usize = 4;
/// Slices of the range of speeds by which failures are counted.
const SPEEDS: usize = 5;
/// Parts of such a slice that are weighed.
const FINE: usize = 3;
/// Parts of the range of speeds that are weighed.
pub(crate) const SPEED_PARTS: usize = SPEEDS * FINE;
/// How fast old counts fade, per update.
const FADE: f64 = 0.97;

/// Draws starting ticks and speeds; counts where episodes fail.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct StartSampler {
    last: usize,
    visits: Vec<f64>,
    failures: Vec<f64>,
    cumulative: Vec<f64>,
    cyclic: bool,
    /// Part of the starts that is uniform over the motion and the speeds.
    #[serde(default = "all_uniform", alias = "even")]
    uniform_share: f64,
    /// Part of the episodes that begin as one began that failed.
    #[serde(default, alias = "again")]
    replay_share: f64,
    /// How much more each part of the speeds is to blame than what was counted says.
    #[serde(default = "as_counted")]
    weights: [f64; SPEED_PARTS],
}

fn as_counted() -> [f64; SPEED_PARTS] {
    [1.0; SPEED_PARTS]
}

fn all_uniform() -> f64 {
    1.0
}

/// Visits and failures of one worker, by bin; the speeds of a place are neighbours.
#[derive(Clone, Debug)]
pub(crate) struct StartCounts {
    visits: Vec<f64>,
    failures: Vec<f64>,
}

impl StartCounts {
    /// A tick was passed at `tick`, in an episode at that part (0 to 1) of the range of speeds.
    pub fn visit(&mut self, tick: usize, speed: f64, failed: bool) {
        let slice = ((speed * SPEEDS as f64) as usize).min(SPEEDS - 1);
        let bin = ((tick / BIN) * SPEEDS + slice).min(self.visits.len() - 1);
        self.visits[bin] += 1.0;
        self.failures[bin] += f64::from(u8::from(failed));
    }
}

impl StartSampler {
    /// A uniform sampler for a motion whose last tick is `last`.
    pub fn uniform(last: usize, cyclic: bool) -> Self {
        Self::new(last, cyclic, all_uniform())
    }

    /// A sampler of whose starts the part `uniform_share` stays uniform.
    pub(crate) fn new(last: usize, cyclic: bool, uniform_share: f64) -> Self {
        let zeros = vec![0.0; last.max(1).div_ceil(BIN) * SPEEDS];
        let visits = vec![1.0; zeros.len()];
        let mut sampler = Self {
            last,
            visits,
            failures: zeros.clone(),
            cumulative: zeros,
            cyclic,
            uniform_share,
            replay_share: 0.0,
            weights: as_counted(),
        };
        sampler.refresh();
        sampler
    }

    /// How likely an episode lasts from the start of the motion to its end, by what was counted (0 to 1).
    fn lasting(&self) -> f64 {
        let sum = |counts: &[f64]| counts.iter().sum::<f64>();
        let places = self.visits.chunks(SPEEDS).zip(self.failures.chunks(SPEEDS));
        places
            .map(|(visits, failures)| (1.0 - sum(failures) / sum(visits).max(1.0)).max(0.0).powi(BIN as i32))
            .product()
    }

    /// Grows from 0 to 1 while a motion is learnt: 1 once one episode of four would last from its start to its end.
    pub(crate) fn ripeness(&self) -> f64 {
        (4.0 * self.lasting()).min(1.0)
    }

    /// Part of the episodes that repeat a start that failed.
    pub(crate) fn replay_share(&self) -> f64 {
        self.replay_share
    }

    /// Which part of the episodes repeats starts that failed.
    pub(crate) fn set_replay_share(&mut self, share: f64) {
        self.replay_share = share;
    }

    /// Which part of the starts stays uniform.
    pub(crate) fn set_uniform_share(&mut self, share: f64) {
        self.uniform_share = share;
        self.refresh();
    }

    /// Weighs what was counted at each part of the speeds. What is not a positive number counts as 1.
    pub(crate) fn weigh_speeds(&mut self, weights: [f64; SPEED_PARTS]) {
        self.weights = weights.map(|w| if w > 0.0 && w.is_finite() { w } else { 1.0 });
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
                mean(self.fine(slice)) * within.map(|p| rate(p * SPEEDS + slice)).sum::<f64>()
            })
            .collect();
        let total: f64 = blame.iter().sum::<f64>().max(1e-9);
        let mut sum = 0.0;
        for (bin, cumulative) in self.cumulative.iter_mut().enumerate() {
            sum += self.uniform_share / blame.len() as f64 + (1.0 - self.uniform_share) * blame[bin] / total;
            *cumulative = sum;
        }
    }

    /// Weights of the parts of a slice.
    fn fine(&self, slice: usize) -> &[f64] {
        &self.weights[slice * FINE..(slice + 1) * FINE]
    }

    /// Where (0 to 1) in its slice a speed lies that is the part `u` of all of the bin's.
    fn within_slice(&self, bin: usize, u: f64) -> f64 {
        let weights = self.fine(bin % SPEEDS);
        if weights.iter().all(|w| *w == weights[0]) {
            return u;
        }
        let before = bin.checked_sub(1).map_or(0.0, |b| self.cumulative[b]);
        let all = self.cumulative[bin] - before;
        // What is uniform over the speeds stays so.
        let uniform = (self.uniform_share / self.cumulative.len() as f64).min(all);
        let mut left = u * all;
        for (part, weight) in weights.iter().enumerate() {
            let share = (uniform + (all - uniform) * weight / mean(weights)) / FINE as f64;
            if left < share {
                return (part as f64 + left / share) / FINE as f64;
            }
            left -= share;
        }
        u
    }

    /// A starting tick, and which part (0 to 1) of the range of speeds.
    pub fn draw(&self, random: &mut RandomStream) -> (usize, f64) {
        let total = self.cumulative.last().copied().unwrap_or(1.0);
        let u = random.uniform() * total;
        let bin = self.cumulative.partition_point(|c| *c < u).min(self.cumulative.len() - 1);
        let tick = ((bin / SPEEDS) * BIN + random.below(BIN)).min(self.last.saturating_sub(1));
        (tick, ((bin % SPEEDS) as f64 + self.within_slice(bin, random.uniform())) / SPEEDS as f64)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
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
    fn starts_are_uniform_until_something_fails() {
        let (early, slow) = drawn(&StartSampler::new(80, false, 0.4));
        assert!((4_800..5_200).contains(&early), "{early}");
        assert!((1_800..2_200).contains(&slow), "{slow}");
    }

    #[test]
    fn more_episodes_begin_ahead_of_failures_and_at_their_speed() {
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
    fn speeds_at_which_measured_trials_fail_are_drawn_more_often() {
        let mut sampler = StartSampler::new(80, false, 0.4);
        let mut counts = sampler.counts();
        for k in 0..80 * 900 {
            let (tick, part) = (k % 80, (k / 80) as f64 / 900.0);
            counts.visit(tick, part, tick == 60 && k / 80 % 10 == 0);
        }
        sampler.add(&[counts]);
        // How many of 10,000 starts lie in the slowest fifteenth of the speeds, and how many in the next.
        let slowest = |sampler: &StartSampler| {
            let mut random = RandomStream::new(7, 1);
            let parts: Vec<_> = (0..10_000).map(|_| sampler.draw(&mut random).1 * SPEED_PARTS as f64).collect();
            [0.0, 1.0].map(|from| parts.iter().filter(|p| (from..from + 1.0).contains(*p)).count())
        };
        let even = |[first, second]: [usize; 2]| (580..760).contains(&first) && (580..760).contains(&second);
        assert!(even(slowest(&sampler)), "as often as the others: {:?}", slowest(&sampler));
        let mut weights = as_counted();
        weights[0] = SPEED_PARTS as f64 - 1.0;
        sampler.weigh_speeds(weights);
        // Half of the six of ten starts that are not even, and a fifteenth of the others.
        let [first, second] = slowest(&sampler);
        assert!((3_070..3_470).contains(&first), "{first}");
        // Of the fourteen other parts, each has a fourteenth of the other half.
        assert!((400..560).contains(&second), "{second}");
        sampler.weigh_speeds([f64::NAN; SPEED_PARTS]);
        assert!(even(slowest(&sampler)), "{:?}", slowest(&sampler));
    }

    #[test]
    fn a_motion_is_lasted_through_as_its_ticks_are() {
        let mut sampler = StartSampler::uniform(80, false);
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
        let sampler = StartSampler::uniform(80, false);
        assert!(sampler.fits(&StartSampler::uniform(80, false)));
        assert!(!sampler.fits(&StartSampler::uniform(40, false)) && !sampler.fits(&StartSampler::uniform(80, true)));
    }
}
