//! A stick for thumbs: once a finger has touched the window, it lies in the lower right corner and steers the skater, the
//! runner or the walker as the arrow keys do.

use crate::app::act::Act;
use crate::app::menu::moves;
use crate::app::scenes::skating::RinkSkater;
use crate::app::thumb::ThumbStick;
use crate::engine::PerformSkill;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

/// How far the knob goes from the middle, points.
pub const REACH: f32 = 52.0;
/// Distance of the stick's rim from the corner, points.
pub const MARGIN: f32 = 22.0;
/// Radius of the knob, points.
const KNOB: f32 = 22.0;
/// Part of the way within which the thumb rests.
const DEAD: f32 = 0.15;

/// Draws the stick and moves its knob; returns where it is: to the right and up, at most 1 from the middle.
pub fn stick(ui: &mut egui::Ui) -> Vec2 {
    let size = egui::Vec2::splat(2.0 * (REACH + KNOB));
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::drag());
    let held = response.is_pointer_button_down_on().then(|| response.interact_pointer_pos()).flatten();
    let off = held.map_or(egui::Vec2::ZERO, |at| (at - rect.center()) / REACH);
    let off = Vec2::new(off.x, -off.y).clamp_length_max(1.0);
    let value = if off.length() < DEAD { Vec2::ZERO } else { off };
    let painter = ui.painter_at(rect);
    let knob = rect.center() + egui::vec2(off.x, -off.y) * REACH;
    painter.circle_filled(rect.center(), REACH + KNOB, egui::Color32::from_black_alpha(70));
    painter.circle_stroke(rect.center(), REACH, egui::Stroke::new(1.5, egui::Color32::from_white_alpha(90)));
    painter.circle_filled(knob, KNOB, egui::Color32::from_white_alpha(if held.is_some() { 210 } else { 140 }));
    value
}

/// The stick in the window, with the turns and the jump over it while the skater is steered.
pub(super) fn show_stick(
    mut contexts: EguiContexts,
    touches: Res<Touches>,
    mut thumb: ResMut<ThumbStick>,
    mut commands: Commands,
    skaters: Query<Entity, With<RinkSkater>>,
    act: Res<Act>,
) -> Result {
    let mut now = *thumb;
    now.shown |= touches.iter().next().is_some();
    now.value = Vec2::ZERO;
    if now.shown {
        let corner = egui::Area::new("athlete_stick".into()).anchor(egui::Align2::RIGHT_BOTTOM, [-MARGIN, -MARGIN]);
        now.value = corner
            .show(contexts.ctx_mut()?, |ui| {
                ui.with_layout(egui::Layout::top_down(egui::Align::Max), |ui| {
                    if *act == Act::Steer
                        && !skaters.is_empty()
                        && let Some(name) = moves(ui)
                    {
                        skaters.iter().for_each(|skater| commands.trigger(PerformSkill::new(skater, name)));
                    }
                    stick(ui)
                })
                .inner
            })
            .inner;
    }
    thumb.set_if_neq(now);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect};

    /// The stick's place in a window of its own, and what it says after these events, one a frame.
    fn after(context: &egui::Context, events: Vec<Event>) -> Vec2 {
        let mut value = Vec2::ZERO;
        for event in events {
            let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, egui::vec2(400.0, 400.0)));
            let input = RawInput { screen_rect, events: vec![event], ..RawInput::default() };
            let mut output = context.run_ui(input, |ui| value = stick(ui));
            output.textures_delta.clear();
        }
        value
    }

    fn button(pos: Pos2, pressed: bool) -> Event {
        Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
    }

    #[test]
    fn the_knob_follows_the_thumb_and_springs_back() {
        let context = egui::Context::default();
        let mut middle = Pos2::ZERO;
        for _ in 0..2 {
            let mut output = context.run_ui(RawInput::default(), |ui| {
                middle = ui.next_widget_position() + egui::Vec2::splat(REACH + KNOB);
                stick(ui);
            });
            output.textures_delta.clear();
        }
        let to = |x: f32, y: f32| Event::PointerMoved(middle + egui::vec2(x, y));
        assert_eq!(after(&context, vec![to(0.0, 0.0), button(middle, true)]), Vec2::ZERO);
        let half = after(&context, vec![to(0.5 * REACH, 0.0), to(0.5 * REACH, 0.0)]);
        assert!((half - Vec2::new(0.5, 0.0)).length() < 1e-4, "half way to the right: {half}");
        // Up on the screen is ahead, and beyond the rim it stays at the rim.
        let far = after(&context, vec![to(0.0, -3.0 * REACH), to(0.0, -3.0 * REACH)]);
        assert!((far - Vec2::Y).length() < 1e-4, "all the way ahead: {far}");
        // A thumb that rests near the middle means nothing.
        assert_eq!(after(&context, vec![to(0.1 * REACH, 0.0), to(0.1 * REACH, 0.0)]), Vec2::ZERO);
        let away = middle + egui::vec2(REACH, 0.0);
        assert_eq!(after(&context, vec![to(REACH, 0.0), button(away, false), to(REACH, 0.0)]), Vec2::ZERO);
    }
}
