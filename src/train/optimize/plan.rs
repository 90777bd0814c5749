//! What has to be optimised: the windows of key poses, in ticks, with all their objectives.

use super::OptimizeError;
use crate::asset::clip::MotionClip;
use crate::control::Reference;
use crate::model::{KeyPoses, Objective, OptimizeRecord, SharedModel};
use crate::sim::SimulationSettings;
use crate::train::objectives::Meter;

/// Target updates per second, as in a reconstruction.
pub(super) const TICK_RATE: f64 = 100.0;

/// One window in its place.
#[derive(Clone, Debug)]
pub struct PlannedWindow {
    /// Number of the window in its file, from 1, and whether left and right are exchanged.
    pub label: String,
    /// Ticks in which its targets are set, from the first to one past the last.
    pub ticks: core::ops::Range<usize>,
    /// What is asked.
    pub objectives: Vec<Objective>,
}

/// Key poses made ready: every repetition and mirror image of every window.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Name of the motion.
    pub name: String,
    /// The clip of the key poses, clear of the ground.
    pub clip: MotionClip,
    /// The clip at every tick.
    pub reference: Reference,
    /// The windows, in order of time; each begins where the one before ends.
    pub windows: Vec<PlannedWindow>,
    /// How the file wants them optimised.
    pub record: OptimizeRecord,
    pub(super) model: SharedModel,
    pub(super) settings: SimulationSettings,
    pub(super) steps_per_tick: usize,
}

impl Plan {
    /// The plan of key poses for a character. Fails where the poses cannot be used, name no windows, or ask for what the
    /// character does not have.
    pub fn new(poses: &KeyPoses, model: &SharedModel) -> Result<Self, OptimizeError> {
        let settings = SimulationSettings::of(model);
        let per_tick = settings.rate / TICK_RATE;
        if (per_tick - per_tick.round()).abs() > 1e-9 || per_tick < 1.0 {
            let valid = format!("a whole multiple of {TICK_RATE}");
            return Err(OptimizeError::value("steps per second", settings.rate, &valid));
        }
        let (clip, _) = poses.to_clip(model)?.lifted_clear(model)?;
        if poses.windows.is_empty() {
            return Err(OptimizeError::value("windows", "none", "at least one (seconds: ..., objectives: [...])"));
        }
        let reference = Reference::new(&clip.to_model(model)?, TICK_RATE, None);
        let last = reference.ticks.len() - 1;
        let sides: &[bool] = if poses.mirrored { &[false, true] } else { &[false] };
        let passes = (0..poses.repeat).flat_map(|_| sides.iter().copied());
        let mut windows = Vec::new();
        let (mut time, mut start) = (0.0, 0);
        for (flip, (number, window)) in passes.flat_map(|flip| poses.windows.iter().enumerate().map(move |w| (flip, w)))
        {
            time += window.seconds;
            let end = ((time * TICK_RATE).round() as usize).min(last);
            // The last frame of a clip may come before the end of its last pose.
            if end <= start {
                continue;
            }
            let mut objectives = window.objectives.clone();
            // What is asked in every window, where it does not say itself how much.
            let record = &poses.optimize;
            let common = [
                Objective::TrackPose { weight: record.track_pose, at_end: false },
                Objective::TrackVelocity { weight: record.track_velocity, at_end: false },
                Objective::TrackPath { weight: record.track_path, at_end: false },
            ];
            for objective in common {
                let same = |o: &Objective| core::mem::discriminant(o) == core::mem::discriminant(&objective);
                if !objectives.iter().any(same) {
                    objectives.push(objective);
                }
            }
            for objective in &mut objectives {
                if let Some(missing) = Meter::lacks(model, objective) {
                    let place = format!("window {}, {}", number + 1, objective.label());
                    return Err(OptimizeError::value(&place, &missing, &format!("what {} has", model.name)));
                }
                if flip {
                    *objective = objective.mirrored();
                }
            }
            let side = if flip { " mirrored" } else { "" };
            windows.push(PlannedWindow { label: format!("{}{side}", number + 1), ticks: start..end, objectives });
            start = end;
        }
        if windows.is_empty() {
            return Err(OptimizeError::value("seconds", clip.duration(), "at least one tick of 0.01 s"));
        }
        Ok(Self {
            name: poses.name.clone(),
            clip,
            reference,
            windows,
            record: poses.optimize.clone(),
            model: model.clone(),
            settings,
            steps_per_tick: per_tick.round() as usize,
        })
    }

    /// Ticks in all: where the last window ends.
    pub fn ticks(&self) -> usize {
        self.windows.last().map_or(0, |w| w.ticks.end)
    }

    /// Length, s.
    pub fn seconds(&self) -> f64 {
        self.ticks() as f64 / TICK_RATE
    }

    /// The character.
    pub fn model(&self) -> &SharedModel {
        &self.model
    }
}
