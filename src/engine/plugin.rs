//! The plugin group, the system sets and the core plugin.

use crate::engine::detail::choose_detail;
use crate::engine::diagnostics::StepTally;
use crate::engine::history;
use crate::engine::{
    Athlete, AthleteAssetPlugin, AthleteBudget, AthleteController, AthleteDetail, AthleteDiagnosticsPlugin,
    AthleteFell, AthleteForces, AthleteLanes, AthleteLod, AthleteLodReport, AthletePlaybackPlugin, AthleteQuarantined,
    AthleteRefused, AthleteReset, AthleteRewind, AthleteSettings, AthleteSkinPlugin, AthleteTargets, AthleteViewer,
    AthleteWorld, BladeEdgeChanged, ControlFinished, Landing, LinkPoses, PlaybackSpeed, SkatingProgram,
    SkillController, SkillEnded, SkillStarted, Steering, TakeOff, forces, spawn, systems,
};
use bevy::app::{PluginGroupBuilder, RunFixedMainLoopSystems};
use bevy::ecs::system::NonSendMarker;
use bevy::prelude::*;

/// What an athlete goes through in a fixed tick: chained sets in `FixedPostUpdate`, and one before `Update`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AthleteSystems {
    /// The world is brought up to date ([`AthleteWorld`]), athletes whose files have arrived get their bodies.
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

/// All plugins of this crate; the table is in the [module's documentation](crate::engine).
#[derive(Debug, Default)]
pub struct AthletePlugins;

impl PluginGroup for AthletePlugins {
    fn build(self) -> PluginGroupBuilder {
        let group = PluginGroupBuilder::start::<Self>()
            .add(AthleteAssetPlugin)
            .add(AthleteSimulationPlugin)
            .add(AthletePlaybackPlugin)
            .add(AthleteDiagnosticsPlugin)
            .add(AthleteSkinPlugin);
        #[cfg(feature = "render")]
        let group = group.add(crate::engine::AthleteRenderPlugin);
        group
    }
}

/// Bodies, stepping, write-back, events, interpolation.
#[derive(Debug, Default)]
pub struct AthleteSimulationPlugin;

impl Plugin for AthleteSimulationPlugin {
    fn build(&self, app: &mut App) {
        use AthleteSystems::{Control, Interpolate, ReadWorld, Step, WriteBack};
        #[cfg(feature = "render")]
        type Viewers = Or<(With<AthleteViewer>, With<Camera3d>)>;
        #[cfg(not(feature = "render"))]
        type Viewers = With<AthleteViewer>;
        app.init_resource::<AthleteWorld>()
            .init_resource::<AthleteLanes>()
            .init_resource::<AthleteBudget>()
            .init_resource::<AthleteLodReport>()
            .init_resource::<StepTally>()
            .register_type::<Athlete>()
            .register_type::<AthleteController>()
            .register_type::<AthleteSettings>()
            .register_type::<AthleteTargets>()
            .register_type::<SkillController>()
            .register_type::<SkatingProgram>()
            .register_type::<Steering>()
            .register_type::<LinkPoses>()
            .register_type::<PlaybackSpeed>()
            .register_type::<AthleteForces>()
            .register_type::<AthleteLanes>()
            .register_type::<AthleteLod>()
            .register_type::<AthleteDetail>()
            .register_type::<AthleteViewer>()
            .register_type::<AthleteBudget>()
            .register_type::<AthleteLodReport>()
            .add_message::<AthleteReset>()
            .add_message::<AthleteRewind>()
            .add_message::<BladeEdgeChanged>()
            .add_message::<TakeOff>()
            .add_message::<Landing>()
            .add_message::<SkillStarted>()
            .add_message::<SkillEnded>()
            .add_message::<AthleteFell>()
            .add_message::<ControlFinished>()
            .add_message::<AthleteQuarantined>()
            .add_message::<AthleteRefused>()
            .add_observer(systems::note_reset)
            .add_observer(history::rewind_now)
            .configure_sets(FixedPostUpdate, (ReadWorld, Control, Step, WriteBack).chain())
            .configure_sets(RunFixedMainLoop, Interpolate.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop))
            .add_systems(
                FixedPostUpdate,
                (
                    on_main_thread.pipe(spawn::build_bodies).in_set(ReadWorld),
                    (
                        on_main_thread.pipe(spawn::change_controllers),
                        on_main_thread.pipe(systems::reset_bodies),
                        on_main_thread.pipe(systems::read_wishes),
                        on_main_thread.pipe(systems::read_skill_wishes),
                        on_main_thread.pipe(systems::check_transforms),
                        on_main_thread.pipe(choose_detail::<Viewers>),
                        on_main_thread.pipe(forces::give_forces),
                    )
                        .chain()
                        .in_set(Control),
                    on_main_thread.pipe(systems::step_bodies).in_set(Step),
                    (
                        on_main_thread.pipe(forces::take_forces),
                        on_main_thread.pipe(systems::write_poses),
                        on_main_thread.pipe(systems::tell),
                        on_main_thread.pipe(history::record),
                    )
                        .chain()
                        .in_set(WriteBack),
                ),
            )
            .add_systems(
                RunFixedMainLoop,
                on_main_thread.pipe(history::rewind_bodies).in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop),
            )
            .add_systems(RunFixedMainLoop, on_main_thread.pipe(systems::interpolate_poses).in_set(Interpolate));
    }
}

/// Ahead of a system in a pipe: it keeps the system on the main thread. The systems of a tick follow each other, and most are
/// short: to wake another thread for each costs more than they do. The step spreads over the pool from there.
pub(super) fn on_main_thread(_: NonSendMarker) {}
