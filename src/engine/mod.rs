//! The Bevy plugins: spawn an athlete with one component, and it is simulated.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_athlete::prelude::*;
//!
//! fn spawn(mut commands: Commands, assets: Res<AssetServer>) {
//!     commands.spawn((
//!         Athlete(assets.load("characters/skater.character.ron")),
//!         AthleteController::Play(assets.load("skills/skating/stroking/stroking.control.ron")),
//!         Transform::from_xyz(0.0, 0.0, 10.0),
//!     ));
//! }
//! # fn main() { App::new().add_plugins((MinimalPlugins, AssetPlugin::default(), AthletePlugins)).add_systems(Startup, spawn); }
//! ```
//!
//! # Plugins
//! [`AthletePlugins`] is this group; each member can be left out or replaced:
//!
//! | plugin | feature | what it adds |
//! | --- | --- | --- |
//! | [`AthleteAssetPlugin`] | `engine` | [`CharacterAsset`], [`ControlAsset`], [`SkillAsset`] and [`ProgramAsset`] with their loaders, the characters of the crate under `embedded://bevy_athlete/`, with the feature `skills` its skating skills under `embedded://bevy_athlete/skills/skating/` |
//! | [`AthleteSimulationPlugin`] | `engine` | bodies, stepping, write-back, events, interpolation |
//! | [`AthletePlaybackPlugin`] | `engine` | [`PlaybackSpeed`]: pause and slow motion |
//! | [`AthleteDiagnosticsPlugin`] | `engine` | figures in Bevy's `DiagnosticsStore` |
//! | [`AthleteSkinPlugin`] | `engine` | skinned meshes whose bones follow the links ([`AthleteSkin`]) |
//! | [`AthleteRenderPlugin`] | `render` | meshes for the shapes of every link, the ghost of the reference |
//!
//! # Time
//! Athletes step in `FixedPostUpdate`, in the chained sets [`AthleteSystems`]. The fixed timestep stays yours (64 Hz unless
//! you change it). A character has a rate of its own (1200 Hz for the skater), so a fixed tick runs as many whole steps as
//! are due: 18 or 19 at 64 Hz. What is due is counted in integers: simulated time never drifts from `Time<Fixed>`, and
//! the same number of ticks gives the same bits, however long the frames were. Between ticks poses are interpolated in
//! `RunFixedMainLoop`, after the fixed ticks and before `Update`. [`AthleteTime`] slows athletes down alone.
//!
//! # Snapshots
//! [`AthleteBody::snapshot`] gives one value that holds everything the body remembers, [`AthleteBody::restore`] puts it back,
//! and what follows has the same bits. [`AthleteSnapshot::to_bytes`] is for files and networks.
//!
//! # When something goes bad
//! A body whose state, target, policy, ground or force is no number is quarantined: it is no longer stepped, keeps its last
//! good pose, and [`AthleteQuarantined`] says why. Nobody else is affected.
//!
//! # Transforms
//! The `Transform` at spawn says where the character's own frame lies in the world: the place on the ground it starts from
//! and the direction it faces (tilt is ignored, a scale other than one is refused). A child of a moved parent is where both
//! put it. From then on the `Transform` is written so that the entity is where the root link is, whatever its parents do. To
//! move an athlete, trigger [`AthleteReset`] with a placement, in the world.
//!
//! # Words
//! | name | kind | |
//! | --- | --- | --- |
//! | [`Athlete`] | component | spawns an athlete |
//! | [`AthleteController`] | component | what tells its joints where to go: targets, a control, trained skills |
//! | [`AthleteInput`] | component | what is wished of it: direction, speed, turn, parameters of its skills |
//! | [`AthleteTargets`] | component | joint targets set by you, for [`AthleteController::External`] |
//! | [`AthleteSettings`] | component | switches of one athlete; in single precision ([`AthletePrecision`]) a crowd is nearly twice as large |
//! | [`AthleteForces`] | component | pushes and pulls from outside |
//! | [`AthleteBody`] | component | the simulation of one athlete; present once its files have arrived |
//! | [`LinkPoses`], [`LinkId`] | component | where its links are; a link, by name |
//! | [`AtLink`] | component | an entity that follows a link |
//! | [`AthleteHistory`] | component | its last seconds, for [`AthleteRewind`] |
//! | [`AthleteLod`], [`AthleteDetail`], [`AthleteViewer`] | component | level of detail by distance |
//! | [`AthleteSkin`], [`DressedIn`], [`SkinRefused`] | component | a skinned mesh in place of the plain shapes |
//! | [`AthleteWorld`] | resource | what athletes stand on |
//! | [`ArenaWorld`], [`InArena`] | component | a world of its own, and who is in it |
//! | [`AthleteTime`] | resource | pause and slow motion of athletes alone |
//! | [`PlaybackSpeed`] | resource | pause and slow motion of the whole game |
//! | [`AthleteBudget`], [`AthleteLodReport`] | resource | time for the steps of a frame, and what it allowed |
//! | [`PerformSkill`] | event, message | asks for a skill; answered by [`SkillStarted`] or [`SkillRefused`] |
//! | [`AthleteReset`] | event, message | back to the start |
//! | [`AthleteRewind`] | event, message | back by some seconds |
//! | [`AthleteReady`], [`BladeEdgeChanged`], [`Footstep`], [`StepTaken`], [`Stumbled`], [`TakeOff`], [`Landing`], [`SkillStarted`], [`SkillEnded`], [`SkillRefused`], [`ParameterRefused`], [`ObstaclePlanned`], [`AthleteFell`], [`GripSlipped`], [`ControlFinished`], [`AthleteQuarantined`], [`AthleteRefused`] | event, message | what happened |

