//! What tells the joints of an athlete where to go.
//!
//! | file | what is in it |
//! | --- | --- |
//! | `component` | [`AthleteController`], the one component that says what plays, and [`AthleteInput`], the one for wishes |
//! | `start` | from the files that the component names to what runs; what does not fit is refused |
//! | `running` | [`Controller`]: what runs, as the body keeps it |
//! | `requests` | [`PerformSkill`] and its answers; wishes, handed to the bodies |
//!
//! Another kind of controller is a variant of [`AthleteController`] with its arms in `component.rs` and `start.rs`. Where it
//! plays trained skills, what is chosen is a kind of the director (`skill/director/`), and nothing else here changes.

mod component;
mod requests;
mod running;
mod start;

pub use component::{AthleteController, AthleteInput, AthleteTargets, BalancePose};
pub use requests::PerformSkill;
pub(super) use requests::{hand_over_inputs, hear_requests, note_request};
pub(super) use running::{Controller, hash};
pub(super) use start::{ControllerAssets, StartedController, change_controllers};
