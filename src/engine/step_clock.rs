//! The clock of a body.

use std::time::Duration;

/// Counts the steps that are due, in integers: nothing is lost, and no frame length matters.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StepClock {
    /// Time not yet stepped, in 1e-15 steps.
    pub remainder: u128,
}

impl StepClock {
    /// 1e9 ns/s times 1e6 (rates are counted in millionths of a hertz).
    const STEP: u128 = 1_000_000_000_000_000;

    /// The most that can be left over, in 1e-15 steps: a change of rate multiplies it.
    pub const MOST: u128 = 1000 * Self::STEP;

    fn micro_hertz(rate: f64) -> u128 {
        (rate * 1e6).round().max(0.0) as u128
    }

    /// Whole steps after another `dt`.
    pub fn take(&mut self, dt: Duration, rate: f64) -> u32 {
        self.remainder += dt.as_nanos() * Self::micro_hertz(rate);
        let due = self.remainder / Self::STEP;
        self.remainder %= Self::STEP;
        u32::try_from(due).unwrap_or(u32::MAX)
    }

    /// The same time in steps of another rate.
    pub fn change_rate(&mut self, from: f64, to: f64) {
        self.remainder = self.remainder * Self::micro_hertz(to) / Self::micro_hertz(from).max(1);
    }

    /// Time not yet stepped, s.
    pub fn remainder_seconds(&self, rate: f64) -> f64 {
        self.remainder as f64 / Self::STEP as f64 / rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_minute_of_ticks_is_a_minute_of_steps() {
        let mut clock = StepClock::default();
        let mut steps = 0;
        for _ in 0..64 * 60 {
            let due = clock.take(Duration::from_micros(15_625), 1200.0);
            assert!(due == 18 || due == 19);
            steps += due;
        }
        assert_eq!(steps, 1200 * 60);
        assert_eq!(clock.remainder, 0);
    }

    #[test]
    fn a_change_of_rate_keeps_the_time() {
        let mut clock = StepClock::default();
        assert_eq!(clock.take(Duration::from_micros(15_625), 1200.0), 18);
        clock.change_rate(1200.0, 600.0);
        // 15 of 20 steps are done; 0.75 of a step of 1200 Hz are left, 0.375 of one of 600 Hz.
        assert!((clock.remainder_seconds(600.0) - 0.75 / 1200.0).abs() < 1e-15);
        assert_eq!(clock.take(Duration::from_micros(15_625), 600.0), 9);
        clock.change_rate(600.0, 1200.0);
        assert_eq!(clock.take(Duration::from_micros(31_250), 1200.0), 39);
    }
}
