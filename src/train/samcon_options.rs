//! How to search for a control, and why a search is refused or gives up.

use crate::asset::clip::ClipError;
use crate::control::ControlError;
use crate::sim::SimulationSettings;

/// How to search.
#[derive(Clone, Debug)]
pub struct ReconstructOptions {
    /// Samples in a window.
    pub samples: usize,
    /// States kept after a window.
    pub keep: usize,
    /// Standard deviation of an offset at the hips and the trunk, rad; lighter joints get less.
    pub deviation: f64,
    /// Part of the last window's offset around which the next one is drawn.
    pub persistence: f64,
    /// Target updates per second.
    pub tick_rate: f64,
    /// Target updates in a window.
    pub ticks_per_window: usize,
    /// Servo gains for all joints (kp N m/rad, kd N m s/rad) in place of the character's.
    pub gains: Option<(f64, f64)>,
    /// Simulation settings in place of the character's.
    pub settings: Option<SimulationSettings>,
    /// Seed of all random streams.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// How often the search may go back before it gives up.
    pub backtracks: usize,
    /// Searches that may be made until one result is within `tolerance`: the second with [`STIFF_GAINS`], unless gains
    /// are given, the third with twice the samples, each with a seed of its own. The best one counts.
    pub attempts: usize,
    /// What is close enough.
    pub tolerance: Tolerance,
}

/// Gains of the second attempt (kp N m/rad, kd N m s/rad): those of the skating paper's jump (Yu, Park, Lee 2019).
pub const STIFF_GAINS: (f64, f64) = (2000.0, 60.0);

/// How closely a simulation has to follow its clip, without a fall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest distance of the root, m.
    pub worst_root: f64,
    /// Largest mean joint error, rad.
    pub mean_joint: f64,
}

impl Default for Tolerance {
    /// 0.3 m and 15 degrees.
    fn default() -> Self {
        Self { worst_root: 0.3, mean_joint: 15.0 * core::f64::consts::PI / 180.0 }
    }
}

impl Tolerance {
    /// How far a result is from the limits: at most one where it is within all of them. Largest distance of the root in
    /// m, mean joint error in rad.
    pub fn excess(&self, fell: bool, worst_root: f64, mean_joint: f64) -> f64 {
        let fall = if fell { 100.0 } else { 0.0 };
        fall + (worst_root / self.worst_root).max(mean_joint / self.mean_joint)
    }
}

impl std::fmt::Display for Tolerance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let degrees = self.mean_joint.to_degrees();
        write!(f, "no fall, root within {:.2} m, joints within {degrees:.1} degrees", self.worst_root)
    }
}

impl Default for ReconstructOptions {
    fn default() -> Self {
        Self {
            samples: 2048,
            keep: 512,
            deviation: 0.30,
            persistence: 0.7,
            tick_rate: 100.0,
            ticks_per_window: 6,
            gains: None,
            settings: None,
            seed: 1,
            threads: crate::train::default_threads(),
            backtracks: 24,
            attempts: 3,
            tolerance: Tolerance::default(),
        }
    }
}

/// Why a reconstruction could not begin, or gave up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReconstructError {
    /// The clip does not fit the character.
    #[error(transparent)]
    Clip(#[from] ClipError),
    /// The result does not fit the character.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// An option cannot be used.
    #[error("reconstruct: {option} is {found}; {valid}")]
    Option {
        /// The option.
        option: &'static str,
        /// What it was.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// Every way forward fell.
    #[error(
        "no sample passes window {window} of {windows} (at {time:.2} s) after going back {backtracks} times; best cost {cost:.1}"
    )]
    DeadEnd {
        /// Window in which all samples fall.
        window: usize,
        /// Windows in all.
        windows: usize,
        /// Start of the window, s.
        time: f64,
        /// Times the search went back.
        backtracks: usize,
        /// Best cost there.
        cost: f64,
    },
    /// The caller's progress function asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// Whether every number can be used; `rate` is that of the simulation, steps per second.
pub(super) fn check(options: &ReconstructOptions, rate: f64) -> Result<(), ReconstructError> {
    let bad =
        |option, found: String, valid: &str| Err(ReconstructError::Option { option, found, valid: valid.to_string() });
    if !(4..=1 << 20).contains(&options.samples) {
        return bad("samples", options.samples.to_string(), "4 to 1048576");
    }
    if !(1..=options.samples).contains(&options.keep) {
        return bad("keep", options.keep.to_string(), "1 to the number of samples");
    }
    if !(options.deviation.is_finite() && options.deviation >= 0.0 && options.deviation < 3.0) {
        return bad("deviation", options.deviation.to_string(), "0 to 3 rad");
    }
    if !(1..=1000).contains(&options.ticks_per_window) {
        return bad("ticks_per_window", options.ticks_per_window.to_string(), "1 to 1000");
    }
    if !(1..=256).contains(&options.threads) {
        return bad("threads", options.threads.to_string(), "1 to 256");
    }
    let per_tick = rate / options.tick_rate;
    if !(per_tick.is_finite() && per_tick >= 1.0 && (per_tick - per_tick.round()).abs() < 1e-9) {
        return bad(
            "tick_rate",
            options.tick_rate.to_string(),
            &format!("a whole fraction of {rate} steps per second"),
        );
    }
    Ok(())
}
