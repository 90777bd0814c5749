//! `athlete evaluate`: how often a policy lasts, on fresh random trials.

use crate::follow::follow_policies;
use crate::interrupt;
use crate::motion;
use crate::output::{Outcome, announce_trace, complain, say, say_json};
use bevy_athlete::cli::feet::with_foot_armature;
use bevy_athlete::cli::{
    ArgumentError, FrameRecorder, check_output, course_scenery, find_skill, load_character, load_task_with,
    skill_of_policy, threads, within,
};
use bevy_athlete::control::Policy;
use bevy_athlete::model::CharacterModel;
use bevy_athlete::sim::TraceWriter;
use bevy_athlete::skill::{PushOptions, TrialOptions, TrialRow};
use bevy_athlete::storyboard::{Ground, Storyboard, StoryboardOptions};
use bevy_athlete::train::ppo::{
    Actor, CardReport, Environment, EpisodeStatus, JointLoad, SkillTask, StartSampler, robustness_card_until,
};
use clap::Args;
use serde_json::json;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// Seed of the trials of a card where no other is asked for.
pub const TRIALS_SEED: u64 = 1_000_003;

/// Try a policy on fresh random trials, all of them counted: it is read from its file and run at the character's own
/// simulation rate, as in a game. Writes nothing unless asked. Ctrl-C begins no more trials and shows those that were begun.
#[derive(Debug, Args)]
pub struct Evaluate {
    /// A skill with a trained policy (its name or its .skill.ron), a .onnx file, or a folder that `athlete train` has filled
    policy: PathBuf,
    /// Trials in a row of the table
    #[arg(long, default_value_t = 200)]
    trials: usize,
    #[arg(long, help = character_help!(", instead of the skill's own character. A body that the policy does not fit is refused, as in a game"))]
    character: Option<String>,
    /// Instead of the skill's own rows: three pushes of so many newtons for 0.1 s at the trunk, from random sides
    #[arg(long)]
    push: Option<f64>,
    /// Instead of the skill's own rows: speeds drawn from this range, such as 0..2.5 (m/s)
    #[arg(long)]
    speed: Option<String>,
    /// Steps of simulation per second; by default as in a game
    #[arg(long)]
    step_rate: Option<f64>,
    /// Armature of the feet's joints beyond the ankle, kg m^2, 0 to 10, which the policy was not trained with
    #[arg(long)]
    foot_armature: Option<f64>,
    /// Seed of the trials
    #[arg(long, default_value_t = TRIALS_SEED)]
    seed: u64,
    /// Threads; by default one for each core
    #[arg(long)]
    threads: Option<usize>,
    /// Write a storyboard (PNG) of one trial from the start, the reference as a ghost
    #[arg(long)]
    storyboard: Option<PathBuf>,
    /// Write a trace (JSON lines, one a step) of the same trial
    #[arg(long)]
    trace: Option<PathBuf>,
    /// Write the robustness card (card.json) of the skill's own rows beside the policy
    #[arg(long, conflicts_with_all = ["push", "speed", "character", "step_rate", "foot_armature"])]
    card: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The policy file of a skill, a folder or a path.
fn policy_file(given: &Path) -> Result<PathBuf, Box<dyn std::error::Error>> {
    if given.is_dir() {
        return Ok(given.join("policy.onnx"));
    }
    if given.to_string_lossy().ends_with(".skill.ron") {
        return Ok(given.with_file_name("policy.onnx"));
    }
    if given.extension().is_some() || given.is_file() {
        return Ok(given.to_path_buf());
    }
    let skill = find_skill(&given.to_string_lossy())?;
    Ok(skill.with_file_name("policy.onnx"))
}

/// `0..2.5` as two numbers in order.
fn parse_range(text: &str) -> Result<(f64, f64), ArgumentError> {
    let parsed = text.split_once("..").and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    match parsed {
        Some((a, b)) if (0.0..=30.0).contains(&a) && a <= b && b <= 30.0 => Ok((a, b)),
        _ => Err(ArgumentError::new("--speed", text, "two numbers in order from 0 to 30, such as 0..2.5")),
    }
}

impl Evaluate {
    pub fn run(&self) -> Outcome {
        within("--trials", self.trials, 1..=1_000_000, "")?;
        self.push.map(|newtons| within("--push", newtons, 0.0..=1e5, "N")).transpose()?;
        let threads = threads(self.threads)?;
        for (option, path) in [("--trace", &self.trace), ("--storyboard", &self.storyboard)] {
            path.as_ref().map(|path| check_output(option, path)).transpose()?;
        }
        let file = policy_file(&self.policy)?;
        let (mut task, policy) =
            read_trials(&file, self.character.as_deref(), &[], |trial, model| self.change_rows(trial, model))?;
        if let Some(armature) = self.foot_armature {
            let armature = within("--foot-armature", armature, 0.0..=10.0, "kg m^2")?;
            task.model = Arc::new(with_foot_armature(&task.model, armature));
        }
        if let Some(rate) = self.step_rate {
            task = task.at_rate(rate)?;
        }
        let (rate, folder) = (task.settings.rate, file.parent().unwrap_or(Path::new("")));
        let card_file = folder.join("card.json");
        if self.card {
            check_output("--card", &card_file)?;
        }

        interrupt::watch()?;
        if !self.json {
            let (skill, character) = (&task.skill.name, &task.model.name);
            say(&format!("{skill} of {character} at {rate} steps per second, seed {}", self.seed))?;
        }
        let (command, stop) = (self.command(), &interrupt::asked);
        let report = robustness_card_until(&task, &policy, self.trials, self.seed, threads, command, stop)?;
        let card = &report.card;
        if self.card && !report.stopped {
            card.save(&card_file)?;
        }
        if report.stopped {
            let unwritten =
                [(self.card, "card"), (self.storyboard.is_some(), "storyboard"), (self.trace.is_some(), "trace")];
            let unwritten: Vec<_> = unwritten.iter().filter(|(asked, _)| *asked).map(|(_, what)| *what).collect();
            let rest =
                if unwritten.is_empty() { String::new() } else { format!("; not written: {}", unwritten.join(", ")) };
            complain(&format!("stopped after {} trials, which are counted{rest}", card.trials));
        } else if let (true, Some((_, row))) =
            (self.storyboard.is_some() || self.trace.is_some(), task.trials()?.first())
        {
            show_trial(self.storyboard.as_deref(), self.trace.as_deref(), row, &policy, self.seed)?;
        }
        if self.json {
            let rows: Vec<_> = (card.rows.iter())
                .map(|r| json!({"name": r.name, "trials": r.trials, "successes": r.successes}))
                .collect();
            say_json(&json!({"skill": card.skill, "rows": rows, "quality": card.quality, "joints": report.joints,
                "stopped": report.stopped}))?;
        } else {
            say_card(&report)?;
            if self.card && !report.stopped {
                say(&format!("card             {}", card_file.display()))?;
            }
        }
        Ok(if report.stopped { interrupt::stopped() } else { ExitCode::SUCCESS })
    }

