//! The keys, and what they do.

use crate::app::act::Act;
use crate::app::camera::{CameraMode, OrbitCamera};
use crate::app::panel::ShowPanel;
use crate::app::scenes::DemoScene;
use crate::app::scenes::skating::Overlays;
use crate::app::stage::SLOW;
use crate::engine::{Athlete, AthleteHistory, AthleteReset, AthleteRewind, PlaybackSpeed};
use bevy::prelude::*;

/// Every key with its meaning, for the help.
pub const KEYS: [(&str, &str); 18] = [
    ("Arrows", "steer: skater, runner, walker; Shift walks faster"),
    ("T / B", "turn backwards / forwards"),
    ("J", "jump, while going backwards"),
    ("P", "short program"),
    ("1 to 5", "scenes"),
    ("Space", "pause"),
    ("N", "one step, while paused"),
    ("M", "slow motion"),
    ("Backspace", "rewind, while held"),
    ("R", "start again"),
    ("C", "camera: orbit, follow, free"),
    ("Drag", "turn the camera; move a piece of the course"),
    ("Del", "take the chosen piece away"),
    ("Wheel", "zoom"),
    ("W A S D Q E", "move the free camera"),
    ("Right drag", "pull at a limb; a finger does too"),
    ("G / F", "ghost / edges and forces"),
    ("H", "hide the windows"),
];

/// Simulated seconds that a rewind goes back for each real second.
const REWIND: f32 = 1.0;

/// What the keys change besides scenes.
pub(super) fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut playback: ResMut<PlaybackSpeed>,
    mut show: ResMut<ShowPanel>,
    mut overlays: ResMut<Overlays>,
    mut act: ResMut<Act>,
    mut commands: Commands,
    mut cameras: Query<&mut OrbitCamera>,
    athletes: Query<Entity, With<Athlete>>,
) {
    if keys.just_pressed(KeyCode::Space) {
        playback.paused = !playback.paused;
    }
    if keys.just_pressed(KeyCode::KeyM) {
        playback.speed = if playback.speed < 1.0 { 1.0 } else { SLOW };
    }
    if keys.just_pressed(KeyCode::KeyH) {
        show.0 = !show.0;
    }
    if keys.just_pressed(KeyCode::KeyG) {
        overlays.ghost = !overlays.ghost;
    }
    if keys.just_pressed(KeyCode::KeyF) {
        overlays.edges = !overlays.edges;
    }
    if keys.just_pressed(KeyCode::KeyP) {
        *act = Act::Program;
    }
    if keys.just_pressed(KeyCode::KeyC) {
        for mut camera in &mut cameras {
            camera.mode = match camera.mode {
                CameraMode::Orbit => CameraMode::Follow,
                CameraMode::Follow => CameraMode::Free,
                CameraMode::Free => CameraMode::Orbit,
            };
        }
    }
    if keys.just_pressed(KeyCode::KeyR) {
        for athlete in &athletes {
            commands.trigger(AthleteReset::new(athlete));
        }
    }
}

/// The number keys: scenes.
pub(super) fn scene_keys(keys: Res<ButtonInput<KeyCode>>, mut next: ResMut<NextState<DemoScene>>) {
    let digits = [KeyCode::Digit1, KeyCode::Digit2, KeyCode::Digit3, KeyCode::Digit4, KeyCode::Digit5];
    for (key, scene) in digits.into_iter().zip(DemoScene::ALL) {
        if keys.just_pressed(key) {
            next.set(scene);
        }
    }
}

/// A single tick while paused, on N.
pub(super) fn single_step(
    keys: Res<ButtonInput<KeyCode>>,
    playback: Res<PlaybackSpeed>,
    fixed: Res<Time<Fixed>>,
    mut time: ResMut<Time<Virtual>>,
) {
    if playback.paused && keys.just_pressed(KeyCode::KeyN) {
        time.advance_by(fixed.timestep());
    }
}

/// Goes back in the history while Backspace is held.
pub(super) fn rewind(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time<Real>>,
    mut commands: Commands,
    mut virtual_time: ResMut<Time<Virtual>>,
    playback: Res<PlaybackSpeed>,
    athletes: Query<Entity, With<AthleteHistory>>,
    mut holding: Local<bool>,
) {
    let held = keys.pressed(KeyCode::Backspace);
    if held {
        // Time stands still while it is turned back.
        virtual_time.pause();
        for entity in &athletes {
            commands.trigger(AthleteRewind { entity, seconds: REWIND * time.delta_secs() });
        }
    } else if *holding && !playback.paused {
        virtual_time.unpause();
    }
    *holding = held;
}
