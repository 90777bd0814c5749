//! The course's part of the menu: what to add, and the numbers of the chosen piece.

use crate::app::scenes::course::{DEPTHS, HEIGHTS, Piece, PieceKind, Race, Site, WIDTHS, first_pieces};
use bevy::prelude::*;
use bevy_egui::egui;

/// How far ahead of the runner a new piece comes up, m.
const AHEAD: f32 = 9.0;

/// Pieces to add, the chosen one's numbers, the file.
pub(super) fn site(ui: &mut egui::Ui, site: &mut ResMut<Site>, race: &mut ResMut<Race>, runners: &[Vec3]) {
    ui.label("Build while it runs: drag a block, pull its knob.");
    ui.horizontal(|ui| {
        for kind in PieceKind::ALL {
            if ui.button(format!("+ {}", kind.title())).clicked() {
                // On its round it comes by there.
                let ahead = runners.first().map_or(AHEAD, |runner| (AHEAD - runner.z).clamp(4.0, 38.0));
                site.add(Piece::new(kind, ahead), runners);
            }
        }
    });
    if let Some((k, mut piece)) = site.chosen.and_then(|k| Some((k, *site.pieces.get(k)?))) {
        ui.strong(format!("{} {}", piece.kind.title(), k + 1));
        let mut slider = |value: &mut f32, (low, high): (f32, f32), text: &str| {
            ui.add(egui::Slider::new(value, low..=high).fixed_decimals(2).text(text));
        };
        if piece.kind == PieceKind::Gap {
            slider(&mut piece.depth, DEPTHS, "m long");
        } else {
            slider(&mut piece.height, HEIGHTS, "m high");
            slider(&mut piece.depth, DEPTHS, "m deep");
            if site.race_width.is_none() {
                slider(&mut piece.width, WIDTHS, "m wide");
            }
        }
        if site.pieces.get(k) != Some(&piece) {
            site.change(k, piece, runners);
        }
    }
    ui.horizontal(|ui| {
        if ui.add_enabled(site.chosen.is_some(), egui::Button::new("Remove")).clicked() {
            site.remove();
        }
        if ui.button("As before").clicked() {
            site.lay(first_pieces());
        }
        if ui.button("Copy").on_hover_text("The course as text, for a .course.ron file").clicked() {
            ui.ctx().copy_text(site.to_ron());
        }
    });
    let mut on = race.on;
    ui.checkbox(&mut on, "Race of eight");
    if on != race.on {
        race.on = on;
    }
    ui.weak("Arrow keys, the left stick or a thumb take the runner over.");
}
