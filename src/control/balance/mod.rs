//! Balance by control of momentum: standing on segments of feet.
//!
//! Macchietto, Zordan, Shelton 2009, "Momentum control for balance", as Park, Yu, Lee 2018 use it (Section 5.1, equations 6 and 7).
//! A decision looks at the body, wishes for a change of linear and angular momentum, finds accelerations of all joints that bring it
//! about while the touching segments stay where they are, and forces of the ground that go with it. Every step turns accelerations and
//! forces into torques.
//!
//! | file | what it does |
//! | --- | --- |
//! | `settings` | gains, weights, the rate of decisions, the method |
//! | `stance` | what shall touch, how high and how tilted the ankles, the posture above |
//! | `hull` | the convex hull of what touches, its middle, the nearest point in it |
//! | `supports` | where the touching segments shall be, their points, their rows of the Jacobian |
//! | `momentum` | the wished change of momentum; the wrench at the wished centre of pressure |
//! | `forces` | forces in friction cones that come nearest to a wrench: a small quadratic programme |
//! | `accelerations` | the one linear system |
//! | `controller` | what it remembers, how it begins, goes over to another stance and ticks |
//! | `controller/decision` | the above in order |
//! | `controller/system` | the rows of the linear system |
//! | `controller/torques` | torques at every step |
//! | `controller/state` | the memory as numbers, for snapshots |

mod accelerations;
mod controller;
mod forces;
mod hull;
mod momentum;
mod settings;
mod stance;
mod supports;

pub use controller::{Balance, BalanceError, BalanceProbe};
pub use forces::{ConeForces, ForceWeights, SupportPoint};
pub use hull::{Hull, MOST_CORNERS};
pub use settings::{BalanceMethod, BalanceSettings};
pub use stance::{AnkleStance, Stance, StanceError};
