//! `athlete course`: a runner over obstacles, many times.

use crate::output::{Outcome, bar, say, say_json};
use bevy_athlete::asset::card::wilson_interval;
use bevy_athlete::asset::{Course, CourseError};
use bevy_athlete::cli::{
    ArgumentError, CourseEnd, CourseRun, CourseTask, FrameRecorder, Setting, SkillInputError, check_output,
    course_scenery, find_skill, load_character, load_trained_skill, random_course, run_course, single_obstacle,
    threads, within,
};
use bevy_athlete::math::RandomStream;
use bevy_athlete::skill::planner::Clearance;
use bevy_athlete::skill::{CourseView, Director, DirectorInput, Disturbance, SkillDefinition, TrainedSkill};
use bevy_athlete::storyboard::{Ground, Storyboard, StoryboardOptions};
use clap::Args;
use glam::DVec3;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Run a course with a step planner, from fresh random starts, all counted. A run counts if it comes to the finish: without a fall, between the side walls, in time.
#[derive(Debug, Args)]
pub struct CourseCommand {
    /// Obstacles (.course.ron)
    #[arg(required_unless_present_any = ["random", "skill"], conflicts_with_all = ["random", "skill"])]
    course: Option<PathBuf>,
    /// So many random obstacles, of the kinds and sizes that the skills clear, 8 to 20 m apart, other ones in every run
    #[arg(long, value_name = "NUMBER", conflicts_with = "skill")]
    random: Option<usize>,
    /// One obstacle, which this skill clears (one of --skills), at each of --distances
    #[arg(long, value_name = "NAME", requires = "distances")]
    skill: Option<String>,
    /// Distances from the start for --skill: FROM..TO:STEP, m; a run for each
    #[arg(long, value_name = "FROM..TO:STEP", requires = "skill")]
    distances: Option<String>,
    /// Height of the obstacle of --skill, m, or whole: drawn from all that the skill clears
    #[arg(long, default_value = "whole", value_name = "HEIGHT", requires = "skill")]
    height: String,
    /// How it runs: a skill with a gait, its name below assets/skills or the path of a .skill.ron file
    #[arg(long, default_value = "run")]
    run: String,
    /// Skills that clear obstacles, by name or file
    #[arg(long, value_delimiter = ',', default_value = "jump,hop_down,hurdle,gap,leap,step_vault,drop_roll")]
    skills: Vec<String>,
    /// Running speed, m/s
    #[arg(long, default_value_t = 3.2)]
    speed: f64,
    /// A parameter of the course that stays, NAME=NUMBER; may be repeated. All others are drawn for every run
    #[arg(long)]
    set: Vec<Setting>,
    /// Way ahead at which the course is over, m; by default 30, of --random and --skill 8 behind the last obstacle
    #[arg(long)]
    finish: Option<f64>,
    /// Longest time, s; by default three times what the way takes, and at least a minute
    #[arg(long)]
    seconds: Option<f64>,
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
    json!({"end": format!("{:?}", run.end), "fell_by": run.fell_by, "seconds": run.seconds, "begun": run.skills, "seen": run.plans.iter().map(plan).collect::<Vec<_>>()})
}

/// Where the obstacles come from.
enum Source {
    File(Box<Course>),
    Random { clears: Vec<Clearance>, obstacles: usize },
    Distances { clears: Box<Clearance>, from: f64, step: f64, height: Option<f64> },
}

/// Number of the random stream of a course.
const STREAM: u64 = 0x7261_6e64;

/// `30..100:0.1` as the first, the step and how many.
fn distances(text: &str) -> Result<(f64, f64, u64), ArgumentError> {
    let numbers = text.split_once("..").and_then(|(from, rest)| {
        let (to, step) = rest.split_once(':')?;
        Some((from.trim().parse().ok()?, to.trim().parse().ok()?, step.trim().parse().ok()?))
    });
    match numbers {
        Some((from, to, step)) if (1.0..=1e4).contains(&from) && from <= to && to <= 1e4 && step >= 1e-3 => {
            Ok((from, step, ((to - from) / step + 1.0 + 1e-9) as u64))
        }
        _ => Err(ArgumentError::new("--distances", text, "FROM..TO:STEP from 1 to 10000 m, such as 30..100:0.1")),
    }
}

impl CourseCommand {
    /// The course, and how many runs there are.
    fn source(&self, skills: &[Arc<TrainedSkill>]) -> Result<(Source, u64), Box<dyn std::error::Error>> {
        let clears = |skill: &Arc<TrainedSkill>| {
            let clears = skill.definition.clears.clone()?;
            Some(Clearance { skill: skill.name().to_owned(), ..clears })
        };
        let clears: Vec<Clearance> = skills.iter().filter_map(clears).collect();
        if let Some(obstacles) = self.random {
            within("--random", obstacles, 1..=1000, "")?;
            return Ok((Source::Random { clears, obstacles }, self.runs));
        }
        let (Some(name), Some(text)) = (&self.skill, &self.distances) else {
            let file = self.course.as_deref().unwrap_or(Path::new(""));
            return Ok((Source::File(Box::new(Course::read(file)?)), self.runs));
        };
        let (from, step, count) = distances(text)?;
        let height = match self.height.as_str() {
            "whole" => None,
            text => {
                let height = text.parse().ok().filter(|h| (0.01..=20.0).contains(h));
                Some(height.ok_or_else(|| ArgumentError::new("--height", text, "whole, or 0.01 to 20 m"))?)
            }
        };
        let known = || clears.iter().map(|c| c.skill.as_str()).collect::<Vec<_>>().join(", ");
        let chosen = clears.iter().find(|c| c.skill == *name);
        let chosen = chosen.ok_or_else(|| ArgumentError::new("--skill", name, format!("one of {}", known())))?;
        Ok((Source::Distances { clears: Box::new(chosen.clone()), from, step, height }, count))
    }

