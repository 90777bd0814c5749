//! Scenes whose last bits must be the same everywhere. Shared by `tests/core/determinism.rs` and `examples/golden_bits.rs`, which
//! runs them on other targets.
//!
//! Only rational numbers and square roots go in, so that no library function has a say.
#![allow(dead_code)]

use bevy_athlete::contact::World;
use bevy_athlete::control::{ControlPlayer, ReconstructedControl};
use bevy_athlete::math::{Quat, RandomStream, Real};
use bevy_athlete::model::{SharedModel, preset, skater};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};

/// Characters of the scenes and how long each is thrown onto its ground and sways, s.
pub const SCENES: [(&str, f64); 5] =
    [("skater", 2.0), ("foot_human", 1.0), ("two_segment_human", 0.5), ("toes_human", 0.5), ("runner", 0.5)];

pub fn new<R: Real>(model: &SharedModel) -> Simulator<R> {
    Simulator::new(model.clone(), SimulationSettings::of(model))
}

/// Targets that sway at `k` steps: trunk and limbs.
pub fn sway<R: Real>(sim: &mut Simulator<R>, k: usize) {
    // A triangle wave between -1 and 1 with a period of 800 steps.
    let phase = (k % 800) as f64 / 400.0;
    let wave = 1.0 - 2.0 * (phase - 1.0).abs();
    for (i, command) in sim.commands.iter_mut().enumerate().skip(1) {
        let s = 0.06 * wave * if i % 2 == 0 { 1.0 } else { -0.5 };
        command.rotation = Quat::splat(DQuat::from_xyzw(s, 0.3 * s, 0.0, (1.0 - 1.09 * s * s).sqrt()));
    }
}

/// A start that differs from lane to lane.
pub fn start<R: Real>(sim: &mut Simulator<R>, lane: usize, n: usize) {
    let mut random = RandomStream::new(77, n as u64);
    let velocity = DVec3::new(random.range(-0.5, 0.5), random.range(-1.0, 0.3), random.range(-2.0, 0.5));
    let spin = DVec3::new(random.range(-1.0, 1.0), random.range(-2.0, 2.0), random.range(-1.0, 1.0));
    let still = vec![DVec3::ZERO; sim.model().links.len()];
    let at = sim.state.root_position.lane(lane) + DVec3::Y * random.range(0.0, 0.05);
    sim.state.root_position.set_lane(lane, at);
    sim.state.set_velocity(lane, velocity, spin, &still);
    sim.state_changed();
}

pub fn world_of(name: &str) -> World {
    if name == "skater" { World::ice() } else { World::ground() }
}

/// One fingerprint for all lanes; for a scalar its own.
fn all_lanes<R: Real>(sim: &Simulator<R>) -> u64 {
    assert!((0..R::LANES).all(|lane| sim.is_sane(lane)) && (0..R::LANES).any(|lane| sim.loaded_points(lane) > 0));
    (0..R::LANES).fold(0, |hash: u64, lane| hash.rotate_left(7) ^ sim.state.fingerprint(lane))
}

/// The fingerprint after a character was thrown onto its ground, each lane differently, and swayed for so many seconds.
pub fn thrown<R: Real>(name: &str, seconds: f64) -> u64 {
    let (model, world) = (preset(name).unwrap(), world_of(name));
    let mut sim = new::<R>(&model);
    for lane in 0..R::LANES {
        start(&mut sim, lane, lane);
    }
    for k in 0..(seconds * model.step_rate) as usize {
        sway(&mut sim, k);
        step(&mut sim, &world);
    }
    all_lanes(&sim)
}

/// The fingerprint after `control` was played on the skater on ice.
pub fn played<R: Real>(control: &ReconstructedControl) -> u64 {
    let model = skater();
    let mut sim = new::<R>(&model);
    let mut player = ControlPlayer::new(control, &model).unwrap();
    player.restart(&mut sim);
    while !player.is_finished() {
        player.drive(&mut sim);
        step(&mut sim, &World::ice());
    }
    all_lanes(&sim)
}
