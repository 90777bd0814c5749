//! The foot lab's part of the menu.

use crate::app::scenes::foot_lab::{FootLab, HIGHEST, LabGround, Lump, MOTIONS, STEEPEST, STRONGEST};
use bevy::prelude::*;
use bevy_egui::egui;

/// Motions, ground, slope, lumps and pushes.
pub(super) fn lab(ui: &mut egui::Ui, lab: &mut ResMut<FootLab>) {
    motions(ui, lab);
    ground(ui, lab);
    pushes(ui, lab);
    ui.weak("Left: feet of five segments; right: of two.");
    ui.weak("Contact plate: click segments, drag an ankle.");
    ui.weak("Right drag, or a finger, pulls at a limb.");
}

fn motions(ui: &mut egui::Ui, lab: &mut ResMut<FootLab>) {
    let name = |k: usize| MOTIONS.get(k).map(|(name, _)| *name);
    let mut motion = lab.motion;
    egui::ComboBox::from_id_salt("lab_motion")
        .selected_text(motion.and_then(name).unwrap_or("As on the contact plate"))
        .width(190.0)
        .height(280.0)
        .show_ui(ui, |ui| {
            for (k, (name, _)) in MOTIONS.iter().enumerate() {
                ui.selectable_value(&mut motion, Some(k), *name);
            }
        });
    if let Some(chosen) = motion
        && motion != lab.motion
    {
        lab.choose(chosen);
    }
}

fn ground(ui: &mut egui::Ui, lab: &mut ResMut<FootLab>) {
    let mut wanted = (**lab).clone();
    ui.horizontal(|ui| {
        ui.selectable_value(&mut wanted.ground, LabGround::Floor, "Floor");
        ui.selectable_value(&mut wanted.ground, LabGround::Ball, "A ball each");
    });
    ui.add_enabled_ui(wanted.ground == LabGround::Floor, |ui| {
        let slope = |ui: &mut egui::Ui, value: &mut f32, name: &str| {
            ui.add(egui::Slider::new(value, -STEEPEST..=STEEPEST).suffix("\u{b0}").text(name));
        };
        slope(ui, &mut wanted.slope.x, "sideways");
        slope(ui, &mut wanted.slope.y, "ahead");
        if ui.button("Level").clicked() {
            (wanted.slope, wanted.height) = (Vec2::ZERO, 0.0);
        }
        ui.label("Under a foot");
        let down = wanted.raised == 0.0;
        // What is up goes down first.
        ui.add_enabled_ui(down, |ui| {
            ui.horizontal(|ui| {
                ui.selectable_value(&mut wanted.lump, Lump::Bump, "bump");
                ui.selectable_value(&mut wanted.lump, Lump::Ball, "ball");
                ui.separator();
                ui.selectable_value(&mut wanted.under, 0, "left");
                ui.selectable_value(&mut wanted.under, 1, "right");
            });
        });
        ui.add(egui::Slider::new(&mut wanted.height, 0.0..=HIGHEST).fixed_decimals(3).text("m high"));
    });
    let seen = |lab: &FootLab| (lab.ground, lab.slope, lab.lump, lab.under, lab.height);
    if seen(&wanted) != seen(lab) {
        **lab = wanted;
    }
}

fn pushes(ui: &mut egui::Ui, lab: &mut ResMut<FootLab>) {
    let mut force = lab.force;
    ui.add(egui::Slider::new(&mut force, 0.0..=STRONGEST).fixed_decimals(0).text("N push"));
    let mut push = None;
    ui.horizontal(|ui| {
        for (name, azimuth) in [("on", 0.0), ("back", 180.0), ("left", 90.0), ("right", -90.0)] {
            if ui.button(name).clicked() {
                push = Some(azimuth);
            }
        }
    });
    if force != lab.force || push.is_some() {
        (lab.force, lab.push) = (force, push);
    }
}
