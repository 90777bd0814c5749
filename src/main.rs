//! `cargo run --release`: a figure skater, simulated, on a rink. `--help` lists the options.

//! Built for wasm32 it is a page: `web/build.sh`.

use std::process::ExitCode;

#[cfg(not(target_arch = "wasm32"))]
fn main() -> ExitCode {
    use clap::Parser;
    bevy_athlete::app::run(&bevy_athlete::app::DemoOptions::parse())
}

#[cfg(target_arch = "wasm32")]
fn main() -> ExitCode {
    bevy_athlete::app::run_in_page()
}
