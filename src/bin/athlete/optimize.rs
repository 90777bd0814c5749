//! `athlete optimize`: from the key poses of a skill and their windows to a motion that was simulated.

use crate::interrupt;
use crate::output::{Outcome, bar, complain, say, say_json};
use crate::simulate::draw;
use bevy_athlete::asset::Character;
use bevy_athlete::asset::clip::MotionClip;
use bevy_athlete::cli::{
    ChosenWorld, FrameRecorder, PerformOptions, PerformanceReport, Script, Stopped, WorldSpec, check_folder,
    find_key_poses, keep_earlier, load_character, perform, threads, within,
};
use bevy_athlete::control::{MotionRecorder, ReconstructedControl};
use bevy_athlete::model::{KeyPoses, SharedModel};
use bevy_athlete::sim::{BuildInfo, SimulationSettings};
use bevy_athlete::train::ReconstructOptions;
use bevy_athlete::train::optimize::{Checkpoint, Kept, News, OptimizeOptions, Optimized, Plan, TrialCosts, optimize};
use clap::Args;
use serde_json::{Value, json};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Exit code where the result falls.
const FALLS: u8 = 3;

#[derive(Debug, Args)]
pub struct Optimize {
    /// Name of a skill below assets/skills, or path of a .keyposes.ron file
    skill: String,
    /// Name of a preset or path of a .character.ron file; by default the one that the key poses name
    #[arg(long)]
    character: Option<String>,
    /// ice, ground, empty, stairs, sphere or slope:DEGREES; by default ice for a character with blades, else ground
    #[arg(long)]
    world: Option<WorldSpec>,
    /// Folder for clip, control, storyboard and checkpoint; by default that of the key poses
    #[arg(long)]
    out: Option<PathBuf>,
    /// Generations for each pair of windows, instead of the file's
    #[arg(long)]
    iterations: Option<u64>,
    /// Seed instead of the file's: the same one gives the same motion, whatever the number of threads
    #[arg(long)]
    seed: Option<u64>,
    /// Threads; by default one for each core
    #[arg(long)]
    threads: Option<usize>,
    /// Generations end early so that the whole takes about so long; the motion then depends on the machine
    #[arg(long)]
    minutes: Option<f64>,
    /// Begin at the bare key poses, not at a control found by sampling
    #[arg(long)]
    no_samcon: bool,
    /// Samples in a window of the control found by sampling
    #[arg(long, default_value_t = ReconstructOptions::default().samples)]
    samples: usize,
    /// Go on after the last window of a run that was stopped
    #[arg(long)]
    resume: bool,
    /// Replace clip, control, storyboard and checkpoint in the folder
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Optimize {
    pub fn run(&self) -> Outcome {
        let file = find_key_poses(&self.skill)?;
        let poses = KeyPoses::load(&file)?;
        let own = Character::beside(&file, &poses.character);
        let model = load_character(self.character.as_deref().unwrap_or(&own))?;
        let plan = Plan::new(&poses, &model).map_err(|error| format!("{}: {error}", file.display()))?;
        let world = self.world.unwrap_or_else(|| WorldSpec::default_for(&model));
        self.minutes.map(|minutes| within("--minutes", minutes, 0.01..=1e4, "")).transpose()?;
        self.iterations.map(|n| within("--iterations", n, 1..=1_000_000, "")).transpose()?;
        within("--samples", self.samples, 4..=1 << 20, "")?;
        let threads = threads(self.threads)?;
        let folder = match &self.out {
            Some(folder) => folder.clone(),
            None => file.parent().map(PathBuf::from).unwrap_or_default(),
        };
        check_folder("--out", &folder)?;
        let stem = file.file_name().unwrap_or_default().to_string_lossy().replace(".keyposes.ron", "");
        let place = |ending: &str| folder.join(format!("{stem}.{ending}"));
        let mut results: Vec<PathBuf> = ["clip.ron", "control.ron", "storyboard.png"].map(place).into();
        if !self.resume {
            results.push(place("optimize.ron"));
        }
        keep_earlier("--out", &results, self.force, "a folder without them (--out), --resume after a stopped run")?;

        let defaults = ReconstructOptions::default();
        let options = OptimizeOptions {
            iterations: self.iterations,
            seed: self.seed,
            threads,
            seconds: self.minutes.map(|m| 60.0 * m),
            samcon: (!self.no_samcon).then(|| ReconstructOptions {
                samples: self.samples,
                keep: defaults.keep.min(self.samples),
                ..defaults
            }),
        };
        let saved = place("optimize.ron");
        let resume = if self.resume { Some(Checkpoint::load(&saved)?) } else { None };
        interrupt::watch()?;
        let build = BuildInfo::current();
        if !self.json {
            say(&build.to_string())?;
            say(&format!(
                "{} on {world}: {}, {:.2} s in {} windows",
                model.name,
                plan.name,
                plan.seconds(),
                plan.windows.len()
            ))?;
            if let Some(saved) = &resume {
                say(&format!("goes on after window {}", saved.done()))?;
            }
        }

        let begin = Instant::now();
        let result = self.search(&plan, world, &options, resume, &saved)?;
        let taken = begin.elapsed().as_secs_f64();
        let (clip, report, frames) = replay(&model, world, &plan.name, &result.control)?;
        let outcome = Replayed { report, tracking: track(&model, world, &clip)? };
        clip.rounded().save(place("clip.ron"))?;
        result.control.save(place("control.ron"))?;
        let storyboard = place("storyboard.png");
        let title = format!("{}, {} optimised", model.name, plan.name);
        draw(&storyboard, &model, frames, &ChosenWorld::named(world), &title, &outcome.report)?;
        // A missing checkpoint is what is wanted.
        let _ = std::fs::remove_file(&saved);

        let fell = outcome.report.fell_at.is_some();
        if self.json {
            let files = json!({
                "clip": place("clip.ron"), "control": place("control.ron"), "storyboard": storyboard,
            });
            say_json(&json!({
                "build": build, "character": model.name, "world": world.to_string(), "skill": plan.name,
                "taken_s": taken, "seed": self.seed.unwrap_or(plan.record.seed), "threads": options.threads,
                "kept": if result.kept == Kept::Optimized { "optimized" } else { "first" },
                "cost_before": result.before.total(), "cost_after": result.after.total(),
                "windows": windows_json(&plan, &result), "dimension": result.dimension,
                "candidates": result.candidates, "performance": outcome.report,
                "tracking_survives_s": outcome.survives(), "files": files,
            }))?;
        } else {
            print(&plan, &result)?;
            outcome.print(taken)?;
            for (what, ending) in [("clip", "clip.ron"), ("control", "control.ron"), ("storyboard", "storyboard.png")] {
                say(&format!("{what:<16} {}", place(ending).display()))?;
            }
        }
        if !fell {
            return Ok(ExitCode::SUCCESS);
        }
        complain(
            "warning: the motion falls; easier key poses, more --iterations or --samples, or another --seed may help",
        );
        Ok(ExitCode::from(FALLS))
    }

    /// The search with its bar and its checkpoints.
    fn search(
        &self,
        plan: &Plan,
        world: WorldSpec,
        options: &OptimizeOptions,
        resume: Option<Checkpoint>,
        saved: &PathBuf,
    ) -> Result<Optimized, Box<dyn Error>> {
        let iterations = self.iterations.unwrap_or(plan.record.iterations);
        let bar = bar(iterations * plan.windows.len() as u64, "optimize");
        let mut failure = None;
        let result = optimize(plan, &world.world(), &world.to_string(), options, resume, |news| {
            match news {
                News::First(news) => {
                    let (at, of) = (news.window + 1, news.windows);
                    bar.set_message(format!("sampling {at}/{of}, attempt {}, cost {:.2}", news.attempt + 1, news.cost));
                }
                News::Generation { window, generation, before, best } => {
                    bar.set_position(window as u64 * iterations + generation);
                    bar.set_message(format!("window {}, best cost {best:.3}, was {before:.3}", window + 1));
                }
                News::Window(checkpoint) => failure = checkpoint.save(saved).err(),
            }
            failure.is_none() && !interrupt::asked()
        });
        bar.finish_and_clear();
        match failure {
            Some(failure) => Err(failure.into()),
            None if result.is_err() && interrupt::asked() => {
                let found = match saved.exists() {
                    true => {
                        format!("the windows that were done are in {}: --resume goes on from there", saved.display())
                    }
                    false => "no window was done yet".into(),
                };
                Err(Stopped(found).into())
            }
            None => Ok(result?),
        }
    }
}

/// What a replay and the tracking of the recorded clip showed.
struct Replayed {
    report: PerformanceReport,
    tracking: PerformanceReport,
}

impl Replayed {
    /// How long open-loop tracking of the clip by plain stable PD stays on its feet, s.
    fn survives(&self) -> f64 {
        self.tracking.fell_at.unwrap_or(self.tracking.seconds)
    }

