//! The short program: one trained skill after the other, by itself.
//!
//! Space is slow motion, R starts again. What happens is told in the log.
//!
//! `cargo run --release --example short_program`

mod common;

use bevy::prelude::*;
use bevy_athlete::engine::*;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, AthletePlugins, common::Rink { camera: Vec3::new(3.0, 0.9, 3.2) }))
        .add_systems(Startup, setup)
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

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn((
        Athlete(assets.load("characters/skater.character.ron")),
        AthleteController::Program(assets.load("skills/skating/short_program.program.ron")),
        AthleteSettings { restart_after: Some(2.0), ..default() },
        AthleteGizmos::default(),
        Transform::from_xyz(0.0, 0.0, 20.0),
    ));
}
