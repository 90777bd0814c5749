//! Open-loop controls: a clip plus offsets to the servo targets, window by window, whose simulation follows the clip.
//!
//! After Liu, Yin, van de Panne, Shao, Xu 2010, "Sampling-based Contact-rich Motion Control". A control holds no state of the
//! body: played on the same character, world and rate it gives the same motion, bit for bit, because the step is
//! deterministic.

use crate::asset::clip::{ClipError, MotionClip};
use crate::asset::read_file::read_text;
use crate::asset::{StateError, StateReader, StateWriter};
use crate::control::{Reference, apply_initial_state};
use crate::math::{Quat, Real, Vec3};
use crate::model::{CharacterModel, Gains};
use crate::sim::Simulator;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Offset of one joint's target in one window: a rotation by `2 atan(|o| / 2)` about `o`, child axes. For small values
/// the rotation vector, rad.
pub type Offset = DVec3;

/// The result of a reconstruction, as saved in a `*.control.ron` file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReconstructedControl {
    /// Format version; 1.
    pub version: u32,
    /// Character it was made for.
    pub character: String,
    /// World it was made in: `ice` or `ground`.
    pub world: String,
    /// Simulation steps per second.
    pub rate: f64,
    /// Target updates per second; `rate` is a whole multiple.
    pub tick_rate: f64,
    /// Target updates in a window.
    pub ticks_per_window: usize,
    /// Length of the control, s.
    pub seconds: f64,
    /// Servo gains used for all joints; `None` takes those of the character file.
    pub gains: Option<(f64, f64)>,
    /// The clip that is followed.
    pub clip: MotionClip,
    /// For each window, an offset for each link (entry 0, the root, unused).
    pub offsets: Vec<Vec<Offset>>,
}

/// Why a control was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// The file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The text is not a control.
    #[error("{}: not a control file: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Where and why.
        message: String,
    },
    /// A field has a value that cannot be played.
    #[error("control: {field} is {found}; {valid}")]
    Value {
        /// The field.
        field: &'static str,
        /// What it holds.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// The clip inside does not fit.
    #[error("control: {0}")]
    Clip(#[from] ClipError),
}

/// The rotation of an [`Offset`].
pub(crate) fn offset_rotation(o: Offset) -> DQuat {
    let v = o * 0.5;
    let s = 1.0 / (1.0 + v.length_squared()).sqrt();
    DQuat::from_xyzw(v.x * s, v.y * s, v.z * s, s)
}

/// Largest file of a control, bytes.
const MAX_CONTROL_BYTES: u64 = 256 << 20;

impl ReconstructedControl {
    /// Reads a control and checks everything that does not depend on the character.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ControlError> {
        let path = path.as_ref();
        let text = read_text(path, MAX_CONTROL_BYTES)
            .map_err(|e| ControlError::Io { path: path.to_path_buf(), source: e.into() })?;
        Self::from_ron(&text, path)
    }

    /// Reads a control from text; `path` is for messages.
    pub fn from_ron(text: &str, path: impl AsRef<Path>) -> Result<Self, ControlError> {
        let control: Self = ron::from_str(text)
            .map_err(|e| ControlError::Syntax { path: path.as_ref().to_path_buf(), message: e.to_string() })?;
        control.validate()?;
        Ok(control)
    }

    /// Writes the control.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), ControlError> {
        let path = path.as_ref();
        let pretty = ron::ser::PrettyConfig::new().depth_limit(2).compact_arrays(true);
        let text = ron::ser::to_string_pretty(self, pretty)
            .map_err(|e| ControlError::Syntax { path: path.to_path_buf(), message: e.to_string() })?;
        std::fs::write(path, text).map_err(|source| ControlError::Io { path: path.to_path_buf(), source })
    }

    fn validate(&self) -> Result<(), ControlError> {
        let value =
            |field, found: String, valid: &str| Err(ControlError::Value { field, found, valid: valid.to_string() });
        if self.version != 1 {
            return value("version", self.version.to_string(), "this program reads version 1");
        }
        if !(self.rate.is_finite() && (30.0..=20_000.0).contains(&self.rate)) {
            return value("rate", self.rate.to_string(), "30 to 20000 steps per second");
        }
        let per_tick = self.rate / self.tick_rate;
        if !(self.tick_rate.is_finite()
            && self.tick_rate >= 1.0
            && per_tick > 0.5
            && (per_tick - per_tick.round()).abs() < 1e-9)
        {
            return value("tick_rate", self.tick_rate.to_string(), "a whole fraction of the rate");
        }
        if !(1..=10_000).contains(&self.ticks_per_window) {
            return value("ticks_per_window", self.ticks_per_window.to_string(), "1 to 10000");
        }
        if !(self.seconds.is_finite() && (0.0..=3600.0).contains(&self.seconds)) {
            return value("seconds", self.seconds.to_string(), "0 to 3600 s");
        }
        if self.seconds * self.tick_rate > Reference::MAX_TICKS as f64 {
            let valid = format!("at most {} target updates in all", Reference::MAX_TICKS);
            return value("seconds", format!("{} at {} updates per second", self.seconds, self.tick_rate), &valid);
        }
        if let Some((kp, kd)) = self.gains
            && !(kp.is_finite() && kd.is_finite() && kp >= 0.0 && kd >= 0.0)
        {
            return value("gains", format!("({kp}, {kd})"), "two finite numbers, not negative");
        }
        if let Some(bad) = self.offsets.iter().flatten().find(|o| !o.is_finite() || o.length() > 1e3) {
            return value("offsets", bad.to_string(), "finite, below 1000");
        }
        self.clip.validate()?;
        Ok(())
    }

    /// Checks the control, and that it fits a character.
    pub fn check_for(&self, model: &CharacterModel) -> Result<(), ControlError> {
        self.validate()?;
        if self.character != model.name {
            return Err(ControlError::Value {
                field: "character",
                found: self.character.clone(),
                valid: format!("the character is {}", model.name),
            });
        }
        if let Some((w, found)) = self.offsets.iter().map(Vec::len).enumerate().find(|(_, n)| *n != model.links.len()) {
            return Err(ControlError::Value {
                field: "offsets",
                found: format!("{found} entries in window {w}"),
                valid: format!("{} has {} links", model.name, model.links.len()),
            });
        }
        Ok(())
    }
}

