//! The panel of the key-pose editor.

use crate::model::{JointKind, Link};
use crate::ui::editor::document::{DocumentError, PoseDocument, PoseField};
use crate::ui::editor::job::JOBS_CAN_RUN;
use crate::ui::editor::state::PoseEditor;
use crate::ui::marks::{ALARM, fault};
use crate::ui::monitor::chart;
use bevy_egui::egui::{
    self, Button, CollapsingHeader, DragValue, Grid, ProgressBar, ScrollArea, Slider, SliderClamping, TextEdit,
};
use std::path::{Path, PathBuf};

/// Folder below which key-pose files are offered.
const FILES: &str = "assets";
/// Folders deep that are looked into.
const DEEP: usize = 4;
/// Most files that are offered.
const MOST: usize = 100;
/// Width of a slider, points.
const SLIDER: f32 = 170.0;
/// Height of the list of poses, points.
const LIST: f32 = 130.0;

/// A change that the panel asks for.
type Change = Box<dyn FnOnce(&mut PoseDocument) -> Result<(), DocumentError>>;

/// Draws the editor.
pub fn pose_editor(ui: &mut egui::Ui, editor: &mut PoseEditor) {
    file_row(ui, editor);
    if let Some(message) = &editor.message {
        if message.fault {
            fault(ui, &message.text);
        } else {
            ui.label(&message.text);
        }
    }
    let Some(document) = editor.document() else {
        ui.weak("open a .keyposes.ron file");
        return;
    };
    let unknown = document.unknown_fields();
    if !unknown.is_empty() {
        ui.weak(format!("kept, but not known: {}", unknown.join(", ")));
    }
    if let Some(Err(reason)) = editor.clip() {
        let reason = reason.to_owned();
        fault(ui, &reason);
    }
    let mut changes: Vec<Change> = Vec::new();
    jobs(ui, editor);
    ui.separator();
    pose_list(ui, editor, &mut changes);
    ui.separator();
    ScrollArea::vertical()
        .id_salt("pose fields")
        .auto_shrink([false, true])
        .show(ui, |ui| fields(ui, editor, &mut changes));
    for change in changes {
        editor.change(change);
    }
    editor.refresh();
}

fn file_row(ui: &mut egui::Ui, editor: &mut PoseEditor) {
    ui.horizontal(|ui| {
        ui.menu_button("Open", |ui| {
            let found = files();
            if found.is_empty() {
                ui.weak(format!("no .keyposes.ron below {FILES}"));
            }
            for file in found {
                if ui.button(file.file_name().unwrap_or_default().to_string_lossy()).clicked() {
                    editor.open(&file);
                }
            }
        });
        let edit = TextEdit::singleline(&mut editor.path).hint_text("NAME.keyposes.ron").desired_width(f32::INFINITY);
        let typed = ui.add(edit);
        if typed.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter)) {
            let path = PathBuf::from(editor.path.trim());
            editor.open(path);
        }
    });
    let Some(document) = editor.document() else { return };
    let (dirty, undo, redo) = (document.is_dirty(), document.can_undo(), document.can_redo());
    let other = Path::new(editor.path.trim()) != document.path();
    ui.horizontal(|ui| {
        if ui.add_enabled(dirty || other, Button::new(if other { "Save as" } else { "Save" })).clicked() {
            editor.save(false);
        }
        if editor.message.as_ref().is_some_and(|m| m.fault && m.text.contains("changed on disk"))
            && ui.button("Save anyway").clicked()
        {
            editor.save(true);
        }
        if ui.add_enabled(undo, Button::new("Undo")).clicked() {
            editor.step_history(false);
        }
        if ui.add_enabled(redo, Button::new("Redo")).clicked() {
            editor.step_history(true);
        }
        ui.toggle_value(&mut editor.playing, "Play").on_hover_text("the ghost plays the motion, or stands in the pose");
        if ui.button("Bring here").on_hover_text("put the ghost beside the selected athlete").clicked() {
            editor.bring_here = true;
        }
    });
}

