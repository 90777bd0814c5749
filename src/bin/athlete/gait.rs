//! `athlete gait`: a walk as a gait laboratory measures it.

use crate::output::{Outcome, say, say_json};
use bevy_athlete::cli::gait::{
    Agreement, Curve as GaitCurve, GaitReport, GaitTask, POINTS, People, agreement, csv_text, gait_report, mot_text,
    record_gait, sto_text,
};
use bevy_athlete::cli::{check_output, find_skill, load_character, load_trained_skill, within, write_whole};
use bevy_athlete::skill::{Director, Disturbance, SkillDefinition};
use bevy_athlete::storyboard::{Chart, Curve, charts_png};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Walk straight on over level ground and measure the gait: forces, pressure path, ankle moment, toe angle and the stiffness that the policy sets, as means
/// over 20 strides of each foot, low-passed at 20 Hz. With --people, beside tables of people.
#[derive(Debug, Args)]
pub struct Gait {
    /// A skill with a gait: its name below assets/skills, or the path of a .skill.ron file
    #[arg(default_value = "walk")]
    skill: String,
    /// Commanded speed, m/s
    #[arg(long, default_value_t = 1.2)]
    speed: f64,
    /// Measured time, s; the first 5 s are not measured
    #[arg(long, default_value_t = 40.0)]
    seconds: f64,
    /// Tables of people (.csv), known by the names of their columns: ankle_moment, vertical_grf, cop_pct; may be repeated
    #[arg(long, value_name = "FILE")]
    people: Vec<PathBuf>,
    /// Seed of the start
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Draw the curves (PNG)
    #[arg(long)]
    plot: Option<PathBuf>,
    /// Write all samples, comma separated
    #[arg(long)]
    csv: Option<PathBuf>,
    /// Write forces of the ground as an OpenSim storage file (.sto)
    #[arg(long)]
    sto: Option<PathBuf>,
    /// Write angles of ankles and toes as an OpenSim motion file (.mot)
    #[arg(long)]
    mot: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Time before the first measurement, s.
const SETTLE: f64 = 5.0;

impl Gait {
    pub fn run(&self) -> Outcome {
        within("--speed", self.speed, 0.1..=10.0, "m/s")?;
        within("--seconds", self.seconds, 1.0..=3600.0, "s")?;
        let outputs = [("--plot", &self.plot), ("--csv", &self.csv), ("--sto", &self.sto), ("--mot", &self.mot)];
        for (option, path) in outputs {
            path.as_ref().map(|path| check_output(option, path)).transpose()?;
        }
        let people = People::read(&self.people)?;
        let definition = SkillDefinition::load(find_skill(&self.skill)?)?;
        let model = load_character(&definition.character)?;
        let skill = Arc::new(load_trained_skill(&self.skill, &model)?);
        let mut director = Director::single(skill, definition.simulation_rate(&model))?;
        let task = GaitTask {
            speed: self.speed,
            settle: SETTLE,
            seconds: self.seconds,
            disturbance: Disturbance { joint: 0.02, joint_velocity: 0.1, velocity: 0.05 },
            seed: self.seed,
        };
        let recording = record_gait(&mut director, &model, &task)?;
        let report = gait_report(&recording)?;
        let near = agreement(&report, &people);
        let text = |path: &Option<PathBuf>, text: &dyn Fn() -> String| {
            path.as_ref().map(|path| write_whole(path, text().as_bytes())).transpose()
        };
        text(&self.csv, &|| csv_text(&recording))?;
        text(&self.sto, &|| sto_text(&recording))?;
        text(&self.mot, &|| mot_text(&recording))?;
        if let Some(path) = &self.plot {
            let charts = charts(&report, &people);
            let png = charts_png(&charts, 900, 260)?;
            write_whole(path, &png)?;
        }
        self.report(&report, &near)
    }