mod arena;
mod arrival;
mod assets;
mod at_link;
mod athlete_time;
#[cfg(feature = "avian")]
pub mod avian;
mod body;
mod body_state;
mod body_step;
mod components;
mod controller;
mod detail;
mod detail_choice;
mod diagnostics;
#[cfg(feature = "skills")]
mod embedded_skills;
mod errors;
mod event_detector;
mod events;
mod foot_watch;
mod footstep;
mod forces;
mod ground;
mod history;
mod interpolation;
mod lane_steps;
mod link;
mod placement;
mod playback;
mod plugin;
mod poses;
mod quarantine;
mod schedule;
mod settings;
mod skill_assets;
mod skin;
mod snapshot;
mod spawn;
mod step_clock;
mod stumble;
mod systems;

#[cfg(feature = "render")]
mod ghost;
#[cfg(feature = "render")]
mod gizmos;
#[cfg(feature = "render")]
mod look;
#[cfg(feature = "render")]
mod rounded_box;
#[cfg(feature = "render")]
mod visuals;

pub use arena::{ArenaWorld, InArena};
pub use assets::{AthleteAssetPlugin, CharacterAsset, ControlAsset, FileAsset, FileLoader};
pub use at_link::AtLink;
pub use athlete_time::AthleteTime;
pub use body::{AthleteBody, BodyStatus};
pub use components::{Athlete, AthleteWorld};
pub use controller::{AthleteController, AthleteInput, AthleteTargets, BalancePose, PerformSkill};
pub use detail::{AthleteBudget, AthleteDetail, AthleteLod, AthleteLodReport, AthleteViewer};
pub use diagnostics::AthleteDiagnosticsPlugin;
pub use errors::{AthleteRefusal, LoadError, Refused, SkillMisfit};
pub use events::{
    AthleteFell, AthleteQuarantined, AthleteReady, AthleteRefused, AthleteReset, BladeEdgeChanged, ControlFinished,
    GripSlipped, Landing, ObstaclePlanned, ParameterRefused, SkillEnded, SkillRefused, SkillStarted, TakeOff,
};
pub use footstep::{FootPhase, Footstep};
pub use forces::{AthleteForce, AthleteForces};
#[cfg(feature = "render")]
pub use ghost::AthleteGhost;
#[cfg(feature = "render")]
pub use gizmos::AthleteGizmos;
pub use history::{AthleteHistory, AthleteRewind};
pub use lane_steps::AthleteLanes;
pub use link::LinkId;
#[cfg(feature = "render")]
pub use look::AthleteLook;
pub use placement::Placement;
pub use playback::{AthletePlaybackPlugin, PlaybackSpeed};
pub use plugin::{AthletePlugins, AthleteSimulationPlugin};
pub use poses::LinkPoses;
pub use quarantine::QuarantineReason;
pub use schedule::AthleteSystems;
pub use settings::{AthletePrecision, AthleteSettings};
pub use skill_assets::{ProgramAsset, ProgramLoader, SkillAsset, SkillLoader};
pub use skin::{AthleteSkin, AthleteSkinPlugin, BoneMapAsset, DressedIn, SkinRefused};
pub use snapshot::{AthleteSnapshot, SnapshotError};
pub use stumble::{StepTaken, StumbleCause, Stumbled};
#[cfg(feature = "ui")]
pub(crate) use visuals::shape_mesh;
#[cfg(feature = "render")]
pub use visuals::{AthleteRenderPlugin, BladeVisual, LinkVisual};

/// The code of the guide is compiled with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/book/walk.md")]
struct WalkGuide;
