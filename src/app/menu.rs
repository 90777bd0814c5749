//! The menu of the demo: scenes, what there is to do in each, camera, help. Functions of `&mut egui::Ui`.

use crate::app::act::Act;
use crate::app::camera::{CameraMode, OrbitCamera};
use crate::app::course_menu::site;
use crate::app::keys::KEYS;
use crate::app::lab_menu::lab;
use crate::app::panel::ShowPanel;
use crate::app::scenes::DemoScene;
use crate::app::scenes::course::{Race, Runner, Site};
use crate::app::scenes::crowd::CrowdCount;
use crate::app::scenes::field::{ROUGHEST, Roughness};
use crate::app::scenes::foot_lab::FootLab;
use crate::app::scenes::skating::{Overlays, RinkSkater};
use crate::engine::{AthleteInput, PerformSkill};
use crate::skill::SKATING_SKILLS;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

/// Everything that the menu shows and changes.
#[derive(SystemParam)]
pub(super) struct MenuData<'w, 's> {
    scene: Res<'w, State<DemoScene>>,
    next: ResMut<'w, NextState<DemoScene>>,
    act: ResMut<'w, Act>,
    overlays: ResMut<'w, Overlays>,
    lab: ResMut<'w, FootLab>,
    crowd: Res<'w, CrowdCount>,
    roughness: ResMut<'w, Roughness>,
    site: ResMut<'w, Site>,
    race: ResMut<'w, Race>,
    runners: Query<'w, 's, &'static Transform, With<Runner>>,
    cameras: Query<'w, 's, &'static mut OrbitCamera>,
    skaters: Query<'w, 's, (Entity, &'static mut AthleteInput), With<RinkSkater>>,
    commands: Commands<'w, 's>,
}

/// The menu in the upper right corner.
pub(super) fn show_menu(mut contexts: EguiContexts, show: Res<ShowPanel>, mut data: MenuData) -> Result {
    if !show.0 {
        return Ok(());
    }
    egui::Window::new("Athletes")
        .anchor(egui::Align2::RIGHT_TOP, [-14.0, 54.0])
        .resizable(false)
        .default_width(210.0)
        .show(contexts.ctx_mut()?, |ui| {
            scenes(ui, &data.scene, &mut data.next);
            ui.separator();
            match data.scene.get() {
                DemoScene::Rink => {
                    let mut chosen = *data.act;
                    acts(ui, &mut chosen);
                    data.act.set_if_neq(chosen);
                    if chosen == Act::Steer {
                        for (skater, mut input) in &mut data.skaters {
                            if let Some(name) = wishes(ui, &mut input) {
                                data.commands.trigger(PerformSkill::new(skater, name));
                            }
                        }
                    }
                    let mut overlays = *data.overlays;
                    ui.checkbox(&mut overlays.ghost, "Ghost of the reference");
                    ui.checkbox(&mut overlays.edges, "Edges and forces");
                    data.overlays.set_if_neq(overlays);
                }
                DemoScene::FootLab => lab(ui, &mut data.lab),
                DemoScene::Course => {
                    let runners: Vec<Vec3> = data.runners.iter().map(|place| place.translation).collect();
                    site(ui, &mut data.site, &mut data.race, &runners);
                }
                DemoScene::Crowd => crowd(ui, &data.crowd),
                DemoScene::Field => field(ui, &mut data.roughness),
            }
            ui.separator();
            for mut camera in &mut data.cameras {
                let mut mode = camera.mode;
                cameras(ui, &mut mode);
                if mode != camera.mode {
                    camera.mode = mode;
                }
            }
            ui.collapsing("Keys", help);
        });
    Ok(())
}

/// One button for each scene.
fn scenes(ui: &mut egui::Ui, scene: &State<DemoScene>, next: &mut NextState<DemoScene>) {
    ui.horizontal_wrapped(|ui| {
        for choice in DemoScene::ALL {
            if ui.selectable_label(*scene.get() == choice, choice.title()).clicked() && *scene.get() != choice {
                next.set(choice);
            }
        }
    });
}

/// What the skater may do.
pub(crate) fn acts(ui: &mut egui::Ui, chosen: &mut Act) {
    for act in [Act::Program, Act::Steer, Act::Clip] {
        ui.radio_value(chosen, act, act.title());
    }
    ui.add_space(4.0);
    for k in 0..SKATING_SKILLS.len() {
        ui.radio_value(chosen, Act::Skill(k), Act::Skill(k).title());
    }
}

/// Wishes that need no keys: speed, turns and the jump; the skill that was asked for.
fn wishes(ui: &mut egui::Ui, input: &mut Mut<AthleteInput>) -> Option<&'static str> {
    let mut speed = input.speed.unwrap_or(2.5);
    if ui.add(egui::Slider::new(&mut speed, 1.0..=4.0).text("m/s")).changed() {
        input.speed = Some(speed);
    }
    moves(ui)
}

/// The turns and the jump as buttons; the skill that was asked for.
pub(super) fn moves(ui: &mut egui::Ui) -> Option<&'static str> {
    let mut asked = None;
    ui.horizontal(|ui| {
        for (title, name) in
            [("Backwards", "forward_three_turn"), ("Forwards", "backward_three_turn"), ("Jump", "double_salchow")]
        {
            if ui.button(title).clicked() {
                asked = Some(name);
            }
        }
    });
    asked
}

/// How rough the field is.
fn field(ui: &mut egui::Ui, roughness: &mut ResMut<Roughness>) {
    ui.label("The walker goes round over bumps.");
    let mut wanted = roughness.wanted;
    // In steps: the field is laid anew for each.
    let slider = egui::Slider::new(&mut wanted, 0.0..=ROUGHEST).step_by(0.005).fixed_decimals(3);
    ui.add(slider.text("m up and down"));
    if wanted != roughness.wanted {
        roughness.wanted = wanted;
    }
    ui.weak("Arrow keys, the left stick or a thumb take it over; Shift walks faster.");
}

/// The live count.
fn crowd(ui: &mut egui::Ui, count: &CrowdCount) {
    ui.heading(format!("{} skaters", count.skaters));
    ui.label(format!("stepping takes {:.0} % of the time", 100.0 * count.load));
    if count.load > 0.0 {
        ui.label(format!("room for about {:.0}", count.capacity()));
    }
    let state = match (count.fixed, count.full) {
        (true, _) => "as many as were asked for",
        (false, true) => "full",
        (false, false) => "growing",
    };
    ui.weak(state);
}

/// The kinds of camera.
fn cameras(ui: &mut egui::Ui, mode: &mut CameraMode) {
    ui.horizontal(|ui| {
        for (choice, title) in
            [(CameraMode::Orbit, "Orbit"), (CameraMode::Follow, "Follow"), (CameraMode::Free, "Free")]
        {
            ui.selectable_value(mode, choice, title);
        }
    });
}

/// The keys.
fn help(ui: &mut egui::Ui) {
    egui::Grid::new("athlete_keys").num_columns(2).spacing([14.0, 2.0]).show(ui, |ui| {
        for (key, meaning) in KEYS {
            ui.strong(key);
            ui.label(meaning);
            ui.end_row();
        }
    });
}
