//! What all commands say, and how.

use bevy_athlete::cli::{PerformanceReport, trace_bytes};
use bevy_athlete::model::CharacterModel;
use indicatif::{ProgressBar, ProgressStyle};
use std::error::Error;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;
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

/// Size of a trace from which it is told before it is written, bytes.
const LARGE_TRACE: f64 = 100e6;

/// Tells about how large a trace of so many steps will be, where it is large.
pub fn announce_trace(model: &CharacterModel, steps: f64) {
    let bytes = trace_bytes(model.links.len(), steps);
    if bytes > LARGE_TRACE {
        complain(&format!("note: the trace of {steps:.0} steps will take about {:.1} GB", bytes / 1e9));
    }
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

/// What was measured, in words, and the files that were written.
pub fn say_report(report: &PerformanceReport, written: &[(&str, &Option<PathBuf>)]) -> Result<(), Box<dyn Error>> {
    say(&format!("simulated        {:.3} s, {} steps", report.seconds, report.steps))?;
    match (report.fell_at, report.fall) {
        (Some(time), Some(fall)) => say(&format!("fell             at {time:.3} s ({fall})"))?,
        _ => say("fell             no")?,
    }
    say(&format!("root error       {:.3} m at worst", report.worst_root_m))?;
    say(&format!("joint error      {:.2} degrees on average", report.mean_joint_deg))?;
    say(&format!("longest flight   {:.3} s", report.longest_flight_s))?;
    say(&format!("time of a step   {:.2} us", report.us_per_step))?;
    say(&format!("final state      {}", report.fingerprint))?;
    for (what, path) in written {
        if let Some(path) = path {
            say(&format!("{what:<16} {}", path.display()))?;
        }
    }
    Ok(())
}

/// What was measured, as JSON on one line, with the entries of the object `rest`.
pub fn say_report_json(report: &PerformanceReport, rest: serde_json::Value) -> Result<(), Box<dyn Error>> {
    let mut value = serde_json::to_value(report)?;
    if let (Some(value), serde_json::Value::Object(rest)) = (value.as_object_mut(), rest) {
        value.extend(rest);
    }
    say_json(&value)
}