/// Key-pose files below the folder of assets.
fn files() -> Vec<PathBuf> {
    fn look(folder: &Path, deep: usize, found: &mut Vec<PathBuf>) {
        let Ok(entries) = std::fs::read_dir(folder) else { return };
        for path in entries.filter_map(|e| Some(e.ok()?.path())) {
            if path.is_dir() && deep > 0 {
                look(&path, deep - 1, found);
            } else if path.to_string_lossy().ends_with(".keyposes.ron") && found.len() < MOST {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    look(Path::new(FILES), DEEP, &mut found);
    found.sort();
    found
}

fn pose_list(ui: &mut egui::Ui, editor: &mut PoseEditor, changes: &mut Vec<Change>) {
    let Some(document) = editor.document() else { return };
    let poses = document.poses().clone();
    let (count, selected) = (poses.poses.len(), editor.selected);
    ui.horizontal(|ui| {
        ui.strong("Poses");
        if ui.small_button("copy").clicked() {
            changes.push(Box::new(move |d| d.duplicate(selected)));
        }
        if ui.add_enabled(count > 1, Button::new("delete").small()).clicked() {
            changes.push(Box::new(move |d| d.remove(selected)));
        }
        if ui.add_enabled(selected > 0, Button::new("up").small()).clicked() {
            changes.push(Box::new(move |d| d.swap_with_next(selected - 1)));
            editor.selected = selected - 1;
        }
        if ui.add_enabled(selected + 1 < count, Button::new("down").small()).clicked() {
            changes.push(Box::new(move |d| d.swap_with_next(selected)));
            editor.selected = selected + 1;
        }
        if ui.small_button("mirror").on_hover_text("swap left and right in this pose").clicked() {
            changes.push(Box::new(move |d| d.mirror(selected)));
        }
    });
    let mut start = 0.0;
    ScrollArea::vertical().id_salt("pose list").max_height(LIST).auto_shrink([false, true]).show(ui, |ui| {
        Grid::new("pose list").num_columns(4).spacing([10.0, 2.0]).striped(true).show(ui, |ui| {
            for (k, pose) in poses.poses.iter().enumerate() {
                if ui.selectable_label(k == selected, format!("{:2}", k + 1)).clicked() {
                    editor.selected = k;
                }
                ui.monospace(format!("at {start:5.2} s"));
                let mut seconds = poses.seconds.get(k).copied().unwrap_or_default();
                start += seconds;
                let drag = DragValue::new(&mut seconds).range(0.01..=10.0).speed(0.005).max_decimals(4).suffix(" s");
                let response = ui.add(drag).on_hover_text("time to the next pose");
                number(&response, k, PoseField::Seconds, seconds, changes);
                let mut airborne = pose.airborne;
                if ui.checkbox(&mut airborne, "in the air").changed() {
                    changes.push(Box::new(move |d| d.set_airborne(k, airborne)));
                }
                ui.end_row();
            }
        });
    });
    let marks = editor.marks();
    let names: Vec<&str> = marks.iter().map(|m| m.name.as_str()).collect();
    ui.weak(if names.is_empty() { "nothing touches".into() } else { format!("touches: {}", names.join(", ")) });
}

/// Hands a changed number on, and ends the step of the history when the pointer lets go.
fn number(response: &egui::Response, pose: usize, field: PoseField, value: f64, changes: &mut Vec<Change>) {
    if response.changed() {
        changes.push(Box::new(move |d| d.set(pose, field, value)));
    }
    if response.drag_stopped() || response.lost_focus() {
        changes.push(Box::new(|d| {
            d.end_gesture();
            Ok(())
        }));
    }
}

fn fields(ui: &mut egui::Ui, editor: &PoseEditor, changes: &mut Vec<Change>) {
    let (Some(document), Some(model)) = (editor.document(), editor.model()) else { return };
    let pose = editor.selected;
    let slider =
        |ui: &mut egui::Ui, label: &str, field: PoseField, range: (f64, f64), unit: &str, changes: &mut Vec<Change>| {
            let Some(mut value) = document.value(pose, &field) else { return };
            let outside = value < range.0 || value > range.1;
            if outside {
                ui.colored_label(ALARM, label);
            } else {
                ui.label(label);
            }
            let decimals = if unit == "\u{b0}" { 1 } else { 3 };
            let slider = Slider::new(&mut value, range.0..=range.1).clamping(SliderClamping::Edits);
            let response = ui.add(slider.max_decimals(decimals).suffix(unit));
            let response = if outside { response.on_hover_text("outside the joint's range") } else { response };
            number(&response, pose, field, value, changes);
            ui.end_row();
        };
    ui.spacing_mut().slider_width = SLIDER;
    CollapsingHeader::new("The way").show(ui, |ui| {
        Grid::new("file fields").num_columns(2).show(ui, |ui| {
            slider(ui, "speed", PoseField::Speed, (-10.0, 10.0), " m/s", changes);
            slider(ui, "acceleration", PoseField::Acceleration, (-2.0, 2.0), " m/s\u{b2}", changes);
            slider(ui, "curvature", PoseField::Curvature, (-1.0, 1.0), " 1/m", changes);
        });
    });
    CollapsingHeader::new("Root").default_open(true).show(ui, |ui| {
        Grid::new("root fields").num_columns(2).show(ui, |ui| {
            for (k, label) in ["x: bend back", "y: turn left", "z: tilt left"].into_iter().enumerate() {
                slider(ui, label, PoseField::Root(k), (-90.0, 90.0), "\u{b0}", changes);
            }
            slider(ui, "turn", PoseField::Turn, (-1080.0, 1080.0), "\u{b0}", changes);
            slider(ui, "to the right", PoseField::Lateral, (-1.0, 1.0), " m", changes);
            slider(ui, "height", PoseField::Height, (0.0, 3.0), " m", changes);
        });
    });
    for link in model.links.iter().skip(1) {
        CollapsingHeader::new(&link.name).default_open(true).show(ui, |ui| {
            Grid::new(("joint fields", &link.name)).num_columns(2).show(ui, |ui| {
                for (k, label) in ["x", "y", "z"].into_iter().enumerate() {
                    if moves(link, k) {
                        let range =
                            link.limits.map_or((-180.0, 180.0), |l| (l.low[k].to_degrees(), l.high[k].to_degrees()));
                        slider(ui, label, PoseField::Joint(link.name.clone(), k), range, "\u{b0}", changes);
                    }
                }
            });
        });
    }
}

/// Whether a joint can move about this component.
fn moves(link: &Link, axis: usize) -> bool {
    match link.joint {
        JointKind::Hinge { axis: of } => of[axis].abs() > 1e-6,
        _ => link.limits.is_none_or(|l| l.high[axis] - l.low[axis] > 1e-6),
    }
}

fn jobs(ui: &mut egui::Ui, editor: &mut PoseEditor) {
    let ready = JOBS_CAN_RUN && matches!(editor.clip(), Some(Ok(_)));
    let (mut simulate, mut train) = (false, false);
    ui.horizontal(|ui| {
        let idle = (editor.simulating().is_none(), editor.training().is_none());
        simulate = ui
            .add_enabled(ready && idle.0, Button::new("Simulate"))
            .on_hover_text("search for a control that makes the body follow the poses; takes seconds")
            .clicked();
        train = ui
            .add_enabled(ready && idle.1, Button::new("Train"))
            .on_hover_text("learn a policy that follows the simulated motion, or the poses where there is none")
            .clicked();
        if editor.performance().1.is_some() && ui.button("Hide").on_hover_text("the athlete beside the ghost").clicked()
        {
            editor.end_performance();
        }
        if !JOBS_CAN_RUN {
            ui.weak("a browser has no threads for these");
        }
    });
    if simulate {
        editor.simulate_by_default();
    }
    if train {
        editor.train();
    }
    if let Some((job, progress)) = editor.simulating() {
        ui.horizontal(|ui| {
            if ui.add_enabled(!job.is_cancelled(), Button::new("Cancel")).clicked() {
                job.cancel();
            }
            let (part, text) = progress.map_or((0.0, "begins".into()), |p| {
                let part = (p.window + 1) as f32 / p.windows.max(1) as f32;
                (part, format!("attempt {}, cost {:.2}, went back {} times", p.attempt + 1, p.cost, p.backtracks))
            });
            ui.add(ProgressBar::new(part).text(text));
        });
    }
    training(ui, editor);
}

fn training(ui: &mut egui::Ui, editor: &mut PoseEditor) {
    if let Some((job, judging)) = editor.training() {
        let last = editor.curve().last().copied().unwrap_or_default();
        ui.horizontal(|ui| {
            if ui.add_enabled(!job.is_cancelled(), Button::new("Cancel")).clicked() {
                job.cancel();
            }
            if ui
                .add_enabled(!judging && !editor.curve().is_empty(), Button::new("Finish"))
                .on_hover_text("keep what has been learnt")
                .clicked()
            {
                job.finish();
            }
            let part = (last.seconds / editor.plan.seconds.max(1e-9)) as f32;
            let text = match (job.is_cancelled(), judging) {
                (true, _) => "stops".into(),
                (_, true) => "measures its card".into(),
                _ => {
                    format!("{:.0} s, trials of {:.1} s, {:.0} % fail", last.seconds, last.length, 100.0 * last.failed)
                }
            };
            ui.add(ProgressBar::new(part).text(text));
        });
    } else {
        CollapsingHeader::new("How to train").show(ui, |ui| {
            Grid::new("train plan").num_columns(2).show(ui, |ui| {
                ui.label("at most");
                ui.add(
                    Slider::new(&mut editor.plan.seconds, 10.0..=3600.0).logarithmic(true).max_decimals(0).suffix(" s"),
                );
                ui.end_row();
                ui.label("or until");
                let mut percent = 100.0 * editor.plan.until;
                ui.add(Slider::new(&mut percent, 50.0..=100.0).max_decimals(0).suffix(" % last"));
                editor.plan.until = percent / 100.0;
                ui.end_row();
                ui.label("save to");
                let hint = editor.skill_folder();
                ui.add(TextEdit::singleline(&mut editor.folder).hint_text(hint));
                ui.end_row();
            });
        });
    }
    if !editor.curve().is_empty() {
        let curve = |y: &dyn Fn(&crate::train::ppo::Iteration) -> Option<f64>| -> Vec<[f64; 2]> {
            editor.curve().iter().filter_map(|i| Some([i.seconds, y(i)?])).collect()
        };
        let curves = [
            ("reward", curve(&|i| Some(i.reward))),
            ("failed", curve(&|i| Some(i.failed))),
            ("survival", curve(&|i| i.evaluation.map(|(survival, _)| survival))),
        ];
        chart(ui, "editor curve", 110.0, &curves);
    }
    if let Some(learnt) = editor.learnt() {
        for row in &learnt.card.rows {
            let interval = format!("{:.0} to {:.0}", 100.0 * row.low, 100.0 * row.high);
            ui.label(format!("{}: {} of {} trials ({interval} %)", row.name, row.successes, row.trials));
        }
        if editor.saved_to() != Some(editor.skill_folder().as_str()) && ui.button("Save the skill").clicked() {
            editor.save_skill();
        }
    }
}
