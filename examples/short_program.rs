//! The short program: one trained skill after the other, by itself.
//!
//! Space is slow motion, R starts again. What happens is told in the log.
//!
//! `cargo run --release --example short_program`

use bevy::prelude::*;
use bevy_athlete::engine::*;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins))
        .insert_resource(ClearColor(Color::srgb(0.55, 0.68, 0.80)))
        .add_systems(Startup, setup)
        .add_systems(Update, (keys, follow))
        .add_observer(|started: On<SkillStarted>| info!("{:6.2} s  {}", started.time, started.skill))
        .add_observer(|landing: On<Landing>| {
            // Steps from foot to foot are no jumps.
            if landing.airtime > 0.2 {
                info!(
                    "landed after {:.2} s and {:.2} turns, {:.2} m high",
                    landing.airtime, landing.turns, landing.height
                );
            }
        })
        .add_observer(|fell: On<AthleteFell>| info!("{:6.2} s  fell", fell.time))
        .run()
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Athlete(assets.load("characters/skater.character.ron")),
        SkatingProgram(assets.load("skills/skating/short_program.program.ron")),
        AthleteSettings { restart_after: Some(2.0), ..default() },
        AthleteGizmos::default(),
        Transform::from_xyz(0.0, 0.0, 20.0),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(60.0, 80.0))),
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
    skater: Single<Entity, With<Athlete>>,
    mut playback: ResMut<PlaybackSpeed>,
) {
    if keys.just_pressed(KeyCode::Space) {
        playback.speed = if playback.speed < 1.0 { 1.0 } else { 0.2 };
    }
    if keys.just_pressed(KeyCode::KeyR) {
        commands.trigger(AthleteReset::new(*skater));
    }
}

fn follow(
    skater: Single<&Transform, With<Athlete>>,
    mut camera: Single<&mut Transform, (With<Camera>, Without<Athlete>)>,
) {
    let target = skater.translation.with_y(0.85);
    **camera = Transform::from_translation(target + Vec3::new(3.0, 0.9, 3.2)).looking_at(target, Vec3::Y);
}
