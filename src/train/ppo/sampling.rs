//! Where trials begin: more often ahead of the places where trials fail.

use crate::math::RandomStream;

/// Ticks in a bin.
const BIN: usize = 4;
/// How many bins before a failure share the blame.
const LOOK_BACK: usize = 4;
/// Part of the starts that is even over the motion.
const EVEN: f64 = 0.4;
/// How fast old counts fade, per update.
const FADE: f64 = 0.97;

/// Draws starting ticks; counts where trials fail.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct StartSampler {
    last: usize,
    visits: Vec<f64>,
    failures: Vec<f64>,
    cumulative: Vec<f64>,
    cyclic: bool,
}

/// Visits and failures of one worker, by bin.
#[derive(Clone, Debug)]
pub(crate) struct StartCounts {
    visits: Vec<f64>,
    failures: Vec<f64>,
}

impl StartCounts {
    /// A tick was passed at `tick`.
    pub fn visit(&mut self, tick: usize, failed: bool) {
        let bin = (tick / BIN).min(self.visits.len() - 1);
        self.visits[bin] += 1.0;
        self.failures[bin] += f64::from(u8::from(failed));
    }
}

impl StartSampler {
    /// An even sampler for a motion whose last tick is `last`.
    pub fn even(last: usize, cyclic: bool) -> Self {
        let bins = last.max(1).div_ceil(BIN);
        let mut sampler =
            Self { last, visits: vec![1.0; bins], failures: vec![0.0; bins], cumulative: vec![0.0; bins], cyclic };
        sampler.refresh();
        sampler
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
        let n = self.visits.len();
        let rate = |bin: usize| self.failures[bin] / self.visits[bin].max(1.0);
        let blame: Vec<f64> = (0..n)
            .map(|bin| {
                let after = bin..bin + LOOK_BACK;
                let within = after.filter_map(|b| if self.cyclic { Some(b % n) } else { (b < n).then_some(b) });
                within.map(rate).sum()
            })
            .collect();
        let total: f64 = blame.iter().sum::<f64>().max(1e-9);
        let mut sum = 0.0;
        for (bin, cumulative) in self.cumulative.iter_mut().enumerate() {
            sum += EVEN / n as f64 + (1.0 - EVEN) * blame[bin] / total;
            *cumulative = sum;
        }
    }

    /// A starting tick.
    pub fn draw(&self, random: &mut RandomStream) -> usize {
        let total = self.cumulative.last().copied().unwrap_or(1.0);
        let u = random.uniform() * total;
        let bin = self.cumulative.partition_point(|c| *c < u);
        (bin * BIN + random.below(BIN)).min(self.last.saturating_sub(1))
    }
}
