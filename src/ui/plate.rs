//! The virtual contact plate: soles seen from above, the pressure under them and its way (Park, Yu, Lee 2018, Figure 13).

use crate::asset::Side;
use crate::contact::BladeEdge;
use crate::control::balance::AnkleStance;
use crate::ui::marks::{VALUE, edge_label, nobody};
use crate::ui::plate_action::PlateAction;
use crate::ui::plate_view::{PlateAnkle, PlateBlade, PlateFoot, PlateView, blade_pressure};
use crate::ui::pressure::{PathPlace, PressureGrid, PressurePath};
use bevy_egui::egui::{
    self, Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Vec2, pos2, vec2,
};
use glam::DVec2;

/// Height of the plate, points.
const HEIGHT: f32 = 240.0;
/// Room around a sole, m.
const MARGIN: f64 = 0.03;
/// Height of the drawn pressure of a blade that bears the whole weight evenly, m on the plate.
const PRESSURE: f64 = 0.012;

/// Edge of a cell of the drawn pressure, m.
const CELL: f64 = 0.004;
/// Pressure that is drawn red, Pa, and the one below which it fades away.
const RED: f64 = 200e3;
const FADES: f64 = 4e3;
/// What dragging the ankle by a point of the screen does: upwards, m, and aside, rad.
const RISE: f64 = 0.00075;
const ROLL: f64 = 0.005;

/// Draws the plate: the pressure under both soles, and the way of its centres where a path is given. `None` is an empty selection.
///
/// Where the feet of an athlete that balances are asked to stand on segments, the segments can be clicked and the ankles dragged; what was done is
/// returned, nothing is changed.
pub fn contact_plate(ui: &mut egui::Ui, view: Option<&PlateView>, path: Option<&PressurePath>) -> Option<PlateAction> {
    let Some(view) = view else {
        nobody(ui);
        return None;
    };
    let mut done = None;
    ui.columns(2, |columns| {
        for (side, (ui, foot)) in columns.iter_mut().zip(&view.feet).enumerate() {
            let name = ["left", "right"][side];
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
            let way = path.map_or_else(Vec::new, |path| path.runs(side));
            let inward = if side == 0 { Side::Left } else { Side::Right };
            done = sole(ui, foot, view.weight, &way, inward).or(done);
        }
    });
    ui.weak("seen from above, in the zero pose; the cross is the centre of pressure, red is 200 kPa");
    let asked = view.feet.iter().any(|foot| foot.ankle.as_ref().is_some_and(|ankle| ankle.asked.is_some()));
    if asked {
        ui.weak("click a segment: it shall touch, or no longer; drag the diamond: the ankle; double click: as before");
    }
    done
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

/// One sole, and what was done to it.
fn sole(ui: &mut egui::Ui, foot: &PlateFoot, weight: f64, way: &[Vec<PathPlace>], side: Side) -> Option<PlateAction> {
    let ankle = foot.ankle.as_ref().and_then(|ankle| Some((ankle, ankle.asked?)));
    let sense = if ankle.is_some() { Sense::click() } else { Sense::hover() };
    let (rect, plate) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), sense);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let ends = foot.blade.iter().flat_map(|b| b.ends.map(|e| (e, 0.0)));
    let places: Vec<(DVec2, f64)> = foot.points.iter().map(|p| (p.place, p.radius)).chain(ends).collect();
    if places.is_empty() {
        painter.text(rect.center(), Align2::CENTER_CENTER, "no sole", FontId::proportional(12.0), Color32::GRAY);
        return None;
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
    pressure(&painter, &map, foot);
    points(&painter, &map, foot, ankle, ui.ctx().pointer_hover_pos());
    draw_way(&painter, &map, way);
    if let Some(center) = foot.center_of_pressure() {
        let at = map.at(center);
        let stroke = Stroke::new(2.0, Color32::WHITE);
        for arm in [vec2(6.0, 0.0), vec2(0.0, 6.0)] {
            painter.line_segment([at - arm, at + arm], stroke);
        }
    }
    let (ankle, asked) = ankle?;
    clicked(&plate, &map, foot, ankle).or(dragged(ui, &painter, &map, ankle, asked, side))
}

/// The pressure as a picture: shaded between the middles of the cells.
fn pressure(painter: &Painter, map: &Map, foot: &PlateFoot) {
    let Some(grid) = PressureGrid::of(foot, CELL) else { return };
    let mut mesh = Mesh::default();
    for (k, value) in grid.values.iter().enumerate() {
        let shade = heat(value / RED).gamma_multiply((value / FADES).min(1.0) as f32);
        mesh.colored_vertex(map.at(grid.middle(k % grid.columns, k / grid.columns)), shade);
    }
    for j in 1..grid.rows {
        for i in 1..grid.columns {
            let corner = |i: usize, j: usize| j * grid.columns + i;
            let cell = [corner(i - 1, j - 1), corner(i, j - 1), corner(i - 1, j), corner(i, j)];
            if cell.iter().any(|&k| grid.values[k] > 0.0) {
                let [a, b, c, d] = cell.map(|k| k as u32);
                mesh.add_triangle(a, b, c);
                mesh.add_triangle(b, d, c);
            }
        }
    }
    painter.add(Shape::mesh(mesh));
}

