//! The key-pose editor: a document with undo whose text keeps what it does not change, jobs in the background, a panel.
//!
//! | file | what it does |
//! | --- | --- |
//! | `spans` | where the values of a RON text are |
//! | `patch` | changes to a text that touch only what changes |
//! | `document` | a key-pose file, its history |
//! | `job` | work in a thread: news, result, cancel |
//! | `jobs` | simulating the poses, learning them |
//! | `state` | the editor without its panel |
//! | `panel` | the panel |
//! | `preview` | the ghost and the athlete beside it, in the 3D view |

mod document;
mod job;
mod jobs;
mod panel;
mod patch;
mod preview;
mod spans;
mod state;

pub use document::{DocumentError, PoseDocument, PoseField};
pub use job::{JOBS_CAN_RUN, Job, JobControl, JobError};
pub use jobs::{
    Cycle, Learnt, SimulateJob, Simulated, TrainJob, TrainNews, TrainPlan, job_threads, start_simulation,
    start_training, world_name,
};
pub use panel::pose_editor;
pub(super) use preview::EditorPreviewPlugin;
pub use preview::{EditorAthlete, EditorStage, PoseEditorState};
pub use state::{ContactMark, EditorMessage, Performance, PoseEditor};
