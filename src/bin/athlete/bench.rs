//! `athlete bench`: microseconds per character and step.

use crate::output::{Outcome, bar, say, say_json};
use bevy_athlete::cli::{ArgumentError, BenchRow, LANE_NAMES, time_scene};
use bevy_athlete::scenes::{SCENE_NAMES, scene};
use bevy_athlete::sim::BuildInfo;
use clap::Args;
use serde::Serialize;
use std::process::ExitCode;

/// Time the simulation, on one core. Rows without `play` are the training configuration (fused where the build has the
/// instruction), rows with it never fuse and have the same bits on every machine.
#[derive(Debug, Args)]
pub struct Bench {
    /// Print JSON: {"build": {...}, "rows": [...]}
    #[arg(long)]
    json: bool,
    /// Fewer repetitions: rougher figures in a few seconds
    #[arg(long)]
    quick: bool,
    /// Only scenes whose names contain this; may be repeated
    #[arg(long)]
    scene: Vec<String>,
    /// Only this lane type, such as "8 x f32"; may be repeated
    #[arg(long)]
    lanes: Vec<String>,
}

#[derive(Serialize)]
struct Report {
    build: BuildInfo,
    rows: Vec<BenchRow>,
}

impl Bench {
    pub fn run(&self) -> Outcome {
        let wanted = |name: &str| self.scene.is_empty() || self.scene.iter().any(|part| name.contains(part.as_str()));
        let scenes: Vec<_> = SCENE_NAMES.iter().filter(|n| wanted(n)).filter_map(|n| scene(n)).collect();
        if scenes.is_empty() {
            let valid = format!("a part of {}", SCENE_NAMES.join(", "));
            return Err(ArgumentError::new("--scene", self.scene.join(", "), valid).into());
        }
        if let Some(bad) = self.lanes.iter().find(|l| !LANE_NAMES.contains(&l.as_str())) {
            return Err(ArgumentError::new("--lanes", bad, format!("one of {}", LANE_NAMES.join(", "))).into());
        }
        let lanes: Vec<&str> =
            LANE_NAMES.into_iter().filter(|l| self.lanes.is_empty() || self.lanes.iter().any(|m| m == l)).collect();
        let blocks = if self.quick { 12 } else { 60 };

        let build = BuildInfo::current();
        if !self.json {
            say(&build.to_string())?;
            say(&format!("{:<18} {:<13} {:>6} {:>10} {:>10}", "scene", "lanes", "points", "us min", "us median"))?;
        }
        let bar = bar((scenes.len() * lanes.len()) as u64, "bench");
        let mut rows = Vec::new();
        for scene in &scenes {
            for lanes in &lanes {
                bar.set_message(format!("{} {lanes}", scene.name));
                let Some(row) = time_scene(scene, lanes, blocks) else { continue };
                if !self.json {
                    let BenchRow { scene, lanes, points, us_min, us_median, .. } = &row;
                    bar.suspend(|| {
                        say(&format!("{scene:<18} {lanes:<13} {points:>6.1} {us_min:>10.3} {us_median:>10.3}"))
                    })?;
                }
                rows.push(row);
                bar.inc(1);
            }
        }
        bar.finish_and_clear();
        if self.json {
            say_json(&Report { build, rows })?;
        } else {
            say("microseconds per character and step on one core")?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
