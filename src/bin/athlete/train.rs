//! `athlete train`: from a skill or a motion to a policy.

use crate::evaluate::{TRIALS_SEED, evaluate_command, read_trials, say_card};
use crate::follow::follow_policies;
use crate::interrupt;
use crate::motion;
use crate::output::{Outcome, bar, say};
use crate::run_folder::RunFolder;
use crate::train_affine::{self, Goal};
use bevy_athlete::asset::read_file::read_text;
use bevy_athlete::cli::{ArgumentError, POLICY_FILE, find_skill, load_task_with, threads, within, write_whole};
use bevy_athlete::control::tracking::TARGET_SUBSTEPS;
use bevy_athlete::sim::BuildInfo;
use bevy_athlete::skill::{Criterion, SkillDefinition};
use bevy_athlete::storyboard::{Chart, Curve, charts_png};
use bevy_athlete::train::ppo::{
    Iteration, TrainError, TrainOptions, Trainer, curve_csv, robustness_card_until, trained_policy,
};
use bevy_athlete::train::{AffineOptions, load_layers, save_policy};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Steps per second of training where nothing else is asked.
const CLIP_RATE: f64 = 600.0;
/// Largest checkpoint that is read, bytes.
const MAX_CHECKPOINT_BYTES: u64 = 1 << 30;

/// Learn a policy. Progress and checkpoints go to the folder --out, in the end with the policy's card; the last line printed
/// gives the evaluated survival and the reward per step.
#[derive(Debug, Args)]
pub struct Train {
    /// A skill: its name below assets/skills, or the path of a .skill.ron file; a motion is given by --clip
    #[arg(required_unless_present = "clip", conflicts_with = "clip")]
    skill: Option<String>,
    /// Imitate this motion (.bvh, .clip.ron, .keyposes.ron) instead of a skill
    #[arg(long, requires = "character")]
    clip: Option<PathBuf>,
    /// Character for --clip: a preset's name or a .character.ron file
    #[arg(long, requires = "clip")]
    character: Option<String>,
    /// World for --clip: ice or ground
    #[arg(long, default_value = "ice", requires = "clip")]
    world: String,
    /// The motion of --clip repeats
    #[arg(long, requires = "clip")]
    cyclic: bool,
    /// It keeps its heading from cycle to cycle
    #[arg(long, requires = "cyclic")]
    straight: bool,
    /// Trials of --clip count only if the root stays within METRES of the reference, and the joints within DEGREES on average
    #[arg(long, value_name = "METRES,DEGREES", requires = "clip")]
    within: Option<String>,
    /// Find an affine policy (one matrix and an offset) by CMA-ES instead of a network by reinforcement; --iterations are its generations
    #[arg(long, conflicts_with_all = ["resume", "from", "hidden"])]
    affine: bool,
    /// Joint map for a .bvh file, instead of the built-in one that knows its skeleton, or the one that is found
    #[arg(long)]
    map: Option<PathBuf>,
    /// Servo gains KP,KD for --clip instead of the character's
    #[arg(long, requires = "clip")]
    gains: Option<String>,
    /// Simulation steps per second in training, a multiple of four times the decisions per second (of 120 for --clip); by default
    /// the skill's, or 600 for --clip. What was learnt is tried at the character's own rate, or the nearest that fits
    #[arg(long)]
    rate: Option<f64>,
    /// Stop after so many minutes
    #[arg(long, default_value_t = 20.0)]
    minutes: f64,
    /// Stop after so many iterations
    #[arg(long)]
    iterations: Option<usize>,
    /// Stop as soon as a measured survival reaches this, in percent
    #[arg(long)]
    until: Option<f64>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; by default one for each core
    #[arg(long)]
    threads: Option<usize>,
    /// Hidden layers, such as 128,128,128
    #[arg(long)]
    hidden: Option<String>,
    /// Passes over each iteration's experience
    #[arg(long)]
    epochs: Option<usize>,
    /// Iterations between measurements
    #[arg(long)]
    evaluate_every: Option<usize>,
    /// Standard deviation of the exploration at the start and in the end, in units of the action
    #[arg(long, alias = "sigma", value_name = "FIRST,LAST")]
    action_std: Option<String>,
    /// How strongly actions are drawn to those before and after them; 0 not at all [default: 0.1]
    #[arg(long)]
    smoothness: Option<f32>,
    /// Iterations over which the measured policy is a running mean; 1 for the actor as it is [default: 20]
    #[arg(long)]
    average: Option<usize>,
    /// Batches of 64 episodes that are played side by side [default: 4]
    #[arg(long, alias = "pods", value_name = "NUMBER")]
    env_batches: Option<usize>,
    /// Part of the episodes that begin uniformly over the motion and its speeds, not where episodes fail [default: 0.4]
    #[arg(long, alias = "even-starts", value_name = "SHARE")]
    uniform_share: Option<f64>,
    /// Part of the episodes that begin as one began that failed, soon where the motion repeats, once the motion can be done
    /// [default: 0.25]
    #[arg(long, alias = "hard-starts", value_name = "SHARE")]
    replay_share: Option<f64>,
    /// Kullback-Leibler divergence at which an iteration's update stops [default: 0.06]
    #[arg(long, alias = "divergence")]
    kl: Option<f32>,
    /// Decisions of every episode from one update to the next [default: 16]
    #[arg(long, value_name = "NUMBER")]
    ticks: Option<usize>,
    /// Samples over which the exploration falls while every episode fails, and where none does [default: 4e6,1.2e6]
    #[arg(long, value_name = "FAILING,ABLE")]
    action_std_samples: Option<String>,
    /// Discount of a decision, 0 to 1: how far ahead the policy looks [default: 0.97]
    #[arg(long)]
    discount: Option<f32>,
    /// Trials in a row of the table by which the policy is evaluated in the end; 0 for none, and no card
    #[arg(long, default_value_t = 200)]
    card_trials: usize,
    /// Folder of the results; by default runs/NAME
    #[arg(long)]
    out: Option<PathBuf>,
    /// Replace an earlier training in --out
    #[arg(long, conflicts_with = "resume")]
    force: bool,
    /// Go on from the checkpoint in --out, with the seed and layers it was begun with, and its learning options where no
    /// others are given
    #[arg(long)]
    resume: bool,
    /// Begin with this policy file, of this skill or another, instead of from nothing; its layers and normaliser stay
    #[arg(long, value_name = "POLICY", conflicts_with_all = ["resume", "hidden"])]
    from: Option<PathBuf>,
}

