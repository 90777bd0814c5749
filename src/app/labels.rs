//! Words over the picture: numbers of obstacles, the force of a pull, what has just happened.

use crate::app::news::News;
use crate::app::pull::PointerPull;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

/// A text that stands over an entity.
#[derive(Component, Clone, Debug)]
pub(super) struct Label {
    pub text: String,
    /// How far above the entity, m.
    pub above: f32,
}

/// Paints all of them.
pub(super) fn paint_labels(
    mut contexts: EguiContexts,
    cameras: Query<(&Camera, &GlobalTransform), With<Camera3d>>,
    labels: Query<(&Label, &GlobalTransform)>,
    pull: Res<PointerPull>,
    news: Res<News>,
) -> Result {
    let Some((camera, place)) = cameras.iter().next() else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let painter = context.layer_painter(egui::LayerId::background());
    let screen = |point: Vec3| camera.world_to_viewport(place, point).ok().map(|p| egui::pos2(p.x, p.y));
    let write = |at: egui::Pos2, text: &str, size: f32, color: egui::Color32| {
        let galley = painter.layout_no_wrap(text.to_owned(), egui::FontId::proportional(size), color);
        let corner = at - galley.size() * 0.5;
        let shade = egui::Color32::from_black_alpha((f32::from(color.a()) * 0.55) as u8);
        let plate = egui::Rect::from_min_size(corner, galley.size()).expand2(egui::vec2(0.45 * size, 0.12 * size));
        painter.rect_filled(plate, 0.4 * size, shade);
        painter.galley(corner, galley, color);
    };
    for (label, transform) in &labels {
        if let Some(at) = screen(transform.translation() + Vec3::Y * label.above) {
            write(at, &label.text, 26.0, egui::Color32::WHITE);
        }
    }
    if let Some((_, end)) = pull.arrow
        && let Some(at) = screen(end)
    {
        write(
            at - egui::vec2(0.0, 16.0),
            &format!("{:.0} N", pull.force),
            18.0,
            egui::Color32::from_rgb(255, 190, 200),
        );
    }
    let area = context.content_rect();
    for (k, (line, left)) in news.0.iter().rev().enumerate() {
        let alpha = (left.min(1.0) * 255.0) as u8;
        let at = egui::pos2(area.center().x, area.bottom() - 70.0 - 30.0 * k as f32);
        let size = if k == 0 { 26.0 } else { 18.0 };
        write(at, line, size, egui::Color32::from_rgba_unmultiplied(255, 255, 255, alpha));
    }
    Ok(())
}
