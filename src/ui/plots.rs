//! Curves over the last seconds.

use crate::ui::history::{History, Sample};
use crate::ui::marks::{LEFT, RIGHT, VALUE};
use crate::ui::monitor::GRID;
use bevy_egui::egui::{self, Color32, ScrollArea};
use egui_plot::{Corner, Legend, Line, Plot, PlotPoint, PlotPoints};
use std::ops::RangeInclusive;

/// Least time that is shown, s.
const SHORTEST: f64 = 2.0;
/// Height of one plot, points.
const HEIGHT: f32 = 92.0;

/// A curve: its name, colour, and value at a sample.
struct Curve {
    name: &'static str,
    color: Color32,
    value: fn(&Sample) -> f64,
}

const SPEED: &[Curve] = &[Curve { name: "speed", color: VALUE, value: |s| s.speed }];
const HEIGHT_OF_MASS: &[Curve] = &[Curve { name: "centre of mass", color: VALUE, value: |s| s.mass_height }];
const LEAN: &[Curve] = &[
    Curve { name: "to the right", color: RIGHT, value: |s| s.lean[0].to_degrees() },
    Curve { name: "forwards", color: LEFT, value: |s| s.lean[1].to_degrees() },
];
const FORCE: &[Curve] = &[
    Curve { name: "left", color: LEFT, value: |s| s.force[0] },
    Curve { name: "right", color: RIGHT, value: |s| s.force[1] },
];
const COST: &[Curve] = &[Curve { name: "a step", color: VALUE, value: |s| s.step_micros }];

/// Draws the plots of a history: speed, height of the centre of mass, lean, contact forces, step cost.
pub fn plots(ui: &mut egui::Ui, history: &History) {
    if history.samples().len() == 0 {
        ui.weak("nothing has been sampled yet");
        return;
    }
    let time = |s: Option<&Sample>| s.map_or(0.0, |s| s.time);
    let (first, now) = (time(history.samples().next()), time(history.samples().last()));
    let from = first.max(now - history.seconds());
    ScrollArea::vertical().auto_shrink([false, true]).show(ui, |ui| {
        for (title, curves, least) in [
            ("speed, m/s", SPEED, 0.5),
            ("height of the centre of mass, m", HEIGHT_OF_MASS, 1.0),
            ("lean, degrees", LEAN, 5.0),
            ("contact force upwards, N", FORCE, 500.0),
            ("cost of a step, microseconds", COST, 5.0),
        ] {
            ui.small(title);
            plot(ui, title, curves, least, from..=from.max(now).max(from + SHORTEST), history);
        }
    });
}

fn plot(ui: &mut egui::Ui, title: &str, curves: &[Curve], least: f64, range: RangeInclusive<f64>, history: &History) {
    let mut plot = Plot::new(title)
        .height(HEIGHT)
        .include_y(0.0)
        .include_y(least)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .grid_spacing(GRID)
        .y_axis_min_width(36.0)
        .link_cursor("athlete_plots", [true, false]);
    if curves.len() > 1 {
        plot = plot.legend(Legend::default().position(Corner::LeftTop));
    }
    plot.show(ui, |plot| {
        plot.set_plot_bounds_x(range);
        plot.set_auto_bounds([false, true]);
        for curve in curves {
            // A gap (NaN) ends a stretch.
            let points: Vec<PlotPoint> = history.samples().map(|s| PlotPoint::new(s.time, (curve.value)(s))).collect();
            for stretch in points.split(|p| !p.y.is_finite()).filter(|s| !s.is_empty()) {
                let line = Line::new(curve.name, PlotPoints::Owned(stretch.to_vec()));
                plot.line(line.color(curve.color).width(1.5));
            }
        }
    });
}
