//! What all commands say, and how.

use indicatif::{ProgressBar, ProgressStyle};
use std::error::Error;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;

/// The end of a command: its exit code, or what went wrong in one line.
pub type Outcome = Result<ExitCode, Box<dyn Error>>;

/// Writes a line to stdout. A reader that has gone away (such as `head`) is no failure.
pub fn say(line: &str) -> Result<(), Box<dyn Error>> {
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{line}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(format!("cannot write to stdout: {error}").into()),
        _ => Ok(()),
    }
}

/// Writes a line to stderr; there is nobody left to tell if that fails.
pub fn complain(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// A value as JSON on stdout, on one line.
pub fn say_json(value: &impl serde::Serialize) -> Result<(), Box<dyn Error>> {
    say(&serde_json::to_string(value)?)
}

/// A bar on stderr for `length` units of work; invisible where stderr is no terminal.
pub fn bar(length: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template("{prefix} [{bar:32}] {pos}/{len} {msg} ({eta} left)") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_prefix(what.to_owned());
    bar
}
