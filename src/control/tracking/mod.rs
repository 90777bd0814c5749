//! Following a motion with a policy: the reference tick by tick, what the policy sees, and what its action does.

/// Targets move on so often within a tick.
pub const TARGET_SUBSTEPS: usize = 4;

mod contacts;
mod gathered;
mod heading;
mod mirror;
mod motion;
mod seen_body;
mod support;
mod tracker;
mod warp;

pub use super::terms::{ObservationLayout, PolicyMirror};
pub use contacts::SoleParts;
pub(crate) use gathered::Gathered;
pub use heading::Heading;
pub use mirror::mirror_links;
pub use motion::{CycleShift, GaitLevel, STANDS, TrackedMotion, TrackedTick};
pub(crate) use seen_body::{AllLanes, SeenBody};
#[cfg(feature = "engine")]
pub(crate) use seen_body::{OneLane, com_velocity};
pub use support::Support;
pub use tracker::{Tracker, TrackerOptions, TrackingTerms};
pub use warp::Warp;
