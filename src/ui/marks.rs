//! Small drawings that several panels share.

use crate::contact::BladeEdge;
use bevy_egui::egui::{self, Color32, Rect, Sense, Stroke, pos2, vec2};

/// Left side of the body.
pub(super) const LEFT: Color32 = Color32::from_rgb(105, 180, 250);
/// Right side of the body.
pub(super) const RIGHT: Color32 = Color32::from_rgb(240, 130, 100);
/// Something is at its limit, or wrong.
pub(super) const ALARM: Color32 = Color32::from_rgb(240, 90, 80);
/// A value.
pub(super) const VALUE: Color32 = Color32::from_rgb(120, 200, 140);

/// The word and colour of an edge.
pub(super) fn edge_label(edge: BladeEdge) -> (&'static str, Color32) {
    match edge {
        BladeEdge::Off => ("off the ice", Color32::from_gray(140)),
        BladeEdge::Flat => ("flat", Color32::from_gray(225)),
        BladeEdge::Inside => ("inside", Color32::from_rgb(240, 160, 80)),
        BladeEdge::Outside => ("outside", Color32::from_rgb(105, 180, 250)),
    }
}

/// A line of text in the colour of a fault.
pub(super) fn fault(ui: &mut egui::Ui, text: &str) {
    ui.colored_label(ALARM, text);
}

/// What is shown where no athlete is selected.
pub(super) fn nobody(ui: &mut egui::Ui) {
    ui.weak("no athlete is selected");
}

/// A value in its range: a bar from zero to the value, a tick for a target, red within a fiftieth of an end.
pub(super) fn range_bar(ui: &mut egui::Ui, value: f64, range: (f64, f64), target: Option<f64>, width: f32) {
    let (rect, _) = ui.allocate_exact_size(vec2(width, 10.0), Sense::hover());
    let (low, high) = range;
    let span = (high - low).max(1e-9);
    let x = |v: f64| rect.left() + rect.width() * (((v - low) / span).clamp(0.0, 1.0) as f32);
    let painter = ui.painter();
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    if !value.is_finite() {
        return;
    }
    let (from, to) = (x(0.0_f64.clamp(low, high)), x(value));
    let near = value < low + 0.02 * span || value > high - 0.02 * span;
    let bar = Rect::from_x_y_ranges(
        from.min(to)..=from.max(to).max(from.min(to) + 1.0),
        rect.top() + 2.0..=rect.bottom() - 2.0,
    );
    painter.rect_filled(bar, 1.0, if near { ALARM } else { VALUE });
    if low < 0.0 && high > 0.0 {
        let zero = x(0.0);
        painter.line_segment(
            [pos2(zero, rect.top()), pos2(zero, rect.bottom())],
            Stroke::new(1.0, Color32::from_gray(110)),
        );
    }
    if let Some(target) = target {
        let at = x(target);
        painter.line_segment([pos2(at, rect.top()), pos2(at, rect.bottom())], Stroke::new(1.5, Color32::WHITE));
    }
}
