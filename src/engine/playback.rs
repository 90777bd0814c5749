//! Pause and slow motion for everything that lives in virtual time.

use bevy::prelude::*;

/// How fast time passes. A change of it sets the speed of `Time<Virtual>`: fixed ticks come more rarely but stay the same
/// ticks, so slow motion shows the same motion, bit for bit. Everything else in virtual time slows down with it.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default)]
pub struct PlaybackSpeed {
    /// Simulated seconds per real second (0.01 to 10; what is outside is clamped).
    pub speed: f32,
    /// Time stands still.
    pub paused: bool,
}

impl Default for PlaybackSpeed {
    fn default() -> Self {
        Self { speed: 1.0, paused: false }
    }
}

impl PlaybackSpeed {
    /// The speed with anything outside the range, or no number, brought back into it.
    pub fn clamped_speed(&self) -> f32 {
        if self.speed.is_finite() { self.speed.clamp(0.01, 10.0) } else { 1.0 }
    }
}

/// Adds [`PlaybackSpeed`]. Leave it out where you set the speed of `Time<Virtual>` yourself.
#[derive(Debug, Default)]
pub struct AthletePlaybackPlugin;

impl Plugin for AthletePlaybackPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PlaybackSpeed>().add_systems(PreUpdate, apply_playback_speed);
    }
}

fn apply_playback_speed(playback: Res<PlaybackSpeed>, mut time: ResMut<Time<Virtual>>) {
    // What it holds at the start is not a wish: a speed set by someone else before stays.
    if !playback.is_changed() || playback.is_added() && *playback == PlaybackSpeed::default() {
        return;
    }
    time.set_relative_speed(playback.clamped_speed());
    if playback.paused {
        time.pause();
    } else {
        time.unpause();
    }
}
