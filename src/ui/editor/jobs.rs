//! The two jobs of the editor: a motion is simulated, a policy is learnt. Both in threads of their own.

use crate::asset::card::RobustnessCard;
use crate::asset::clip::MotionClip;
use crate::contact::World;
use crate::control::{ControlPlayer, MotionRecorder, Policy, ReconstructedControl};
use crate::model::{CharacterModel, KeyPoses, SharedModel};
use crate::sim::{SimulationSettings, Simulator, step};
use crate::skill::{SkillDefinition, TrainedSkill, fitting_rate};
use crate::train::ppo::{
    Iteration, SkillTask, TrainOptions, Trained, Trainer, curve_csv, robustness_card, trained_policy,
};
use crate::train::{Progress, ReconstructError, ReconstructOptions, ReconstructionReport, policy_bytes, reconstruct};
use crate::ui::editor::job::{Job, JobControl, JobError};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Simulation steps per second of a training, at least; the character's own rate may be higher.
const TRAINING_RATE: f64 = 600.0;
/// Poses per second of a simulated motion that a policy learns from.
const RECORDED_RATE: f64 = 60.0;
/// Of a motion that repeats: how far the reference may be from the character, m, and the length of the trials in training
/// and for the card, s.
const LEASH: f64 = 0.3;
const EPISODE: f64 = 4.0;
const TRIAL: f64 = 10.0;
/// Seed of the trials of a card.
const CARD_SEED: u64 = 1_000_003;

/// Threads for a job: one core is left to the frame.
pub fn job_threads() -> usize {
    crate::train::default_threads().saturating_sub(1).max(1)
}

/// Name of the world that a character is for: ice with blades, else ground.
pub fn world_name(model: &CharacterModel) -> &'static str {
    if model.blades.is_empty() { "ground" } else { "ice" }
}

fn world_of(model: &CharacterModel) -> World {
    if model.blades.is_empty() { World::ground() } else { World::ice() }
}

/// A motion that was simulated.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// Its control.
    pub control: Arc<ReconstructedControl>,
    /// How well it follows.
    pub report: ReconstructionReport,
    /// The simulated motion itself.
    pub motion: MotionClip,
}

/// Searches for a control whose simulation follows a clip.
pub type SimulateJob = Job<Progress, Simulated>;

/// Starts a search with these options. A cancel is noticed after each window, a fraction of a second.
pub fn start_simulation(
    model: SharedModel,
    clip: MotionClip,
    options: ReconstructOptions,
) -> Result<SimulateJob, JobError> {
    Job::start("simulate key poses", move |control: &JobControl<Progress>| {
        let world = world_of(&model);
        let found = reconstruct(&model, &world, world_name(&model), &clip, &options, |news| {
            control.tell(news);
            !control.is_cancelled()
        });
        let found = found.map_err(|error| match error {
            ReconstructError::Cancelled => JobError::Cancelled,
            error => JobError::failed(error),
        })?;
        let motion = record(&model, &world, &found.control)?;
        Ok(Simulated { control: Arc::new(found.control), report: found.report, motion })
    })
}

/// Plays a control and keeps the poses.
fn record(model: &SharedModel, world: &World, control: &ReconstructedControl) -> Result<MotionClip, JobError> {
    let settings = SimulationSettings { rate: control.rate, ..SimulationSettings::of(model) };
    let mut sim = Simulator::<f64>::new(model.clone(), settings);
    let mut player = ControlPlayer::new(control, model).map_err(JobError::failed)?;
    let mut recorder = MotionRecorder::new(0, RECORDED_RATE, control.seconds).map_err(JobError::failed)?;
    player.restart(&mut sim);
    recorder.look(&sim);
    while !player.is_finished() {
        player.drive(&mut sim);
        step(&mut sim, world);
        recorder.look(&sim);
    }
    recorder.into_clip(&control.clip.name, model).map_err(JobError::failed)
}

/// A part of a motion that repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// Where it begins and ends in the motion, s.
    pub window: (f64, f64),
    /// Whether it keeps its heading from cycle to cycle.
    pub straight: bool,
}

