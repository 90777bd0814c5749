//! A skater among the rigid bodies of Avian, without a window: she glides into a crate of 5 kg that stands on the ice, and
//! both momenta are printed.
//!
//! Nothing to press. Look at the two columns of impulses: what the skater loses the crate gets. The crate then slides on the
//! ice, slowed by Avian's friction; the skater goes on, slower and maybe off her balance.
//!
//! `cargo run --release --no-default-features --features avian --example avian_push`

use avian3d::prelude::*;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::engine::avian::{AthleteAvianPlugin, AthleteSurface, ColliderGround};
use bevy_athlete::engine::*;
use std::time::Duration;

/// The crate.
#[derive(Component)]
struct Crate;

fn main() -> AppExit {
    App::new()
        .add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default()))
        .add_plugins((PhysicsPlugins::default(), AthletePlugins, AthleteAvianPlugin))
        // Simulated time does not wait for the clock on the wall: every frame is one fixed tick.
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)))
        .add_systems(Startup, spawn)
        .add_systems(FixedUpdate, push_off)
        .add_systems(FixedLast, report)
        .run()
}

fn spawn(mut commands: Commands, mut characters: ResMut<Assets<CharacterAsset>>) {
    // The rink: any collider will do; this one says that it is ice.
    commands.spawn((
        RigidBody::Static,
        Collider::cuboid(30.0, 1.0, 60.0),
        AthleteSurface::ICE,
        Friction::new(0.05),
        Transform::from_xyz(0.0, -0.5, 0.0),
    ));
    commands.spawn((
        Crate,
        RigidBody::Dynamic,
        Collider::cuboid(0.5, 0.5, 0.5),
        Mass(5.0),
        Friction::new(0.05),
        Transform::from_xyz(0.0, 0.25, -2.0),
    ));
    let skater = CharacterAsset::preset("skater").expect("a character of the crate");
    commands.spawn(Athlete(characters.add(skater)));
}

/// Sends the skater off once her body is there.
fn push_off(mut bodies: Query<&mut AthleteBody, Added<AthleteBody>>) {
    for mut body in &mut bodies {
        let simulator = body.simulator_mut();
        simulator.state.root_velocity.linear = bevy_athlete::math::Vec3::splat(DVec3::new(0.0, 0.0, -3.0));
        simulator.state_changed();
    }
}

fn report(
    mut athletes: Query<(&mut AthleteBody, &ColliderGround)>,
    crates: Query<(Entity, &LinearVelocity, &ComputedMass), With<Crate>>,
    mut given: Local<DVec3>,
    mut exit: MessageWriter<AppExit>,
) {
    let Ok((crate_, velocity, mass)) = crates.single() else { return };
    for (mut body, ground) in &mut athletes {
        let push: DVec3 = ground.pushes().filter(|p| p.body == crate_).map(|p| p.impulse).sum();
        if push != DVec3::ZERO {
            *given += push;
            let time = body.time();
            let skater = body.simulator_mut().total_momentum().linear.lane(0);
            println!(
                "{time:6.3} s  push {:+7.3} N s, {:+7.3} in all; ahead: skater {:7.2} N s, crate {:6.2} N s",
                -push.z,
                -given.z,
                -skater.z,
                -f64::from(velocity.0.z * mass.value())
            );
        }
        if body.time() > 2.0 {
            exit.write(AppExit::Success);
        }
    }
}