    /// Rows that the command line asks for in place of the skill's own.
    fn change_rows(&self, trial: &mut TrialOptions, model: &CharacterModel) -> Result<(), Box<dyn std::error::Error>> {
        let speed = match &self.speed {
            None => None,
            Some(text) => Some(parse_range(text)?),
        };
        if self.push.is_none() && speed.is_none() {
            return Ok(());
        }
        let push = |newtons: f64| PushOptions {
            link: model.links[model.trunk()].name.clone(),
            force: (newtons, newtons),
            seconds: 0.1,
            every: 2.0,
            count: Some(3),
            airborne: false,
        };
        let name = match (self.push, &self.speed) {
            (Some(n), Some(s)) => format!("{n} N, {s} m/s"),
            (Some(n), None) => format!("three pushes of {n} N"),
            (None, s) => format!("{} m/s", s.clone().unwrap_or_default()),
        };
        trial.rows =
            vec![TrialRow { name, speed, start_speed: speed, push: self.push.map(push), ..TrialRow::default() }];
        Ok(())
    }

    fn command(&self) -> String {
        let push = self.push.map_or(String::new(), |n| format!(" --push {n}"));
        let speed = self.speed.as_ref().map_or(String::new(), |s| format!(" --speed {s}"));
        let character = self.character.as_ref().map_or(String::new(), |c| format!(" --character {c}"));
        let rate = self.step_rate.map_or(String::new(), |r| format!(" --step-rate {r}"));
        let armature = self.foot_armature.map_or(String::new(), |a| format!(" --foot-armature {a}"));
        format!("{}{character}{push}{speed}{rate}{armature}", evaluate_command(&self.policy, self.trials, self.seed))
    }
}

/// A policy file, and the task that its trials are made of once `change` has been made to them. On `character` instead of the skill's own
/// where one is given: whether the policy fits it is asked as a game does, before anything is laid out for it.
/// `after` stands for the skills before, where the policy lies in a folder that has no skill file.
pub fn read_trials(
    file: &Path,
    character: Option<&str>,
    after: &[PathBuf],
    change: impl FnOnce(&mut TrialOptions, &CharacterModel) -> Result<(), Box<dyn std::error::Error>>,
) -> Result<(SkillTask, Policy), Box<dyn std::error::Error>> {
    let policy = Policy::load(file)?;
    let mut skill = skill_of_policy(&policy, file, character)?;
    skill.validate()?;
    let model = load_character(&skill.character)?;
    skill.check_policy(&policy, &model)?;
    change(&mut skill.trial, &model)?;
    if skill.after.is_empty() {
        skill.after = after.to_vec();
    }
    if !skill.trial.rows.iter().any(|row| row.after) {
        // What may come before matters to training alone.
        skill.after.clear();
    } else if skill.after.is_empty() {
        let left_out: Vec<_> = skill.trial.rows.extract_if(.., |row| row.after).map(|row| row.name).collect();
        complain(&format!("not tried, for the skills before are not known here: {}", left_out.join(", ")));
    }
    let mut task = load_task_with(&skill, None, &mut motion::tell)?.at_play_rate()?;
    if skill.episode.after_policy {
        for (name, of, _) in follow_policies(&mut task)?.iter().filter(|(.., ways)| *ways == 0) {
            complain(&format!("{name} is never left for {of}: trials begin in the pose of its motion"));
        }
    }
    Ok((task, policy))
}

/// The command that measures a policy file, or one in a folder, again.
pub fn evaluate_command(policy: &Path, trials: usize, seed: u64) -> String {
    let name = policy.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    format!("athlete evaluate {name} --trials {trials} --seed {seed}")
}

/// Prints the table of a card, the quality of the motion and what the joints had to bear.
pub fn say_card(report: &CardReport) -> Result<(), Box<dyn std::error::Error>> {
    let CardReport { card, shortfalls, joints, .. } = report;
    say(&format!(
        "{:<24} {:>7} {:>7} {:>8}  {:<14} {}",
        "trials", "made", "counted", "percent", "95 % interval", "the others lacked"
    ))?;
    for (row, lacked) in card.rows.iter().zip(shortfalls) {
        let interval = format!("{:.1} to {:.1}", 100.0 * row.low, 100.0 * row.high);
        say(&format!(
            "{:<24} {:>7} {:>7} {:>8.1}  {interval:<14} {lacked}",
            row.name,
            row.trials,
            row.successes,
            100.0 * row.rate(),
        ))?;
    }
    for (name, value) in &card.quality {
        say(&format!("{name:<48} {value:.4}"))?;
    }
    if !joints.is_empty() {
        say(&format!("{:<24} {:>10} {:>10} {:>10}", "joint", "limit N m", "peak N m", "at limit"))?;
    }
    for JointLoad { joint, limit, peak, at_limit } in joints {
        let limit = limit.map_or("-".to_owned(), |n| format!("{n:.0}"));
        say(&format!("{joint:<24} {limit:>10} {peak:>10.1} {:>8.2} %", 100.0 * at_limit))?;
    }
    Ok(())
}

/// Draws and writes down one trial from the start of the motion, to its end or to where it failed.
fn show_trial(
    storyboard: Option<&Path>,
    trace: Option<&Path>,
    task: &SkillTask,
    policy: &Policy,
    seed: u64,
) -> Result<(), Box<dyn std::error::Error>> {
    let at = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    let mut task = task.clone();
    task.skill.episode.start = Some((0.0, 0.0));
    let (size, seconds) = (task.layout.size(), task.motion.duration().min(task.skill.episode.seconds));
    let task = Arc::new(task);
    let starts = StartSampler::uniform(task.motion.last(), task.motion.cycle().is_some());
    let mut trial = Environment::<f64>::new(task.clone(), seed, 0, &starts);
    let (mut seen, mut scratch) = (vec![0.0; size], Vec::new());
    let mut frames = FrameRecorder::new(seconds, true);
    let mut status = EpisodeStatus::Running;
    let mut writer = match trace {
        None => None,
        Some(path) => {
            announce_trace(&task.model, seconds * task.settings.rate);
            let out = BufWriter::new(File::create(path).map_err(|e| at(path, e))?);
            Some(TraceWriter::new(out, &trial.sim, 0).map_err(|e| at(path, e))?)
        }
    };
    let mut failed = None;
    frames.look(&mut trial.sim, &trial.tracker.reference_pose(0));
    while status == EpisodeStatus::Running {
        trial.observe(&mut seen);
        let action = Actor::act(policy, &mut scratch, &mut seen, 1);
        let outcomes = trial.tick_with(action, |sim, _| {
            if let Some(writer) = &mut writer {
                failed = failed.take().or(writer.record(sim).err());
            }
        });
        status = outcomes[0].status;
        frames.look(&mut trial.sim, &trial.tracker.reference_pose(0));
    }
    if let (Some(path), Some(error)) = (trace, failed) {
        return Err(at(path, error).into());
    }
    let Some(path) = storyboard else { return Ok(()) };
    if status == EpisodeStatus::Terminated {
        frames.caption_from(trial.sim.state.time, "failed");
    }
    let options = StoryboardOptions {
        ground: if task.skill.world == "ice" { Ground::Ice } else { Ground::Floor },
        title: format!("{}, {} by its policy", task.model.name, task.skill.name),
        scenery: trial.course().map_or_else(Vec::new, course_scenery),
        ..Default::default()
    };
    Storyboard::new(options).write(&task.model, frames.frames(), path)?;
    Ok(())
}
