//! Ctrl-C: a command that has found something saves it first.

use bevy_athlete::cli::STOPPED;
use std::error::Error;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on the first Ctrl-C only asks the command to stop; the second ends it at once.
pub fn watch() -> Result<(), Box<dyn Error>> {
    let stop = || {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(STOPPED));
        }
    };
    ctrlc::set_handler(stop).map_err(|e| format!("cannot watch for Ctrl-C: {e}").into())
}

/// The end of a command that was stopped and has saved or shown what it found.
pub fn stopped() -> ExitCode {
    ExitCode::from(STOPPED)
}

/// Whether Ctrl-C was pressed.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
