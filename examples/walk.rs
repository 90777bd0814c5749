//! A human with feet of five segments, to walk about with: arrow keys or a gamepad's left stick; shift walks faster. Let go, and it stands.
//!
//! `cargo run --release --example walk`

mod common;

use bevy::prelude::*;
use bevy_athlete::contact::World as Surroundings;
use bevy_athlete::engine::*;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins, common::Rink { camera: Vec3::new(0.0, 1.4, 3.6) }))
        .insert_resource(AthleteWorld(Surroundings::ground()))
        .add_systems(Startup, setup)
        .add_systems(Update, steer)
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn((
        Athlete(assets.load("characters/foot_human.character.ron")),
        AthleteController::skill(assets.load("skills/walking/walk/walk.skill.ron")),
        AthleteInput::default().at(0.0),
        AthleteSettings { restart_after: Some(1.5), ..default() },
        AthleteGizmos::default(),
        Transform::default(),
    ));
}

fn steer(keys: Res<ButtonInput<KeyCode>>, gamepads: Query<&Gamepad>, mut walker: Single<&mut AthleteInput>) {
    let axis = |more: KeyCode, less: KeyCode| f32::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)));
    let mut stick =
        Vec2::new(axis(KeyCode::ArrowRight, KeyCode::ArrowLeft), axis(KeyCode::ArrowUp, KeyCode::ArrowDown));
    stick += gamepads.iter().map(Gamepad::left_stick).sum::<Vec2>();
    let stick = stick.clamp_length_max(1.0);
    let fastest = if keys.pressed(KeyCode::ShiftLeft) { 1.8 } else { 1.2 };
    let wanted = AthleteInput::towards(Vec3::new(stick.x, 0.0, -stick.y)).at(fastest * stick.length());
    if **walker != wanted {
        **walker = wanted;
    }
}