fn pair(text: &str, option: &str) -> Result<(f64, f64), ArgumentError> {
    let numbers: Vec<f64> = text.split(',').filter_map(|t| t.trim().parse().ok()).collect();
    match numbers[..] {
        [a, b] if a.is_finite() && b.is_finite() => Ok((a, b)),
        _ => Err(ArgumentError::new(option, text, "two numbers, such as 600,49")),
    }
}

impl Train {
    fn definition(&self) -> Result<SkillDefinition, Box<dyn std::error::Error>> {
        let mut skill = match (&self.skill, &self.clip, &self.character) {
            (Some(name), _, _) => SkillDefinition::load(find_skill(name)?)?,
            (None, Some(clip), Some(character)) => {
                let stem = clip.file_name().map_or("clip".into(), |s| s.to_string_lossy().into_owned());
                let name = stem.split('.').next().unwrap_or("clip").to_owned();
                let mut skill = SkillDefinition::imitate_alone(&name, character, clip, &self.world);
                skill.training_rate = Some(CLIP_RATE);
                if self.cyclic {
                    skill.repeat(self.straight);
                }
                if let Some(text) = &self.within {
                    let (root, joints) = pair(text, "--within")?;
                    // A reference that is dragged along stays well within what counts.
                    skill.max_reference_drift = skill.max_reference_drift.map(|drift| drift.min(0.5 * root));
                    skill.trial.success.push(Criterion::Follows { root, turn: 57.3, joints });
                }
                if let Some(text) = &self.gains {
                    let (kp, kd) = pair(text, "--gains")?;
                    if !((0.0..=1e6).contains(&kp) && (0.0..=1e6).contains(&kd)) {
                        return Err(
                            ArgumentError::new("--gains", text, "two numbers from 0 to 1e6, such as 600,49").into()
                        );
                    }
                    skill.gains = Some((kp, kd));
                }
                skill
            }
            _ => return Err(ArgumentError::new("--clip", "is missing", "a skill, or --clip and --character").into()),
        };
        if let Some(rate) = self.rate {
            // Targets move on several times between two decisions.
            let least = skill.control_rate * TARGET_SUBSTEPS as f64;
            let parts = rate / least;
            if !((1.0..=1000.0).contains(&parts) && (parts - parts.round()).abs() < 1e-9) {
                let valid = format!(
                    "a multiple of {least}, {TARGET_SUBSTEPS} times the {} decisions per second",
                    skill.control_rate
                );
                return Err(ArgumentError::new("--rate", rate, valid).into());
            }
            skill.training_rate = Some(rate);
        }
        Ok(skill)
    }

