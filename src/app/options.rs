//! The command line of the demo.

use crate::ui::Panel;
use clap::Parser;
use std::path::PathBuf;

/// A simulated figure skater on a rink.
///
/// In the window: drag to turn the camera, wheel to zoom, space pauses, S is slow motion, R starts again, H hides the
/// panel.
#[derive(Clone, Debug, Parser)]
#[command(name = "bevy_athlete", version)]
pub struct DemoOptions {
    /// Run without a window: print a summary table and write a storyboard.
    #[arg(long)]
    pub headless: bool,
    /// Render some frames, save a PNG and exit. Works without a display.
    #[arg(long, value_name = "FILE")]
    pub screenshot: Option<PathBuf>,
    /// Frames to render before the picture is taken.
    #[arg(long, default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub frames: u32,
    /// Simulated time of the picture, s.
    #[arg(long, default_value_t = 1.3, value_name = "SECONDS")]
    pub at: f64,
    /// Width of the window or picture, pixels.
    #[arg(long, default_value_t = 1280, value_parser = clap::value_parser!(u32).range(64..=7680))]
    pub width: u32,
    /// Height of the window or picture, pixels.
    #[arg(long, default_value_t = 720, value_parser = clap::value_parser!(u32).range(64..=4320))]
    pub height: u32,
    /// Cheap rendering, for software renderers and old machines.
    #[arg(long)]
    pub low: bool,
    /// Where the storyboard of a headless run goes.
    #[arg(long, value_name = "FILE", default_value = "storyboard.png")]
    pub storyboard: PathBuf,
    /// Perform this control instead of the demo's own.
    #[arg(long, value_name = "FILE")]
    pub control: Option<PathBuf>,
    /// Panels that are open at the start: inspector, plots, push, plate, editor, monitor.
    #[arg(long, value_name = "PANELS", value_delimiter = ',', value_parser = panel)]
    pub panels: Vec<Panel>,
    /// Open these key poses (.keyposes.ron) in the editor.
    #[arg(long, value_name = "FILE")]
    pub key_poses: Option<PathBuf>,
    /// Follow the training in this folder in the monitor.
    #[arg(long, value_name = "FOLDER")]
    pub follow_run: Option<PathBuf>,
    /// Camera azimuth at the start, degrees: 0 looks at the skater from behind, 180 from the front.
    #[arg(long, default_value_t = 145.0, allow_negative_numbers = true, value_name = "DEGREES")]
    pub azimuth: f32,
    /// Camera distance at the start, m.
    #[arg(long, default_value_t = 4.6, value_name = "METRES")]
    pub distance: f32,
}

fn panel(name: &str) -> Result<Panel, String> {
    Panel::of_name(name).ok_or_else(|| format!("valid: {}", Panel::ALL.map(Panel::name).join(", ")))
}
