//! How many skaters the machine holds: headless; a crowd on one thread.
//!
//! Nothing to press. Look at the microseconds a skater takes for a tick, alone, in lanes of four (f64) and of eight (f32), at how many skaters
//! with their policies that makes in real time, at the cost of a frame with one skater against one without, and at the
//! price of a snapshot.
//! Least times are those that nothing else on the machine disturbed; medians are what it was like.
//!
//! `cargo run --release --no-default-features --features engine --example crowd_capacity -- [SKATERS]`

use bevy::diagnostic::DiagnosticsStore;
use bevy::ecs::schedule::{Schedules, SingleThreadedExecutor};
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::engine::*;
use std::time::{Duration, Instant};

/// The argument that measures the frames of one skater only.
const FRAMES: &str = "frames";
/// Ticks in a block; blocks with and without lanes take turns.
const BLOCK: usize = 32;
const BLOCKS: usize = 8;

fn main() {
    let argument = std::env::args().nth(1);
    if argument.as_deref() == Some(FRAMES) {
        one_skater(false);
        one_skater(true);
        return;
    }
    let count: usize = argument.and_then(|n| n.parse().ok()).unwrap_or(64);
    // The thread that runs the systems steps all skaters.
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(0).build());
    crowd(count);
    // Frames are those of an ordinary app, whose pools have threads: in a process of its own.
    let program = std::env::current_exe().expect("the path of this program");
    let status = std::process::Command::new(program).arg(FRAMES).status().expect("this program again");
    assert!(status.success(), "the frames of one skater");
}

/// An app with the shipped skills, whose frames last `frame`, as do its fixed ticks.
fn app(frame: Duration) -> (App, Handle<CharacterAsset>, Vec<Handle<SkillAsset>>) {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), AthletePlugins));
    app.insert_resource(AthleteWorld::ice());
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    app.insert_resource(Time::<Fixed>::from_duration(frame));
    app.finish();
    app.cleanup();
    let server = app.world().resource::<AssetServer>().clone();
    let character = server.load("characters/skater.character.ron");
    let skill = |name: &str| server.load::<SkillAsset>(format!("skills/skating/{name}/{name}.skill.ron"));
    let skills = ["stroking", "forward_crossover", "backward_crossover"].map(skill).to_vec();
    while !skills.iter().all(|s| server.is_loaded_with_dependencies(s)) {
        assert!(
            !skills.iter().any(|s| server.load_state(s).is_failed()),
            "run it by cargo: it reads the crate's assets"
        );
        app.update();
        std::thread::sleep(Duration::from_millis(5));
    }
    (app, character, skills)
}

fn crowd(count: usize) {
    let tick = Duration::from_micros(15_625);
    let (mut app, character, skills) = app(tick);
    for k in 0..count {
        let place = Transform::from_xyz((k % 32) as f32 * 20.0, 0.0, (k / 32) as f32 * 20.0);
        let skill = AthleteController::skill(skills[k % skills.len()].clone());
        app.world_mut().spawn((Athlete(character.clone()), place, skill));
        // They come one after the other, so that they do not move in step.
        if k % 4 == 0 {
            app.update();
        }
    }
    (0..64).for_each(|_| app.update());
    // What is at half rate is so by its distance: everybody, once there is a viewer.
    for entity in app.world_mut().query_filtered::<Entity, With<Athlete>>().iter(app.world()).collect::<Vec<_>>() {
        app.world_mut().entity_mut(entity).insert(AthleteLod { full: -1.0, reduced: f32::MAX });
    }
    let kinds = [
        ("each alone", false, AthletePrecision::Double, false),
        ("in lanes of four", true, AthletePrecision::Double, false),
        ("... at half rate", true, AthletePrecision::Double, true),
        ("in lanes of eight", true, AthletePrecision::Single, false),
        ("... at half rate", true, AthletePrecision::Single, true),
    ];
    let mut times = kinds.map(|_| Vec::new());
    for block in 0..kinds.len() * BLOCKS {
        let kind = block % kinds.len();
        let (_, lanes, precision, far) = kinds[kind];
        app.insert_resource(AthleteLanes(lanes));
        for mut settings in app.world_mut().query::<&mut AthleteSettings>().iter_mut(app.world_mut()) {
            settings.precision = precision;
        }
        let viewer = far.then(|| app.world_mut().spawn(AthleteViewer).id());
        // A change of rate waits for the right step.
        (0..8).for_each(|_| app.update());
        for _ in 0..BLOCK {
            app.update();
            let store = app.world().resource::<DiagnosticsStore>();
            let measured = store.get_measurement(&AthleteDiagnosticsPlugin::STEP_TIME);
            times[kind].push(measured.map_or(f64::NAN, |m| m.value * 1e3));
        }
        viewer.map(|viewer| app.world_mut().despawn(viewer));
    }
    println!("{count} skaters with their policies, 1200 steps per second, 64 ticks per second, one thread:");
    for ((name, ..), mut times) in kinds.into_iter().zip(times) {
        let (least, median) = least_and_median(&mut times);
        let per = |time: f64| time / count as f64;
        let held = |time: f64| 15_625.0 / per(time);
        println!(
            "  {name:17}  {:6.1} us a skater and tick ({:.1} median): {:.0} skaters in real time ({:.0})",
            per(least),
            per(median),
            held(least),
            held(median)
        );
    }
    let mut bodies = app.world_mut().query::<&mut AthleteBody>();
    let stopped = bodies.iter(app.world()).filter(|b| b.status() == BodyStatus::Quarantined).count();
    assert_eq!(stopped, 0, "skaters went bad");
    let mut body = bodies.iter_mut(app.world_mut()).next().expect("a skater");
    snapshots(&mut body);
}

