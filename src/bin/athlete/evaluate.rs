//! `athlete evaluate`: how often a policy lasts, on fresh random trials.

use crate::output::{Outcome, say, say_json};
use bevy_athlete::asset::card::{CARD_VERSION, CardRow, RobustnessCard};
use bevy_athlete::cli::{FrameRecorder, load_task};
use bevy_athlete::control::Policy;
use bevy_athlete::math::F32x8;
use bevy_athlete::skill::{PushOptions, SkillDefinition};
use bevy_athlete::storyboard::{Ground, Storyboard, StoryboardOptions};
use bevy_athlete::train::ppo::{Actor, Ending, Environment, SkillTask, StartSampler, evaluate};
use clap::Args;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// Try a policy on fresh random trials, all of them counted: it is read from its file and run at the character's own
/// simulation rate, as in a game. Writes the robustness card beside the policy.
#[derive(Debug, Args)]
pub struct Evaluate {
    /// The policy: a .onnx file, or a folder that `athlete train` has filled
    policy: PathBuf,
    /// Trials in a row of the table
    #[arg(long, default_value_t = 200)]
    trials: usize,
    /// A row with pushes at the trunk from random sides, up to so many newtons for 0.1 s, every second on average
    #[arg(long)]
    push: Option<f64>,
    /// Seed of the trials
    #[arg(long, default_value_t = 1_000_003)]
    seed: u64,
    /// Threads; by default one for each core
    #[arg(long)]
    threads: Option<usize>,
    /// Write a storyboard (PNG) of one trial from the start, the reference as a ghost
    #[arg(long)]
    storyboard: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Evaluate {
    pub fn run(&self) -> Outcome {
        if !(1..=1_000_000).contains(&self.trials) {
            return Err(format!("--trials {}: valid is 1 to 1000000", self.trials).into());
        }
        if self.push.is_some_and(|n| !(0.0..=1e5).contains(&n)) {
            return Err(format!("--push {:?}: valid is 0 to 100000 N", self.push).into());
        }
        let file = if self.policy.is_dir() { self.policy.join("policy.onnx") } else { self.policy.clone() };
        let policy = Policy::load(&file)?;
        let contract = policy.contract();
        let mut skill: SkillDefinition = contract.parse_skill_settings()?;
        let folder = file.parent().unwrap_or(Path::new(""));
        skill.motion = folder.join(&contract.reference.file);
        if self.push.is_some() && skill.episode.push.is_none() {
            skill.episode.push = Some(PushOptions { link: "spine".into(), force: 0.0, seconds: 0.1, every: 1.0 });
        }
        if let (Some(newtons), Some(push)) = (self.push, &mut skill.episode.push) {
            push.force = newtons;
        }
        let task = load_task(&skill, None)?;
        policy.check_for(&task.model)?;
        let rate = task.model.step_rate;
        let task = Arc::new(task.at_rate(rate)?);
        let threads = self.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()));

        let mut rows = Vec::new();
        let mut quality = BTreeMap::new();
        let mut table = |name: &str, task: &Arc<SkillTask>, from_start: bool, pushed: bool| {
            let found = evaluate::<F32x8, _>(task, &policy, self.trials, self.seed, threads, from_start, pushed);
            rows.push(CardRow::new(name, found.trials as u64, found.survived as u64));
            quality.insert(format!("reward_per_step, {name}"), found.reward);
            quality.insert(format!("residual_rad, {name}"), found.residual);
        };
        table("from the start", &task, true, false);
        table("from anywhere", &task, false, false);
        if self.push.is_some() {
            table("from anywhere, pushed", &task, false, true);
        }
        let card = RobustnessCard {
            version: CARD_VERSION,
            skill: skill.name.clone(),
            character: task.model.name.clone(),
            policy: policy.fingerprint().into(),
            crate_version: env!("CARGO_PKG_VERSION").into(),
            seed: self.seed,
            trials: rows.iter().map(|r| r.trials).sum(),
            rows,
            quality,
            command: self.command(),
        };
        card.save(folder.join("card.json"))?;
        if let Some(path) = &self.storyboard {
            draw_trial(path, &task, &policy, self.seed)?;
        }
        if self.json {
            let rows: Vec<_> = (card.rows.iter())
                .map(|r| json!({"name": r.name, "trials": r.trials, "successes": r.successes}))
                .collect();
            say_json(&json!({"skill": card.skill, "rows": rows, "quality": card.quality}))?;
            return Ok(ExitCode::SUCCESS);
        }
        say(&format!("{} of {} at {rate} steps per second, seed {}", card.skill, card.character, self.seed))?;
        say(&format!("{:<24} {:>7} {:>7} {:>8}  {}", "trials", "made", "lasted", "percent", "95 % interval"))?;
        for row in &card.rows {
            say(&format!(
                "{:<24} {:>7} {:>7} {:>8.1}  {:.1} to {:.1}",
                row.name,
                row.trials,
                row.successes,
                100.0 * row.rate(),
                100.0 * row.low,
                100.0 * row.high
            ))?;
        }
        for (name, value) in &card.quality {
            say(&format!("{name:<48} {value:.4}"))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn command(&self) -> String {
        let push = self.push.map_or(String::new(), |n| format!(" --push {n}"));
        let name = self.policy.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        format!("athlete evaluate {name} --trials {} --seed {}{push}", self.trials, self.seed)
    }
}

/// Draws one trial from the start of the motion, to its end or to where it failed.
fn draw_trial(path: &Path, task: &SkillTask, policy: &Policy, seed: u64) -> Result<(), Box<dyn std::error::Error>> {
    let mut task = task.clone();
    task.skill.episode.from_start = true;
    let (size, seconds) = (task.layout.size(), task.motion.duration().min(task.skill.episode.seconds));
    let task = Arc::new(task);
    let starts = StartSampler::even(task.motion.last(), task.motion.cycle().is_some());
    let mut trial = Environment::<f64>::new(task.clone(), seed, 0, &starts);
    trial.pushes = false;
    let (mut seen, mut scratch) = (vec![0.0; size], Vec::new());
    let mut frames = FrameRecorder::new(seconds, true);
    let mut ending = Ending::GoesOn;
    frames.look(&mut trial.sim, &trial.tracker.reference_pose(0));
    while ending == Ending::GoesOn {
        trial.observe(&mut seen);
        ending = trial.tick(Actor::act(policy, &mut scratch, &mut seen, 1))[0].ending;
        frames.look(&mut trial.sim, &trial.tracker.reference_pose(0));
    }
    if ending == Ending::Failed {
        frames.caption_from(trial.sim.state.time, "failed");
    }
    let options = StoryboardOptions {
        ground: if task.skill.world == "ice" { Ground::Ice } else { Ground::Floor },
        title: format!("{}, {} by its policy", task.model.name, task.skill.name),
        ..Default::default()
    };
    Storyboard::new(options).write(&task.model, frames.frames(), path)?;
    Ok(())
}
