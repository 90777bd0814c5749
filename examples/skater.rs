//! A skater on ice in a window.
//!
//! Press space for slow motion and R to start again. Look at the blades: nothing moves the skater but what its joints do,
//! and the translucent figure beside it is the motion it tries to follow.
//!
//! `cargo run --release --example skater`

use bevy::prelude::*;
use bevy_athlete::engine::*;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins))
        .insert_resource(ClearColor(Color::srgb(0.55, 0.68, 0.80)))
        .add_systems(Startup, setup)
        .add_systems(Update, (keys, follow))
        .run()
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    // The skater: a character, what it performs, where it starts.
    commands.spawn((
        Athlete(assets.load("characters/skater.character.ron")),
        AthleteController::Play(assets.load("skills/skating/stroking/stroking.control.ron")),
        AthleteSettings { restart_after: Some(1.0), ..default() },
        AthleteGhost::default(),
        Transform::from_xyz(0.0, 0.0, 5.0),
    ));
    // The ice is in `AthleteWorld` already; this is what is seen of it.
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(30.0, 60.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.82, 0.91, 0.96),
            perceptual_roughness: 0.25,
            ..default()
        })),
    ));
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(-4.0, 9.0, 5.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((Camera3d::default(), Transform::default()));
}

fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut commands: Commands,
    skaters: Query<Entity, With<Athlete>>,
    mut playback: ResMut<PlaybackSpeed>,
) {
    if keys.just_pressed(KeyCode::Space) {
        playback.speed = if playback.speed < 1.0 { 1.0 } else { 0.2 };
    }
    if keys.just_pressed(KeyCode::KeyR) {
        for skater in &skaters {
            commands.trigger(AthleteReset::new(skater));
        }
    }
}

fn follow(
    skater: Single<&Transform, With<Athlete>>,
    mut camera: Single<&mut Transform, (With<Camera>, Without<Athlete>)>,
) {
    let target = skater.translation.with_y(0.85);
    **camera = Transform::from_translation(target + Vec3::new(3.0, 0.9, 3.2)).looking_at(target, Vec3::Y);
}
