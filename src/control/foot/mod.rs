//! The foot pose controller: which way the ankle and the joints of a foot turn so that chosen segments lie on the ground.
//!
//! Park, Yu, Lee 2018, "Multi-Segment Foot for Human Modelling and Simulation", Section 4. In: where the ankle is, which segments
//! shall touch, where the foot points, and the plane of the ground under it. Out: the ankle's rotation, a target for each joint of the
//! foot, how far the ankle had to be moved, and a report of what could not be met.
//!
//! | file | what it does |
//! | --- | --- |
//! | `anatomy` | the links of a foot as segments: joints, soles, limits, read from the model once |
//! | `segments` | sets of segments, the four basic poses |
//! | `ground` | the plane under a foot |
//! | `aim` | the smallest rotation that brings a joint to a height (equations 1 and 2) |
//! | `ankle` | rotation and displacement of the ankle that a set of segments asks for |
//! | `pose` | the whole pose (equations 3 to 5), limits, the report |

mod aim;
mod anatomy;
mod ankle;
mod ground;
mod pose;
mod segments;

pub use anatomy::{FootAnatomy, FootError, Segment};
pub use ground::GroundPlane;
pub use pose::{FootFault, FootPose, FootPoseOptions, FootPoseReport, FootPoseRequest, SegmentReport, foot_pose};
pub use segments::{BasicPose, MOST_SEGMENTS, SegmentSet};
