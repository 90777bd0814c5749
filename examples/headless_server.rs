//! A server without a window or a renderer: one skater performs a control, and what happens is printed.
//!
//! Nothing to press. Look at the edges the blades take, at the line printed every half second, and at how much faster than
//! real time it runs.
//!
//! `cargo run --release --no-default-features --features engine --example headless_server`

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::engine::*;
use std::time::{Duration, Instant};

fn main() -> AppExit {
    App::new()
        .add_plugins((MinimalPlugins, AssetPlugin::default(), AthletePlugins))
        // Simulated time does not wait for the clock on the wall: every frame is one fixed tick.
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)))
        .insert_resource(AthleteWorld::ice())
        .add_systems(Startup, spawn)
        .add_systems(FixedLast, (report, stop_at_the_end))
        .add_observer(|edge: On<BladeEdgeChanged>| {
            println!("{:6.3} s  blade {}: {:?} -> {:?}", edge.time, edge.blade, edge.from, edge.to);
        })
        .add_observer(|fall: On<AthleteFell>| println!("{:6.3} s  fell", fall.time))
        .add_observer(|refused: On<AthleteRefused>| println!("refused: {}", refused.reason))
        .run()
}

fn spawn(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn((
        Athlete(assets.load("characters/skater.character.ron")),
        AthleteController::Play(assets.load("skills/skating/stroking/stroking.control.ron")),
    ));
}

fn report(athletes: Query<&AthleteBody>, mut next: Local<f64>) {
    for body in &athletes {
        if body.time() >= *next {
            *next = body.time() + 0.5;
            let deviation = body.tracking_error().map_or(0.0, |e| e.root);
            let speed = body.root_velocity().length();
            println!("{:6.3} s  {speed:.2} m/s, {:.1} cm from the reference", body.time(), deviation * 100.0);
        }
    }
}

fn stop_at_the_end(
    mut ends: MessageReader<ControlFinished>,
    mut refusals: MessageReader<AthleteRefused>,
    mut exit: MessageWriter<AppExit>,
    mut begin: Local<Option<Instant>>,
) {
    let begin = begin.get_or_insert_with(Instant::now);
    for end in ends.read() {
        println!("{:6.3} s  done, {:.1} times real time", end.time, end.time / begin.elapsed().as_secs_f64());
        exit.write(AppExit::Success);
    }
    if refusals.read().count() > 0 {
        exit.write(AppExit::error());
    }
}
