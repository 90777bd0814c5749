//! The skater in a skinned mesh: a glTF humanoid whose bones follow the simulated links.
//!
//! Press space for slow motion, R to start again, H to see the plain links under the skin. Look at the arms: the mesh rests with
//! its arms half raised, and the bone map says so. The ponytail follows no link; a system swings it, as an animation would.
//!
//! `cargo run --release --features gltf --example dress_skater`

use bevy::prelude::*;
use bevy_athlete::engine::*;
use std::f32::consts::PI;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins))
        .insert_resource(ClearColor(Color::srgb(0.55, 0.68, 0.80)))
        .add_systems(Startup, setup)
        .add_systems(Update, (keys, swing, follow))
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
        AthleteController::Play(assets.load("skills/skating/stroking/stroking.control.ron")),
        AthleteSettings { restart_after: Some(1.0), ..default() },
        // Which bone follows which link.
        AthleteSkin::new(assets.load("maps/humanoid.bones.ron")),
        Transform::from_xyz(0.0, 0.0, 5.0),
        // The mesh stands on the ground at the skater's place. It faces +Z; she faces -Z.
        children![(
            WorldAssetRoot(assets.load(GltfAssetLabel::Scene(0).from_asset("models/humanoid.glb"))),
            Transform::from_rotation(Quat::from_rotation_y(PI)),
        )],
    ));
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
    mut skaters: Query<(Entity, &mut AthleteSkin)>,
    mut shapes: Query<&mut Visibility, With<LinkVisual>>,
    mut playback: ResMut<PlaybackSpeed>,
) {
    if keys.just_pressed(KeyCode::Space) {
        playback.speed = if playback.speed < 1.0 { 1.0 } else { 0.2 };
    }
    for (skater, mut skin) in &mut skaters {
        if keys.just_pressed(KeyCode::KeyR) {
            commands.trigger(AthleteReset::new(skater));
        }
        if keys.just_pressed(KeyCode::KeyH) {
            skin.hide_shapes = !skin.hide_shapes;
            shapes.iter_mut().for_each(|mut shape| *shape = Visibility::Inherited);
        }
    }
}

/// Any system, or an `AnimationPlayer`, may write bones that the map leaves out.
fn swing(time: Res<Time>, mut bones: Query<(&Name, &mut Transform)>) {
    for (_, mut bone) in bones.iter_mut().filter(|(name, _)| name.as_str() == "Ponytail") {
        bone.rotation = Quat::from_rotation_x(2.8 + 0.3 * (5.0 * time.elapsed_secs()).sin());
    }
}

fn follow(
    skater: Single<&Transform, With<Athlete>>,
    mut camera: Single<&mut Transform, (With<Camera>, Without<Athlete>)>,
) {
    let target = skater.translation.with_y(0.85);
    **camera = Transform::from_translation(target + Vec3::new(2.2, 0.5, -2.6)).looking_at(target, Vec3::Y);
}
