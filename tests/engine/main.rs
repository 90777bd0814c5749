//! The tests that need the engine, in one program: Bevy is linked once for all of them.
//!
//! Each module opens with its contract. `cargo test --features "avian gltf" --test engine MODULE` runs one of them; without a
//! feature, the modules that need it are left out.

#[cfg(feature = "avian")]
#[path = "../support/counting_allocator.rs"]
mod counting_allocator;
mod engine_support;
#[path = "../support/grounds.rs"]
mod grounds;
#[path = "../support/plain_skill.rs"]
mod plain_skill;

mod asked_feet;
#[cfg(feature = "avian")]
mod avian;
#[cfg(feature = "avian")]
mod avian_ground;
mod balancing;
mod bevy_plugin;
mod bodies;
mod course_runner;
mod engine_detail;
mod engine_rooms;
mod engine_snapshots;
mod engine_time;
mod footings;
mod footsteps;
#[path = "../families/hopper/engine.rs"]
mod hopper;
#[cfg(feature = "ui")]
mod key_pose_editor;
mod moving_worlds;
#[cfg(feature = "ui")]
mod panels;
mod skill_parameters;
mod skin;
mod stumbles;