    /// Puts what was asked for in place of what is there. Seed and layers are those a training is begun with.
    fn change(&self, options: &mut TrainOptions) -> Result<(), ArgumentError> {
        fn put<T: Copy>(asked: Option<T>, option: &mut T) {
            *option = asked.unwrap_or(*option);
        }
        put(self.threads, &mut options.threads);
        put(self.epochs, &mut options.epochs);
        put(self.evaluate_every, &mut options.evaluate_every);
        put(self.smoothness, &mut options.smoothness);
        put(self.average, &mut options.average);
        put(self.env_batches, &mut options.env_batches);
        put(self.kl, &mut options.kl);
        put(self.ticks, &mut options.ticks);
        put(self.discount, &mut options.gamma);
        put(self.uniform_share, &mut options.uniform_share);
        put(self.replay_share, &mut options.replay_share);
        if let Some(text) = &self.action_std {
            let (first, last) = pair(text, "--action-std")?;
            options.action_std = (first as f32, last as f32);
        }
        if let Some(text) = &self.action_std_samples {
            (options.action_std_samples, options.action_std_able_samples) = pair(text, "--action-std-samples")?;
        }
        Ok(())
    }

    fn options(&self) -> Result<TrainOptions, ArgumentError> {
        let mut options = TrainOptions { seed: self.seed, ..TrainOptions::default() };
        if self.until.is_some() {
            // What it stops at has to be seen at once.
            options.evaluation_share = 1.0;
        }
        self.change(&mut options)?;
        if let Some(text) = &self.hidden {
            let sizes: Result<Vec<usize>, _> = text.split(',').map(|t| t.trim().parse()).collect();
            options.hidden =
                sizes.map_err(|_| ArgumentError::new("--hidden", text, "whole numbers, such as 128,128"))?;
        }
        Ok(options)
    }

    /// Refuses options that no training could use.
    fn check(&self) -> Result<(), ArgumentError> {
        if !(self.minutes > 0.0 && self.minutes <= 1e5) {
            return Err(ArgumentError::new("--minutes", self.minutes, "more than 0, up to 100000"));
        }
        self.iterations.map(|n| within("--iterations", n, 1..=100_000_000, "")).transpose()?;
        self.until.map(|percent| within("--until", percent, 0.0..=100.0, "percent")).transpose()?;
        self.epochs.map(|n| within("--epochs", n, 1..=1000, "")).transpose()?;
        self.evaluate_every.map(|n| within("--evaluate-every", n, 1..=1_000_000, "")).transpose()?;
        within("--card-trials", self.card_trials, 0..=1_000_000, "")?;
        threads(self.threads).map(drop)
    }

    /// An error by the option that it is about, with what was typed.
    fn by_option(&self, error: TrainError) -> Box<dyn std::error::Error> {
        let TrainError::Option { option, found, valid } = error else { return error.into() };
        let (option, typed) = match option {
            "gamma" | "gamma, lambda" => ("discount", self.discount.map(|g| g.to_string())),
            "action_std" => (option, self.action_std.clone()),
            "action_std_samples" | "action_std_able_samples" => ("action_std_samples", self.action_std_samples.clone()),
            "hidden" => (option, self.hidden.clone()),
            _ => (option, None),
        };
        ArgumentError::new(format!("--{}", option.replace('_', "-")), typed.unwrap_or(found), valid).into()
    }

