//! `athlete simulate`: a motion or a control, headless.

use crate::motion::load_motion;
use crate::output::{Outcome, announce_trace, bar, complain, say, say_report, say_report_json};
use crate::record::Record;
use crate::world_args::WorldArgs;
use bevy_athlete::cli::{
    ArgumentError, ChosenWorld, FrameRecorder, PerformOptions, PerformanceReport, Push, Script, WorldSpec,
    check_output, load_character, perform_on,
};
use bevy_athlete::control::ReconstructedControl;
use bevy_athlete::model::{PRESET_NAMES, SharedModel};
use bevy_athlete::sim::{BuildInfo, SimulationSettings, TraceWriter};
use bevy_athlete::storyboard::{Ground, Storyboard, StoryboardOptions};
use clap::{ArgGroup, Args};
use serde_json::json;
use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("script").required(true))]
pub struct Simulate {
    #[arg(long, help = character_help!("; with --control it may be left out"))]
    character: Option<String>,
    #[command(flatten)]
    world: WorldArgs,
    /// Motion to follow by plain stable PD: a .bvh, .clip.ron or .keyposes.ron file
    #[arg(long, group = "script")]
    motion: Option<PathBuf>,
    /// Control to replay: a .control.ron file
    #[arg(long, group = "script")]
    control: Option<PathBuf>,
    /// Joint map for a .bvh file, instead of the built-in one that knows its skeleton, or the one that is found
    #[arg(long, requires = "motion")]
    map: Option<PathBuf>,
    /// Move the motion so that it starts above the world's origin, facing -Z
    #[arg(long, requires = "motion")]
    from_origin: bool,
    /// Seconds to simulate; by default the whole motion. Beyond its end the last pose is held
    #[arg(long)]
    seconds: Option<f64>,
    /// Steps per second, instead of the character's
    #[arg(long)]
    rate: Option<f64>,
    /// Stiffness of all servos, N m/rad, instead of the character's
    #[arg(long, conflicts_with = "control")]
    kp: Option<f64>,
    /// Damping of all servos, N m s/rad, instead of the character's
    #[arg(long, conflicts_with = "control")]
    kd: Option<f64>,
    /// A push, LINK:FX,FY,FZ:START:DURATION (N, s) at the link's centre of mass; may be repeated
    #[arg(long)]
    push: Vec<Push>,
    /// Write a trace (JSON lines, one a step)
    #[arg(long)]
    trace: Option<PathBuf>,
    #[command(flatten)]
    record: Record,
    /// Write a storyboard (PNG): figures at even times, the reference as a ghost, contacts as dots
    #[arg(long)]
    storyboard: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Simulate {
    pub fn run(&self) -> Outcome {
        let (model, script, made_in) = self.script()?;
        let world = self.world.choose(&model, made_in.as_deref()).map_err(|error| match &self.control {
            Some(path) if made_in.is_some() => in_file(path, &error),
            _ => error.to_string(),
        })?;
        let mut settings = SimulationSettings::of(&model);
        if let Script::Control(control) = &script {
            settings.rate = control.rate;
        }
        settings.rate = self.rate.unwrap_or(settings.rate);
        let options =
            PerformOptions { settings, seconds: self.seconds, kp: self.kp, kd: self.kd, pushes: self.push.clone() };
        // Places that cannot be written are better found before the work.
        for (option, path) in [("--trace", &self.trace), ("--storyboard", &self.storyboard)] {
            path.as_ref().map(|path| check_output(option, path)).transpose()?;
        }
        let build = BuildInfo::current();
        if !self.json {
            say(&build.to_string())?;
        }

        let seconds = self.seconds.unwrap_or(script.seconds());
        if self.trace.is_some() {
            announce_trace(&model, seconds * settings.rate);
        }
        let mut trace = None;
        let mut recorder = self.record.recorder(seconds)?;
        let mut frames = self.storyboard.as_ref().map(|_| FrameRecorder::new(seconds, true));
        let bar = bar((seconds * settings.rate).max(0.0) as u64, "simulate");
        let (mut started, mut steps) = (false, 0_u64);
        let report = perform_on(&model, &mut world.terrain(), &script, &options, |sim, reference| {
            let failed = |path: &Path, error: std::io::Error| format!("cannot write {}: {error}", path.display());
            if let Some(path) = &self.trace {
                if started {
                    if let Some(writer) = &mut trace {
                        TraceWriter::record(writer, sim).map_err(|e| failed(path, e))?;
                    }
                } else {
                    let file = File::create(path).map_err(|e| failed(path, e))?;
                    trace = Some(TraceWriter::new(BufWriter::new(file), sim, 0).map_err(|e| failed(path, e))?);
                }
            }
            if let Some(recorder) = &mut recorder {
                recorder.look(sim);
            }
            if let Some(frames) = &mut frames {
                frames.look(sim, reference);
            }
            started = true;
            steps += 1;
            if steps.is_multiple_of(64) {
                bar.set_position(steps);
            }
            Ok(())
        })?;
        bar.finish_and_clear();
        if let (Some(writer), Some(path)) = (trace, &self.trace) {
            writer.finish().map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        }
        self.record.save(recorder, &model)?;
        if let (Some(frames), Some(path)) = (frames, &self.storyboard) {
            let title = format!("{}, {}", model.name, script.clip().name);
            draw(path, &model, frames, &world, &title, &report)?;
        }
        self.print(&model, &world, &script, &options, &report, build)?;
        Ok(ExitCode::SUCCESS)
    }

    /// The character, what it performs, and the world that was made for.
    fn script(&self) -> Result<(SharedModel, Script, Option<String>), Box<dyn Error>> {
        if let Some(path) = &self.control {
            let control = ReconstructedControl::load(path).map_err(|error| in_file(path, &error))?;
            let model = load_character(self.character.as_deref().unwrap_or(&control.character))?;
            control.check_for(&model).map_err(|error| in_file(path, &error))?;
            let world = control.world.clone();
            return Ok((model, Script::Control(Box::new(control)), Some(world)));
        }
        let Some(path) = &self.motion else {
            return Err(ArgumentError::new("--motion", "is missing", "--motion FILE or --control FILE").into());
        };
        let Some(character) = &self.character else {
            let valid = format!("{} or the path of a .character.ron file", PRESET_NAMES.join(", "));
            return Err(ArgumentError::new("--character", "is missing, which --motion needs", valid).into());
        };
        let model = load_character(character)?;
        let mut clip = load_motion(path, self.map.as_deref(), &model)?;
        if self.from_origin {
            clip = clip.moved_to_origin();
        }
        Ok((model, Script::Motion(clip), None))
    }

    fn print(
        &self,
        model: &SharedModel,
        world: &ChosenWorld,
        script: &Script,
        options: &PerformOptions,
        report: &PerformanceReport,
        build: BuildInfo,
    ) -> Result<(), Box<dyn Error>> {
        if self.json {
            let rest = json!({
                "build": build,
                "character": model.name,
                "world": world.to_string(),
                "motion": self.motion,
                "control": self.control,
                "clip": script.clip().name,
                "rate": options.settings.rate,
                "trace": self.trace,
                "record": self.record.path(),
                "storyboard": self.storyboard,
            });
            return say_report_json(report, rest);
        }
        let how = match script {
            Script::Motion(_) => "plain stable PD on",
            Script::Control(_) => "control for",
        };
        say(&format!("{} on {world}, {how} {}, {} steps/s", model.name, script.clip().name, options.settings.rate))?;
        let written = [("trace", &self.trace), ("record", self.record.path()), ("storyboard", &self.storyboard)];
        say_report(report, &written)?;
        if world.course().is_none() && world.spec() == WorldSpec::Empty && report.fell_at.is_some() {
            complain("note: the world is empty, so everything falls");
        }
        Ok(())
    }
}

/// An error that belongs to a file, named once.
pub fn in_file(path: &Path, error: &impl std::fmt::Display) -> String {
    let (path, text) = (path.display().to_string(), error.to_string());
    if text.contains(&path) { text } else { format!("{path}: {text}") }
}

/// Draws the frames of a performance.
pub fn draw(
    path: &Path,
    model: &SharedModel,
    mut frames: FrameRecorder,
    world: &ChosenWorld,
    title: &str,
    report: &PerformanceReport,
) -> Result<(), Box<dyn Error>> {
    if let Some(time) = report.fell_at {
        frames.caption_from(time, "fallen");
    }
    let options = StoryboardOptions {
        ground: if world.spec() == WorldSpec::Ice { Ground::Ice } else { Ground::Floor },
        scenery: world.scenery(),
        title: title.to_owned(),
        ..Default::default()
    };
    Storyboard::new(options).write(model, frames.frames(), path)?;
    Ok(())
}
