//! The virtual contact plate: soles seen from above, the points that touch and how hard.

use crate::contact::BladeEdge;
use crate::ui::marks::{edge_label, nobody};
use crate::ui::plate_view::{PlateBlade, PlateFoot, PlateView, blade_pressure};
use bevy_egui::egui::{self, Align2, Color32, FontId, Painter, Pos2, Rect, Sense, Shape, Stroke, Vec2, pos2, vec2};
use glam::DVec2;

/// Height of the plate, points.
const HEIGHT: f32 = 240.0;
/// Room around a sole, m.
const MARGIN: f64 = 0.03;
/// Height of the drawn pressure of a blade that bears the whole weight evenly, m on the plate.
const PRESSURE: f64 = 0.012;

/// Draws the plate; `None` is an empty selection.
pub fn contact_plate(ui: &mut egui::Ui, view: Option<&PlateView>) {
    let Some(view) = view else { return nobody(ui) };
    ui.columns(2, |columns| {
        for ((ui, foot), name) in columns.iter_mut().zip(&view.feet).zip(["left", "right"]) {
            let share = 100.0 * foot.force() / view.weight.max(1e-9);
            ui.horizontal(|ui| {
                ui.strong(name);
                ui.monospace(format!("{:5.0} N, {share:3.0} %", foot.force()));
            });
            if let Some(blade) = &foot.blade {
                let (word, color) = edge_label(blade.edge);
                let lean = blade.lean.map_or(String::new(), |l| format!(", lean {:+.1}\u{b0}", l.to_degrees()));
                ui.colored_label(color, format!("{word}{lean}"));
            }
            sole(ui, foot, view.weight);
        }
    });
    ui.weak("seen from above, in the zero pose; the cross is the centre of pressure");
}

/// From the plate (m) to the screen.
struct Map {
    center: Pos2,
    middle: DVec2,
    scale: f32,
}

impl Map {
    fn at(&self, place: DVec2) -> Pos2 {
        let from = (place - self.middle) * f64::from(self.scale);
        self.center + vec2(from.x as f32, -from.y as f32)
    }
}

fn sole(ui: &mut egui::Ui, foot: &PlateFoot, weight: f64) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let ends = foot.blade.iter().flat_map(|b| b.ends.map(|e| (e, 0.0)));
    let places: Vec<(DVec2, f64)> = foot.points.iter().map(|p| (p.place, p.radius)).chain(ends).collect();
    if places.is_empty() {
        painter.text(rect.center(), Align2::CENTER_CENTER, "no sole", FontId::proportional(12.0), Color32::GRAY);
        return;
    }
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for (place, radius) in places {
        low = low.min(place - radius - MARGIN);
        high = high.max(place + radius + MARGIN);
    }
    let size = high - low;
    let scale = (f64::from(rect.width()) / size.x).min(f64::from(rect.height()) / size.y) as f32;
    let map = Map { center: rect.center(), middle: (low + high) * 0.5, scale };
    outline(&painter, &map, foot);
    if let Some(blade) = &foot.blade {
        draw_blade(&painter, &map, blade, weight);
    }
    let pointer = ui.ctx().pointer_hover_pos();
    for point in &foot.points {
        let (at, radius) = (map.at(point.place), (point.radius as f32 * scale).max(4.0));
        if point.force > 0.0 {
            painter.circle_filled(at, radius, heat(point.force / weight.max(1e-9) * 4.0));
            if radius > 9.0 {
                let text = format!("{:.0}", point.force);
                painter.text(at, Align2::CENTER_CENTER, text, FontId::monospace(9.0), Color32::BLACK);
            }
        }
        painter.circle_stroke(at, radius, Stroke::new(1.0, Color32::from_gray(120)));
        if pointer.is_some_and(|p| p.distance(at) <= radius) {
            let text = format!("{}: {:.1} N", point.name, point.force);
            painter.text(
                rect.left_top() + vec2(6.0, 4.0),
                Align2::LEFT_TOP,
                text,
                FontId::proportional(12.0),
                Color32::WHITE,
            );
        }
    }
    if let Some(center) = foot.center_of_pressure() {
        let at = map.at(center);
        let stroke = Stroke::new(2.0, Color32::WHITE);
        for arm in [vec2(6.0, 0.0), vec2(0.0, 6.0)] {
            painter.line_segment([at - arm, at + arm], stroke);
        }
    }
}

/// A faint shape around the points, so that one sees a foot.
fn outline(painter: &Painter, map: &Map, foot: &PlateFoot) {
    let fill = Color32::from_gray(48);
    for point in &foot.points {
        let radius = (point.radius + 0.012) as f32 * map.scale;
        painter.circle_filled(map.at(point.place), radius, fill);
    }
    if let Some(blade) = &foot.blade {
        let (toe, heel) = (map.at(blade.ends[0]), map.at(blade.ends[1]));
        let half = Vec2::splat(0.035 * map.scale);
        painter.rect_filled(Rect::from_two_pos(toe - half, heel + half).intersect(painter.clip_rect()), 14.0, fill);
    }
}

fn draw_blade(painter: &Painter, map: &Map, blade: &PlateBlade, weight: f64) {
    let (_, color) = edge_label(blade.edge);
    let [toe, heel] = blade.ends;
    let along = (toe - heel).normalize_or_zero();
    let length = (toe - heel).length();
    // Pressure stands to the side of the edge that cuts; a flat blade has it on both.
    let sides: &[f64] = match blade.edge {
        BladeEdge::Inside => &[1.0],
        BladeEdge::Outside => &[-1.0],
        BladeEdge::Flat | BladeEdge::Off => &[1.0, -1.0],
    };
    if let Some([(a, p), (b, q)]) = blade_pressure(blade.force[0], blade.force[1], length) {
        let even = weight.max(1e-9) / length;
        for side in sides {
            let out = blade.inside * (side * PRESSURE / sides.len() as f64 / even);
            let (from, to) = (heel + along * a, heel + along * b);
            let corners = [from, to, to + out * q, from + out * p].map(|c| map.at(c)).to_vec();
            painter.add(Shape::convex_polygon(corners, color.gamma_multiply(0.55), Stroke::new(1.0, color)));
        }
    }
    painter.line_segment([map.at(heel), map.at(toe)], Stroke::new(3.0, color));
    let outside = -blade.inside;
    for (end, force) in blade.ends.into_iter().zip(blade.force) {
        let side = if outside.x < 0.0 { Align2::RIGHT_CENTER } else { Align2::LEFT_CENTER };
        let at = map.at(end + outside * 0.012);
        painter.text(pos2(at.x, at.y), side, format!("{force:.0} N"), FontId::monospace(11.0), Color32::from_gray(200));
    }
}

/// From dark blue over green and yellow to red; 0 to 1.
fn heat(part: f64) -> Color32 {
    const STOPS: [[f64; 3]; 5] =
        [[60.0, 90.0, 200.0], [40.0, 170.0, 170.0], [110.0, 200.0, 80.0], [245.0, 205.0, 60.0], [235.0, 70.0, 50.0]];
    let at = part.clamp(0.0, 1.0) * 4.0;
    let k = (at as usize).min(3);
    let mix = |c: usize| (STOPS[k][c] + (STOPS[k + 1][c] - STOPS[k][c]) * (at - k as f64)) as u8;
    Color32::from_rgb(mix(0), mix(1), mix(2))
}
