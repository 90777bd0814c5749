//! Pause, slow motion and a new start as buttons, for hands without a keyboard.

use crate::app::stage::SLOW;
use crate::engine::{Athlete, AthleteReset, PlaybackSpeed};
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

/// Size of a button, points.
const SIZE: egui::Vec2 = egui::vec2(64.0, 32.0);

/// Draws the buttons; true when a new start is wanted.
pub fn buttons(ui: &mut egui::Ui, playback: &mut PlaybackSpeed) -> bool {
    let button = |ui: &mut egui::Ui, name: &str| ui.add(egui::Button::new(name).min_size(SIZE)).clicked();
    ui.horizontal(|ui| {
        if button(ui, if playback.paused { "Go on" } else { "Pause" }) {
            playback.paused = !playback.paused;
        }
        let slow = playback.speed < 1.0;
        if button(ui, if slow { "Full speed" } else { "Slow" }) {
            playback.speed = if slow { 1.0 } else { SLOW };
        }
        button(ui, "Again")
    })
    .inner
}

/// The buttons in the lower left corner of the window.
pub(super) fn show_buttons(
    mut commands: Commands,
    mut contexts: EguiContexts,
    mut playback: ResMut<PlaybackSpeed>,
    athletes: Query<Entity, With<Athlete>>,
) -> Result {
    let mut wanted = *playback;
    let corner = egui::Area::new("athlete_buttons".into()).anchor(egui::Align2::LEFT_BOTTOM, [14.0, -14.0]);
    if corner.show(contexts.ctx_mut()?, |ui| buttons(ui, &mut wanted)).inner {
        for athlete in &athletes {
            commands.trigger(AthleteReset::new(athlete));
        }
    }
    // A change is seen as a wish: only a real one is made.
    playback.set_if_neq(wanted);
    Ok(())
}
