//! The plugin: which panels are open, which athlete is selected, and the systems that feed the panels.

use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteDiagnosticsPlugin, AthleteForces, AthleteSettings, AthleteSystems,
    BalancePose, LinkPoses,
};
use crate::ui::disturbance::{Disturbance, disturbance};
use crate::ui::editor::{EditorPreviewPlugin, PoseEditorState, pose_editor};
use crate::ui::history::{History, Sample};
use crate::ui::inspector::inspector;
use crate::ui::inspector_view::InspectorView;
use crate::ui::monitor::{TrainingMonitor, training_monitor};
use crate::ui::panel_choice::{AthletePanels, Panel};
use crate::ui::plate::contact_plate;
use crate::ui::plate_action::PlateAction;
use crate::ui::plate_view::PlateView;
use crate::ui::plots::plots;
use crate::ui::pressure::PressurePath;
use crate::ui::push_systems::{WorldPull, apply_pull};
use bevy::diagnostic::{Diagnostic, DiagnosticPath, DiagnosticsStore};
use bevy::ecs::entity::Entity;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};

/// Samples of the selected athlete.
#[derive(Resource, Clone, Debug, Default)]
pub struct SelectedHistory {
    /// The samples.
    pub history: History,
    /// The way of its centres of pressure, while the contact plate is open.
    pub path: PressurePath,
    /// Whose they are.
    pub of: Option<Entity>,
}

/// What the disturbance panel holds.
#[derive(Resource, Clone, Debug, Default, Deref, DerefMut)]
pub struct DisturbanceState(pub Disturbance);

/// What the training monitor holds.
#[derive(Resource, Clone, Debug, Default, Deref, DerefMut)]
pub struct MonitorState(pub TrainingMonitor);

/// Windows for all panels, a menu bar, and the systems that feed them. Add it after `EguiPlugin` and
/// [`AthletePlugins`](crate::engine::AthletePlugins).
#[derive(Debug, Default)]
pub struct AthletePanelsPlugin;

impl Plugin for AthletePanelsPlugin {
    fn build(&self, app: &mut App) {
        use AthleteSystems::{Control, Step, WriteBack};
        app.init_resource::<AthletePanels>()
            .init_resource::<SelectedHistory>()
            .init_resource::<DisturbanceState>()
            .init_resource::<MonitorState>()
            .init_resource::<WorldPull>()
            .add_systems(FixedPostUpdate, (apply_pull.after(Control).before(Step), sample.after(WriteBack)))
            .add_plugins(EditorPreviewPlugin)
            .add_systems(Update, select)
            .add_systems(
                EguiPrimaryContextPass,
                (show_menu, show_inspector, show_plots, show_disturbance, show_plate, show_editor, show_monitor)
                    .chain(),
            );
    }
}

/// Wall time of one step of one athlete in the last fixed tick, microseconds; no number where nothing was stepped.
fn step_micros(diagnostics: Option<&DiagnosticsStore>) -> f64 {
    let value =
        |path: DiagnosticPath| diagnostics.and_then(|all| all.get(&path)).and_then(Diagnostic::value).unwrap_or(0.0);
    let steps = value(AthleteDiagnosticsPlugin::STEPS);
    if steps > 0.0 { value(AthleteDiagnosticsPlugin::STEP_TIME) * 1e3 / steps } else { f64::NAN }
}

/// Selects an athlete where none is, or where it is gone.
fn select(mut panels: ResMut<AthletePanels>, athletes: Query<Entity, (With<Athlete>, With<AthleteBody>)>) {
    if panels.selected.is_none_or(|s| !athletes.contains(s)) {
        let first = athletes.iter().min();
        if panels.selected != first {
            panels.selected = first;
        }
    }
}