impl Cycle {
    /// One of the middle repetitions of key poses that are repeated three times or more: the ends of a simulated motion
    /// are those of a body that starts and stops.
    pub fn of(poses: &KeyPoses) -> Option<Self> {
        let sides = if poses.mirrored { 2.0 } else { 1.0 };
        let period = sides * poses.seconds.iter().sum::<f64>();
        let middle = (poses.repeat / 2) as f64;
        let window = (middle * period, (middle + 1.0) * period);
        (poses.repeat >= 3).then_some(Self { window, straight: poses.curvature == 0.0 })
    }
}

/// How long and how to learn.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainPlan {
    /// Longest training, s.
    pub seconds: f64,
    /// Stop at this measured survival, 0 to 1.
    pub until: f64,
    /// Seconds between policies that are handed out to be looked at.
    pub every: f64,
    /// Trials of the card.
    pub trials: usize,
    /// Simulation steps per second in training; `None` is half the character's rate, at least 600.
    pub rate: Option<f64>,
    /// Learn this part of the motion over and over; `None` is the whole, once.
    pub cycle: Option<Cycle>,
    /// Servo gains (kp N m/rad, kd N m s/rad) in place of the character's.
    pub gains: Option<(f64, f64)>,
    /// The learner's own options.
    pub options: TrainOptions,
}

impl Default for TrainPlan {
    fn default() -> Self {
        let options = TrainOptions {
            threads: job_threads(),
            evaluate_every: 10,
            evaluation_share: 1.0,
            ..TrainOptions::default()
        };
        Self { seconds: 180.0, until: 0.98, every: 4.0, trials: 200, rate: None, cycle: None, gains: None, options }
    }
}

/// News of a training.
#[derive(Clone, Debug)]
pub enum TrainNews {
    /// An iteration is done.
    Iteration(Iteration),
    /// A policy as it is now.
    Policy(Arc<TrainedSkill>),
    /// Training is over, the card is being measured.
    Judging,
}

/// A skill that was learnt, and the files it is made of.
#[derive(Clone, Debug)]
pub struct Learnt {
    /// The skill.
    pub skill: Arc<TrainedSkill>,
    /// How it does, on fresh trials.
    pub card: RobustnessCard,
    /// The motion it follows.
    pub motion: MotionClip,
    /// The policy file.
    pub onnx: Vec<u8>,
    /// The curve.
    pub curve: Vec<Iteration>,
}

/// Learns a policy.
pub type TrainJob = Job<TrainNews, Learnt>;

/// Starts a training that follows a clip. A cancel is noticed after each iteration, about a second.
pub fn start_training(model: SharedModel, clip: MotionClip, plan: TrainPlan) -> Result<TrainJob, JobError> {
    Job::start("learn key poses", move |control: &JobControl<TrainNews>| {
        let definition = definition_of(&model, &clip, &plan);
        let task = SkillTask::new(&definition, model.clone(), &clip).map_err(JobError::failed)?;
        let mut trainer = Trainer::new(task.clone(), plan.options.clone()).map_err(JobError::failed)?;
        let skill_of = |trained: &Trained| skill_of(&task, &definition, &clip, &model, trained);
        let began = Instant::now();
        let mut shown = Instant::now();
        loop {
            if control.is_cancelled() {
                return Err(JobError::Cancelled);
            }
            let news = trainer.iterate();
            control.tell(TrainNews::Iteration(news));
            let good = news.evaluation.is_some_and(|(survival, _)| survival >= plan.until);
            if good || control.should_finish() || began.elapsed().as_secs_f64() >= plan.seconds {
                break;
            }
            if shown.elapsed() >= Duration::from_secs_f64(plan.every.clamp(0.1, 1e6)) {
                control.tell(TrainNews::Policy(skill_of(&trainer.present())?.0));
                shown = Instant::now();
            }
        }
        control.tell(TrainNews::Judging);
        let best = trainer.best().cloned().unwrap_or_else(|| trainer.present());
        let (skill, onnx) = skill_of(&best)?;
        let judged = task.at_play_rate().map_err(JobError::failed)?;
        // The command that measures the same again, beside the saved files.
        let command = format!("athlete evaluate policy.onnx --trials {} --seed {CARD_SEED}", plan.trials);
        let threads = plan.options.threads;
        let card = robustness_card(&judged, &skill.policy, plan.trials, CARD_SEED, threads, command)
            .map_err(JobError::failed)?
            .card;
        Ok(Learnt { skill, card, motion: clip, onnx, curve: trainer.curve().to_vec() })
    })
}

