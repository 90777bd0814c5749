//! What `core/determinism.rs` proves, in a program of its own, small enough to be built in release too.

#[path = "support/common.rs"]
mod common;
#[path = "core/determinism.rs"]
mod determinism;
#[path = "support/golden.rs"]
mod golden;