fn sample(
    panels: Res<AthletePanels>,
    diagnostics: Option<Res<DiagnosticsStore>>,
    mut kept: ResMut<SelectedHistory>,
    bodies: Query<(&AthleteBody, &LinkPoses)>,
) {
    if kept.of != panels.selected {
        kept.of = panels.selected;
        kept.history.clear();
        kept.path.clear();
    }
    let Some((body, poses)) = panels.selected.and_then(|s| bodies.get(s).ok()) else { return };
    if let Some(sample) = Sample::of(body, poses, step_micros(diagnostics.as_deref())) {
        kept.history.push(sample);
    }
    if panels.is_open(Panel::ContactPlate) {
        kept.path.push(body.time(), &PlateView::of(body));
    }
}

/// A window for a panel; nothing while it is closed.
pub(super) fn panel_window(
    panels: &mut AthletePanels,
    panel: Panel,
    place: [f32; 2],
    size: [f32; 2],
    ctx: &egui::Context,
    body: impl FnOnce(&mut egui::Ui),
) {
    if !panels.is_open(panel) {
        return;
    }
    let mut open = true;
    egui::Window::new(panel.title())
        .id(egui::Id::new(("athlete panel", panel)))
        .default_pos(place)
        .default_size(size)
        .open(&mut open)
        .show(ctx, body);
    if !open {
        panels.set_open(panel, false);
    }
}

/// Draws the menu: which panels are open, which athlete is selected.
pub fn panel_menu(ui: &mut egui::Ui, panels: &mut AthletePanels, athletes: &[(Entity, String)]) {
    ui.menu_button("Panels", |ui| {
        for panel in Panel::ALL {
            let mut open = panels.is_open(panel);
            if ui.checkbox(&mut open, panel.title()).changed() {
                panels.set_open(panel, open);
            }
        }
    });
    if athletes.len() > 1 {
        let name = |e: Entity| athletes.iter().find(|(a, _)| *a == e).map(|(_, n)| n.as_str());
        let selected = panels.selected.and_then(name).unwrap_or("nobody").to_owned();
        egui::ComboBox::from_id_salt("selected athlete").selected_text(selected).show_ui(ui, |ui| {
            for (entity, name) in athletes {
                ui.selectable_value(&mut panels.selected, Some(*entity), name);
            }
        });
    }
}

fn show_menu(
    mut contexts: EguiContexts,
    mut panels: ResMut<AthletePanels>,
    athletes: Query<(Entity, &AthleteBody, Option<&Name>), With<Athlete>>,
) -> Result {
    if !panels.menu {
        return Ok(());
    }
    let mut names: Vec<(Entity, String)> = athletes
        .iter()
        .map(|(e, body, name)| (e, name.map_or_else(|| format!("{} {e}", body.model().name), |n| n.to_string())))
        .collect();
    names.sort_by_key(|(e, _)| *e);
    let ctx = contexts.ctx_mut()?;
    egui::Area::new(egui::Id::new("athlete panels menu"))
        .anchor(egui::Align2::RIGHT_TOP, [-14.0, 14.0])
        .order(egui::Order::Foreground)
        .show(ctx, |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.horizontal(|ui| panel_menu(ui, panels.bypass_change_detection(), &names));
            });
        });
    Ok(())
}

fn show_inspector(
    mut contexts: EguiContexts,
    mut panels: ResMut<AthletePanels>,
    bodies: Query<(&AthleteBody, &LinkPoses)>,
) -> Result {
    if !panels.is_open(Panel::Inspector) {
        return Ok(());
    }
    let view = panels.selected.and_then(|s| bodies.get(s).ok()).map(|(body, poses)| InspectorView::of(body, poses));
    panel_window(&mut panels, Panel::Inspector, [14.0, 352.0], [350.0, 380.0], contexts.ctx_mut()?, |ui| {
        inspector(ui, view.as_ref());
    });
    Ok(())
}

fn show_plots(mut contexts: EguiContexts, mut panels: ResMut<AthletePanels>, kept: Res<SelectedHistory>) -> Result {
    panel_window(&mut panels, Panel::Plots, [690.0, 54.0], [350.0, 600.0], contexts.ctx_mut()?, |ui| {
        plots(ui, &kept.history);
    });
    Ok(())
}

