//! Storyboards: a strip of figures at even times, drawn without a GPU.
//!
//! ```no_run
//! # use bevy_athlete::{model::CharacterModel, storyboard::*};
//! # fn demo(model: &CharacterModel, frames: &[StoryboardFrame]) -> Result<(), StoryboardError> {
//! let options = StoryboardOptions { frames: 8, title: "skate_gliding".into(), ..Default::default() };
//! Storyboard::new(options).write(model, frames, "gliding.png")
//! # }
//! ```
//!
//! One frame is one instant: where every link is, optionally where the reference has it (drawn as a ghost), what
//! touches the ground and how hard. More frames than cells may be given: cells show the instants nearest to even times,
//! the band below shows the way of the centre of mass through all of them, seen from above.
//!
//! | file | what it does |
//! | --- | --- |
//! | `frame` | what to draw: frames, options, errors |
//! | `camera` | world to cell: an orthographic view that follows the root |
//! | `mesh` | boxes, capsules and spheres as triangles |
//! | `raster` | triangles to shaded, outlined samples with a depth buffer |
//! | `cell` | one figure: ground, shadow, ghost, figure, contact dots, labels |
//! | `path_band` | the way of the centre of mass from above |
//! | `font` | stroked digits and letters |
//! | `plot` | training curves |
//! | `sheet` | lays cells and band out and encodes the picture |

mod camera;
mod cell;
mod font;
mod frame;
mod mesh;
mod path_band;
mod plot;
mod raster;
mod sheet;

pub use camera::travel;
pub use frame::{Follow, Ground, Heading, StoryboardError, StoryboardFrame, StoryboardOptions, TouchPoint};
pub use plot::{Chart, Curve, charts_png};
pub use sheet::Storyboard;
