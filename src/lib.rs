//! Really simulated athletes for the Bevy engine.
//!
//! A figure skater on ice whose blades cut like knife edges, a human with feet of sixteen bones, a runner. Each is an articulated
//! rigid body: what moves it is joint torques, contact forces and the pushes you give it, nothing else.
//!
//! # Quick start
//!
//! In a game: add `AthletePlugins` and spawn an `Athlete`; `examples/skater.rs` is the whole of it. Without an engine:
//!
//! ```
//! use bevy_athlete::contact::World;
//! use bevy_athlete::prelude::*;
//!
//! let model = preset("skater").expect("a character of the crate");
//! let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(&model));
//! let ice = World::ice();
//! for _ in 0..120 {
//!     step(&mut sim, &ice);
//! }
//! assert!((sim.state.time - 0.1).abs() < 1e-9);
//! assert!(sim.loaded_points(0) > 0, "it stands on its blades");
//! ```
//!
//! From a motion to a control whose simulation follows it: `athlete reconstruct --character skater --clip FILE.bvh --out FILE.control.ron`.
//!
//! # Features
//!
//! | feature | brings | on by default |
//! | --- | --- | --- |
//! | none | the simulation core: no Bevy, no clap, no inference in its tree | |
//! | `train` | reconstruction of motions and learning of policies on all cores | yes |
//! | `policy` | trained policies: ONNX files with their contract, inference | yes |
//! | `storyboard` | strips of figures as PNG, without a GPU | yes |
//! | `cli` | the `athlete` command line (with `train`, `policy`, `storyboard`) | yes |
//! | `engine` | the Bevy plugins, without a renderer | yes |
//! | `render` | meshes for characters and ghosts | yes |
//! | `ui` | panels for any egui window: inspector, plots, pushes, contact plate, key-pose editor, training monitor | yes |
//! | `skills` | the six skating skills inside the program: no folder to copy, 1.8 MB | yes |
//! | `avian` | athletes on the colliders of Avian, pushing its bodies | |
//! | `gltf` | Bevy's glTF loader, for skinned meshes over the links | |
//! | `app` | the demo: a window on a rink | yes |
//!
//! Features only add. A game wants `default-features = false, features = ["render", "skills"]`, a server `["engine"]`.
//!
//! # Rooms
//!
//! | module | what lives there |
//! | --- | --- |
//! | [`math`] | numbers over lanes, rotations, spatial algebra |
//! | [`asset`] | files to validated data |
//! | [`model`] | characters, clips laid out for them |
//! | [`dynamics`] | kinematics, forward and inverse dynamics, momentum |
//! | [`contact`] | the world, blades, grips, the contact solver |
//! | [`sim`] | the simulator, the step, the trace |
//! | [`control`] | targets, open-loop controls, trained policies |
//!
//! # Conventions
//!
//! SI units, radians, right-handed axes, Y up; a character faces -Z and +X is to its right. Angular parts come before linear ones. The numeric
//! core is generic over [`math::Real`]: `f64`, [`math::F64x4`] and [`math::F32x8`] give the same bits on every machine (play), the fused types
//! are the fastest (training).
#![warn(missing_docs)]
#![forbid(unsafe_code)]

#[cfg(feature = "app")]
pub mod app;
pub mod asset;
#[cfg(feature = "cli")]
pub mod cli;
pub mod contact;
pub mod control;
pub mod dynamics;
#[cfg(feature = "engine")]
pub mod engine;
#[cfg(feature = "engine")]
pub mod guide;
pub mod math;
pub mod model;
pub mod scenes;
pub mod sim;
pub mod skill;
#[cfg(feature = "storyboard")]
pub mod storyboard;
#[cfg(feature = "train")]
pub mod train;
#[cfg(feature = "ui")]
pub mod ui;

/// What most users need: in a game beside `bevy::prelude`, whose names are not taken again.
pub mod prelude {
    #[cfg(feature = "engine")]
    pub use crate::engine::{
        Athlete, AthleteBody, AthleteController, AthleteFell, AthleteInput, AthletePlugins, AthleteReady,
        AthleteRefused, AthleteReset, AthleteSettings, AthleteWorld, LinkPoses, PerformSkill, SkillRefused,
        SkillStarted,
    };
    pub use crate::model::{CharacterModel, preset};
    pub use crate::sim::{SimulationSettings, Simulator, step};
    #[cfg(feature = "engine")]
    pub use crate::skill::SkillParameters;
}
