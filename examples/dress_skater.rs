//! The skater in a skinned mesh: a glTF humanoid whose bones follow the simulated links.
//!
//! Press space for slow motion, R to start again, H to see the plain links under the skin. Look at the arms: the mesh rests with
//! its arms half raised, and the bone map says so. The ponytail follows no link; a system swings it, as an animation would.
//!
//! `cargo run --release --features gltf --example dress_skater`

mod common;

use bevy::prelude::*;
use bevy_athlete::engine::*;
use std::f32::consts::PI;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins, common::Rink { camera: Vec3::new(2.2, 0.5, -2.6) }))
        .add_systems(Startup, setup)
        .add_systems(Update, (hide, swing))
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
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
}

fn hide(
    keys: Res<ButtonInput<KeyCode>>,
    mut skins: Query<&mut AthleteSkin>,
    mut shapes: Query<&mut Visibility, With<LinkVisual>>,
) {
    if keys.just_pressed(KeyCode::KeyH) {
        for mut skin in &mut skins {
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
