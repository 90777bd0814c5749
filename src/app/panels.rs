//! The panels of feature `ui`, opened as the command line asks.

use crate::app::DemoOptions;
use crate::ui::editor::PoseEditorState;
use crate::ui::{AthletePanels, AthletePanelsPlugin, MonitorState, Panel, TrainingMonitor};
use bevy::prelude::*;

/// Adds the panels to the demo.
pub(super) fn add_panels(app: &mut App, options: &DemoOptions) {
    app.add_plugins(AthletePanelsPlugin);
    let world = app.world_mut();
    let mut open = options.panels.clone();
    if let Some(file) = &options.key_poses {
        world.resource_mut::<PoseEditorState>().open(file);
        open.push(Panel::Editor);
    }
    if let Some(folder) = &options.follow_run {
        world.resource_mut::<MonitorState>().0 = TrainingMonitor::of(folder.display().to_string());
        open.push(Panel::Monitor);
    }
    let mut panels = world.resource_mut::<AthletePanels>();
    for panel in open {
        panels.set_open(panel, true);
    }
}