    pub fn run(&self) -> Outcome {
        self.check()?;
        let skill = self.definition()?;
        let mut task = load_task_with(&skill, self.map.as_deref(), &mut motion::tell)?;
        if skill.episode.after_policy {
            for (name, of, found) in follow_policies(&mut task)? {
                say(&format!("{found} ways in which {name} is left for {of}"))?;
            }
        }
        if let (Some(clip), 0..2) = (&self.clip, task.clip.poses.len()) {
            let found = task.clip.poses.len();
            return Err(format!("{}: {found} pose, so nothing to follow; valid: 2 or more", clip.display()).into());
        }
        let out = self.out.clone().unwrap_or_else(|| Path::new("runs").join(&skill.name));
        let folder = RunFolder::open(&out, &skill.name, &task.clip, self.resume, self.force)?
            .with_course(&skill.name, task.course.as_deref())?;
        let checkpoint = folder.place("checkpoint.json");
        if self.affine {
            let options =
                AffineOptions { seed: self.seed, threads: threads(self.threads)?, ..AffineOptions::default() };
            let limit = Duration::from_secs_f64(self.minutes * 60.0);
            let goal = Goal { limit, generations: self.iterations, until: self.until };
            return train_affine::run(task, options, &goal, &folder);
        }
        let mut trainer = if self.resume {
            let text = read_text(&checkpoint, MAX_CHECKPOINT_BYTES)
                .map_err(|error| format!("{}: {}", checkpoint.display(), error.fault))?;
            let mut asked = Ok(());
            let trainer = Trainer::resume(task, &text, |options| asked = self.change(options));
            asked?;
            trainer.map_err(|error| self.by_option(error))?
        } else if let Some(policy) = &self.from {
            let (layers, contract) = load_layers(policy)?;
            let mut options = self.options()?;
            if self.action_std.is_none() {
                // It has been explored before.
                options.action_std.0 = options.action_std.1;
            }
            Trainer::from_policy(task, options, &layers, &contract).map_err(|error| self.by_option(error))?
        } else {
            Trainer::new(task, self.options()?).map_err(|error| self.by_option(error))?
        };
        // What cannot be written in the end is found out before the first step.
        trainer
            .policy_file(folder.motion())
            .map_err(|error| format!("what will be learnt could not be written: {error}"))?;
        let instructions = bevy_athlete::train::nn::instructions()?;
        interrupt::watch()?;
        let motion = &trainer.task().motion;
        say(&format!("{}, networks by {instructions}", BuildInfo::current()))?;
        say(&format!(
            "{} learns {}: {:.2} s{}, {} numbers seen, {} told, results in {}",
            skill.character,
            skill.name,
            motion.duration(),
            if motion.cycle().is_some() { " a cycle" } else { "" },
            trainer.task().layout.size(),
            trainer.task().action_size(),
            out.display()
        ))?;

        let limit = Duration::from_secs_f64(self.minutes * 60.0);
        let began = Instant::now();
        let bar = bar(limit.as_secs(), "train");
        let mut saved = Instant::now();
        loop {
            let news = trainer.iterate();
            bar.set_position(began.elapsed().as_secs().min(limit.as_secs()));
            bar.set_message(line(&news));
            if let Some((survival, reward)) = news.evaluation {
                let text = format!(
                    "{:>7.1} s {:>9} samples {:>6.0}/s  survival {:>5.1} %  reward {reward:.3}  (exploring: reward {:.3}, {:.2} s)",
                    news.seconds,
                    news.samples,
                    news.samples as f64 / news.seconds.max(1e-9),
                    100.0 * survival,
                    news.reward,
                    news.length
                );
                bar.suspend(|| say(&text))?;
            }
            let reached = self.until.is_some_and(|p| news.evaluation.is_some_and(|(s, _)| 100.0 * s >= p));
            let stopped = interrupt::asked();
            let done = stopped
                || reached
                || began.elapsed() >= limit
                || self.iterations.is_some_and(|n| trainer.curve().len() >= n);
            if done || saved.elapsed() > Duration::from_secs(30) {
                save(&folder, &trainer)?;
                saved = Instant::now();
            }
            if stopped {
                bar.finish_and_clear();
                say(&format!("stopped after {} samples; saved in {}", news.samples, out.display()))?;
                say("to go on: the same command with --resume")?;
                return Ok(interrupt::stopped());
            }
            if done {
                break;
            }
        }
        bar.finish_and_clear();
        let parts = trainer.curve().iter().fold([0.0; 3], |s, i| core::array::from_fn(|k| s[k] + i.parts[k]));
        let all: f64 = parts.iter().sum();
        say(&format!(
            "time: simulation {:.0} %, inference {:.0} %, learning {:.0} %",
            100.0 * parts[0] / all,
            100.0 * parts[1] / all,
            100.0 * parts[2] / all
        ))?;
        let (survival, reward) = if self.card_trials > 0 {
            match self.evaluate(&out, &skill.after)? {
                Some(measured) => measured,
                None => {
                    let out = out.display();
                    say(&format!("stopped before the card was done; the policy is saved in {out}"))?;
                    say(&format!("to go on: athlete evaluate {out} --card"))?;
                    return Ok(interrupt::stopped());
                }
            }
        } else {
            trainer.best().map_or((0.0, 0.0), |b| b.evaluation)
        };
        say(&format!("survival {:.1} % reward {reward:.3}", 100.0 * survival))?;
        Ok(ExitCode::SUCCESS)
    }

