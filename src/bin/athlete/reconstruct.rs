//! `athlete reconstruct`: from a motion to a control whose simulation follows it.

use crate::interrupt;
use crate::motion::load_motion;
use crate::output::{Outcome, bar, complain, say, say_report, say_report_json};
use crate::record::Record;
use crate::simulate::draw;
use crate::world_args::WorldArgs;
use bevy_athlete::cli::{
    ArgumentError, FrameRecorder, PerformOptions, Script, Stopped, check_output, keep_earlier, load_character, perform,
    threads, within,
};
use bevy_athlete::sim::{BuildInfo, SimulationSettings};
use bevy_athlete::train::{ReconstructError, ReconstructOptions, reconstruct};
use clap::Args;
use serde_json::json;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Exit code of a control that was written but follows worse than that.
const FOLLOWS_BADLY: u8 = 3;
/// Over how long the ends of a cycle are blended, s.
const SEAM: f64 = 0.2;

#[derive(Debug, Args)]
pub struct Reconstruct {
    #[arg(long, help = character_help!())]
    character: String,
    /// Motion to follow: a .bvh, .clip.ron or .keyposes.ron file
    #[arg(long)]
    clip: PathBuf,
    #[command(flatten)]
    world: WorldArgs,
    /// Joint map for a .bvh file, instead of the built-in one that knows its skeleton, or the one that is found
    #[arg(long)]
    map: Option<PathBuf>,
    /// Where to write the control (.control.ron)
    #[arg(long)]
    out: Option<PathBuf>,
    /// Repeat the motion so many times, straight on
    #[arg(long, default_value_t = 1)]
    cycles: usize,
    /// Samples in a window
    #[arg(long, default_value_t = ReconstructOptions::default().samples)]
    samples: usize,
    /// States kept after a window
    #[arg(long, default_value_t = ReconstructOptions::default().keep)]
    keep: usize,
    /// Standard deviation of the offsets to the targets, rad
    #[arg(long, default_value_t = ReconstructOptions::default().deviation)]
    deviation: f64,
    /// Stiffness of all servos, N m/rad, instead of the character's
    #[arg(long, requires = "kd")]
    kp: Option<f64>,
    /// Damping of all servos, N m s/rad, instead of the character's
    #[arg(long, requires = "kp")]
    kd: Option<f64>,
    /// Seed: the same one gives the same control, whatever the number of threads
    #[arg(long, default_value_t = ReconstructOptions::default().seed)]
    seed: u64,
    /// Searches that may be made until one is close enough: the second with stiff servos, the third with more samples
    #[arg(long, default_value_t = ReconstructOptions::default().attempts)]
    attempts: usize,
    /// Threads; by default one for each core
    #[arg(long)]
    threads: Option<usize>,
    #[command(flatten)]
    record: Record,
    /// Write a storyboard (PNG) of the result
    #[arg(long)]
    storyboard: Option<PathBuf>,
    /// Replace what is in the file --out
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// An option of the search by the name that it has on the command line, anything else with the file.
pub fn failure(file: &Path, error: ReconstructError) -> Box<dyn Error> {
    match error {
        // No option of the command line: it is the clip that is too long.
        ReconstructError::Option { option: "tick_rate", found, valid } => {
            format!("{}: target updates per second: {found}; valid is {valid}", file.display()).into()
        }
        ReconstructError::Option { option, found, valid } => {
            ArgumentError::new(format!("--{}", option.replace('_', "-")), found, valid).into()
        }
        ReconstructError::Cancelled => Stopped("nothing was found, not even the first window".into()).into(),
        other => format!("{}: {other}", file.display()).into(),
    }
}

impl Reconstruct {
    pub fn run(&self) -> Outcome {
        let defaults = ReconstructOptions::default();
        let gains = self.kp.zip(self.kd);
        if let Some((kp, kd)) = gains {
            within("--kp", kp, 0.0..=1e6, "N m/rad")?;
            within("--kd", kd, 0.0..=1e6, "N m s/rad")?;
        }
        within("--cycles", self.cycles, 1..=10_000, "")?;
        within("--attempts", self.attempts, 1..=100, "")?;
        let threads = threads(self.threads)?;
        let model = load_character(&self.character)?;
        let world = self.world.choose(&model, None)?;
        let mut clip = load_motion(&self.clip, self.map.as_deref(), &model)?;
        if clip.poses.len() < 2 {
            let found = clip.poses.len();
            return Err(format!("{}: {found} pose, so nothing to follow; valid: 2 or more", self.clip.display()).into());
        }
        if self.cycles > 1 {
            clip = clip.repeated_straight(self.cycles, SEAM)?;
        }
        let lift;
        (clip, lift) = clip.lifted_clear(&model)?;
        if clip.duration() > 3600.0 {
            let found = clip.duration();
            return Err(format!("{}: {found:.0} s after repetition; valid is up to 3600 s", self.clip.display()).into());
        }
        // A place that cannot be written is better found before the search than after it.
        if let Some(path) = &self.out {
            check_output("--out", path)?;
            keep_earlier("--out", core::slice::from_ref(path), self.force, "a new file")?;
        }
        if let Some(path) = &self.storyboard {
            check_output("--storyboard", path)?;
        }
        let mut recorder = self.record.recorder(clip.duration())?;
        if world.moves() {
            return Err(
                "--course: it has solids that move; valid: a course that stands still, since windows are searched anew"
                    .into(),
            );
        }
        let solids = world.world()?;
        let options = ReconstructOptions {
            samples: self.samples,
            keep: self.keep,
            deviation: self.deviation,
            gains,
            seed: self.seed,
            attempts: self.attempts,
            threads,
            ..defaults
        };
        interrupt::watch()?;
        let build = BuildInfo::current();
        if !self.json {
            say(&build.to_string())?;
            say(&format!("{} on {world} follows {} ({:.2} s)", model.name, clip.name, clip.duration()))?;
            if lift > 0.001 {
                say(&format!("root lifted by up to {lift:.3} m where the clip is below the ground"))?;
            }
        }

        let bar = bar(1, "reconstruct");
        let begin = Instant::now();
        let found = reconstruct(&model, &solids, &world.to_string(), &clip, &options, |news| {
            bar.set_length(news.windows as u64);
            bar.set_position(news.window as u64 + 1);
            bar.set_message(format!(
                "attempt {}: best cost {:.2}, went back {} times",
                news.attempt + 1,
                news.cost,
                news.backtracks
            ));
            !interrupt::asked()
        });
        bar.finish_and_clear();
        let found = found.map_err(|error| failure(&self.clip, error))?;
        let taken = begin.elapsed().as_secs_f64();
        if let Some(path) = &self.out {
            found.control.save(path)?;
        }
        if interrupt::asked() {
            let (done, whole) = (found.control.seconds, clip.duration());
            let kept = match &self.out {
                Some(path) => format!("saved in {}", path.display()),
                None => "lost without --out".into(),
            };
            complain(&format!("stopped: a control of {done:.2} of {whole:.2} s was found, {kept}"));
            return Ok(interrupt::stopped());
        }

        // Replayed as `simulate --control` would.
        let script = Script::Control(Box::new(found.control));
        let replay = PerformOptions {
            settings: SimulationSettings::of(&model),
            seconds: None,
            kp: None,
            kd: None,
            pushes: vec![],
        };
        let mut frames = self.storyboard.as_ref().map(|_| FrameRecorder::new(script.seconds(), true));
        let report = perform(&model, &solids, &script, &replay, |sim, reference| {
            if let Some(recorder) = &mut recorder {
                recorder.look(sim);
            }
            if let Some(frames) = &mut frames {
                frames.look(sim, reference);
            }
            Ok(())
        })?;
        self.record.save(recorder, &model)?;
        if let (Some(frames), Some(path)) = (frames, &self.storyboard) {
            draw(path, &model, frames, &world, &format!("{}, {} reconstructed", model.name, clip.name), &report)?;
        }

        let asked = options.tolerance;
        let excess = asked.excess(report.fell_at.is_some(), report.worst_root_m, report.mean_joint_deg.to_radians());
        let meets = excess <= 1.0;
        let backtracks = found.report.backtracks;
        if self.json {
            let rest = json!({
                "build": build, "character": model.name, "world": world.to_string(), "clip": clip.name,
                "taken_s": taken, "backtracks": backtracks, "meets": meets, "seed": self.seed,
                "samples": self.samples, "keep": self.keep, "threads": options.threads,
                "out": self.out, "record": self.record.path(), "storyboard": self.storyboard,
            });
            say_report_json(&report, rest)?;
        } else {
            say(&format!("search           {taken:.1} s, went back {backtracks} times"))?;
            let written = [("control", &self.out), ("record", self.record.path()), ("storyboard", &self.storyboard)];
            say_report(&report, &written)?;
            if meets {
                say(&format!("meets            {asked}"))?;
            }
        }
        if meets {
            return Ok(ExitCode::SUCCESS);
        }
        complain(&format!(
            "warning: follows worse than asked ({asked}); more --samples, another --seed or --deviation may help"
        ));
        Ok(ExitCode::from(FOLLOWS_BADLY))
    }
}
