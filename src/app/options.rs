//! The options of the demo: its command line, and the same as the query of a page's address.

use crate::app::{Act, DemoScene};
use crate::ui::Panel;
use clap::Parser;
use std::path::PathBuf;

/// A simulated figure skater on a rink.
///
/// In the window: arrow keys steer, drag turns the camera, wheel zooms, space pauses; the menu lists all keys.
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
    /// Record an animated picture (GIF) and exit. Works without a display.
    #[arg(long, value_name = "FILE", conflicts_with = "screenshot")]
    pub record: Option<PathBuf>,
    /// Length of the animated picture, s.
    #[arg(long, default_value_t = 4.0, value_name = "SECONDS", value_parser = length)]
    pub seconds: f64,
    /// Simulated time of the picture, or of the first one of many, s.
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
    /// Scene at the start: rink, foot-lab, course, crowd, field.
    #[arg(long, default_value = "rink", value_parser = scene)]
    pub scene: DemoScene,
    /// What the skater on the rink does: clip, program, steer, or the name of a skill.
    #[arg(long, default_value = "clip", value_parser = act)]
    pub play: Act,
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
    /// Skaters in the scene `crowd`; 0 lets their number grow to what the machine holds.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub crowd: u32,
    /// Eight runners race in the scene `course`.
    #[arg(long)]
    pub race: bool,
}

/// Why the query of an address holds no options.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum QueryError {
    /// What the command line would say to the same options.
    #[error(transparent)]
    Option(#[from] clap::Error),
    /// A page has no disk, and always a window.
    #[error("`{name}` is for the program on your machine, not for the page")]
    NotInPage {
        /// The option.
        name: &'static str,
    },
}

impl DemoOptions {
    /// The file of the picture that is to be made, still or animated.
    pub fn picture(&self) -> Option<&PathBuf> {
        self.screenshot.as_ref().or(self.record.as_ref())
    }

    /// The options of a page: names and values of its query, `?low&azimuth=30` as `--low --azimuth=30`.
    ///
    /// # Errors
    /// For names and values that the command line would refuse, and for options that need files or do without a window.
    pub fn from_query<N: AsRef<str>, V: AsRef<str>>(
        pairs: impl IntoIterator<Item = (N, V)>,
    ) -> Result<Self, QueryError> {
        let word = |(name, value): (N, V)| match (name.as_ref(), value.as_ref()) {
            (name, "") => format!("--{name}"),
            (name, value) => format!("--{name}={value}"),
        };
        let options = Self::try_parse_from(std::iter::once("page".to_owned()).chain(pairs.into_iter().map(word)))?;
        let absent = [
            ("headless", options.headless),
            ("screenshot", options.screenshot.is_some()),
            ("record", options.record.is_some()),
            ("control", options.control.is_some()),
            ("key-poses", options.key_poses.is_some()),
            ("follow-run", options.follow_run.is_some()),
        ];
        match absent.into_iter().find(|(_, asked)| *asked) {
            Some((name, _)) => Err(QueryError::NotInPage { name }),
            None => Ok(options),
        }
    }
}

fn length(text: &str) -> Result<f64, String> {
    let valid = |seconds: &f64| (0.1..=30.0).contains(seconds);
    text.parse().ok().filter(valid).ok_or_else(|| "valid: 0.1 to 30 seconds".into())
}

fn scene(name: &str) -> Result<DemoScene, String> {
    DemoScene::of_name(name).ok_or_else(|| format!("valid: {}", DemoScene::ALL.map(DemoScene::name).join(", ")))
}

fn act(name: &str) -> Result<Act, String> {
    Act::of_name(name).ok_or_else(|| format!("valid: {}", Act::names().collect::<Vec<_>>().join(", ")))
}

fn panel(name: &str) -> Result<Panel, String> {
    Panel::of_name(name).ok_or_else(|| format!("valid: {}", Panel::ALL.map(Panel::name).join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_query_says_what_the_command_line_says() {
        let page = DemoOptions::from_query([("low", ""), ("azimuth", "-30"), ("crowd", "7")]).unwrap();
        let line = DemoOptions::parse_from(["demo", "--low", "--azimuth", "-30", "--crowd", "7"]);
        assert_eq!(format!("{page:?}"), format!("{line:?}"));
        let none: [(&str, &str); 0] = [];
        let (page, line) = (DemoOptions::from_query(none).unwrap(), DemoOptions::parse_from(["demo"]));
        assert_eq!(format!("{page:?}"), format!("{line:?}"));
    }

    #[test]
    fn a_query_that_makes_no_sense_is_refused_by_name() {
        for (name, value) in [("lwo", ""), ("azimuth", "north"), ("width", "3"), ("low", "7")] {
            let refused = DemoOptions::from_query([(name, value)]).unwrap_err();
            assert!(refused.to_string().contains(name), "{refused}");
        }
        for (name, value) in [
            ("headless", ""),
            ("screenshot", "a.png"),
            ("record", "a.gif"),
            ("control", "a.ron"),
            ("key-poses", "a.ron"),
            ("follow-run", "a"),
        ] {
            let refused = DemoOptions::from_query([(name, value)]).unwrap_err();
            assert!(matches!(refused, QueryError::NotInPage { name: found } if found == name), "{refused}");
        }
    }
}