    fn print(&self, taken: f64) -> Result<(), Box<dyn Error>> {
        let report = &self.report;
        say(&format!("time             {taken:.1} s"))?;
        match (report.fell_at, report.fall) {
            (Some(time), Some(fall)) => say(&format!("fell             at {time:.3} s ({fall})"))?,
            _ => say("fell             no")?,
        }
        say(&format!("root error       {:.3} m at worst", report.worst_root_m))?;
        say(&format!("joint error      {:.2} degrees on average", report.mean_joint_deg))?;
        say(&format!("final state      {}", report.fingerprint))?;
        say(&format!(
            "tracking         plain PD on the clip stays up for {:.2} of {:.2} s",
            self.survives(),
            self.tracking.seconds
        ))
    }
}

/// The control as `simulate --control` would play it: recorded, measured, and watched for a storyboard.
fn replay(
    model: &SharedModel,
    world: WorldSpec,
    name: &str,
    control: &ReconstructedControl,
) -> Result<(MotionClip, PerformanceReport, FrameRecorder), Box<dyn Error>> {
    let mut recorder = MotionRecorder::new(0, MotionRecorder::DEFAULT_RATE, control.seconds)?;
    let mut frames = FrameRecorder::new(control.seconds, true);
    let script = Script::Control(Box::new(control.clone()));
    let report = perform(model, &world.world(), &script, &plainly(model), |sim, reference| {
        recorder.look(sim);
        frames.look(sim, reference);
        Ok(())
    })?;
    Ok((recorder.into_clip(name, model)?, report, frames))
}

/// The clip tracked by plain stable PD.
fn track(model: &SharedModel, world: WorldSpec, clip: &MotionClip) -> Result<PerformanceReport, Box<dyn Error>> {
    Ok(perform(model, &world.world(), &Script::Motion(clip.clone()), &plainly(model), |_, _| Ok(()))?)
}

fn plainly(model: &SharedModel) -> PerformOptions {
    PerformOptions { settings: SimulationSettings::of(model), seconds: None, kp: None, kd: None, pushes: vec![] }
}

/// The cost of objective `k` of a window, if it was reached.
fn cost_of(costs: &TrialCosts, window: usize, k: usize) -> f64 {
    costs.windows.get(window).and_then(|w| w.get(k)).copied().unwrap_or(0.0)
}

fn windows_json(plan: &Plan, result: &Optimized) -> Vec<Value> {
    let window = |(w, window): (usize, &bevy_athlete::train::optimize::PlannedWindow)| {
        let terms: Vec<Value> = window
            .objectives
            .iter()
            .enumerate()
            .map(|(k, o)| {
                json!({
                    "objective": o.label(), "before": cost_of(&result.before, w, k), "after": cost_of(&result.after, w, k),
                })
            })
            .collect();
        json!({ "window": window.label, "objectives": terms })
    };
    plan.windows.iter().enumerate().map(window).collect()
}

/// Every window with its objectives before and after, and what was kept.
fn print(plan: &Plan, result: &Optimized) -> Result<(), Box<dyn Error>> {
    for (w, window) in plan.windows.iter().enumerate() {
        let seconds = |tick: usize| tick as f64 / plan.reference.tick_rate;
        say(&format!(
            "window {:<2} {:<11} {:.2} to {:.2} s",
            w + 1,
            format!("({})", window.label),
            seconds(window.ticks.start),
            seconds(window.ticks.end)
        ))?;
        for (k, objective) in window.objectives.iter().enumerate() {
            let (before, after) = (cost_of(&result.before, w, k), cost_of(&result.after, w, k));
            say(&format!("  {:<28} {before:>9.3} -> {after:>9.3}", objective.label()))?;
        }
    }
    let falls = |costs: &TrialCosts| match costs.fell_at {
        Some(tick) => format!(" (falls at {:.2} s)", tick as f64 / plan.reference.tick_rate),
        None => String::new(),
    };
    let (before, after) = (&result.before, &result.after);
    say(&format!("cost             {:.2}{} -> {:.2}{}", before.total(), falls(before), after.total(), falls(after)))?;
    say(match result.kept {
        Kept::Optimized => "kept             the optimised control",
        Kept::First => "kept             the control the search began with: the optimised one costs more",
    })?;
    say(&format!("search           {} candidates, {} variables at most", result.candidates, result.dimension))
}
