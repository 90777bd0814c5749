//! A skater that goes where you point: arrow keys or a gamepad's left stick.
//!
//! It strokes when the path is straight and crosses over when it curves. T turns backwards, B forwards again, J jumps (while it goes backwards), R starts again.
//!
//! `cargo run --release --example steer_skater`

use bevy::prelude::*;
use bevy_athlete::engine::*;

const SKILLS: [&str; 6] = [
    "stroking",
    "forward_crossover",
    "forward_three_turn",
    "backward_crossover",
    "double_salchow",
    "backward_three_turn",
];

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins))
        .insert_resource(ClearColor(Color::srgb(0.55, 0.68, 0.80)))
        .add_systems(Startup, setup)
        .add_systems(Update, (steer, follow))
        .add_observer(|started: On<SkillStarted>| info!("{}", started.skill))
        .run()
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let skills = SKILLS.iter().map(|name| assets.load(format!("skills/skating/{name}/{name}.skill.ron"))).collect();
    commands.spawn((
        Athlete(assets.load("characters/skater.character.ron")),
        Steering::new(skills),
        AthleteGizmos::default(),
        Transform::default(),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(200.0, 200.0))),
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

fn steer(
    keys: Res<ButtonInput<KeyCode>>,
    gamepads: Query<&Gamepad>,
    mut commands: Commands,
    skater: Single<(Entity, &mut Steering)>,
) {
    let (entity, mut steering) = skater.into_inner();
    let axis = |more: KeyCode, less: KeyCode| f32::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)));
    let mut stick =
        Vec2::new(axis(KeyCode::ArrowRight, KeyCode::ArrowLeft), axis(KeyCode::ArrowUp, KeyCode::ArrowDown));
    stick += gamepads.iter().map(Gamepad::left_stick).sum::<Vec2>();
    let direction = Vec3::new(stick.x, 0.0, -stick.y);
    if steering.direction != direction {
        steering.direction = direction;
    }
    let started = |key, button| keys.just_pressed(key) || gamepads.iter().any(|g| g.just_pressed(button));
    // Backwards and forwards again by three-turns.
    if started(KeyCode::KeyT, GamepadButton::West) {
        steering.perform = Some("forward_three_turn".into());
    } else if started(KeyCode::KeyB, GamepadButton::East) {
        steering.perform = Some("backward_three_turn".into());
    } else if started(KeyCode::KeyJ, GamepadButton::South) {
        steering.perform = Some("double_salchow".into());
    }
    if started(KeyCode::KeyR, GamepadButton::Start) {
        commands.trigger(AthleteReset::new(entity));
    }
}

fn follow(
    skater: Single<&Transform, With<Athlete>>,
    mut camera: Single<&mut Transform, (With<Camera>, Without<Athlete>)>,
) {
    let target = skater.translation.with_y(0.85);
    **camera = Transform::from_translation(target + Vec3::new(0.0, 2.2, 5.5)).looking_at(target, Vec3::Y);
}
