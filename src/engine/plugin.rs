//! The plugin group and the core plugin.

use crate::engine::detail_choice::choose_detail;
use crate::engine::diagnostics::StepTally;
use crate::engine::schedule::on_main_thread;
use crate::engine::{
    ArenaWorld, AtLink, Athlete, AthleteAssetPlugin, AthleteBody, AthleteBudget, AthleteController, AthleteDetail,
    AthleteDiagnosticsPlugin, AthleteFell, AthleteForces, AthleteHistory, AthleteInput, AthleteLanes, AthleteLod,
    AthleteLodReport, AthletePlaybackPlugin, AthleteQuarantined, AthleteReady, AthleteRefused, AthleteReset,
    AthleteRewind, AthleteSettings, AthleteSkinPlugin, AthleteSystems, AthleteTargets, AthleteTime, AthleteViewer,
    AthleteWorld, BladeEdgeChanged, ControlFinished, Footstep, GripSlipped, InArena, Landing, LinkId, LinkPoses,
    ObstaclePlanned, ParameterRefused, PerformSkill, PlaybackSpeed, Refused, SkillEnded, SkillRefused, SkillStarted,
    StepTaken, Stumbled, TakeOff, at_link, controller, forces, interpolation, spawn, systems,
};
use crate::engine::{athlete_time, history};
use bevy::app::{PluginGroupBuilder, RunFixedMainLoopSystems};
use bevy::prelude::*;
use bevy::transform::TransformSystems;

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
            .init_resource::<AthleteTime>()
            .init_resource::<AthleteBudget>()
            .init_resource::<AthleteLodReport>()
            .init_resource::<StepTally>()
            .register_type::<Athlete>()
            .register_type::<AthleteController>()
            .register_type::<AthleteSettings>()
            .register_type::<AthleteTargets>()
            .register_type::<AthleteBody>()
            .register_type::<AthleteHistory>()
            .register_type::<Refused>()
            .register_type::<ArenaWorld>()
            .register_type::<InArena>()
            .register_type::<LinkId>()
            .register_type::<AtLink>()
            .register_type::<AthleteInput>()
            .register_type::<LinkPoses>()
            .register_type::<PlaybackSpeed>()
            .register_type::<AthleteForces>()
            .register_type::<AthleteLanes>()
            .register_type::<AthleteTime>()
            .register_type::<AthleteWorld>()
            .register_type::<AthleteLod>()
            .register_type::<AthleteDetail>()
            .register_type::<AthleteViewer>()
            .register_type::<AthleteBudget>()
            .register_type::<AthleteLodReport>()
            .add_message::<AthleteReset>()
            .add_message::<AthleteRewind>()
            .add_message::<BladeEdgeChanged>()
            .add_message::<Footstep>()
            .add_message::<StepTaken>()
            .add_message::<Stumbled>()
            .add_message::<TakeOff>()
            .add_message::<Landing>()
            .add_message::<SkillStarted>()
            .add_message::<SkillEnded>()
            .add_message::<SkillRefused>()
            .add_message::<ParameterRefused>()
            .add_message::<ObstaclePlanned>()
            .add_message::<PerformSkill>()
            .add_message::<AthleteFell>()
            .add_message::<GripSlipped>()
            .add_message::<ControlFinished>()
            .add_message::<AthleteQuarantined>()
            .add_message::<AthleteRefused>()
            .add_message::<AthleteReady>()
            .add_observer(systems::note_reset)
            .add_observer(controller::note_request)
            .add_observer(history::rewind_now)
            .configure_sets(FixedPostUpdate, (ReadWorld, Control, Step, WriteBack).chain())
            .configure_sets(RunFixedMainLoop, Interpolate.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop))
            .add_systems(
                FixedPostUpdate,
                (
                    (athlete_time::pass_time, on_main_thread.pipe(spawn::build_bodies)).chain().in_set(ReadWorld),
                    (
                        on_main_thread.pipe(controller::change_controllers),
                        on_main_thread.pipe(systems::reset_bodies),
                        on_main_thread.pipe(controller::hand_over_inputs),
                        on_main_thread.pipe(controller::hear_requests),
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
                        on_main_thread.pipe(systems::emit),
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
            .add_systems(RunFixedMainLoop, on_main_thread.pipe(interpolation::interpolate_poses).in_set(Interpolate))
            .add_systems(
                PostUpdate,
                (interpolation::stay_in_world, at_link::follow_links).before(TransformSystems::Propagate),
            );
    }
}
