//! The inspector: everything that there is to know of one athlete at this moment.

use crate::engine::BodyStatus;
use crate::ui::inspector_view::{BladeRow, ContactRow, InspectorView, JointRow, LinkRow, PolicyRow};
use crate::ui::marks::{edge_label, fault, nobody, range_bar};
use bevy_egui::egui::{self, CollapsingHeader, Grid, RichText, ScrollArea};

/// Range that is shown of a joint without limits, rad.
const FREE: (f64, f64) = (-std::f64::consts::PI, std::f64::consts::PI);
/// Torque that is shown of a joint without a largest one, N m.
const FREE_TORQUE: f64 = 300.0;
/// Width of a bar, points.
const BAR: f32 = 90.0;

/// Draws the inspector; `None` is an empty selection.
pub fn inspector(ui: &mut egui::Ui, view: Option<&InspectorView>) {
    let Some(view) = view else { return nobody(ui) };
    ui.horizontal(|ui| {
        ui.strong(&view.character);
        ui.monospace(format!("{:.2} s", view.time));
        if view.status == BodyStatus::Quarantined {
            fault(ui, "stopped: its state went bad");
        }
    });
    if let Some(phase) = view.phase {
        ui.add(egui::ProgressBar::new(phase as f32).text(format!("phase {phase:.3}")).desired_height(14.0));
    }
    ScrollArea::vertical().auto_shrink([false, true]).show(ui, |ui| {
        section(ui, "Blades", view.blades.len(), true, |ui| blades(ui, &view.blades));
        section(ui, "Contacts", view.contacts.len(), true, |ui| contacts(ui, &view.contacts));
        section(ui, "Joints", view.joints.len(), true, |ui| view.joints.iter().for_each(|j| joint(ui, j)));
        if let Some(policy) = &view.policy {
            CollapsingHeader::new(format!("Policy of {}", policy.skill))
                .id_salt("policy")
                .show(ui, |ui| outputs_and_inputs(ui, policy));
        }
        section(ui, "Links", view.links.len(), false, |ui| links(ui, &view.links));
    });
}

fn section(ui: &mut egui::Ui, title: &str, count: usize, open: bool, body: impl FnOnce(&mut egui::Ui)) {
    if count == 0 && title == "Blades" {
        return;
    }
    CollapsingHeader::new(format!("{title} ({count})")).id_salt(title).default_open(open).show(ui, body);
}

fn blades(ui: &mut egui::Ui, blades: &[BladeRow]) {
    Grid::new("inspector_blades").num_columns(5).spacing([12.0, 2.0]).striped(true).show(ui, |ui| {
        for head in ["blade", "edge", "lean", "radius", "toe, heel"] {
            ui.weak(head);
        }
        ui.end_row();
        for blade in blades {
            ui.label(&blade.name);
            let (word, color) = edge_label(blade.edge);
            ui.colored_label(color, word);
            match blade.lean {
                Some((lean, curvature)) => {
                    ui.monospace(format!("{:+5.1}\u{b0}", lean.to_degrees()));
                    let straight = curvature.abs() < 1e-3;
                    ui.monospace(if straight { "straight".into() } else { format!("{:.1} m", 1.0 / curvature.abs()) });
                }
                None => {
                    ui.weak("-");
                    ui.weak("-");
                }
            }
            ui.monospace(format!("{:4.0} {:4.0} N", blade.force[0], blade.force[1]));
            ui.end_row();
        }
    });
}

fn contacts(ui: &mut egui::Ui, contacts: &[ContactRow]) {
    if contacts.is_empty() {
        ui.weak("nothing touches");
        return;
    }
    Grid::new("inspector_contacts").num_columns(4).spacing([12.0, 2.0]).striped(true).show(ui, |ui| {
        for head in ["point", "link", "up", "along the ground"] {
            ui.weak(head);
        }
        ui.end_row();
        for contact in contacts {
            ui.label(&contact.name);
            ui.weak(&contact.link);
            ui.monospace(format!("{:6.0} N", contact.force.y));
            ui.monospace(format!("{:5.1} N", contact.force.with_y(0.0).length()));
            ui.end_row();
        }
    });
}

fn joint(ui: &mut egui::Ui, joint: &JointRow) {
    let torque = joint.torque.length();
    let most = if joint.max_torque.is_finite() { joint.max_torque } else { FREE_TORQUE };
    ui.horizontal(|ui| {
        ui.label(RichText::new(&joint.name).strong());
        range_bar(ui, torque, (0.0, most.max(1e-9)), None, BAR);
        ui.monospace(format!("{torque:5.1} N m"));
    });
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if !joint.axes[axis] {
            continue;
        }
        let range = joint.limits.map_or(FREE, |l| (l.low[axis], l.high[axis]));
        let (angle, velocity) = (joint.angle[axis], joint.velocity[axis]);
        let row = ui.horizontal(|ui| {
            ui.add_space(10.0);
            ui.monospace(name);
            range_bar(ui, angle, range, Some(joint.target[axis]), BAR);
            ui.monospace(format!("{:+6.1}\u{b0} {velocity:+5.1} rad/s", angle.to_degrees()));
        });
        row.response.on_hover_text(format!(
            "range {:.0} to {:.0} degrees{}, the white tick is the servo's target at {:.1}",
            range.0.to_degrees(),
            range.1.to_degrees(),
            if joint.limits.is_none() { " (no limits)" } else { "" },
            joint.target[axis].to_degrees(),
        ));
    }
}

fn outputs_and_inputs(ui: &mut egui::Ui, policy: &PolicyRow) {
    if policy.outputs.is_empty() {
        ui.weak("no decision yet");
    }
    CollapsingHeader::new("Outputs").default_open(true).show(ui, |ui| {
        for (link, action) in &policy.outputs {
            ui.horizontal(|ui| {
                ui.add_sized([84.0, 14.0], egui::Label::new(link).truncate());
                for value in action {
                    range_bar(ui, f64::from(*value), (-2.0, 2.0), None, 52.0);
                }
                ui.monospace(format!("{:+.2} {:+.2} {:+.2}", action[0], action[1], action[2]));
            });
        }
    });
    CollapsingHeader::new("Inputs").show(ui, |ui| {
        for block in &policy.inputs {
            let head = format!("{} ({})", block.name, block.values.len());
            CollapsingHeader::new(head).id_salt(&block.name).show(ui, |ui| {
                ui.weak(&block.meaning);
                for row in block.values.chunks(6) {
                    let text: Vec<String> = row.iter().map(|v| format!("{v:+7.3}")).collect();
                    ui.monospace(text.join(" "));
                }
            });
        }
    });
}

fn links(ui: &mut egui::Ui, links: &[LinkRow]) {
    Grid::new("inspector_links").num_columns(3).spacing([12.0, 2.0]).striped(true).show(ui, |ui| {
        for head in ["link", "mass", "place"] {
            ui.weak(head);
        }
        ui.end_row();
        for link in links {
            ui.label(format!("{}{}", "  ".repeat(link.depth), link.name));
            ui.monospace(format!("{:5.2} kg", link.mass));
            ui.monospace(format!("{:+.2} {:+.2} {:+.2} m", link.position.x, link.position.y, link.position.z));
            ui.end_row();
        }
    });
}