fn show_disturbance(
    mut contexts: EguiContexts,
    mut panels: ResMut<AthletePanels>,
    mut state: ResMut<DisturbanceState>,
    mut pull: ResMut<WorldPull>,
    mut bodies: Query<(&AthleteBody, &mut AthleteSettings, &mut AthleteForces)>,
) -> Result {
    if !panels.is_open(Panel::Disturbance) {
        return Ok(());
    }
    let mut selected = panels.selected.and_then(|s| bodies.get_mut(s).ok());
    let links: Vec<String> = selected
        .as_ref()
        .map_or_else(Vec::new, |(body, ..)| body.model().links.iter().map(|l| l.name.clone()).collect());
    let mut friction = selected.as_ref().map(|(_, settings, _)| settings.friction_scale);
    let before = friction;
    let state = &mut state.bypass_change_detection().0;
    let mut wish = None;
    panel_window(&mut panels, Panel::Disturbance, [226.0, 330.0], [300.0, 300.0], contexts.ctx_mut()?, |ui| {
        wish = Some(disturbance(ui, state, &links, friction.as_mut()));
    });
    let Some(wish) = wish else { return Ok(()) };
    if let Some((body, settings, forces)) = &mut selected {
        if friction != before {
            settings.friction_scale = friction.unwrap_or(1.0);
        }
        if wish.push {
            forces.extend(state.push.on(body));
        }
    }
    if wish.pull {
        pull.set(&state.pull);
    }
    Ok(())
}

fn show_plate(
    mut contexts: EguiContexts,
    mut panels: ResMut<AthletePanels>,
    kept: Res<SelectedHistory>,
    mut bodies: Query<(&AthleteBody, &mut AthleteController)>,
) -> Result {
    if !panels.is_open(Panel::ContactPlate) {
        return Ok(());
    }
    let mut selected = panels.selected.and_then(|s| bodies.get_mut(s).ok());
    let view = selected.as_ref().map(|(body, _)| PlateView::of(body));
    let mut done = None;
    // Beside the inspector, or in its place.
    let place = if panels.is_open(Panel::Inspector) { [372.0, 380.0] } else { [14.0, 150.0] };
    panel_window(&mut panels, Panel::ContactPlate, place, [320.0, 340.0], contexts.ctx_mut()?, |ui| {
        done = contact_plate(ui, view.as_ref(), Some(&kept.path));
    });
    if let (Some(action), Some((body, controller))) = (done, &mut selected)
        && let Some(pose) = asked_by(action, body)
    {
        **controller = AthleteController::Balance(pose);
    }
    Ok(())
}

/// The pose that an action on the plate asks for; `None` where the body does not balance, or could not stand so.
fn asked_by(action: PlateAction, body: &AthleteBody) -> Option<BalancePose> {
    let pose = BalancePose::Feet(action.on(body.feet_asked()?)?);
    pose.stance(body.model()).is_ok().then_some(pose)
}

fn show_monitor(
    mut contexts: EguiContexts,
    mut panels: ResMut<AthletePanels>,
    mut monitor: ResMut<MonitorState>,
) -> Result {
    panel_window(&mut panels, Panel::Monitor, [770.0, 70.0], [420.0, 420.0], contexts.ctx_mut()?, |ui| {
        training_monitor(ui, &mut monitor.bypass_change_detection().0);
    });
    Ok(())
}

fn show_editor(
    mut contexts: EguiContexts,
    mut panels: ResMut<AthletePanels>,
    mut editor: ResMut<PoseEditorState>,
) -> Result {
    panel_window(&mut panels, Panel::Editor, [372.0, 14.0], [380.0, 640.0], contexts.ctx_mut()?, |ui| {
        pose_editor(ui, &mut editor.bypass_change_detection().0);
    });
    Ok(())
}
