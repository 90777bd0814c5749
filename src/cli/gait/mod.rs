//! Gait analysis of a trained walk: what a laboratory measures of a person, measured of an athlete.
//!
//! | file | what is in it |
//! | --- | --- |
//! | `samples` | a skill walks, and is measured 200 times a second: [`GaitSample`] |
//! | `curves` | steps and strides, and the mean of each quantity over the cycle: [`GaitReport`] |
//! | `people` | tables of people, and how far the athlete is from them: [`People`], [`Agreement`] |
//! | `files` | the samples for other programs: CSV, and OpenSim's `.sto` and `.mot` |

mod curves;
mod files;
mod people;
mod samples;

pub use curves::{Curve, GaitReport, POINTS, gait_report};
pub use files::{csv_text, mot_text, sto_text};
pub use people::{Agreement, People, PeopleError, agreement};
pub use samples::{FootGait, GaitError, GaitRecording, GaitSample, GaitTask, SAMPLE_RATE, record_gait};
