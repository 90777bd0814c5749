//! Athletes in a world of [Avian](https://docs.rs/avian3d): they stand, skate and fall on its colliders, are carried by
//! kinematic bodies, push dynamic bodies and are pushed by them.
//!
//! ```no_run
//! use avian3d::prelude::*;
//! use bevy::prelude::*;
//! use bevy_athlete::engine::avian::{AthleteAvianPlugin, AthleteSurface};
//! use bevy_athlete::engine::*;
//!
//! fn spawn(mut commands: Commands, assets: Res<AssetServer>) {
//!     commands.spawn((
//!         RigidBody::Static,
//!         Collider::cuboid(60.0, 1.0, 30.0),
//!         AthleteSurface::ICE,
//!         Transform::from_xyz(0.0, -0.5, 0.0),
//!     ));
//!     commands.spawn(Athlete(assets.load("characters/skater.character.ron")));
//! }
//! # fn main() {
//! # App::new().add_plugins(MinimalPlugins).add_plugins((AssetPlugin::default(), TransformPlugin))
//! .add_plugins((PhysicsPlugins::default(), AthletePlugins, AthleteAvianPlugin))
//! # .add_systems(Startup, spawn); }
//! ```
//!
//! # Order
//! Everything happens in `FixedPostUpdate`, athletes first:
//!
//! | set | what happens |
//! | --- | --- |
//! | `PhysicsSystems::First`, `Prepare` | Avian takes over transforms and masses |
//! | [`AthleteSystems::ReadWorld`](super::AthleteSystems::ReadWorld), `Control` | athletes get bodies, resets and targets |
//! | [`AthleteSystems::Step`](super::AthleteSystems::Step) | each athlete gathers the colliders near it and runs the steps of the tick on them |
//! | [`AthleteSystems::WriteBack`](super::AthleteSystems::WriteBack) | poses are written; pushes are given to the bodies as impulses |
//! | `PhysicsSystems::StepSimulation`, `Writeback`, `Last` | Avian steps, with these impulses in its velocities |
//!
//! # What is exact and what is not
//! - The impulse on the athlete and the impulse on the body are the same number with the opposite sign, at the same point; Avian gets
//!   it rounded to single precision, once per tick.
//! - In the athlete's contact solver a dynamic body has its mass, its inertia and its locked axes. Several contacts on one body share
//!   its mass. Within a tick the body moves by its velocity and these pushes alone: gravity, friction on the floor, joints and its other
//!   contacts follow in Avian's step. A body that leans on something that does not move (the floor, or another body that leans
//!   on it in the same direction) does not give way in that direction within the tick; Avian gets the whole push.
//! - Two athletes who push one body in one tick do not know of each other until the next.
//! - Contacts are inelastic: restitution, and Avian's rules to combine friction, do not apply to athletes.
//! - Kinematic bodies carry by their `LinearVelocity` and `AngularVelocity`; one that is moved by its transform alone is
//!   at rest wherever it is put.
//! - Distances are taken in double precision from the collider's own frame. Meshes and height fields are solid behind their front (corners
//!   counter-clockwise; up) to a depth of 0.2 m. Voxels, polylines and custom shapes are asked through parry in single precision.
//! - What touches is the character's contact points: a thin or small body may pass between them.
//! - Athletes are no colliders: rays and other bodies' contacts do not find them.

mod form;
mod gather;
mod ground;
mod mesh;
mod mover;
mod plugin;
mod profile;
mod push;
mod pushes;
mod surface;
mod triangles;

pub use ground::ColliderGround;
pub use plugin::AthleteAvianPlugin;
pub use push::ColliderPush;
pub use surface::AthleteSurface;

/// The code of the guide compiles.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/book/avian.md")]
struct Guide;
