//! One cell: ground, shadow, ghost, figure, contact dots and labels, from back to front.

use super::camera::Camera;
use super::font::{draw_text, text_width};
use super::frame::{Ground, StoryboardFrame, StoryboardOptions};
use super::mesh::{figure, mark, scenery};
use super::raster::Layer;
use crate::model::CharacterModel;
use glam::{DVec3, Vec3};
use tiny_skia::{
    Color, FillRule, GradientStop, LineCap, LinearGradient, Paint, PathBuilder, Pixmap, Point, Rect, SpreadMode,
    Stroke, Transform,
};

/// How far behind the target the ground fades out, m.
const GROUND_DEPTH: f64 = 1.5;
/// Distance between two lines of the ground's grid, m.
const GRID: f64 = 0.5;
/// Length of the arrow of a force as large as the character's weight, m.
const FORCE_LENGTH: f64 = 0.35;
/// Opacity of the reference.
const GHOST_OPACITY: f32 = 0.30;
/// The ink of labels.
pub(crate) const INK: [u8; 4] = [44, 56, 72, 255];

pub(crate) fn color([r, g, b, a]: [u8; 4]) -> Color {
    Color::from_rgba8(r, g, b, a)
}

pub(crate) fn solid_paint(c: [u8; 4]) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Default::default() };
    paint.set_color(color(c));
    paint
}

pub(crate) fn disc(pixmap: &mut Pixmap, x: f32, y: f32, radius: f32, c: [u8; 4]) {
    if let Some(path) = PathBuilder::from_circle(x, y, radius) {
        pixmap.fill_path(&path, &solid_paint(c), FillRule::Winding, Transform::identity(), None);
    }
}

pub(crate) fn line(pixmap: &mut Pixmap, from: (f32, f32), to: (f32, f32), width: f32, c: [u8; 4]) {
    let mut builder = PathBuilder::new();
    builder.move_to(from.0, from.1);
    builder.line_to(to.0, to.1);
    let stroke = Stroke { width, line_cap: LineCap::Round, ..Default::default() };
    if let Some(path) = builder.finish() {
        pixmap.stroke_path(&path, &solid_paint(c), &stroke, Transform::identity(), None);
    }
}

/// An arrow; `unit` is about half of its line's width, pixels.
fn arrow(pixmap: &mut Pixmap, from: (f32, f32), (x, y): (f32, f32), unit: f32, c: [u8; 4]) {
    let (dx, dy) = (x - from.0, y - from.1);
    let length = dx.hypot(dy).max(1e-3);
    let (ux, uy) = (dx / length, dy / length);
    let head = 4.0 * unit;
    line(pixmap, from, (x - ux * head, y - uy * head), 1.6 * unit, c);
    let mut b = PathBuilder::new();
    b.move_to(x, y);
    b.line_to(x - ux * head * 1.5 - uy * head * 0.7, y - uy * head * 1.5 + ux * head * 0.7);
    b.line_to(x - ux * head * 1.5 + uy * head * 0.7, y - uy * head * 1.5 - ux * head * 0.7);
    b.close();
    if let Some(path) = b.finish() {
        pixmap.fill_path(&path, &solid_paint(c), FillRule::Winding, Transform::identity(), None);
    }
}

/// What a cell is drawn with.
pub(crate) struct CellStyle<'a> {
    pub model: &'a CharacterModel,
    pub options: &'a StoryboardOptions,
    /// Size of the cell, pixels.
    pub size: (u32, u32),
    /// Height of a capital of the time label, pixels.
    pub text: f32,
}

