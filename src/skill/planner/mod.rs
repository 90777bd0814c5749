//! The step planner: running speeds, step by step, that bring a runner to an obstacle with the right speed at the right place; which skill clears
//! it, or why none does.
//!
//! Liu, Yin, van de Panne, Guo 2012, "Terrain Runner: Control, Parameterization, Composition, and Planning for Highly Dynamic Motions", Section 6. Pure functions of
//! numbers: a height profile ahead, a speed, and what the skills can do go in, a plan comes out. No physics, no allocation beyond the plan's own lists,
//! and only sums, products, quotients and roots, so the same bits natively and in WASM.
//!
//! [`profile`](Obstacle::ahead) reads the next obstacle from heights, [`approach`] solves for the speeds, [`plan`] puts both together for a list of
//! [`Clearance`]s.

mod approach;
mod choose;
mod obstacle;

pub use approach::{Approach, ApproachTask, StepLaw, approach};
pub use choose::{Clearance, Plan, Refusal, plan};
pub use obstacle::{Obstacle, ObstacleKind};
