//! The band below the strip: the way of the centre of mass, seen from above, and the marks the contacts left.

use super::camera::travel;
use super::cell::{INK, color, disc, line};
use super::font::{draw_text, text_width};
use super::frame::StoryboardFrame;
use crate::model::CharacterModel;
use glam::{DVec2, DVec3};
use tiny_skia::{Color, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, Transform};

/// Draws the band; it runs along the motion, left to right. `cells` are the frames that the strip shows. `None` only for a
/// size that no picture can have.
pub(crate) fn draw_band(
    model: &CharacterModel,
    frames: &[StoryboardFrame],
    cells: &[usize],
    size: (u32, u32),
    text: f32,
) -> Option<Pixmap> {
    let mut pixmap = Pixmap::new(size.0, size.1)?;
    pixmap.fill(Color::from_rgba8(244, 248, 251, 255));
    let (width, height) = (f64::from(size.0), f64::from(size.1));

    // Seen from above: x along the way, y down to the right of it.
    let right = travel(frames);
    let down = right.cross(DVec3::Y);
    let flat = |p: DVec3| DVec2::new(p.dot(right), p.dot(down));
    let path: Vec<DVec2> = frames.iter().map(|f| flat(f.center_of_mass(model))).collect();
    let marks: Vec<DVec2> = frames.iter().flat_map(|f| &f.contacts).map(|c| flat(c.position)).collect();

    // One scale for both directions, so that turns keep their shape.
    let all = path.iter().chain(&marks);
    let low = all.clone().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = all.copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    let span = (high - low).max(DVec2::splat(0.2));
    let label = f64::from(text) * 9.0;
    let scale = ((width - 2.0 * label) / span.x).min((height - f64::from(text) * 3.4) / span.y).max(1e-3);
    let center = (low + high) / 2.0;
    let shift = f64::from(text) * 0.5;
    let at = |p: DVec2| {
        let q = (p - center) * scale + DVec2::new(width / 2.0, height / 2.0 + shift);
        (q.x as f32, q.y as f32)
    };

    for &m in &marks {
        let (x, y) = at(m);
        disc(&mut pixmap, x, y, (text * 0.11).max(0.8), [112, 164, 204, 130]);
    }
    let mut builder = PathBuilder::new();
    for (i, &p) in path.iter().enumerate() {
        let (x, y) = at(p);
        if i == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    if let Some(path) = builder.finish() {
        let mut paint = Paint { anti_alias: true, ..Default::default() };
        paint.set_color(color([58, 88, 124, 255]));
        let width = (text * 0.16).max(1.2);
        let stroke = Stroke { width, line_cap: LineCap::Round, line_join: LineJoin::Round, ..Default::default() };
        pixmap.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    }
    // A dot for every cell, its time beside it where there is room.
    let mut free_from = f32::NEG_INFINITY;
    for &cell in cells {
        let (x, y) = at(path[cell]);
        disc(&mut pixmap, x, y, text * 0.42, [255, 255, 255, 255]);
        disc(&mut pixmap, x, y, text * 0.28, [214, 40, 90, 255]);
        let time = format!("{:.2}", frames[cell].time);
        let half = text_width(&time, text * 0.7) / 2.0;
        if x - half > free_from {
            draw_text(&mut pixmap, &time, x - half, y - text * 0.8, text * 0.7, color([96, 110, 128, 255]));
            free_from = x + half + text * 0.4;
        }
    }
    draw_text(&mut pixmap, "from above", text * 0.9, text * 1.7, text * 0.75, color([96, 110, 128, 255]));
    scale_bar(&mut pixmap, scale, text);
    Some(pixmap)
}

/// A bar of a round length in the lower right corner.
fn scale_bar(pixmap: &mut Pixmap, scale: f64, text: f32) {
    let (width, height) = (pixmap.width() as f32, pixmap.height() as f32);
    let lengths =
        [(0.1, "0.1 m"), (0.2, "0.2 m"), (0.5, "0.5 m"), (1.0, "1 m"), (2.0, "2 m"), (5.0, "5 m"), (10.0, "10 m")];
    let (length, name) = lengths.into_iter().find(|(l, _)| l * scale > f64::from(text) * 3.0).unwrap_or((10.0, "10 m"));
    let pixels = ((length * scale) as f32).min(width * 0.4);
    let (right, y) = (width - text * 0.9, height - text * 0.8);
    line(pixmap, (right - pixels, y), (right, y), (text * 0.16).max(1.2), INK);
    for x in [right - pixels, right] {
        line(pixmap, (x, y - text * 0.3), (x, y + text * 0.3), (text * 0.16).max(1.2), INK);
    }
    let left = right - text_width(name, text * 0.75);
    draw_text(pixmap, name, left, y - text * 0.6, text * 0.75, color(INK));
}
