//! The training monitor: follows the curve file of a run while it grows.

use crate::ui::curve_file::{CurveError, CurveTable, curve_file};
use crate::ui::marks::fault;
use bevy_egui::egui::{self, Color32, Rangef, TextEdit};
use egui_plot::{Corner, Legend, Line, Plot, PlotPoints};
use std::path::Path;
use std::time::SystemTime;

/// Frames between looks at the file.
const FRAMES: u32 = 30;
/// Height of a chart, points.
const HEIGHT: f32 = 150.0;

/// A chart: its title and the columns in it.
const CHARTS: [(&str, &[&str]); 3] = [
    ("reward and survival", &["reward", "failed", "survival", "evaluated_reward"]),
    ("length of the trials, s", &["length_s"]),
    // Curves of earlier versions call it divergence.
    ("kl of the update", &["kl", "divergence"]),
];

/// What the monitor holds between frames.
#[derive(Clone, Debug, Default)]
pub struct TrainingMonitor {
    /// The run's folder or its CSV file, as typed.
    pub path: String,
    table: CurveTable,
    error: Option<CurveError>,
    /// The path, time and length of the file that was read.
    seen: Option<(String, Option<SystemTime>, u64)>,
    frame: u32,
}

impl TrainingMonitor {
    /// Follows this folder or file.
    pub fn of(path: impl Into<String>) -> Self {
        Self { path: path.into(), ..Self::default() }
    }

    /// The curve as it was last read.
    pub fn table(&self) -> &CurveTable {
        &self.table
    }
    /// What is wrong with the file.
    pub fn error(&self) -> Option<&CurveError> {
        self.error.as_ref()
    }

    /// Reads the file if it changed since the last time. A file that has gone bad keeps the last good curve.
    pub fn refresh(&mut self) {
        if self.path.trim().is_empty() {
            *self = Self { path: std::mem::take(&mut self.path), ..Self::default() };
            return;
        }
        let path = Path::new(self.path.trim());
        let found = std::fs::metadata(curve_file(path)).ok();
        let state = (self.path.clone(), found.as_ref().and_then(|m| m.modified().ok()), found.map_or(0, |m| m.len()));
        if self.seen.as_ref() == Some(&state) {
            return;
        }
        if self.seen.as_ref().is_some_and(|(path, ..)| *path != self.path) {
            self.table = CurveTable::default();
        }
        match CurveTable::load(path) {
            Ok(table) => (self.table, self.error) = (table, None),
            Err(error) => self.error = Some(error),
        }
        self.seen = Some(state);
    }
}

/// Draws the monitor, and looks at the file twice a second.
pub fn training_monitor(ui: &mut egui::Ui, monitor: &mut TrainingMonitor) {
    ui.horizontal(|ui| {
        ui.label("run");
        let edit = TextEdit::singleline(&mut monitor.path).hint_text("runs/NAME").desired_width(f32::INFINITY);
        if ui.add(edit).changed() {
            monitor.frame = 0;
        }
    });
    if monitor.frame.is_multiple_of(FRAMES) {
        monitor.refresh();
    }
    monitor.frame = monitor.frame.wrapping_add(1);
    if let Some(error) = &monitor.error {
        fault(ui, &error.to_string());
    }
    let table = &monitor.table;
    if table.rows() == 0 {
        ui.weak("no curve yet: give the folder that `athlete train` writes to");
        return;
    }
    let number = |name: &str| table.last(name).map_or("-".into(), |v| format!("{v:.3}"));
    ui.monospace(format!(
        "{} iterations, {} s, reward {}, lasts {}",
        table.rows(),
        number("seconds"),
        number("reward"),
        number("survival")
    ));
    for (title, columns) in CHARTS {
        if columns.iter().any(|c| !table.points(c).is_empty()) {
            ui.small(title);
            let curves: Vec<(&str, Vec<[f64; 2]>)> = columns.iter().map(|c| (*c, table.points(c))).collect();
            chart(ui, title, HEIGHT, &curves);
        }
    }
}

/// Colours of the curves of a chart, in order.
const COLORS: [Color32; 4] = [
    Color32::from_rgb(120, 200, 140),
    Color32::from_rgb(240, 90, 80),
    Color32::from_rgb(105, 180, 250),
    Color32::from_rgb(235, 200, 90),
];

/// Distance of grid lines that are labelled, points: from a few to what a small plot has room for.
pub(super) const GRID: Rangef = Rangef { min: 8.0, max: 50.0 };

/// A chart over seconds.
pub(super) fn chart(ui: &mut egui::Ui, name: &str, height: f32, curves: &[(&str, Vec<[f64; 2]>)]) {
    let mut plot =
        Plot::new(name).height(height).include_y(0.0).allow_scroll(false).grid_spacing(GRID).y_axis_min_width(36.0);
    if curves.len() > 1 {
        plot = plot.legend(Legend::default().position(Corner::RightBottom));
    }
    plot.show(ui, |plot| {
        for ((name, points), color) in curves.iter().zip(COLORS).filter(|((_, points), _)| !points.is_empty()) {
            plot.line(Line::new(*name, PlotPoints::from(points.clone())).color(color).width(1.5));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_followed_as_it_grows_and_a_bad_file_keeps_the_last_good_one() {
        let folder = std::env::temp_dir().join(format!("bevy_athlete_monitor_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("curve.csv");
        std::fs::write(&file, "iteration,seconds,reward\n1,1,0.5\n").unwrap();
        let mut monitor = TrainingMonitor::of(folder.display().to_string());
        monitor.refresh();
        assert_eq!(monitor.table().rows(), 1);
        std::fs::write(&file, "iteration,seconds,reward\n1,1,0.5\n2,2,0.6\n").unwrap();
        monitor.refresh();
        assert_eq!((monitor.table().rows(), monitor.error()), (2, None));
        std::fs::write(&file, "iteration,seconds,reward\n1,1,0.5\n2,2,0.6\nrubbish\n").unwrap();
        monitor.refresh();
        assert_eq!(monitor.table().rows(), 2);
        assert!(monitor.error().unwrap().to_string().contains("line 4"));
        std::fs::remove_dir_all(&folder).unwrap();
        monitor.refresh();
        assert!(matches!(monitor.error(), Some(CurveError::File { .. })));
    }
}
