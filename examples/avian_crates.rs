//! A skater among Avian's rigid bodies: steer her through a wall of crates.
//!
//! Arrow keys or the left stick point the way; R builds everything up again. Look at what a crate does to her: she gets as
//! much as she gives, and a full crate (the dark ones) may well take her off her feet.
//!
//! `cargo run --release --features avian --example avian_crates`

use avian3d::prelude::*;
use bevy::prelude::*;
use bevy_athlete::engine::avian::{AthleteAvianPlugin, AthleteSurface};
use bevy_athlete::engine::*;

const SKILLS: [&str; 3] = ["stroking", "forward_crossover", "forward_three_turn"];

/// What is built up again.
#[derive(Component)]
struct Movable;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, PhysicsPlugins::default(), AthletePlugins, AthleteAvianPlugin))
        .insert_resource(ClearColor(Color::srgb(0.55, 0.68, 0.80)))
        .add_systems(Startup, (rink, build_up))
        .add_systems(Update, (steer, follow, again))
        .run()
}

/// The ice: any static collider will do; this one says what it is.
fn rink(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    commands.spawn((
        RigidBody::Static,
        Collider::cuboid(60.0, 1.0, 120.0),
        AthleteSurface::ICE,
        Friction::new(0.03),
        Mesh3d(meshes.add(Cuboid::new(60.0, 1.0, 120.0))),
        MeshMaterial3d(materials.add(Color::srgb(0.82, 0.91, 0.96))),
        Transform::from_xyz(0.0, -0.5, -40.0),
    ));
    let sun = DirectionalLight { shadow_maps_enabled: true, ..default() };
    commands.spawn((sun, Transform::from_xyz(-4.0, 9.0, 5.0).looking_at(Vec3::ZERO, Vec3::Y)));
    commands.spawn((Camera3d::default(), Transform::default()));
}

/// The skater, and three walls of crates in her way.
fn build_up(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let skills = SKILLS.map(|name| assets.load(format!("skills/skating/{name}/{name}.skill.ron")));
    let settings = AthleteSettings { restart_after: Some(2.0), ..default() };
    let skater = Athlete(assets.load("characters/skater.character.ron"));
    let controller = AthleteController::steer(skills);
    commands.spawn((Movable, skater, controller, AthleteInput::default().at(2.5), settings, Transform::default()));
    let cube = meshes.add(Cuboid::from_length(0.4));
    let [light, dark] =
        [Color::srgb(0.80, 0.60, 0.35), Color::srgb(0.35, 0.22, 0.12)].map(|color| materials.add(color));
    for k in 0..60_u8 {
        let (wall, row, column) = (k / 20, k % 20 / 5, k % 5);
        let full = wall == 2;
        commands.spawn((
            Movable,
            RigidBody::Dynamic,
            Collider::cuboid(0.4, 0.4, 0.4),
            Mass(if full { 6.0 } else { 0.8 }),
            Friction::new(0.2),
            Mesh3d(cube.clone()),
            MeshMaterial3d(if full { dark.clone() } else { light.clone() }),
            Transform::from_xyz(
                0.41 * (f32::from(column) - 2.0),
                0.2 + 0.4 * f32::from(row),
                -8.0 - 10.0 * f32::from(wall),
            ),
        ));
    }
}

fn again(keys: Res<ButtonInput<KeyCode>>, movable: Query<Entity, With<Movable>>, mut commands: Commands) {
    if keys.just_pressed(KeyCode::KeyR) {
        movable.iter().for_each(|entity| commands.entity(entity).despawn());
        commands.run_system_cached(build_up);
    }
}

fn steer(keys: Res<ButtonInput<KeyCode>>, gamepads: Query<&Gamepad>, skater: Single<&mut AthleteInput>) {
    let axis = |more, less| f32::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)));
    let arrows = Vec2::new(axis(KeyCode::ArrowRight, KeyCode::ArrowLeft), axis(KeyCode::ArrowUp, KeyCode::ArrowDown));
    let stick = arrows + gamepads.iter().map(Gamepad::left_stick).sum::<Vec2>();
    let direction = Vec3::new(stick.x, 0.0, -stick.y);
    let mut input = skater.into_inner();
    if direction != Vec3::ZERO && input.direction != direction {
        input.direction = direction;
    }
}

fn follow(
    skater: Single<&Transform, With<Athlete>>,
    mut camera: Single<&mut Transform, (With<Camera3d>, Without<Athlete>)>,
) {
    let target = skater.translation.with_y(0.85);
    **camera = Transform::from_translation(target + Vec3::new(1.6, 1.5, 5.0)).looking_at(target, Vec3::Y);
}
