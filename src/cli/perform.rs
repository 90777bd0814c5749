//! A character performs a motion or a control, and is measured.

use crate::asset::clip::{ClipError, MotionClip};
use crate::contact::{CourseTerrain, World};
use crate::control::{
    ControlError, ControlPlayer, Fall, ReconstructedControl, ReferenceTick, apply_initial_state, command_pose, fallen,
    tracking_error,
};
use crate::model::{ModelClip, ModelPose, SharedModel};
use crate::sim::{SimulationSettings, Simulator, step};
use serde::Serialize;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{InputError, Push};

/// How often a motion is compared with its reference, 1/s.
const MEASURE_RATE: f64 = 100.0;

/// What drives the joints.
#[derive(Clone, Debug)]
pub enum Script {
    /// The poses of a clip are the targets of the stable PD servos, step by step; nothing else helps.
    Motion(MotionClip),
    /// A reconstructed control is replayed.
    Control(Box<ReconstructedControl>),
}

impl Script {
    /// The clip that is followed.
    pub fn clip(&self) -> &MotionClip {
        match self {
            Script::Motion(clip) => clip,
            Script::Control(control) => &control.clip,
        }
    }

    /// Length, s.
    pub fn seconds(&self) -> f64 {
        match self {
            Script::Motion(clip) => clip.duration(),
            Script::Control(control) => control.seconds,
        }
    }
}

/// How to perform.
#[derive(Clone, Debug)]
pub struct PerformOptions {
    /// Rates and switches; for a control the rate must be the control's.
    pub settings: SimulationSettings,
    /// Simulated time, s; the script's length if `None`. Beyond its end the script's last pose is held.
    pub seconds: Option<f64>,
    /// Stiffness of all servos in place of the character's, N m/rad (of a motion; a control brings its own).
    pub kp: Option<f64>,
    /// Damping of all servos in place of the character's, N m s/rad.
    pub kd: Option<f64>,
    /// Pushes.
    pub pushes: Vec<Push>,
}

/// Why a performance could not be given, or not to its end.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PerformError {
    /// The clip does not fit the character.
    #[error(transparent)]
    Clip(#[from] ClipError),
    /// The control does not fit the character.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A push does not fit the character.
    #[error(transparent)]
    Input(#[from] InputError),
    /// An option is out of range.
    #[error("--{option} {found}: valid is {valid}")]
    Option {
        /// The option, without its dashes.
        option: &'static str,
        /// What it is.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// The watcher could not go on, such as for a full disk.
    #[error("{0}")]
    Watch(String),
    /// The simulation left the range the step is made for.
    #[error(
        "the simulation of {character} left its range at {time:.4} s; gains or pushes are too large for {rate} steps/s"
    )]
    Diverged {
        /// The character.
        character: String,
        /// When, s.
        time: f64,
        /// Steps per second.
        rate: f64,
    },
}

/// What was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PerformanceReport {
    /// Steps done.
    pub steps: u64,
    /// Simulated time, s.
    pub seconds: f64,
    /// When the character fell, s; `None` if it did not.
    pub fell_at: Option<f64>,
    /// In what way it fell.
    pub fall: Option<&'static str>,
    /// Largest distance of the root from its reference, m.
    pub worst_root_m: f64,
    /// Mean angle between joint rotations and their reference, degrees.
    pub mean_joint_deg: f64,
    /// Longest time without any contact, s.
    pub longest_flight_s: f64,
    /// Wall-clock time of a step, microseconds.
    pub us_per_step: f64,
    /// Hash over every bit of the final state, hexadecimal.
    pub fingerprint: String,
}

/// The script made ready for one character.
enum Player {
    Motion { clip: Box<ModelClip>, tick: Box<ReferenceTick> },
    Control(Box<ControlPlayer>),
}

impl Player {
    fn drive(&mut self, sim: &mut Simulator<f64>, steps: u64) {
        match self {
            Player::Motion { clip, tick } => {
                // The servos aim at where the joints should be when the step ends.
                let end = (steps + 1) as f64 / sim.settings().rate;
                clip.sample_into(end, &mut tick.pose);
                clip.sample_velocity_into(end, &mut tick.velocity);
                command_pose(sim, tick);
            }
            Player::Control(player) => player.drive(sim),
        }
    }
}

fn check(options: &PerformOptions, script: &Script) -> Result<f64, PerformError> {
    let bad = |option, found: f64, valid: &str| {
        Err(PerformError::Option { option, found: found.to_string(), valid: valid.to_owned() })
    };
    let rate = options.settings.rate;
    if !(30.0..=20_000.0).contains(&rate) {
        return bad("rate", rate, "30 to 20000 steps per second");
    }
    if let Script::Control(control) = script
        && control.rate != rate
    {
        return bad("rate", rate, &format!("{}, the rate the control was made for", control.rate));
    }
    for (option, gain) in [("kp", options.kp), ("kd", options.kd)] {
        if let Some(gain) = gain
            && !(0.0..=1e6).contains(&gain)
        {
            return bad(option, gain, "0 to 1e6");
        }
        if gain.is_some() && matches!(script, Script::Control(_)) {
            return bad(option, gain.unwrap_or(0.0), "none with a control, which brings its own gains");
        }
    }
    let seconds = options.seconds.unwrap_or(script.seconds());
    if !(0.0..=3600.0).contains(&seconds) {
        return bad("seconds", seconds, "0 to 3600 s");
    }
    // A push that never comes would look like one that does nothing.
    if let Some(late) = options.pushes.iter().find(|push| push.start >= seconds) {
        let valid = format!("a push that begins before the end, at {seconds} s");
        return Err(PerformError::Option { option: "push", found: late.to_string(), valid });
    }
    Ok(seconds)
}

