//! The demo: scenes of athletes, simulated, in a window, a page or without either. Feature `app`.
//!
//! | file | what it does |
//! | --- | --- |
//! | `options` | the command line, and the query of a page's address |
//! | `window` | the Bevy app: plugins, quality, the camera |
//! | `scenes/` | rink, foot lab, course, crowd, field: one state of the app each |
//! | `stage` | what the scenes need of the command line |
//! | `scene`, `headless` | a control on its character; the same without Bevy: summary table and storyboard |
//! | `menu`, `lab_menu`, `course_menu`, `panel`, `buttons`, `labels` | what is drawn over the picture: functions of `&mut egui::Ui` |
//! | `panels` | the panels of feature `ui`, opened as the command line asks |
//! | `act` | what the skater on the rink does |
//! | `keys`, `touch`, `stick`, `thumb`, `pull` | keys, fingers as a mouse, a stick for thumbs, pulling at a limb |
//! | `news` | what has just happened, in words; who fell starts again |
//! | `camera` | orbit, follow, free |
//! | `props`, `rink`, `scenery` | ice, boards, hall, hills, light |
//! | `reflection`, `tracks`, `spray` | the image in the ice, the lines of the blades, the ice they throw up |
//! | `screenshot` | renders some frames, saves a picture and ends |
//! | `recorder`, `gif_file` | the same with many pictures, as an animated GIF |
//! | `fonts` | the panels' letters, where egui's own set is left out |
//! | `page`, `web` | wasm32: the demo in a page, and what it tells the page |

mod act;
mod buttons;
mod camera;
mod course_menu;
#[cfg(not(feature = "fonts"))]
mod fonts;
#[cfg(not(target_arch = "wasm32"))]
mod gif_file;
#[cfg(not(target_arch = "wasm32"))]
mod headless;
mod keys;
mod lab_menu;
mod labels;
mod menu;
mod news;
mod options;
#[cfg(target_arch = "wasm32")]
mod page;
mod panel;
mod panels;
mod props;
mod pull;
#[cfg(not(target_arch = "wasm32"))]
mod recorder;
mod reflection;
mod rink;
mod scene;
mod scenery;
mod scenes;
mod screenshot;
mod spray;
mod stage;
mod stick;
mod thumb;
mod touch;
mod tracks;
#[cfg(target_arch = "wasm32")]
mod web;
mod window;

pub use act::Act;
pub use buttons::buttons;
pub use camera::{CameraMode, OrbitCamera};
#[cfg(not(target_arch = "wasm32"))]
pub use headless::{HeadlessError, Summary, run_headless, simulate};
pub use keys::KEYS;
pub use options::{DemoOptions, QueryError};
#[cfg(target_arch = "wasm32")]
pub use page::run_in_page;
pub use panel::{PanelView, panel};
pub use scene::{ControlScene, SceneError};
pub use scenes::DemoScene;
pub use window::run_window;

#[cfg(not(target_arch = "wasm32"))]
use std::process::ExitCode;

/// Runs the demo as the command line asks for: in a window, to a picture, or headless. Without a display it says so and
/// runs headless.
#[cfg(not(target_arch = "wasm32"))]
pub fn run(options: &DemoOptions) -> ExitCode {
    let scene = match ControlScene::load(options.control.as_deref()) {
        Ok(scene) => scene,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    };
    if !options.headless && (options.picture().is_some() || has_display()) {
        return run_window(scene, options);
    }
    if !options.headless {
        println!("no display (neither DISPLAY nor WAYLAND_DISPLAY is set): running the scene headless");
    }
    match run_headless(&scene, &options.storyboard) {
        Ok(summary) => {
            print!("{summary}");
            println!("storyboard written to {}", options.storyboard.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Whether a window can be opened. Systems other than Unix ones with X11 or Wayland always have a display.
pub fn has_display() -> bool {
    let needs_server = cfg!(all(unix, not(any(target_os = "macos", target_os = "android", target_os = "ios"))));
    let named = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !needs_server || named("DISPLAY") || named("WAYLAND_DISPLAY")
}