    /// Evaluates the policy that was written, as `athlete evaluate` does: its card, and survival and reward over all rows. `None`, and no
    /// card, where that was stopped.
    fn evaluate(&self, out: &Path, after: &[PathBuf]) -> Result<Option<(f64, f64)>, Box<dyn std::error::Error>> {
        let (task, policy) = read_trials(&out.join(POLICY_FILE), None, after, |_, _| Ok(()))?;
        let threads = threads(self.threads)?;
        let command = evaluate_command(out, self.card_trials, TRIALS_SEED);
        let (trials, stop) = (self.card_trials, &interrupt::asked);
        let report = robustness_card_until(&task, &policy, trials, TRIALS_SEED, threads, command, stop)?;
        if report.stopped {
            return Ok(None);
        }
        let card = &report.card;
        card.save(out.join("card.json"))?;
        say_card(&report)?;
        Ok(Some((card.rate(), card.reward_per_step().unwrap_or(f64::NAN))))
    }
}

fn line(news: &Iteration) -> String {
    format!(
        "{:.0} samples/s, reward {:.3}, episodes of {:.2} s, {:.0} % fail",
        news.samples as f64 / news.seconds.max(1e-9),
        news.reward,
        news.length,
        100.0 * news.failed
    )
}

/// Checkpoint, curve as CSV and PNG, and the best policy.
fn save(folder: &RunFolder, trainer: &Trainer) -> Result<(), Box<dyn std::error::Error>> {
    // First what everything else can be made from again.
    write_whole(&folder.place("checkpoint.json"), trainer.checkpoint().as_bytes())?;
    let best = trainer.best().cloned().unwrap_or_else(|| trainer.present());
    folder.begin_results()?;
    let (layers, mut contract) = trained_policy(trainer.task(), &best, folder.motion());
    contract.reference.fingerprint = Some(folder.motion_fingerprint());
    save_policy(folder.place("policy.onnx"), &layers, &contract).map_err(|error| {
        let checkpoint = folder.place("checkpoint.json");
        format!("{error}; {} is saved: the same command with --resume goes on from it", checkpoint.display())
    })?;

    write_whole(&folder.place("curve.csv"), curve_csv(trainer.curve()).as_bytes())?;

    let curve = |name: &str, y: &dyn Fn(&Iteration) -> f64| Curve {
        name: name.into(),
        points: trainer.curve().iter().map(|i| (i.seconds, y(i))).collect(),
    };
    let measured = |i: &Iteration, k: usize| i.evaluation.map_or(f64::NAN, |(s, r)| if k == 0 { s } else { r });
    let charts = [
        Chart {
            title: trainer.task().skill.name.clone(),
            x_label: "seconds".into(),
            low: 0.0,
            high: 1.0,
            curves: vec![
                curve("reward", &|i| i.reward),
                curve("failed", &|i| i.failed),
                curve("survival", &|i| measured(i, 0)),
                curve("measured reward", &|i| measured(i, 1)),
            ],
        },
        Chart {
            title: "kl of the update".into(),
            x_label: "seconds".into(),
            low: 0.0,
            high: 0.08,
            curves: vec![curve("kl", &|i| f64::from(i.kl))],
        },
    ];
    Ok(write_whole(&folder.place("curve.png"), &charts_png(&charts, 900, 320)?)?)
}
