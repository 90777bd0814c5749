//! What is saved between windows: enough to go on as if nothing had happened.

use super::{OptimizeError, OptimizeOptions, Plan};
use crate::asset::read_file::read_text;
use crate::control::{Offset, ReconstructedControl};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The state of an optimisation after a window, as saved in a `*.optimize.ron` file. The state of the body is not in it:
/// playing the offsets again gives the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    /// Format version; 1.
    pub(super) version: u32,
    /// Says what plan and options it belongs to.
    pub(super) fingerprint: u64,
    /// Windows that are done.
    pub(super) done: usize,
    /// Control that the search began with.
    pub(super) first: ReconstructedControl,
    /// Offsets that the spline is added to, for each tick and link.
    pub(super) base: Vec<Vec<Offset>>,
    /// Control points of the spline, an offset for each link.
    pub(super) points: Vec<Vec<Offset>>,
}

/// Largest file of a checkpoint, bytes.
const MAX_CHECKPOINT_BYTES: u64 = 256 << 20;

impl Checkpoint {
    /// Windows that are done.
    pub fn done(&self) -> usize {
        self.done
    }

    /// Reads a checkpoint.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, OptimizeError> {
        let path = path.as_ref();
        let failed = |reason: String| OptimizeError::Checkpoint { path: path.display().to_string(), reason };
        let text = read_text(path, MAX_CHECKPOINT_BYTES).map_err(|e| failed(e.fault.to_string()))?;
        ron::from_str(&text).map_err(|e| failed(format!("not a checkpoint: {e}")))
    }

    /// Writes a checkpoint: first beside the file, so that a stop in the middle leaves the old one.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), OptimizeError> {
        let path = path.as_ref();
        let failed = |reason: String| OptimizeError::Checkpoint { path: path.display().to_string(), reason };
        let text = ron::to_string(self).map_err(|e| failed(e.to_string()))?;
        let beside = path.with_extension("part");
        std::fs::write(&beside, text).map_err(|e| failed(e.to_string()))?;
        std::fs::rename(&beside, path).map_err(|e| failed(e.to_string()))
    }

    /// Whether it belongs to a plan and options, and has all it should have.
    pub(super) fn check(&self, plan: &Plan, fingerprint: u64, points: usize) -> Result<(), OptimizeError> {
        let links = plan.model.links.len();
        let bad = |reason: &str| {
            Err(OptimizeError::Checkpoint { path: format!("checkpoint of {}", plan.name), reason: reason.to_owned() })
        };
        if self.version != 1 {
            return bad("another version; this program reads version 1");
        }
        if self.fingerprint != fingerprint {
            return bad("made from other key poses or options; valid are those it was made with");
        }
        let complete = |rows: &[Vec<Offset>]| rows.iter().all(|r| r.len() == links && r.iter().all(|o| o.is_finite()));
        if self.done > plan.windows.len()
            || self.base.len() != plan.ticks()
            || self.points.len() != points
            || !complete(&self.base)
            || !complete(&self.points)
        {
            return bad("numbers are missing; valid is what this program wrote");
        }
        self.first.check_for(&plan.model)?;
        Ok(())
    }
}

/// A hash over everything that the result depends on, besides the time.
pub(super) fn fingerprint(plan: &Plan, options: &OptimizeOptions, iterations: u64, seed: u64) -> u64 {
    let samcon = options.samcon.as_ref().map(|s| {
        (s.samples, s.keep, s.deviation.to_bits(), s.persistence.to_bits(), s.ticks_per_window, s.gains, s.attempts)
    });
    let text = format!(
        "{:?} {:?} {:?} {iterations} {seed} {samcon:?} {:?}",
        plan.clip, plan.windows, plan.record, plan.settings
    );
    // FNV-1a, 64 bit.
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
