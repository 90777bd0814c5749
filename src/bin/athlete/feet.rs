//! `athlete feet`: what the segments of a foot buy.

use crate::interrupt;
use crate::output::{Outcome, bar, complain, say, say_json};
use bevy_athlete::cli::feet::{FeetRow, SearchOptions, experiments, measure_row};
use bevy_athlete::cli::{ArgumentError, threads, within};
use bevy_athlete::control::balance::{BalanceMethod, BalanceSettings};
use clap::Args;
use serde_json::json;
use std::process::ExitCode;

/// Feet of five segments, of two, of two with more contact points, and with single toes, under the same controller: the largest disturbance that is held
/// in 90 % of the episodes, beside what was published (Park, Yu, Lee 2018) and what a linear pendulum allows.
#[derive(Debug, Args)]
pub struct Feet {
    /// Only this row; may be repeated
    #[arg(long)]
    row: Vec<String>,
    /// Fewer and shorter episodes: rougher figures
    #[arg(long)]
    quick: bool,
    /// Episodes a point, 1 to 1000; by default 50, with --quick 10
    #[arg(long)]
    trials: Option<usize>,
    /// How forces of the ground are chosen: cones, or pressure as published
    #[arg(long, default_value = "cones")]
    method: String,
    /// Decisions per second, 10 to 2000
    #[arg(long)]
    rate: Option<f64>,
    /// Number of the first episode
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Threads; by default one for each core
    #[arg(long)]
    threads: Option<usize>,
    /// Print JSON: {"rows": [...]}
    #[arg(long)]
    json: bool,
}

/// Settings of the balance, as `--method` and `--rate` ask.
pub fn balance_settings(method: &str, rate: Option<f64>) -> Result<BalanceSettings, ArgumentError> {
    let method = match method {
        "cones" => BalanceMethod::Cones,
        "pressure" => BalanceMethod::Pressure,
        other => return Err(ArgumentError::new("--method", other, "cones or pressure")),
    };
    let mut settings = BalanceSettings { method, steps: 0, ..BalanceSettings::default() };
    if let Some(rate) = rate {
        settings.rate = within("--rate", rate, 10.0..=2000.0, "per second")?;
    }
    Ok(settings)
}

impl Feet {
    pub fn run(&self) -> Outcome {
        let all = experiments();
        let names: Vec<&str> = all.iter().map(|e| e.name).collect();
        if let Some(bad) = self.row.iter().find(|r| !names.contains(&r.as_str())) {
            return Err(ArgumentError::new("--row", bad, format!("one of {}", names.join(", "))).into());
        }
        let trials = self.trials.unwrap_or(if self.quick { 10 } else { 50 });
        within("--trials", trials, 1..=1000, "")?;
        let settings = balance_settings(&self.method, self.rate)?;
        let options = SearchOptions { trials, part: 0.9, seed: self.seed, threads: threads(self.threads)? };
        let long = if self.quick { 12.0 } else { 60.0 };

        let chosen: Vec<_> =
            all.iter().filter(|e| self.row.is_empty() || self.row.iter().any(|r| r == e.name)).collect();
        interrupt::watch()?;
        let count = chosen.len();
        let bar = bar(count as u64, "feet");
        let mut rows = Vec::new();
        if !self.json {
            say(&format!(
                "{:<20} {:>8} {:>8} {:>8} {:>9} {:>8} {:>9} {:>9} {:>8}",
                "experiment", "unit", "multi", "two", "more pts", "toes", "pub multi", "pub two", "bound"
            ))?;
        }
        for experiment in chosen {
            if interrupt::asked() {
                break;
            }
            bar.set_message(experiment.name);
            let row = measure_row(experiment, settings, &options, long)?;
            bar.inc(1);
            if !self.json {
                bar.suspend(|| say(&line(&row)))?;
            }
            rows.push(row);
        }
        bar.finish_and_clear();
        if self.json {
            say_json(&json!({ "rows": rows }))?;
        }
        if rows.len() < count {
            complain(&format!("stopped after {} of {count} rows", rows.len()));
            return Ok(interrupt::stopped());
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// A row in words; a dash where there is no figure.
fn line(row: &FeetRow) -> String {
    let figure = |x: Option<f64>| {
        x.map_or_else(|| "-".to_owned(), |x| if x < 1.0 { format!("{x:.3}") } else { format!("{x:.1}") })
    };
    format!(
        "{:<20} {:>8} {:>8} {:>8} {:>9} {:>8} {:>9} {:>9} {:>8}",
        row.experiment,
        row.unit,
        figure(row.multi),
        figure(row.two),
        figure(row.two_more_points),
        figure(row.toes),
        figure(row.published_multi),
        figure(row.published_two),
        figure(row.bound)
    )
}
