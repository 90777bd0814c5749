//! When things happen: the sets that all systems of the athletes are in.

use bevy::ecs::system::NonSendMarker;
use bevy::prelude::*;

/// What an athlete goes through in a fixed tick: chained sets in `FixedPostUpdate`, and one before `Update`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AthleteSystems {
    /// The world is brought up to date ([`AthleteWorld`](super::AthleteWorld)), athletes whose files have arrived get their bodies.
    ReadWorld,
    /// Controllers, resets and targets are handed to the bodies.
    Control,
    /// All bodies step.
    Step,
    /// Poses are written and events told.
    WriteBack,
    /// In `RunFixedMainLoop`, after the fixed ticks: poses between ticks, the athlete's `Transform`.
    Interpolate,
}

/// Ahead of a system in a pipe: it keeps the system on the main thread. The systems of a tick follow each other, and most are
/// short: to wake another thread for each costs more than they do. The step spreads over the pool from there.
pub(super) fn on_main_thread(_: NonSendMarker) {}