    /// What run `number` is.
    fn task(&self, source: &Source, number: u64) -> Result<CourseTask, CourseError> {
        let mut random = RandomStream::new(self.seed, STREAM + (number << 32));
        let (course, finish) = match source {
            Source::File(course) => (Course::clone(course), 30.0),
            Source::Random { clears, obstacles } => {
                let found = random_course(clears, *obstacles, &mut random)?;
                (found.course, found.finish)
            }
            Source::Distances { clears, from, step, height } => {
                let found = single_obstacle(clears, from + step * number as f64, *height, &mut random)?;
                (found.course, found.finish)
            }
        };
        let finish = self.finish.unwrap_or(finish);
        Ok(CourseTask {
            values: self.set.iter().map(|s| (s.name.clone(), s.value)).collect(),
            finish,
            seconds: self.seconds.unwrap_or((3.0 * finish / self.speed.max(0.5)).max(60.0)),
            disturbance: Disturbance { joint: 0.02, joint_velocity: 0.1, velocity: 0.05 },
            friction: (0.6, 1.0),
            course,
        })
    }

    pub fn run(&self) -> Outcome {
        within("--runs", self.runs, 1..=1_000_000, "")?;
        within("--speed", self.speed, 0.0..=30.0, "m/s")?;
        self.finish.map(|finish| within("--finish", finish, 0.1..=10_000.0, "m")).transpose()?;
        self.seconds.map(|seconds| within("--seconds", seconds, 0.1..=36_000.0, "s")).transpose()?;
        let threads = threads(self.threads)?;
        self.storyboard.as_ref().map(|path| check_output("--storyboard", path)).transpose()?;
        // A course file that is none is found out before policies are read.
        self.course.as_ref().map(Course::read).transpose()?;
        let first = SkillDefinition::load(find_skill(&self.run)?)?;
        let model = load_character(&first.character)?;
        let names = std::iter::once(&self.run).chain(&self.skills);
        let skills = names.map(|name| Ok(Arc::new(load_trained_skill(name, &model)?)));
        let skills = skills.collect::<Result<Vec<_>, SkillInputError>>()?;
        let (source, count) = self.source(&skills)?;
        let rate = first.simulation_rate(&model);
        let input = DirectorInput { direction: DVec3::NEG_Z, speed: Some(self.speed), ..DirectorInput::default() };
        let director = Director::course(skills, &model, rate)?.with_input(input);
        let task = self.task(&source, 0)?;

        if let Some(path) = &self.storyboard {
            let mut frames = FrameRecorder::new(task.seconds.min(task.finish / self.speed.max(0.5)), false);
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

        let (next, progress) = (AtomicU64::new(0), bar(count, "course"));
        let mut runs = std::thread::scope(|scope| -> Result<Vec<_>, Box<dyn std::error::Error>> {
            let work = || -> Result<Vec<_>, Box<dyn std::error::Error + Send + Sync>> {
                let (mut mine, mut done) = (director.clone(), Vec::new());
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        return Ok(done);
                    }
                    let task = self.task(&source, number)?;
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
        // By name: begun, last before a failure, and of those in the skill itself.
        let mut rows: Vec<(String, usize, usize, usize)> = Vec::new();
        for run in runs {
            for (k, skill) in run.skills.iter().enumerate() {
                let name = skill.trim_end_matches("_mirrored");
                let at = rows.iter().position(|r| r.0 == name).unwrap_or_else(|| {
                    rows.push((name.to_owned(), 0, 0, 0));
                    rows.len() - 1
                });
                rows[at].1 += 1;
                let last = k + 1 == run.skills.len() && run.end != CourseEnd::Finished;
                rows[at].2 += usize::from(last);
                rows[at].3 += usize::from(last && run.left_before.is_none());
            }
        }
        // From start to fall, or from fall to fall where the next run goes on.
        let metres: f64 = runs.iter().map(|r| r.ahead.max(0.0)).sum();
        let between = metres / (runs.len() as u64 - whole).max(1) as f64;
        if self.json {
            let rows: Vec<_> = rows
                .iter()
                .map(|(name, begun, lost, within)| {
                    json!({"name": name, "trials": begun, "successes": begun - lost, "failed_within": within})
                })
                .collect();
            say_json(&json!({
                "course": self.course, "runs": runs.len(), "successes": whole, "fell": ended(CourseEnd::Fell),
                "aside": ended(CourseEnd::Aside), "stopped": ended(CourseEnd::Stopped),
                "mean_metres_between_falls": between, "rows": rows,
                "ahead": runs.iter().map(|r| r.ahead).collect::<Vec<_>>(),
                "left_before": runs.iter().map(|r| r.left_before).collect::<Vec<_>>(),
                "plans": runs.iter().map(plans).collect::<Vec<_>>(),
            }))?;
            return Ok(ExitCode::SUCCESS);
        }
        say(&format!("{:<26} {:>7} {:>24} {:>16}", "skill", "begun", "last before a failure", "of those in it"))?;
        for (name, begun, lost, within) in &rows {
            say(&format!("{name:<26} {begun:>7} {lost:>24} {within:>16}"))?;
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
        say(&format!("{metres:.0} m in all, {between:.0} m for each run that did not come to the finish"))?;
        Ok(ExitCode::SUCCESS)
    }
}
