//! `athlete course`: a runner over obstacles, many times.

use crate::output::{Outcome, bar, say, say_json};
use bevy_athlete::asset::Course;
use bevy_athlete::asset::card::wilson_interval;
use bevy_athlete::cli::{
    CourseEnd, CourseRun, CourseTask, FrameRecorder, Setting, SkillInputError, check_output, course_scenery,
    find_skill, load_character, load_trained_skill, run_course, threads, within,
};
use bevy_athlete::skill::{CourseView, Director, DirectorInput, Disturbance, SkillDefinition};
use bevy_athlete::storyboard::{Ground, Storyboard, StoryboardOptions};
use clap::Args;
use glam::DVec3;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Run a course with a step planner, from fresh random starts, all counted. A run counts if it comes to the finish: without a fall, between the side walls, in time.
#[derive(Debug, Args)]
pub struct CourseCommand {
    /// Obstacles (.course.ron)
    course: PathBuf,
    /// How it runs: a skill with a gait, its name below assets/skills or the path of a .skill.ron file
    #[arg(long, default_value = "run")]
    run: String,
    /// Skills that clear obstacles, by name or file
    #[arg(long, value_delimiter = ',', default_value = "jump,hop_down,hurdle,gap")]
    skills: Vec<String>,
    /// Running speed, m/s
    #[arg(long, default_value_t = 3.2)]
    speed: f64,
    /// A parameter of the course that stays, NAME=NUMBER; may be repeated. All others are drawn for every run
    #[arg(long)]
    set: Vec<Setting>,
    /// Way ahead at which the course is over, m
    #[arg(long, default_value_t = 30.0)]
    finish: f64,
    /// Longest time, s
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Runs
    #[arg(long, default_value_t = 100)]
    runs: u64,
    /// Seed of the runs
    #[arg(long, default_value_t = 1_000_003)]
    seed: u64,
    /// Threads; by default one for each core
    #[arg(long)]
    threads: Option<usize>,
    /// Write a storyboard (PNG) of the first run
    #[arg(long)]
    storyboard: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What a run saw and planned, and which skills it began.
fn plans(run: &CourseRun) -> serde_json::Value {
    let plan = |(time, view, skill): &(f64, CourseView, Option<String>)| {
        let o = &view.obstacle;
        json!({
            "time": time, "kind": format!("{:?}", o.kind), "distance": o.distance, "height": o.height, "depth": o.depth,
            "skill": skill, "refused": view.plan.err().map(|reason| reason.to_string()),
        })
    };
    json!({"end": format!("{:?}", run.end), "seconds": run.seconds, "begun": run.skills, "seen": run.plans.iter().map(plan).collect::<Vec<_>>()})
}

impl CourseCommand {
    pub fn run(&self) -> Outcome {
        within("--runs", self.runs, 1..=1_000_000, "")?;
        within("--speed", self.speed, 0.0..=30.0, "m/s")?;
        within("--finish", self.finish, 0.1..=10_000.0, "m")?;
        within("--seconds", self.seconds, 0.1..=3600.0, "s")?;
        let threads = threads(self.threads)?;
        self.storyboard.as_ref().map(|path| check_output("--storyboard", path)).transpose()?;
        let course = Course::read(&self.course)?;
        let first = SkillDefinition::load(find_skill(&self.run)?)?;
        let model = load_character(&first.character)?;
        let names = std::iter::once(&self.run).chain(&self.skills);
        let skills = names.map(|name| Ok(Arc::new(load_trained_skill(name, &model)?)));
        let skills = skills.collect::<Result<Vec<_>, SkillInputError>>()?;
        let rate = first.simulation_rate(&model);
        let input = DirectorInput { direction: DVec3::NEG_Z, speed: Some(self.speed), ..DirectorInput::default() };
        let director = Director::course(skills, &model, rate)?.with_input(input);
        let task = CourseTask {
            values: self.set.iter().map(|s| (s.name.clone(), s.value)).collect(),
            finish: self.finish,
            seconds: self.seconds,
            disturbance: Disturbance { joint: 0.02, joint_velocity: 0.1, velocity: 0.05 },
            friction: (0.6, 1.0),
            course,
        };

        if let Some(path) = &self.storyboard {
            let mut frames = FrameRecorder::new(self.seconds.min(self.finish / self.speed.max(0.5)), false);
            run_course(&mut director.clone(), &model, &task, (self.seed, 0), |sim, director| {
                frames.look(sim, &director.player().reference_pose());
            })??;
            let options = StoryboardOptions {
                ground: Ground::Floor,
                title: task.course.name.clone(),
                scenery: course_scenery(&task.instance((self.seed, 0))?),
                ..Default::default()
            };
            Storyboard::new(options).write(&model, frames.frames(), path)?;
        }

        let (next, progress) = (AtomicU64::new(0), bar(self.runs, "course"));
        let mut runs = std::thread::scope(|scope| -> Result<Vec<_>, Box<dyn std::error::Error>> {
            let work = || -> Result<Vec<_>, Box<dyn std::error::Error + Send + Sync>> {
                let (mut mine, mut done) = (director.clone(), Vec::new());
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= self.runs {
                        return Ok(done);
                    }
                    done.push((number, run_course(&mut mine, &model, &task, (self.seed, number), |_, _| {})??));
                    progress.inc(1);
                }
            };
            let handles: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            let mut all = Vec::new();
            for handle in handles {
                all.extend(
                    handle.join().map_err(|_| "a thread panicked")?.map_err(|e| e as Box<dyn std::error::Error>)?,
                );
            }
            Ok(all)
        })?;
        progress.finish_and_clear();
        runs.sort_by_key(|(number, _)| *number);
        let runs: Vec<CourseRun> = runs.into_iter().map(|(_, run)| run).collect();
        self.report(&runs)
    }