/// The points, those of segments that shall touch marked; the one under the pointer by name.
fn points(
    painter: &Painter,
    map: &Map,
    foot: &PlateFoot,
    ankle: Option<(&PlateAnkle, AnkleStance)>,
    pointer: Option<Pos2>,
) {
    for point in &foot.points {
        let (at, radius) = (map.at(point.place), (point.radius as f32 * map.scale).max(4.0));
        if point.force > 0.0 && radius > 9.0 {
            let text = format!("{:.0}", point.force);
            painter.text(at, Align2::CENTER_CENTER, text, FontId::monospace(9.0), Color32::WHITE);
        }
        let asked = ankle.zip(point.segment).is_some_and(|((_, asked), segment)| asked.touch.contains(segment));
        let stroke = if asked { Stroke::new(2.0, VALUE) } else { Stroke::new(1.0, Color32::from_gray(120)) };
        painter.circle_stroke(at, radius, stroke);
        if pointer.is_some_and(|p| p.distance(at) <= radius) {
            let segment = foot.ankle.as_ref().zip(point.segment).and_then(|(ankle, k)| ankle.segments.get(k));
            let text = format!("{}: {:.1} N", segment.unwrap_or(&point.name), point.force);
            let corner = painter.clip_rect().left_top() + vec2(6.0, 4.0);
            painter.text(corner, Align2::LEFT_TOP, text, FontId::proportional(12.0), Color32::WHITE);
        }
    }
}

/// The way of the centre of pressure; what is older is fainter.
fn draw_way(painter: &Painter, map: &Map, way: &[Vec<PathPlace>]) {
    for pair in way.iter().flat_map(|run| run.windows(2)) {
        let color = Color32::WHITE.gamma_multiply(0.8 * (1.0 - pair[1].age.clamp(0.0, 1.0)) as f32);
        painter.line_segment([map.at(pair[0].place), map.at(pair[1].place)], Stroke::new(1.5, color));
    }
}

/// The segment whose point lies nearest to a click, within a finger's width.
fn clicked(plate: &Response, map: &Map, foot: &PlateFoot, ankle: &PlateAnkle) -> Option<PlateAction> {
    /// How far from the rim of a point a click still counts, points.
    const NEAR: f32 = 8.0;
    let click = plate.interact_pointer_pos().filter(|_| plate.clicked())?;
    let near = foot.points.iter().filter_map(|point| {
        let away = map.at(point.place).distance(click) - (point.radius as f32 * map.scale).max(4.0);
        point.segment.filter(|_| away < NEAR).map(|segment| (segment, away))
    });
    let (segment, _) = near.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(PlateAction::Segment { foot: ankle.foot, segment })
}

/// The ankle as a diamond that can be dragged: up is up, inwards rolls it inwards.
fn dragged(
    ui: &egui::Ui,
    painter: &Painter,
    map: &Map,
    ankle: &PlateAnkle,
    asked: AnkleStance,
    side: Side,
) -> Option<PlateAction> {
    let inward = if side == Side::Left { 1.0 } else { -1.0 };
    let off = vec2((inward * asked.roll / ROLL) as f32, (-asked.rise / RISE) as f32);
    let (home, at) = (map.at(ankle.place), map.at(ankle.place) + off);
    let grip = ui.interact(
        Rect::from_center_size(at, Vec2::splat(24.0)),
        ui.id().with(("ankle", ankle.foot)),
        Sense::click_and_drag(),
    );
    let color = if grip.hovered() || grip.dragged() { Color32::WHITE } else { VALUE };
    painter.line_segment([home, at], Stroke::new(1.0, color));
    let corners = [vec2(0.0, -8.0), vec2(8.0, 0.0), vec2(0.0, 8.0), vec2(-8.0, 0.0)].map(|c| at + c).to_vec();
    painter.add(Shape::convex_polygon(corners, color.gamma_multiply(0.5), Stroke::new(1.5, color)));
    let text = format!("ankle {:.0} mm up, {:+.0}\u{b0} inwards", asked.rise * 1e3, asked.roll.to_degrees());
    let corner = painter.clip_rect().left_bottom() + vec2(6.0, -4.0);
    painter.text(corner, Align2::LEFT_BOTTOM, text, FontId::proportional(11.0), Color32::from_gray(200));
    if grip.double_clicked() {
        return Some(PlateAction::Straight { foot: ankle.foot });
    }
    let by = grip.drag_delta();
    let (rise, roll) = (-f64::from(by.y) * RISE, f64::from(by.x) * inward * ROLL);
    (by != Vec2::ZERO).then_some(PlateAction::Ankle { foot: ankle.foot, rise, roll })
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
