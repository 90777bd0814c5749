//! A skater on ice in a window.
//!
//! Press space for slow motion and R to start again. Look at the blades: nothing moves the skater but what its joints do,
//! and the translucent figure beside it is the motion it tries to follow.
//!
//! `cargo run --release --example skater`

mod common;

use bevy::prelude::*;
use bevy_athlete::engine::*;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins, common::Rink { camera: Vec3::new(3.0, 0.9, 3.2) }))
        .add_systems(Startup, setup)
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    // The skater: a character, what it performs, where it starts.
    commands.spawn((
        Athlete(assets.load("characters/skater.character.ron")),
        AthleteController::Play(assets.load("skills/skating/stroking/stroking.control.ron")),
        AthleteSettings { restart_after: Some(1.0), ..default() },
        AthleteGhost::default(),
        Transform::from_xyz(0.0, 0.0, 5.0),
    ));
}
