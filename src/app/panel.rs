//! The panel. A function of `&mut egui::Ui`, so that it can be docked anywhere.

use crate::contact::BladeEdge;
use crate::control::TrackingError;
use crate::engine::{Athlete, AthleteBody, PlaybackSpeed};
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

/// What the panel shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PanelView {
    /// Simulated time since the start of the control, s.
    pub time: f64,
    /// Length of the control, s.
    pub length: Option<f64>,
    /// Speed of the root, m/s.
    pub speed: f64,
    /// Name and edge of each blade.
    pub blades: Vec<(String, BladeEdge)>,
    /// Deviation from the reference.
    pub error: Option<TrackingError>,
    /// Simulated seconds per real second.
    pub playback: f32,
    /// Time stands still.
    pub paused: bool,
}

impl PanelView {
    /// What there is to show of a body.
    pub fn of(body: &AthleteBody, playback: &PlaybackSpeed) -> Self {
        let blades = body.model().blades.iter().enumerate();
        Self {
            time: body.time(),
            length: body.control_seconds(),
            speed: body.root_velocity().with_y(0.0).length(),
            blades: blades.map(|(i, b)| (b.name.clone(), body.blade_edge(i))).collect(),
            error: body.tracking_error(),
            playback: playback.clamped_speed(),
            paused: playback.paused,
        }
    }
}

/// The word and colour of an edge.
fn edge_label(edge: BladeEdge) -> (&'static str, egui::Color32) {
    match edge {
        BladeEdge::Off => ("off the ice", egui::Color32::from_gray(140)),
        BladeEdge::Flat => ("flat", egui::Color32::from_gray(225)),
        BladeEdge::Inside => ("inside", egui::Color32::from_rgb(240, 160, 80)),
        BladeEdge::Outside => ("outside", egui::Color32::from_rgb(105, 180, 250)),
    }
}

/// Draws the panel.
pub fn panel(ui: &mut egui::Ui, view: &PanelView) {
    egui::Grid::new("athlete_panel").num_columns(2).spacing([14.0, 4.0]).show(ui, |ui| {
        let row = |ui: &mut egui::Ui, name: &str, value: String| {
            ui.label(name);
            ui.monospace(value);
            ui.end_row();
        };
        let length = view.length.map_or(String::new(), |l| format!(" / {l:.2}"));
        row(ui, "time", format!("{:.2}{length} s", view.time));
        row(ui, "speed", format!("{:.2} m/s", view.speed));
        for (name, edge) in &view.blades {
            ui.label(format!("{name} blade"));
            let (word, color) = edge_label(*edge);
            ui.colored_label(color, word);
            ui.end_row();
        }
        if let Some(error) = view.error {
            row(ui, "root off by", format!("{:.1} cm", error.root * 100.0));
            row(ui, "joints off by", format!("{:.1} deg", error.joints.to_degrees()));
        }
        let pace = if view.paused { "paused".into() } else { format!("{:.2} x", view.playback) };
        row(ui, "pace", pace);
    });
}

/// Whether the panel is shown.
#[derive(Resource, Clone, Copy, Debug)]
pub(super) struct ShowPanel(pub bool);

/// The panel in a corner of the window.
pub(super) fn show_panel(
    mut contexts: EguiContexts,
    show: Res<ShowPanel>,
    playback: Res<PlaybackSpeed>,
    athletes: Query<&AthleteBody, With<Athlete>>,
) -> Result {
    let Some(body) = athletes.iter().next() else { return Ok(()) };
    if !show.0 {
        return Ok(());
    }
    let view = PanelView::of(body, &playback);
    egui::Window::new("Numbers")
        .anchor(egui::Align2::LEFT_TOP, [14.0, 14.0])
        .default_width(190.0)
        .resizable(false)
        .collapsible(false)
        .show(contexts.ctx_mut()?, |ui| panel(ui, &view));
    Ok(())
}
