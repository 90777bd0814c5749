//! `athlete program`: one skill after the other, many times.

use crate::interrupt;
use crate::motion;
use crate::output::{Outcome, bar, complain, say, say_json};
use bevy_athlete::asset::card::wilson_interval;
use bevy_athlete::cli::{
    ArgumentError, FrameRecorder, SKILLS_FOLDER, check_output, find_program, load_character, load_trained_skill_with,
    run_program, threads, within,
};
use bevy_athlete::contact::World;
use bevy_athlete::sim::TraceWriter;
use bevy_athlete::skill::{Director, ProgramDefinition, TrialOptions};
use bevy_athlete::storyboard::{Ground, Storyboard, StoryboardOptions};
use clap::Args;
use serde_json::json;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Perform a program of trained skills from fresh random starts, all counted, element by element. A run fails by a fall.
#[derive(Debug, Args)]
pub struct Program {
    /// A program: its name below assets/skills, or the path of a .program.ron file
    program: String,
    /// Performances
    #[arg(long, default_value_t = 100)]
    runs: u64,
    /// Seed of the performances
    #[arg(long, default_value_t = 1_000_003)]
    seed: u64,
    /// Threads; by default one for each core
    #[arg(long)]
    threads: Option<usize>,
    /// Write a storyboard (PNG) of the first performance
    #[arg(long)]
    storyboard: Option<PathBuf>,
    /// Write a trace (JSON lines, one a step) of the first performance
    #[arg(long)]
    trace: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Program {
    pub fn run(&self) -> Outcome {
        within("--runs", self.runs, 1..=1_000_000, "")?;
        let threads = threads(self.threads)?;
        for (option, path) in [("--trace", &self.trace), ("--storyboard", &self.storyboard)] {
            path.as_ref().map(|path| check_output(option, path)).transpose()?;
        }
        let file = find_program(&self.program).ok_or_else(|| {
            let valid = format!("the path of a .program.ron file, or a name of {SKILLS_FOLDER}/*/NAME.program.ron");
            ArgumentError::new("program", &self.program, valid)
        })?;
        let program = ProgramDefinition::load(&file)?;
        let model = load_character(&program.character)?;
        let mut skills = BTreeMap::new();
        for element in &program.elements {
            if !skills.contains_key(&element.skill) {
                let skill = load_trained_skill_with(&element.skill, &model, &mut motion::tell)?;
                skills.insert(element.skill.clone(), Arc::new(skill));
            }
        }
        let director = Director::program(&program, &skills, model.step_rate)?;
        let (world, trial) = (World::ice(), TrialOptions::default());

        let mut frames = self.storyboard.as_ref().map(|_| FrameRecorder::new(60.0, true));
        let mut trace = match &self.trace {
            None => None,
            Some(path) => Some(BufWriter::new(File::create(path).map_err(|e| format!("{}: {e}", path.display()))?)),
        };
        if frames.is_some() || trace.is_some() {
            let mut writer = None;
            let mut failed = None;
            run_program(&mut director.clone(), &model, &world, &trial, (self.seed, 0), |sim, director| {
                if let Some(frames) = &mut frames {
                    frames.look(sim, &director.player().reference_pose());
                }
                let written = match (&mut writer, trace.take()) {
                    (None, Some(out)) => TraceWriter::new(out, sim, 0).map(|w| writer = Some(w)),
                    (Some(w), _) => TraceWriter::record(w, sim),
                    _ => Ok(()),
                };
                failed = failed.take().or(written.err());
            })?;
            if let Some(error) = failed {
                return Err(format!("--trace: {error}").into());
            }
        }
        if let (Some(path), Some(frames)) = (&self.storyboard, &frames) {
            let options = StoryboardOptions { ground: Ground::Ice, title: program.name.clone(), ..Default::default() };
            Storyboard::new(options).write(&model, frames.frames(), path)?;
        }

        interrupt::watch()?;
        let (next, progress) = (AtomicU64::new(0), bar(self.runs, "program"));
        let runs = std::thread::scope(|scope| -> Result<Vec<_>, Box<dyn std::error::Error>> {
            let work = || -> Result<Vec<_>, bevy_athlete::control::PolicyError> {
                let (mut mine, mut done) = (director.clone(), Vec::new());
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= self.runs || (interrupt::asked() && !done.is_empty()) {
                        return Ok(done);
                    }
                    done.push(run_program(&mut mine, &model, &world, &trial, (self.seed, number), |_, _| {})?);
                    progress.inc(1);
                }
            };
            let handles: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            let mut all = Vec::new();
            for handle in handles {
                all.extend(handle.join().map_err(|_| "a thread panicked")??);
            }
            Ok(all)
        })?;
        progress.finish_and_clear();
        let (count, stopped) = (runs.len() as u64, interrupt::asked());
        if stopped {
            complain(&format!("stopped after {count} of {} performances", self.runs));
        }
        let end = if stopped { interrupt::stopped() } else { ExitCode::SUCCESS };

        let elements = &program.elements;
        let reached = |k: usize| runs.iter().filter(|r| r.element >= k).count();
        let fell = |k: usize| runs.iter().filter(|r| r.element == k && r.fell).count();
        let whole = runs.iter().filter(|r| !r.fell).count() as u64;
        if self.json {
            let rows: Vec<_> = (elements.iter().enumerate())
                .map(|(k, e)| json!({"name": e.skill, "trials": reached(k), "successes": reached(k) - fell(k)}))
                .collect();
            say_json(
                &json!({"program": program.name, "runs": count, "successes": whole, "rows": rows, "stopped": stopped}),
            )?;
            return Ok(end);
        }
        say(&format!(
            "{:<3} {:<26} {:>7} {:>6}  {}",
            "", "element", "reached", "falls", "transition from the one before"
        ))?;
        for (k, element) in elements.iter().enumerate() {
            let graph = director.graph();
            let skill = |k: usize| graph.index(&elements.get(k)?.skill);
            let before = k.checked_sub(1).and_then(skill).zip(skill(k));
            let transition = before.and_then(|(from, to)| graph.transition(from, to)).map_or(String::new(), |t| {
                format!("from tick {} to tick {}, distance {:.2}", t.leave, t.enter, t.distance)
            });
            say(&format!("{:<3} {:<26} {:>7} {:>6}  {transition}", k + 1, element.skill, reached(k), fell(k)))?;
        }
        let (low, high) = wilson_interval(whole, count);
        say(&format!(
            "{whole} of {count} performances without a fall, {:.1} % (95 % interval {:.1} to {:.1})",
            100.0 * whole as f64 / count as f64,
            100.0 * low,
            100.0 * high
        ))?;
        Ok(end)
    }
}
