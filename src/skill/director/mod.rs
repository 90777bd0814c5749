//! The director: at each decision it says which skill of a graph plays, where it is entered, how fast it goes and how it turns.
//!
//! | file | what is in it |
//! | --- | --- |
//! | `player` | [`Director`]: one body through the skills that are chosen for it |
//! | `choice` | what a kind is told and what it answers: [`BodyView`], [`DirectorInput`], [`Choice`], [`DirectorEvent`] |
//! | `kind` | [`DirectorKind`]: the ways to choose, one variant each |
//! | `single`, `program`, `steering`, `course` | one file for each way |
//!
//! Another way to choose is a variant of [`DirectorKind`], with its arms in `kind.rs`, and its file here.

mod choice;
mod course;
mod kind;
mod player;
mod program;
mod single;
mod steering;

pub use choice::{BodyView, Choice, CourseView, DirectorEvent, DirectorInput};
pub use course::Course;
pub use kind::DirectorKind;
pub use player::Director;
pub use program::Program;
pub use single::Single;
pub use steering::Steering;