/// The description of a skill that follows a clip.
fn definition_of(model: &CharacterModel, clip: &MotionClip, plan: &TrainPlan) -> SkillDefinition {
    let mut definition =
        SkillDefinition::imitate_alone(&clip.name, &model.name, motion_file(&clip.name), world_name(model));
    let half = fitting_rate((0.5 * model.step_rate).max(TRAINING_RATE), definition.control_rate);
    definition.training_rate = plan.rate.or(Some(half));
    definition.gains = plan.gains;
    // A recorded motion may be a frame shorter than its poses.
    if let Some(cycle) = plan.cycle.filter(|c| c.window.1 <= clip.duration()) {
        definition.window = Some(cycle.window);
        (definition.cyclic, definition.straight) = (true, cycle.straight);
        definition.max_reference_drift = Some(LEASH);
        (definition.episode.seconds, definition.trial.seconds) = (EPISODE, TRIAL);
    }
    definition
}

fn motion_file(name: &str) -> String {
    format!("{name}.clip.ron")
}

/// A trained network as a game would load it, and its file.
fn skill_of(
    task: &SkillTask,
    definition: &SkillDefinition,
    clip: &MotionClip,
    model: &CharacterModel,
    trained: &Trained,
) -> Result<(Arc<TrainedSkill>, Vec<u8>), JobError> {
    let (layers, contract) = trained_policy(task, trained, &motion_file(&definition.name));
    let onnx = policy_bytes(&layers, &contract).map_err(JobError::failed)?;
    let policy = Policy::from_bytes(&onnx, "policy.onnx").map_err(JobError::failed)?;
    let skill = TrainedSkill::new(definition.clone(), clip, policy, model).map_err(JobError::failed)?;
    Ok((Arc::new(skill), onnx))
}

impl Learnt {
    /// Writes the skill into a folder (made where it is missing): `NAME.skill.ron`, `NAME.clip.ron`, `policy.onnx`,
    /// `card.json`, `curve.csv`.
    pub fn save(&self, folder: &Path) -> Result<(), JobError> {
        let at = |name: &str, error: &dyn std::fmt::Display| JobError::Failed {
            reason: format!("{}: {error}", folder.join(name).display()),
        };
        std::fs::create_dir_all(folder).map_err(|e| at("", &e))?;
        let name = self.skill.name();
        let style = ron::ser::PrettyConfig::new().depth_limit(2);
        let described = ron::ser::to_string_pretty(&self.skill.definition, style).map_err(JobError::failed)?;
        let motion = self.motion.to_ron().map_err(JobError::failed)?;
        let card = self.card.to_json().map_err(JobError::failed)?;
        // The policy comes last: what reads the folder finds it whole.
        for (file, bytes) in [
            (format!("{name}.skill.ron"), (described + "\n").as_bytes()),
            (motion_file(name), motion.as_bytes()),
            ("card.json".into(), card.as_bytes()),
            ("curve.csv".into(), curve_csv(&self.curve).as_bytes()),
            ("policy.onnx".into(), &self.onnx),
        ] {
            let part = folder.join(format!("{file}.part"));
            let written = std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, folder.join(&file)));
            written.map_err(|e| at(&file, &e))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cycle_of_repeated_poses_is_one_repetition_from_the_middle() {
        let text = |repeat: usize, mirrored: bool| {
            format!(
                "(name: \"a\", character: \"skater\", speed: 1, seconds: [0.5, 0.25], poses: [(), ()], repeat: {repeat}, \
                 mirrored: {mirrored})"
            )
        };
        let of = |repeat, mirrored| Cycle::of(&KeyPoses::from_ron(&text(repeat, mirrored), "a").unwrap());
        assert_eq!(of(2, true), None);
        assert_eq!(of(3, true).unwrap().window, (1.5, 3.0));
        assert_eq!(of(5, false).unwrap().window, (1.5, 2.25));
    }
}
