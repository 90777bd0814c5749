//! A character, or a batch of them, stepping in a world.

mod simulator;
mod step;
mod trace;

pub use simulator::{ExternalForce, SimulationSettings, Simulator};
pub use step::step;
pub use trace::{TraceWriter, link_transforms};
