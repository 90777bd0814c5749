//! The athletes' own clock: pause and slow motion for them alone.

use bevy::prelude::*;
use std::time::Duration;

/// How fast time passes for athletes, counted in the fixed ticks of the game: a pause and slow motion of theirs alone, while everything
/// else goes on. Of a fixed tick they step the part that is due, and the steps stay the same steps: slow motion shows the same motion,
/// bit for bit, and snapshots know nothing of it. To slow down the whole game, see [`PlaybackSpeed`](super::PlaybackSpeed); to stop one
/// athlete, [`AthleteSettings::paused`](super::AthleteSettings::paused).
///
/// What athletes stand on goes on at the pace of the game: in slow motion a platform that moves runs away under them.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_athlete::engine::*;
/// // A replay in slow motion, while the crowd cheers on.
/// fn slow(mut time: ResMut<AthleteTime>) {
///     time.set_relative_speed(0.25);
/// }
/// # bevy::ecs::system::assert_is_system(slow);
/// ```
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default)]
pub struct AthleteTime {
    paused: bool,
    /// Millionths of the game's pace.
    pace: u64,
    /// Length of the last fixed tick for athletes.
    delta: Duration,
    elapsed: Duration,
    /// What the last tick was too short for, in millionths of a nanosecond.
    rest: u64,
}

impl Default for AthleteTime {
    fn default() -> Self {
        Self { paused: false, pace: Self::WHOLE, delta: Duration::ZERO, elapsed: Duration::ZERO, rest: 0 }
    }
}

impl AthleteTime {
    const WHOLE: u64 = 1_000_000;
    /// Fastest pace.
    const FASTEST: f32 = 10.0;

    /// Whether time stands still for athletes.
    pub fn is_paused(&self) -> bool {
        self.paused
    }
    /// Time stands still for athletes, from the next fixed tick on.
    pub fn pause(&mut self) {
        self.paused = true;
    }
    /// Time goes on.
    pub fn unpause(&mut self) {
        self.paused = false;
    }
    /// Simulated seconds per second of the fixed ticks, while it is not paused.
    pub fn relative_speed(&self) -> f32 {
        (self.pace as f64 / Self::WHOLE as f64) as f32
    }
    /// Sets it (0 to 10; what is outside is clamped, what is no number ignored).
    pub fn set_relative_speed(&mut self, speed: f32) {
        if speed.is_finite() {
            self.pace = (f64::from(speed.clamp(0.0, Self::FASTEST)) * Self::WHOLE as f64).round() as u64;
        }
    }
    /// Length of the last fixed tick for athletes; zero while they are paused.
    pub fn delta(&self) -> Duration {
        self.delta
    }
    /// Time that has passed for athletes.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }

    /// A fixed tick of the game of length `tick`. Whole nanoseconds pass; what is left over passes with the next.
    fn pass(&mut self, tick: Duration) {
        let pace = if self.paused { 0 } else { self.pace };
        let due = tick.as_nanos() * u128::from(pace) + u128::from(self.rest);
        let whole = u128::from(Self::WHOLE);
        self.delta = Duration::from_nanos(u64::try_from(due / whole).unwrap_or(u64::MAX));
        self.rest = (due % whole) as u64;
        self.elapsed = self.elapsed.saturating_add(self.delta);
    }
}

/// The clock goes on by a fixed tick. Nobody wished for that, so it is no change.
pub(super) fn pass_time(time: Res<Time>, mut athletes: ResMut<AthleteTime>) {
    athletes.bypass_change_detection().pass(time.delta());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost_at_any_pace() {
        let mut time = AthleteTime::default();
        let tick = Duration::from_micros(15_625);
        time.pass(tick);
        assert_eq!((time.delta(), time.elapsed()), (tick, tick));
        time.set_relative_speed(1.0 / 3.0);
        let before = time.elapsed();
        (0..64 * 3).for_each(|_| time.pass(tick));
        // A third in millionths, times three seconds.
        assert_eq!(time.elapsed() - before, Duration::from_nanos(999_999_000));
        time.pause();
        time.pass(tick);
        assert_eq!((time.delta(), time.is_paused()), (Duration::ZERO, true));
        time.unpause();
        time.set_relative_speed(f32::NAN);
        assert!((time.relative_speed() - 1.0 / 3.0).abs() < 1e-6);
        time.set_relative_speed(1e9);
        assert_eq!(time.relative_speed(), 10.0);
        time.set_relative_speed(-1.0);
        time.pass(tick);
        assert_eq!(time.delta(), Duration::ZERO);
    }
}