fn snapshots(body: &mut AthleteBody) {
    let snapshot = body.snapshot();
    let bytes = snapshot.to_bytes();
    println!("snapshot of a skater: {} bytes in memory, {} as a file", snapshot.size(), bytes.len());
    timed("take", || drop(std::hint::black_box(body.snapshot())));
    timed("restore", || body.restore(&snapshot).expect("its own snapshot"));
    timed("to bytes", || drop(std::hint::black_box(snapshot.to_bytes())));
    timed("from bytes", || drop(std::hint::black_box(AthleteSnapshot::from_bytes(&bytes))));
}

fn timed(name: &str, mut action: impl FnMut()) {
    let mut times: Vec<f64> = (0..200)
        .map(|_| {
            let begin = Instant::now();
            (0..10).for_each(|_| action());
            begin.elapsed().as_secs_f64() * 1e5
        })
        .collect();
    let (least, median) = least_and_median(&mut times);
    println!("  {name:10} {least:6.2} us ({median:.2} median)");
}

/// The cost of a frame with one skater, and of one of an app without athletes; systems are handed from thread to thread, as
/// is Bevy's default, or not.
fn one_skater(single_threaded: bool) {
    let frame = Duration::from_nanos(1_000_000_000 / 60);
    let (mut skating, character, skills) = app(frame);
    let mut empty = App::new();
    empty.add_plugins((MinimalPlugins, AssetPlugin::default()));
    empty.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    empty.insert_resource(Time::<Fixed>::from_duration(frame));
    empty.finish();
    empty.cleanup();
    if single_threaded {
        for app in [&mut skating, &mut empty] {
            for (_, schedule) in app.world_mut().resource_mut::<Schedules>().iter_mut() {
                schedule.set_executor(SingleThreadedExecutor::new());
            }
        }
    }
    skating.world_mut().spawn((Athlete(character), AthleteController::skill(skills[0].clone())));
    let mut frames = [Vec::new(), Vec::new()];
    for k in 0..660 {
        for (app, frames) in [&mut skating, &mut empty].into_iter().zip(&mut frames) {
            let begin = Instant::now();
            app.update();
            if k >= 60 {
                frames.push(begin.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    let [with, without] = &mut frames;
    let ((least, median), (least_empty, median_empty)) = (least_and_median(with), least_and_median(without));
    let executor = if single_threaded { ", single-threaded executor" } else { "" };
    println!(
        "one skater at 60 frames per second, the whole headless frame{executor}: {least:.3} ms ({median:.3} median); \
         without athletes {least_empty:.3} ({median_empty:.3}): the skater {:.3} ({:.3})",
        least - least_empty,
        median - median_empty,
    );
}

fn least_and_median(times: &mut [f64]) -> (f64, f64) {
    times.sort_by(f64::total_cmp);
    (times[0], times[times.len() / 2])
}
