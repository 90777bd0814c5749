//! A character, or a batch of them, stepping in a world.

mod build_info;
mod lanes;
mod simulator;
mod step;
mod trace;

pub use build_info::BuildInfo;
pub use simulator::{ExternalForce, SimulationSettings, Simulator};
pub use step::step;
pub use trace::{TraceWriter, link_transforms};
