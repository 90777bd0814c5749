//! The Bevy plugins: spawn an athlete with one component, and it is simulated.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_athlete::engine::*;
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
//! | [`AthleteAssetPlugin`] | `engine` | [`CharacterAsset`], [`ControlAsset`], [`SkillAsset`] and [`ProgramAsset`] with their loaders, the characters of the crate under `embedded://bevy_athlete/` |
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
//! `RunFixedMainLoop`, after the fixed ticks and before `Update`.
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
//! The `Transform` at spawn is where the character's own frame lies in the world: the place on the ground it starts from
//! and the direction it faces (tilt is ignored, a scale other than one is refused). From then on the `Transform` is written:
//! it is that of the root link. To move an athlete, trigger [`AthleteReset`] with a placement.
//!
//! # Words
//! | name | kind | |
//! | --- | --- | --- |
//! | [`Athlete`] | component | spawns an athlete |
//! | [`AthleteController`] | component | what tells its joints where to go |
//! | [`SkillController`], [`SkatingProgram`], [`Steering`] | component | trained skills in place of a controller |
//! | [`AthleteTargets`] | component | joint targets set by you, for [`AthleteController::External`] |
//! | [`AthleteSettings`] | component | switches of one athlete; in single precision ([`AthletePrecision`]) a crowd is nearly twice as large |
//! | [`AthleteForces`] | component | pushes and pulls from outside |
//! | [`AthleteBody`] | component | the simulation of one athlete; present once its files have arrived |
//! | [`LinkPoses`] | component | where its links are |
//! | [`AthleteHistory`] | component | its last seconds, for [`AthleteRewind`] |
//! | [`AthleteLod`], [`AthleteDetail`], [`AthleteViewer`] | component | level of detail by distance |
//! | [`AthleteSkin`], [`DressedIn`], [`SkinRefused`] | component | a skinned mesh in place of the plain shapes |
//! | [`AthleteWorld`] | resource | what all athletes stand on |
//! | [`PlaybackSpeed`] | resource | pause and slow motion |
//! | [`AthleteBudget`], [`AthleteLodReport`] | resource | time for the steps of a frame, and what it allowed |
//! | [`AthleteReset`] | event, message | back to the start |
//! | [`AthleteRewind`] | event, message | back by some seconds |
//! | [`BladeEdgeChanged`], [`TakeOff`], [`Landing`], [`SkillStarted`], [`SkillEnded`], [`AthleteFell`], [`ControlFinished`], [`AthleteQuarantined`], [`AthleteRefused`] | event, message | what happened |

mod assets;
#[cfg(feature = "avian")]
pub mod avian;
mod body;
mod body_state;
mod body_step;
mod components;
mod detail;
mod diagnostics;
mod driver;
mod errors;
mod events;
mod forces;
mod ground;
mod history;
mod lane_steps;
mod performer;
mod placement;
mod playback;
mod plugin;
mod poses;
mod quarantine;
mod skill_assets;
mod skill_components;
mod skin;
mod snapshot;
mod spawn;
mod step_clock;
mod systems;
mod watch;

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

pub use assets::{AthleteAssetPlugin, CharacterAsset, ControlAsset, FileAsset, FileLoader};
pub use body::{AthleteBody, BodyStatus};
pub use components::{Athlete, AthleteController, AthletePrecision, AthleteSettings, AthleteTargets, AthleteWorld};
pub use detail::{AthleteBudget, AthleteDetail, AthleteLod, AthleteLodReport, AthleteViewer};
pub use diagnostics::AthleteDiagnosticsPlugin;
pub use errors::{AthleteRefusal, LoadError, Refused};
pub use events::{
    AthleteFell, AthleteQuarantined, AthleteRefused, AthleteReset, BladeEdgeChanged, ControlFinished, Landing,
    SkillEnded, SkillStarted, TakeOff,
};
pub use forces::{AthleteForce, AthleteForces};
#[cfg(feature = "render")]
pub use ghost::AthleteGhost;
#[cfg(feature = "render")]
pub use gizmos::AthleteGizmos;
pub use history::{AthleteHistory, AthleteRewind};
pub use lane_steps::AthleteLanes;
#[cfg(feature = "render")]
pub use look::AthleteLook;
pub use placement::Placement;
pub use playback::{AthletePlaybackPlugin, PlaybackSpeed};
pub use plugin::{AthletePlugins, AthleteSimulationPlugin, AthleteSystems};
pub use poses::LinkPoses;
pub use quarantine::QuarantineReason;
pub use skill_assets::{ProgramAsset, ProgramLoader, SkillAsset, SkillLoader};
pub use skill_components::{SkatingProgram, SkillController, Steering};
pub use skin::{AthleteSkin, AthleteSkinPlugin, BoneMapAsset, DressedIn, SkinRefused};
pub use snapshot::{AthleteSnapshot, SnapshotError};
#[cfg(feature = "ui")]
pub(crate) use visuals::shape_mesh;
#[cfg(feature = "render")]
pub use visuals::{AthleteRenderPlugin, BladeVisual, LinkVisual};