    fn report(&self, report: &GaitReport, near: &Agreement) -> Outcome {
        if self.json {
            say_json(&json!({
                "skill": self.skill, "speed": report.speed, "strides": report.strides,
                "stride_seconds": report.stride_seconds, "stride_length": report.stride_length, "stance": report.stance,
                "cost_of_transport": report.cost_of_transport, "heel_first": report.heel_first,
                "ankle_moment_correlation": near.ankle_moment_correlation,
                "ankle_moment_within_sd": near.ankle_moment_within_sd,
                "vertical_force_correlation": near.vertical_force_correlation,
                "pressure_path_error": near.pressure_path_error,
                "toe_peak_degrees": report.toe_peak_degrees, "toe_peak_percent": report.toe_peak_percent,
                "curves": {
                    "vertical_force": report.vertical_force, "ankle_moment": report.ankle_moment, "ankle": report.ankle,
                    "toes": report.toes, "pressure_path": report.pressure_path,
                    "gains": report.gains.iter().map(|(name, curve)| json!({"joint": name, "curve": curve})).collect::<Vec<_>>(),
                },
            }))?;
            return Ok(ExitCode::SUCCESS);
        }
        let known = |x: Option<f64>, scale: f64, unit: &str| {
            x.map_or_else(|| "not known: no table of people".into(), |x| format!("{:.2}{unit}", x * scale))
        };
        let lines = [
            (
                "strides",
                format!(
                    "{} of both feet, {:.2} s and {:.2} m each",
                    report.strides, report.stride_seconds, report.stride_length
                ),
            ),
            ("speed", format!("{:.2} m/s", report.speed)),
            ("stance", format!("{:.0} % of a stride", 100.0 * report.stance)),
            ("heel first", format!("{:.0} % of all steps", 100.0 * report.heel_first)),
            (
                "toe joint",
                format!("{:.0} degrees at {:.0} % of the cycle", report.toe_peak_degrees, report.toe_peak_percent),
            ),
            ("cost of transport", format!("{:.2}", report.cost_of_transport)),
            ("ankle moment, correlation", known(near.ankle_moment_correlation, 1.0, "")),
            ("... within one deviation", known(near.ankle_moment_within_sd, 100.0, " % of the stance")),
            ("vertical force, correlation", known(near.vertical_force_correlation, 1.0, "")),
            ("pressure path, mean error", known(near.pressure_path_error, 100.0, " % of the foot")),
        ];
        for (name, value) in lines {
            say(&format!("{name:<28} {value}"))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Points of a curve over percent.
fn line(name: &str, values: &[f64]) -> Curve {
    let x = |k: usize| 100.0 * k as f64 / (POINTS - 1) as f64;
    Curve { name: name.into(), points: values.iter().enumerate().map(|(k, y)| (x(k), *y)).collect() }
}

/// A mean with its deviation to either side.
fn band(name: &str, curve: &GaitCurve) -> Vec<Curve> {
    let mut lines = vec![line(name, &curve.mean)];
    if !curve.sd.is_empty() {
        for (ending, sign) in [("+ sd", 1.0), ("- sd", -1.0)] {
            let moved: Vec<f64> = curve.mean.iter().zip(&curve.sd).map(|(m, sd)| m + sign * sd).collect();
            lines.push(line(&format!("{name} {ending}"), &moved));
        }
    }
    lines
}

fn charts(report: &GaitReport, people: &People) -> Vec<Chart> {
    let chart = |title: &str, x: &str, curves: Vec<Curve>| {
        let all = || curves.iter().flat_map(|c| c.points.iter().map(|p| p.1));
        let (low, high) = (all().fold(0.0, f64::min), all().fold(0.1, f64::max));
        let room = 0.05 * (high - low);
        Chart { title: title.into(), x_label: x.into(), low: low - room, high: high + room, curves }
    };
    let beside = |own: &GaitCurve, people: &Option<GaitCurve>| {
        let mut curves = vec![line("athlete", &own.mean)];
        curves.extend(people.iter().flat_map(|curve| band("people", curve)));
        curves
    };
    let cycle = "% of the gait cycle";
    let mut charts = vec![
        chart("Vertical force, body weights", cycle, beside(&report.vertical_force, &people.vertical_force)),
        chart("Ankle moment, N m/kg", cycle, beside(&report.ankle_moment, &people.ankle_moment)),
        chart(
            "Angles, degrees, toes up",
            cycle,
            vec![line("ankle", &report.ankle.mean), line("medial toes", &report.toes.mean)],
        ),
        chart(
            "Pressure along the sole, heel 0 to toe 1",
            "% of the stance",
            beside(&report.pressure_path, &people.pressure_path),
        ),
    ];
    let gains: Vec<Curve> = report.gains.iter().map(|(name, curve)| line(name, &curve.mean)).collect();
    if gains.iter().flat_map(|c| &c.points).any(|p| (p.1 - 1.0).abs() > 1e-6) {
        charts.push(chart("Stiffness set by the policy, of the character's own", cycle, gains));
    }
    charts
}
