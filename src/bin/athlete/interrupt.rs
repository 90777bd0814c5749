//! Ctrl-C: a command that has found something saves it first.

use std::error::Error;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// The exit code of a command that was stopped: 128 and the number of the signal, as shells have it.
pub const STOPPED: u8 = 130;

/// From now on the first Ctrl-C only asks the command to stop; the second ends it at once.
pub fn watch() -> Result<(), Box<dyn Error>> {
    let stop = || {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(STOPPED));
        }
    };
    ctrlc::set_handler(stop).map_err(|e| format!("cannot watch for Ctrl-C: {e}").into())
}

/// Whether Ctrl-C was pressed.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
