//! The tests that need no engine, in one program: what all of them simulate is compiled and linked once.
//!
//! Each module opens with its contract. `cargo test --no-default-features --features cli --test core MODULE` runs one of
//! them. `tests/determinism.rs` has one of them for a build in release.

#[path = "../support/bvh_writer.rs"]
mod bvh_writer;
#[path = "../support/command_line.rs"]
mod command_line;
#[path = "../support/common.rs"]
mod common;
#[path = "../support/counting_allocator.rs"]
mod counting_allocator;
#[path = "../support/golden.rs"]
mod golden;
#[path = "../support/motion_support.rs"]
mod motion_support;
#[path = "../support/plain_skill.rs"]
mod plain_skill;
#[path = "../support/policy_support.rs"]
mod policy_support;
#[path = "../support/puppet.rs"]
mod puppet;
#[path = "../support/seen_momentum.rs"]
mod seen_momentum;

mod arch;
mod architecture;
mod armature;
mod balance;
mod blade;
mod character_files;
mod character_parts;
mod character_refusals;
mod cli;
mod cli_cases;
mod cli_refusals;
mod closed_forms;
mod cma_es;
mod contract_fit;
mod course_runs;
mod courses;
mod courses_in_training;
mod criteria;
mod crossover_clips;
mod determinism;
mod director;
mod dynamics_identities;
mod exported_skill;
mod flight;
mod foot_pose;
mod gait;
mod geometry;
mod grips;
#[path = "../families/hopper/core.rs"]
mod hopper;
mod interrupts;
mod joint_torques;
mod key_poses;
mod lanes;
mod lanes_on_courses;
mod mirrored_skill;
mod mjcf_export;
mod model_fingerprint;
mod motion_clip;
mod motion_import;
mod motion_recorder;
mod motion_reference;
mod mujoco_agreement;
mod mutations;
mod nn;
mod no_allocation;
mod objectives;
mod one_blade;
mod policy;
mod policy_mutations;
mod policy_refusals;
mod position_import;
mod robustness_card;
mod salchow_clip;
mod shipped_skills;
mod skill_parameters;
mod soles;
mod storyboard;
mod stranger_skeletons;
mod support;
mod support_height;
mod three_turn_clips;
mod toes;
mod trace_reader;
mod training;
