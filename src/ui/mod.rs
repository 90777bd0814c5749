//! Panels for any egui window, and the plugin that feeds them. Feature `ui`.
//!
//! Each panel is a function of `&mut egui::Ui` and data, so that it can be docked anywhere; [`AthletePanelsPlugin`] puts
//! them into windows of their own, with a menu. `docs/book/panels.md` shows both.
//!
//! | panel | data | shows |
//! | --- | --- | --- |
//! | [`inspector`] | [`InspectorView`] | links, joints, contacts, blades, phase, policy |
//! | [`plots`] | [`History`] | speed, height, lean, forces, step cost over the last seconds |
//! | [`disturbance`] | [`Disturbance`] | pushes, friction, slope, gravity |
//! | [`contact_plate`] | [`PlateView`], [`PressurePath`] | the pressure under each foot and its way, the edge of each blade; returns a [`PlateAction`] |
//! | [`pose_editor`](editor::pose_editor) | [`PoseEditor`](editor::PoseEditor) | key poses: sliders, undo, simulate, train |
//! | [`training_monitor`] | [`TrainingMonitor`] | the curve file of a run, as it grows |
//!
//! # Resources
//! [`AthletePanels`] says which panels are open and which athlete is selected; [`WorldPull`] sets gravity.

mod curve_file;
mod disturbance;
pub mod editor;
mod history;
mod inspector;
mod inspector_view;
mod marks;
mod monitor;
mod panel_choice;
mod plate;
mod plate_action;
mod plate_view;
mod plots;
mod plugin;
mod pressure;
mod push_systems;

pub use curve_file::{CurveError, CurveTable};
pub use disturbance::{Disturbance, DisturbanceWish, Pull, PushPlan, disturbance};
pub use history::{History, Sample};
pub use inspector::inspector;
pub use inspector_view::{BladeRow, ContactRow, InputBlock, InspectorView, JointRow, LinkRow, PolicyRow};
pub use monitor::{TrainingMonitor, training_monitor};
pub use panel_choice::{AthletePanels, Panel};
pub use plate::contact_plate;
pub use plate_action::PlateAction;
pub use plate_view::{PlateAnkle, PlateBlade, PlateFoot, PlatePoint, PlateView, blade_pressure};
pub use plots::plots;
pub use plugin::{AthletePanelsPlugin, DisturbanceState, MonitorState, SelectedHistory, panel_menu};
pub use pressure::{PathPlace, PressureGrid, PressurePath};
pub use push_systems::WorldPull;

/// The code of the guide is compiled with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/book/panels.md")]
struct PanelsGuide;

/// The code of the guide is compiled with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/book/foot_lab.md")]
struct FootLabGuide;
