//! A skater that goes where you point: arrow keys or a gamepad's left stick.
//!
//! It strokes when the path is straight and crosses over when it curves. T turns backwards, B forwards again, J jumps (while it
//! goes backwards), space is slow motion, R starts again. The log says what began, and why something did not.
//!
//! `cargo run --release --example steer_skater`

mod common;

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
        .add_plugins((DefaultPlugins, AthletePlugins, common::Rink { camera: Vec3::new(0.0, 2.2, 5.5) }))
        .add_systems(Startup, setup)
        .add_systems(Update, steer)
        .add_observer(|started: On<SkillStarted>| info!("{}", started.skill))
        .add_observer(|refused: On<SkillRefused>| info!("no {}: {}", refused.skill, refused.reason))
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    let skills = SKILLS.map(|name| assets.load(format!("skills/skating/{name}/{name}.skill.ron")));
    commands.spawn((
        Athlete(assets.load("characters/skater.character.ron")),
        AthleteController::steer(skills),
        AthleteInput::default().at(2.5),
        AthleteGizmos::default(),
        Transform::default(),
    ));
}

fn steer(
    keys: Res<ButtonInput<KeyCode>>,
    gamepads: Query<&Gamepad>,
    mut commands: Commands,
    skater: Single<(Entity, &mut AthleteInput)>,
) {
    let (entity, mut input) = skater.into_inner();
    let axis = |more: KeyCode, less: KeyCode| f32::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)));
    let mut stick =
        Vec2::new(axis(KeyCode::ArrowRight, KeyCode::ArrowLeft), axis(KeyCode::ArrowUp, KeyCode::ArrowDown));
    stick += gamepads.iter().map(Gamepad::left_stick).sum::<Vec2>();
    input.direction = Vec3::new(stick.x, 0.0, -stick.y);
    // Backwards and forwards again by three-turns.
    for (key, button, skill) in [
        (KeyCode::KeyT, GamepadButton::West, "forward_three_turn"),
        (KeyCode::KeyB, GamepadButton::East, "backward_three_turn"),
        (KeyCode::KeyJ, GamepadButton::South, "double_salchow"),
    ] {
        if keys.just_pressed(key) || gamepads.iter().any(|g| g.just_pressed(button)) {
            commands.trigger(PerformSkill::new(entity, skill));
        }
    }
}
