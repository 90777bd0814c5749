//! What the segments of a foot buy: the experiments of Park, Yu, Lee 2018, Section 6.3, on four feet with one controller.
//!
//! | file | what it does |
//! | --- | --- |
//! | `bodies` | the feet: five segments, two, two with more contact points, eight with single toes |
//! | `episode` | one body, one disturbance: did it keep standing |
//! | `rows` | the experiments, their published figures and mechanical bounds |
//! | `walking` | the rows of a trained walk: rough ground, a push |
//! | `search` | the largest disturbance that is held in 90 % of the episodes |

mod bodies;
mod episode;
mod error;
mod rows;
mod search;
mod walking;

pub use bodies::{FeetBody, with_foot_armature};
pub use episode::{Disturbance, Episode, EpisodeError, EpisodeResult, StancePose, run_episode, watch_episode};
pub use error::FeetError;
pub use rows::{Experiment, FeetRow, experiments, measure_row};
pub use search::{SearchOptions, largest_held};
