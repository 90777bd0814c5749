//! Lays the cells and the band out and encodes the picture.

use super::camera::{fit, targets, view_axes};
use super::cell::{CellStyle, INK, color, draw_cell};
use super::font::draw_text;
use super::frame::{StoryboardError, StoryboardFrame, StoryboardOptions, check_frames};
use super::mesh::{Solid, figure};
use super::path_band::draw_band;
use crate::model::CharacterModel;
use glam::{DVec2, DVec3};
use std::path::Path;
use tiny_skia::{Color, Pixmap, PixmapPaint, Transform};

/// Pixels between two cells.
const GUTTER: u32 = 3;
/// Narrowest cell, pixels; there are fewer cells where the picture has no room for that.
const NARROWEST: u32 = 16;

/// Draws strips of figures.
#[derive(Clone, Debug, Default)]
pub struct Storyboard {
    options: StoryboardOptions,
}

impl Storyboard {
    /// A storyboard with these options; they are checked when something is drawn.
    pub fn new(options: StoryboardOptions) -> Self {
        Self { options }
    }

    /// Draws the frames and returns the bytes of a PNG file. The frames are in order of time.
    pub fn png(&self, model: &CharacterModel, frames: &[StoryboardFrame]) -> Result<Vec<u8>, StoryboardError> {
        self.options.check()?;
        check_frames(model, frames)?;
        let pixmap = self.draw(model, frames).ok_or_else(|| StoryboardError::Encode("too small a cell".into()))?;
        pixmap.encode_png().map_err(|e| StoryboardError::Encode(e.to_string()))
    }

    /// Draws the frames into a PNG file.
    pub fn write(
        &self,
        model: &CharacterModel,
        frames: &[StoryboardFrame],
        path: impl AsRef<Path>,
    ) -> Result<(), StoryboardError> {
        let path = path.as_ref();
        let bytes = self.png(model, frames)?;
        std::fs::write(path, bytes)
            .map_err(|source| StoryboardError::Write { path: path.display().to_string(), source })
    }

    fn draw(&self, model: &CharacterModel, frames: &[StoryboardFrame]) -> Option<Pixmap> {
        let options = &self.options;
        let mut sheet = Pixmap::new(options.width, options.height)?;
        sheet.fill(Color::WHITE);

        // Rows: the title, the strip, the band.
        let text = (options.height as f32 * 0.021).clamp(6.0, 26.0);
        let title = if options.title.is_empty() { 0 } else { (text * 2.8) as u32 };
        let band = if options.path_band { (options.height as f32 * 0.2) as u32 } else { 0 };
        let most = options.columns.min((options.width / NARROWEST) as usize);
        let most_rows = options.frames.div_ceil(options.columns);
        let chosen = even_times(frames, options.frames.min(most * most_rows));
        let columns = chosen.len().min(most);
        let rows = chosen.len().div_ceil(columns) as u32;
        let strips = options.height.checked_sub(title + band + if band > 0 { GUTTER } else { 0 })?;
        let strip = ((strips + GUTTER) / rows).checked_sub(GUTTER)?;
        if !options.title.is_empty() {
            draw_text(&mut sheet, &options.title, text * 0.9, text * 2.0, text * 1.15, color(INK));
        }

        // The left edges of the cells share the width evenly, to the pixel.
        let edge = |i: usize| i as u32 * (options.width + GUTTER) / columns as u32;
        let cells: Vec<&StoryboardFrame> = chosen.iter().map(|&i| &frames[i]).collect();
        let axes = view_axes(options, frames);
        let targets = targets(options, &cells);
        let extents: Vec<Vec<DVec3>> = cells.iter().map(|f| corners(model, f)).collect();
        let narrowest = (0..columns).map(|i| (edge(i + 1) - edge(i)).saturating_sub(GUTTER)).min()?;
        let captions = cells.iter().any(|f| !f.caption.is_empty());
        let lines = u32::from(options.times) + u32::from(captions);
        let labels = f64::from(text) * (1.0 + 1.6 * f64::from(lines));
        let size = DVec2::new(f64::from(narrowest), f64::from(strip));
        let cameras = fit(axes, &targets, &extents, size, labels);
        for (i, (frame, camera)) in cells.iter().zip(&cameras).enumerate() {
            let (row, column) = ((i / columns) as u32, i % columns);
            let (left, right) = (edge(column), edge(column + 1).checked_sub(GUTTER)?);
            let size = (right.checked_sub(left)?, strip);
            let mut camera = *camera;
            camera.anchor.x = f64::from(size.0) / 2.0;
            let cell = draw_cell(&CellStyle { model, options, size, text }, &camera, frame)?;
            blit(&mut sheet, &cell, left, title + row * (strip + GUTTER));
        }
        if band > 0 {
            let picture = draw_band(model, frames, &chosen, (options.width, band), text)?;
            blit(&mut sheet, &picture, 0, options.height - band);
        }
        Some(sheet)
    }
}

fn blit(sheet: &mut Pixmap, part: &Pixmap, x: u32, y: u32) {
    sheet.draw_pixmap(x as i32, y as i32, part.as_ref(), &PixmapPaint::default(), Transform::identity(), None);
}

/// Indices of all frames if they are at most `count`, else of those nearest to even times from the first to the last, each
/// at most once.
fn even_times(frames: &[StoryboardFrame], count: usize) -> Vec<usize> {
    if frames.len() <= count {
        return (0..frames.len()).collect();
    }
    let (first, last) = (frames[0].time, frames[frames.len() - 1].time);
    let mut chosen: Vec<usize> = (0..count)
        .map(|k| {
            let wanted = first + (last - first) * k as f64 / (count - 1).max(1) as f64;
            let distance = |i: &usize| (frames[*i].time - wanted).abs();
            (0..frames.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
        })
        .collect();
    chosen.dedup();
    chosen
}

/// Points that enclose what a cell shows: the figure, its ghost unless it has drifted far away, and what touches.
fn corners(model: &CharacterModel, frame: &StoryboardFrame) -> Vec<DVec3> {
    let points = |solids: Vec<Solid>| solids.into_iter().flat_map(|s| s.vertices).map(|v| v.position);
    let mut out: Vec<DVec3> = points(figure(model, &frame.links)).collect();
    if let Some(ghost) = &frame.ghost {
        let drift = match (ghost.first(), frame.links.first()) {
            (Some(g), Some(l)) => g.position.distance(l.position),
            _ => 0.0,
        };
        if drift < 0.5 {
            out.extend(points(figure(model, ghost)));
        }
    }
    out.extend(frame.contacts.iter().map(|c| c.position));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_at_even_times_and_unique() {
        let at = |t: f64| StoryboardFrame::new(t, Vec::new());
        let dense: Vec<_> = (0..=100).map(|i| at(0.01 * f64::from(i))).collect();
        assert_eq!(even_times(&dense, 5), [0, 25, 50, 75, 100]);
        assert_eq!(even_times(&dense[..1], 5), [0]);
        let uneven: Vec<_> = [0.0, 0.1, 0.2, 1.0].map(at).into();
        assert_eq!(even_times(&uneven, 4), [0, 1, 2, 3]);
        assert_eq!(even_times(&uneven, 3), [0, 2, 3]);
        assert_eq!(even_times(&[at(1.0), at(1.0), at(1.0)], 2), [0]);
    }
}