/// Simulates a script on a character in a world and measures how it goes. A fall is reported, not an error.
///
/// `watch` sees the start (before any step) and then every step just done, with the pose that the reference has then;
/// where it returns an error, the performance ends.
pub fn perform(
    model: &SharedModel,
    world: &World,
    script: &Script,
    options: &PerformOptions,
    watch: impl FnMut(&mut Simulator<f64>, &ModelPose) -> Result<(), String>,
) -> Result<PerformanceReport, PerformError> {
    perform_on(model, &mut CourseTerrain::empty(Arc::new(world.clone())), script, options, watch)
}

/// [`perform`] on a course, whose solids move meanwhile.
pub fn perform_on(
    model: &SharedModel,
    terrain: &mut CourseTerrain<f64>,
    script: &Script,
    options: &PerformOptions,
    mut watch: impl FnMut(&mut Simulator<f64>, &ModelPose) -> Result<(), String>,
) -> Result<PerformanceReport, PerformError> {
    let seconds = check(options, script)?;
    let rate = options.settings.rate;
    let reference = script.clip().to_model(model)?;
    let pushes: Vec<(usize, &Push)> =
        options.pushes.iter().map(|p| Ok((p.link_index(model)?, p))).collect::<Result<_, InputError>>()?;

    let mut sim = Simulator::<f64>::new(model.clone(), options.settings);
    let mut player = match script {
        Script::Motion(_) => {
            let tick = ReferenceTick { pose: reference.sample(0.0), velocity: reference.sample_velocity(0.0) };
            apply_initial_state(&mut sim, &tick);
            for command in &mut sim.commands {
                command.kp = options.kp.unwrap_or(command.kp);
                command.kd = options.kd.unwrap_or(command.kd);
            }
            Player::Motion { clip: Box::new(reference.clone()), tick: Box::new(tick) }
        }
        Script::Control(control) => {
            let mut player = ControlPlayer::new(control, model)?;
            player.restart(&mut sim);
            Player::Control(Box::new(player))
        }
    };
    let mut pose = reference.sample(0.0);
    watch(&mut sim, &pose).map_err(PerformError::Watch)?;

    let steps = (seconds * rate).round() as u64;
    let per_measure = match script {
        Script::Motion(_) => (rate / MEASURE_RATE).round().max(1.0) as u64,
        Script::Control(control) => (rate / control.tick_rate).round().max(1.0) as u64,
    };
    let (mut worst_root, mut joint_sum, mut measured) = (0.0_f64, 0.0, 0_u32);
    let (mut flight, mut longest_flight) = (0_u64, 0_u64);
    let mut fall: Option<(f64, Fall)> = None;
    let mut spent = Duration::ZERO;
    for done in 1..=steps {
        player.drive(&mut sim, done - 1);
        sim.external.clear();
        for (link, push) in &pushes {
            push.apply(*link, &mut sim, 1.0 / rate);
        }
        let begin = Instant::now();
        step(&mut sim, &*terrain);
        terrain.advance(1.0 / rate);
        spent += begin.elapsed();
        if !sim.is_sane(0) {
            return Err(PerformError::Diverged { character: model.name.clone(), time: sim.state.time, rate });
        }

        flight = if sim.loaded_points(0) == 0 { flight + 1 } else { 0 };
        longest_flight = longest_flight.max(flight);
        reference.sample_into(done as f64 / rate, &mut pose);
        if done.is_multiple_of(per_measure) || done == steps {
            let error = tracking_error(&sim, 0, &pose);
            worst_root = worst_root.max(error.root);
            joint_sum += error.joints;
            measured += 1;
            if fall.is_none() {
                fall = fallen(&sim, 0, &pose, &error).map(|kind| (sim.state.time, kind));
            }
        }
        watch(&mut sim, &pose).map_err(PerformError::Watch)?;
    }
    Ok(PerformanceReport {
        steps,
        seconds: steps as f64 / rate,
        fell_at: fall.map(|f| f.0),
        fall: fall.map(|f| f.1.words()),
        worst_root_m: worst_root,
        mean_joint_deg: (joint_sum / f64::from(measured.max(1))).to_degrees(),
        longest_flight_s: longest_flight as f64 / rate,
        us_per_step: spent.as_secs_f64() * 1e6 / steps.max(1) as f64,
        fingerprint: format!("{:016x}", sim.state.fingerprint(0)),
    })
}
