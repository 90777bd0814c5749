//! A server without a window or a renderer: one skater performs a control, and what happens is printed.
//!
//! Nothing to press. Look at the edges the blades take, at the line printed every half second, and at how much faster than
//! real time it runs.
//!
//! `cargo run --release --no-default-features --features engine --example headless_server`
//!
//! Or any skill, for a look at whether it plays in a game as it did on the command line: a character and a skill, and the folder that both are in.
//!
//! `... --example headless_server -- characters/runner.character.ron skills/running/jump/jump.skill.ron assets`

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::engine::*;
use std::time::{Duration, Instant};

/// What plays: a character and a skill, or the skater's control.
#[derive(Resource)]
struct Asked(Option<(String, String)>);

/// A skill is watched for so long, s.
const WATCHED: f64 = 15.0;

fn main() -> AppExit {
    let mut arguments = std::env::args().skip(1);
    let asked = arguments.next().zip(arguments.next());
    let file_path = arguments.next().unwrap_or_else(|| "assets".into());
    let world = if asked.is_some() { AthleteWorld::ground() } else { AthleteWorld::ice() };
    App::new()
        .add_plugins((MinimalPlugins, AssetPlugin { file_path, ..default() }, AthletePlugins))
        // Simulated time does not wait for the clock on the wall: every frame is one fixed tick.
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)))
        .insert_resource(world)
        .insert_resource(Asked(asked))
        .add_systems(Startup, spawn)
        .add_systems(FixedLast, (report, stop_at_the_end))
        .add_observer(|edge: On<BladeEdgeChanged>| {
            println!("{:6.3} s  blade {}: {:?} -> {:?}", edge.time, edge.blade, edge.from, edge.to);
        })
        .add_observer(|fall: On<AthleteFell>| println!("{:6.3} s  fell", fall.time))
        .add_observer(|refused: On<AthleteRefused>| println!("refused: {}", refused.reason))
        .run()
}

fn spawn(mut commands: Commands, assets: Res<AssetServer>, asked: Res<Asked>) {
    let (character, controller) = match &asked.0 {
        Some((character, skill)) => (character.as_str(), AthleteController::skill(assets.load(skill.clone()))),
        None => (
            "characters/skater.character.ron",
            AthleteController::Play(assets.load("skills/skating/stroking/stroking.control.ron")),
        ),
    };
    commands.spawn((Athlete(assets.load(character.to_owned())), controller));
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
    athletes: Query<&AthleteBody>,
) {
    let begin = begin.get_or_insert_with(Instant::now);
    if let Some(body) = athletes.iter().find(|body| body.time() >= WATCHED) {
        let speed = body.time() / begin.elapsed().as_secs_f64();
        println!("{:6.3} s  that is all, {speed:.1} times real time", body.time());
        exit.write(AppExit::Success);
    }
    for end in ends.read() {
        println!("{:6.3} s  done, {:.1} times real time", end.time, end.time / begin.elapsed().as_secs_f64());
        exit.write(AppExit::Success);
    }
    if refusals.read().count() > 0 {
        exit.write(AppExit::error());
    }
}