/// Draws one cell; `None` only for a size that no picture can have.
pub(crate) fn draw_cell(style: &CellStyle, camera: &Camera, frame: &StoryboardFrame) -> Option<Pixmap> {
    let (width, height) = style.size;
    let mut pixmap = Pixmap::new(width, height)?;
    backdrop(&mut pixmap, style, camera);
    grid(&mut pixmap, style.options, camera);

    let mut solids = figure(style.model, &frame.links);
    mark(&mut solids, style.model, &frame.marked);
    let mut shadow = Layer::new(width, height);
    solids.iter().for_each(|s| shadow.shadow(camera, s));
    let blur = (0.05 * camera.scale).round() as usize;
    shadow.over_as_shadow(&mut pixmap, Vec3::new(0.16, 0.24, 0.36), 0.42, blur);

    if let Some(ghost) = &frame.ghost {
        let mut layer = Layer::new(width, height);
        figure(style.model, ghost).iter().for_each(|s| layer.solid(camera, s));
        layer.outline();
        layer.over(&mut pixmap, GHOST_OPACITY);
    }

    let mut layer = Layer::new(width, height);
    scenery(&style.options.scenery).iter().chain(&solids).for_each(|s| layer.solid(camera, s));
    layer.outline();
    layer.over(&mut pixmap, 1.0);

    contacts(&mut pixmap, style, camera, frame);
    if style.options.axes {
        axes(&mut pixmap, style, camera);
    }
    labels(&mut pixmap, style, frame);
    Some(pixmap)
}

fn ground_colors(ground: Ground) -> ([u8; 4], [u8; 4], [u8; 4]) {
    match ground {
        // Near, far, grid.
        Ground::Ice => ([206, 228, 242, 255], [231, 242, 249, 255], [142, 180, 208, 255]),
        Ground::Floor => ([222, 216, 207, 255], [238, 235, 230, 255], [176, 166, 152, 255]),
    }
}

/// A wall fading from white into the ground, and the ground getting deeper in colour towards the viewer.
fn backdrop(pixmap: &mut Pixmap, style: &CellStyle, camera: &Camera) {
    let (near, far, _) = ground_colors(style.options.ground);
    let (width, height) = (style.size.0 as f32, style.size.1 as f32);
    let (_, horizon, _) = camera.project(camera.target + camera.away() * GROUND_DEPTH);
    let horizon = horizon.clamp(1.0, height - 1.0);
    let mut band = |top: f32, bottom: f32, from: [u8; 4], to: [u8; 4]| {
        let stops = vec![GradientStop::new(0.0, color(from)), GradientStop::new(1.0, color(to))];
        let (a, b) = (Point::from_xy(0.0, top), Point::from_xy(0.0, bottom));
        let shader = LinearGradient::new(a, b, stops, SpreadMode::Pad, Transform::identity());
        if let (Some(shader), Some(rect)) = (shader, Rect::from_ltrb(0.0, top, width, bottom)) {
            pixmap.fill_rect(rect, &Paint { shader, ..Default::default() }, Transform::identity(), None);
        }
    };
    band(0.0, horizon, [252, 253, 254, 255], [241, 246, 250, 255]);
    band(horizon, height, far, near);
}

/// Lines at whole multiples of `GRID` in the world, so that the ground is seen to move past a camera that follows.
fn grid(pixmap: &mut Pixmap, options: &StoryboardOptions, camera: &Camera) {
    let (_, _, ink) = ground_colors(options.ground);
    let (width, height) = (f64::from(pixmap.width()), f64::from(pixmap.height()));
    // The visible part of the ground around the target.
    let half_width = width / camera.scale / 2.0 + GRID;
    let near = (height - camera.anchor.y) / camera.scale / options.elevation.sin().max(0.05);
    let near = near.min(24.0);
    let reach = half_width.hypot(GROUND_DEPTH.max(near));
    let (right, away) = (camera.right(), camera.away());
    for (along, across) in [(DVec3::X, DVec3::Z), (DVec3::Z, DVec3::X)] {
        let center = camera.target.dot(across);
        let first = ((center - reach) / GRID).ceil() as i64;
        for k in first..=((center + reach) / GRID).floor() as i64 {
            let base = across * (k as f64 * GRID) + along * camera.target.dot(along) + DVec3::Y * camera.target.y;
            let strong = k.rem_euclid(2) == 0;
            let steps = (reach * 8.0).clamp(24.0, 200.0) as i32;
            for s in 0..steps {
                let at = |s: i32| base + along * (reach * (2.0 * f64::from(s) / f64::from(steps) - 1.0));
                let (from, to) = (at(s), at(s + 1));
                let middle = (from + to) / 2.0 - camera.target;
                let depth = middle.dot(away);
                if depth > GROUND_DEPTH || depth < -near - GRID || middle.dot(right).abs() > half_width + GRID {
                    continue;
                }
                let fade = (1.0 - depth / GROUND_DEPTH).clamp(0.0, 1.0).sqrt();
                let alpha = (if strong { 150.0 } else { 75.0 } * fade) as u8;
                let ((x0, y0, _), (x1, y1, _)) = (camera.project(from), camera.project(to));
                line(pixmap, (x0, y0), (x1, y1), 1.0, [ink[0], ink[1], ink[2], alpha]);
            }
        }
    }
}

