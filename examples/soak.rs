//! A soak: skaters come and go for a long time, headless, faster than real time; memory has to stay flat.
//!
//! Nothing to press. Every simulated second the oldest skater goes and a new one comes. Look at the resident memory, printed
//! every ten seconds of the clock, and at how many times real time it runs.
//!
//! `cargo run --release --no-default-features --features engine --example soak -- [--minutes N] [--speed TIMES]`

use bevy::ecs::schedule::{Schedules, SingleThreadedExecutor};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_athlete::engine::*;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

const TICK: Duration = Duration::from_micros(15_625);
/// Skaters at a time.
const SKATERS: usize = 4;

fn option(name: &str, default: f64) -> f64 {
    let mut arguments = std::env::args().skip_while(|a| a != name).skip(1);
    arguments.next().and_then(|n| n.parse().ok()).unwrap_or(default)
}

fn main() {
    let (minutes, speed) = (option("--minutes", 1.0), option("--speed", 50.0));
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), AthletePlugins));
    app.insert_resource(AthleteWorld::ice());
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
    app.finish();
    app.cleanup();
    // Ticks are too short here for systems to be handed from thread to thread.
    for (_, schedule) in app.world_mut().resource_mut::<Schedules>().iter_mut() {
        schedule.set_executor(SingleThreadedExecutor::new());
    }
    let server = app.world().resource::<AssetServer>().clone();
    let character: Handle<CharacterAsset> = server.load("characters/skater.character.ron");
    let skill = |name: &str| server.load::<SkillAsset>(format!("skills/skating/{name}/{name}.skill.ron"));
    let skills = ["stroking", "forward_crossover"].map(skill);
    while !skills.iter().all(|s| server.is_loaded_with_dependencies(s)) {
        assert!(
            !skills.iter().any(|s| server.load_state(s).is_failed()),
            "run it by cargo: it reads the crate's assets"
        );
        app.update();
        std::thread::sleep(Duration::from_millis(5));
    }

    println!("{minutes} minutes at {speed} times real time: {SKATERS} skaters, one comes and one goes every second");
    let (begin, mut next_report) = (Instant::now(), 10.0);
    let mut skaters = VecDeque::new();
    let (mut ticks, mut spawned, mut first, mut last) = (0_u64, 0_u64, None, 0);
    while begin.elapsed().as_secs_f64() < minutes * 60.0 {
        if ticks.is_multiple_of(64) {
            if skaters.len() == SKATERS
                && let Some(oldest) = skaters.pop_front()
            {
                app.world_mut().despawn(oldest);
            }
            let place = Transform::from_xyz((spawned % 50) as f32 * 10.0, 0.0, 0.0);
            let controller = AthleteController::skill(skills[(spawned % 2) as usize].clone());
            let lasts = AthleteHistory::new(2.0);
            skaters.push_back(app.world_mut().spawn((Athlete(character.clone()), place, controller, lasts)).id());
            spawned += 1;
        }
        app.update();
        ticks += 1;
        // Not faster than asked for.
        let ahead = ticks as f64 / 64.0 / speed - begin.elapsed().as_secs_f64();
        if ahead > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(ahead));
        }
        let elapsed = begin.elapsed().as_secs_f64();
        if elapsed >= next_report {
            next_report += 10.0;
            let simulated = ticks as f64 / 64.0;
            last = resident_kilobytes();
            // The first ten seconds fill caches and pools.
            first = first.or(Some(last));
            println!(
                "{elapsed:6.0} s  {simulated:8.0} s simulated ({:.1} times)  {spawned} came  {last} kB resident",
                simulated / elapsed
            );
        }
    }
    if let Some(first) = first {
        println!("resident memory after the first ten seconds {first} kB, at the end {last} kB");
    }
}

/// Resident memory of this process, kB; zero where the system does not tell.
fn resident_kilobytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"));
    line.and_then(|l| l.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