    fn report(&self, runs: &[CourseRun]) -> Outcome {
        let ended = |end: CourseEnd| runs.iter().filter(|r| r.end == end).count() as u64;
        let whole = ended(CourseEnd::Finished);
        let mut rows: Vec<(String, usize, usize)> = Vec::new();
        for run in runs {
            for (k, skill) in run.skills.iter().enumerate() {
                let name = skill.trim_end_matches("_mirrored");
                let at = rows.iter().position(|r| r.0 == name).unwrap_or_else(|| {
                    rows.push((name.to_owned(), 0, 0));
                    rows.len() - 1
                });
                rows[at].1 += 1;
                rows[at].2 += usize::from(k + 1 == run.skills.len() && run.end != CourseEnd::Finished);
            }
        }
        if self.json {
            let rows: Vec<_> = rows
                .iter()
                .map(|(name, begun, lost)| json!({"skill": name, "begun": begun, "last_before_the_end": lost}))
                .collect();
            say_json(&json!({
                "course": self.course, "runs": runs.len(), "finished": whole, "fell": ended(CourseEnd::Fell),
                "aside": ended(CourseEnd::Aside), "stopped": ended(CourseEnd::Stopped), "skills": rows,
                "ahead": runs.iter().map(|r| r.ahead).collect::<Vec<_>>(),
                "plans": runs.iter().map(plans).collect::<Vec<_>>(),
            }))?;
            return Ok(ExitCode::SUCCESS);
        }
        say(&format!("{:<26} {:>7} {:>24}", "skill", "begun", "last before a failure"))?;
        for (name, begun, lost) in &rows {
            say(&format!("{name:<26} {begun:>7} {lost:>24}"))?;
        }
        let refused = runs.iter().filter_map(|r| r.plans.iter().filter_map(|(_, view, _)| view.plan.err()).next_back());
        if let Some(reason) = refused.clone().next_back() {
            say(&format!("an obstacle that was refused: {reason}"))?;
        }
        let (low, high) = wilson_interval(whole, runs.len() as u64);
        say(&format!(
            "{whole} of {} runs to the finish, {:.1} % (95 % interval {:.1} to {:.1}); {} fell, {} went aside, {} stopped",
            runs.len(),
            100.0 * whole as f64 / runs.len() as f64,
            100.0 * low,
            100.0 * high,
            ended(CourseEnd::Fell),
            ended(CourseEnd::Aside),
            ended(CourseEnd::Stopped),
        ))?;
        Ok(ExitCode::SUCCESS)
    }
}
