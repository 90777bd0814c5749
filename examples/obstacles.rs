//! A runner over what you put in its way: it is told where to run and how fast, not where the obstacles are.
//!
//! B drops a box to leap over ahead of it, S a step, W a wall that is too high; up and down change its speed, space is slow motion, R starts again.
//! The log says what it sees, what it plans and why it stops.
//!
//! `cargo run --release --example obstacles`

mod common;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy_athlete::contact::{Geometry, Solid, Surface, World as Surroundings};
use bevy_athlete::engine::*;

/// How far ahead something is dropped, m.
const AHEAD: f32 = 9.0;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins, common::Rink { camera: Vec3::new(4.0, 1.6, 3.0) }))
        .insert_resource(AthleteWorld(Surroundings::ground()))
        .add_systems(Startup, setup)
        .add_systems(Update, (drop, hurry))
        .add_observer(|planned: On<ObstaclePlanned>| match (&planned.skill, &planned.refusal) {
            (Some(skill), _) => info!("{:.2} m high, {:.1} m ahead: {skill}", planned.height, planned.distance),
            (None, Some(reason)) => info!("{:.2} m high, {:.1} m ahead: {reason}", planned.height, planned.distance),
            (None, None) => {}
        })
        .add_observer(|started: On<SkillStarted>| info!("{}", started.skill))
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    let run = assets.load("skills/running/run/run.skill.ron");
    let clears =
        ["jump", "hop_down", "hurdle"].map(|name| assets.load(format!("skills/running/{name}/{name}.skill.ron")));
    commands.spawn((
        Athlete(assets.load("characters/runner.character.ron")),
        AthleteController::course(run, clears),
        AthleteInput::towards(Vec3::NEG_Z).at(3.2),
        AthleteSettings { restart_after: Some(1.5), ..default() },
        Transform::default(),
    ));
}

/// Puts a block onto the way, to be seen and to be touched.
fn drop(
    keys: Res<ButtonInput<KeyCode>>,
    mut commands: Commands,
    mut world: ResMut<AthleteWorld>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    runner: Single<&Transform, With<Athlete>>,
) {
    for (key, height, depth) in [(KeyCode::KeyB, 0.45, 0.4), (KeyCode::KeyS, 0.35, 6.0), (KeyCode::KeyW, 1.6, 0.4)] {
        if !keys.just_pressed(key) {
            continue;
        }
        let size = Vec3::new(3.0, height, depth);
        let middle = Vec3::new(runner.translation.x, 0.5 * height, runner.translation.z - AHEAD - 0.5 * depth);
        commands.spawn((
            Mesh3d(meshes.add(Cuboid::from_size(size))),
            MeshMaterial3d(materials.add(Color::hsl(40.0 + 200.0 * height, 0.5, 0.55))),
            Transform::from_translation(middle),
        ));
        let (center, half_extents): (DVec3, DVec3) = (middle.as_dvec3(), size.as_dvec3() * 0.5);
        let shape = Geometry::Box { center, half_extents, rotation: DQuat::IDENTITY };
        world.0.solids.push(Solid::fixed(shape, Surface::GROUND));
    }
}

fn hurry(keys: Res<ButtonInput<KeyCode>>, mut runner: Single<&mut AthleteInput>) {
    let change = i8::from(keys.just_pressed(KeyCode::ArrowUp)) - i8::from(keys.just_pressed(KeyCode::ArrowDown));
    if change != 0 {
        let speed = runner.speed.unwrap_or(3.2) + 0.4 * f32::from(change);
        runner.speed = Some(speed.clamp(0.0, 4.2));
    }
}
