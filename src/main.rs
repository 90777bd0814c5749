//! `cargo run --release`: a figure skater, simulated, on a rink. `--help` lists the options.

use bevy_athlete::app::{DemoOptions, run};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    run(&DemoOptions::parse())
}