/// Plays a control on a simulator. Clones share all but the place they are at.
#[derive(Clone, Debug)]
pub struct ControlPlayer {
    reference: Arc<Reference>,
    offsets: Arc<[Vec<Offset>]>,
    ticks_per_window: usize,
    steps_per_tick: u64,
    gains: Option<Gains>,
    step: u64,
}

impl ControlPlayer {
    /// A player at the start of the control.
    pub fn new(control: &ReconstructedControl, model: &CharacterModel) -> Result<Self, ControlError> {
        control.check_for(model)?;
        let clip = control.clip.to_model(model)?;
        Ok(Self {
            reference: Arc::new(Reference::new(&clip, control.tick_rate, Some(control.seconds))),
            offsets: control.offsets.clone().into(),
            ticks_per_window: control.ticks_per_window,
            steps_per_tick: (control.rate / control.tick_rate).round() as u64,
            gains: control.gains.map(|(kp, kd)| Gains { kp, kd }),
            step: 0,
        })
    }

    /// The reference that is followed.
    pub fn reference(&self) -> &Reference {
        &self.reference
    }

    /// True once the control has been played to its end.
    pub fn is_finished(&self) -> bool {
        self.step >= self.last_step()
    }

    /// The step that ends the control.
    fn last_step(&self) -> u64 {
        (self.reference.ticks.len() as u64 - 1) * self.steps_per_tick
    }

    /// Puts the simulator into the control's first pose and starts over.
    pub fn restart<R: Real>(&mut self, sim: &mut Simulator<R>) {
        self.step = 0;
        apply_initial_state(sim, &self.reference.ticks[0]);
        if let Some(gains) = self.gains {
            for command in sim.commands.iter_mut() {
                command.kp = R::splat(gains.kp);
                command.kd = R::splat(gains.kd);
            }
        }
    }

    /// Whether the next [`ControlPlayer::drive`] sets targets.
    pub fn commands_now(&self) -> bool {
        self.step.is_multiple_of(self.steps_per_tick)
    }

    /// Where it is in the control.
    pub fn write_state(&self, out: &mut StateWriter) {
        out.whole(self.step);
    }

    /// Goes to where a player of the same control was.
    pub fn read_state(&mut self, from: &mut StateReader) -> Result<(), StateError> {
        let (step, last) = (from.whole("step of the control")?, self.last_step());
        if step > last {
            return Err(StateError::value("step of the control", step, format!("up to {last}")));
        }
        self.step = step;
        Ok(())
    }

    /// To be called before each step: sets the targets when a tick begins. Beyond its end the last target is held.
    pub fn drive<R: Real>(&mut self, sim: &mut Simulator<R>) {
        if self.commands_now() {
            let tick = (self.step / self.steps_per_tick) as usize;
            let window = (tick / self.ticks_per_window).min(self.offsets.len().saturating_sub(1));
            let blend = window_blend(tick - window * self.ticks_per_window, self.ticks_per_window);
            let target = &self.reference.ticks[(tick + 1).min(self.reference.ticks.len() - 1)];
            for (i, command) in sim.commands.iter_mut().enumerate().skip(1) {
                let before = if window > 0 { self.offsets[window - 1][i] } else { DVec3::ZERO };
                let now = self.offsets.get(window).map_or(DVec3::ZERO, |o| o[i]);
                let rotation = target.pose.joints[i] * offset_rotation(before.lerp(now, blend));
                command.rotation = Quat::splat(rotation);
                command.velocity = Vec3::splat(target.velocity.joints[i]);
            }
        }
        self.step += 1;
    }
}

/// How far a window's offset has replaced the one before at tick `tick` of the window: over the first third, so that
/// targets do not jump.
pub(crate) fn window_blend(tick: usize, ticks_per_window: usize) -> f64 {
    let ramp = (ticks_per_window / 3).max(1);
    ((tick + 1) as f64 / ramp as f64).min(1.0)
}