/// A dot where something touches, and the force as an arrow.
fn contacts(pixmap: &mut Pixmap, style: &CellStyle, camera: &Camera, frame: &StoryboardFrame) {
    let weight = (style.model.mass() * 9.81).max(1e-9);
    let unit = (style.text / 10.0).max(0.7);
    for touch in &frame.contacts {
        let share = (touch.force.length() / weight).min(6.0);
        let (x, y, _) = camera.project(touch.position);
        let (tx, ty, _) = camera.project(touch.position + touch.force / weight * FORCE_LENGTH);
        let (dx, dy) = (tx - x, ty - y);
        if dx.hypot(dy) > 6.0 * unit {
            arrow(pixmap, (x, y), (tx, ty), unit, [214, 40, 90, 220]);
        }
        let radius = unit * (1.8 + 2.0 * share.sqrt() as f32);
        disc(pixmap, x, y, radius + 0.9 * unit, [255, 255, 255, 235]);
        disc(pixmap, x, y, radius, [214, 40, 90, 255]);
    }
}

/// The world's axes, in the lower left corner.
fn axes(pixmap: &mut Pixmap, style: &CellStyle, camera: &Camera) {
    let size = style.text.min(style.size.0 as f32 * 0.04);
    let origin = (size * 4.2, style.size.1 as f32 - size * 3.0);
    let hues: [[u8; 4]; 3] = [[200, 40, 50, 255], [30, 130, 60, 255], [50, 80, 200, 255]];
    for ((axis, name), hue) in [(DVec3::X, "X"), (DVec3::Y, "Y"), (DVec3::Z, "Z")].into_iter().zip(hues) {
        let v = camera.axes * axis;
        let at = |length: f32| (origin.0 + v.x as f32 * length, origin.1 - v.y as f32 * length);
        arrow(pixmap, origin, at(size * 2.8), size / 10.0, hue);
        let (x, y) = at(size * 3.6);
        draw_text(pixmap, name, x - size * 0.3, y + size * 0.4, size * 0.8, color(hue));
    }
}

/// The time, and the caption below it.
fn labels(pixmap: &mut Pixmap, style: &CellStyle, frame: &StoryboardFrame) {
    let size = style.text;
    let x = size * 0.9;
    let mut y = size * 1.9;
    if style.options.times {
        draw_text(pixmap, &format!("{:.2} s", frame.time), x, y, size, color(INK));
        y += size * 1.5;
    }
    if !frame.caption.is_empty() {
        // A caption too long for the cell is written smaller, down to a limit.
        let room = style.size.0 as f32 - 1.8 * size;
        let wanted = text_width(&frame.caption, size * 0.8);
        let small = size * 0.8 * (room / wanted).clamp(0.55, 1.0);
        draw_text(pixmap, &frame.caption, x, y, small, color([96, 110, 128, 255]));
    }
}
