//! Figures of the simulation in Bevy's `DiagnosticsStore`.

use crate::engine::AthleteSystems;
use crate::engine::schedule::on_main_thread;
use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::prelude::*;

/// What the last fixed tick took.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(super) struct StepTally {
    /// Time on the clock for all bodies together, ms.
    pub milliseconds: f64,
    /// Bodies that were stepped.
    pub bodies: usize,
    /// Their steps, all together.
    pub steps: u64,
    /// Bodies that are quarantined.
    pub quarantined: usize,
}

/// Adds figures of every fixed tick to Bevy's `DiagnosticsStore`, to be read or logged like any others.
#[derive(Debug, Default)]
pub struct AthleteDiagnosticsPlugin;

impl AthleteDiagnosticsPlugin {
    /// Time on the clock that a fixed tick took to step all bodies, ms.
    pub const STEP_TIME: DiagnosticPath = DiagnosticPath::const_new("athlete/step_time");
    /// Bodies that were stepped in a fixed tick.
    pub const BODIES: DiagnosticPath = DiagnosticPath::const_new("athlete/bodies");
    /// Simulation steps in a fixed tick, of all bodies together.
    pub const STEPS: DiagnosticPath = DiagnosticPath::const_new("athlete/steps");
    /// Bodies that are quarantined.
    pub const QUARANTINED: DiagnosticPath = DiagnosticPath::const_new("athlete/quarantined");
}

impl Plugin for AthleteDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        app.register_diagnostic(Diagnostic::new(Self::STEP_TIME).with_suffix(" ms"))
            .register_diagnostic(Diagnostic::new(Self::BODIES))
            .register_diagnostic(Diagnostic::new(Self::STEPS))
            .register_diagnostic(Diagnostic::new(Self::QUARANTINED))
            .init_resource::<StepTally>()
            .add_systems(FixedPostUpdate, on_main_thread.pipe(measure).in_set(AthleteSystems::WriteBack));
    }
}

fn measure(tally: Res<StepTally>, mut diagnostics: Diagnostics) {
    diagnostics.add_measurement(&AthleteDiagnosticsPlugin::STEP_TIME, || tally.milliseconds);
    diagnostics.add_measurement(&AthleteDiagnosticsPlugin::BODIES, || tally.bodies as f64);
    diagnostics.add_measurement(&AthleteDiagnosticsPlugin::STEPS, || tally.steps as f64);
    diagnostics.add_measurement(&AthleteDiagnosticsPlugin::QUARANTINED, || tally.quarantined as f64);
}
