//! Following a motion with a policy: the reference tick by tick, what the policy sees, and what its action does.

/// Targets move on so often within a tick.
pub const TICK_PARTS: usize = 4;

mod gathered;
mod heading;
mod layout;
mod mirror;
mod motion;
mod seen_body;
mod tracker;

pub use heading::Heading;
pub use layout::ObservationLayout;
pub use mirror::{PolicyMirror, mirror_links};
pub use motion::{CycleShift, TrackedMotion, TrackedTick};
pub(crate) use seen_body::{AllLanes, SeenBody};
#[cfg(feature = "engine")]
pub(crate) use seen_body::{OneLane, com_velocity};
pub use tracker::{Tracker, TrackerOptions, TrackingTerms};
