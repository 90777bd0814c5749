//! Contract: same input, same bits.
//!
//! In debug and in release (`tests/determinism.rs` is this module alone), in any lane of a wide type, from a restored
//! snapshot, on one thread and on two, and in a replay of a reconstructed control. Everything that is recorded, replayed,
//! trained or sent over a network rests on it. That a portable build and WASM give the same bits too is shown by
//! `scripts/wasm_bits.sh`, on the same scenes.
//!
//! The fingerprints below are goldens: a change of the arithmetic changes them. That is allowed, if meant; print the new
//! ones with `--nocapture` in both profiles, see that they agree, and write them here.

use crate::golden::*;
use bevy_athlete::math::{F32x8, F64x4};
use bevy_athlete::model::{PRESET_NAMES, preset};
use bevy_athlete::sim::{Simulator, step};

const SKATER_ON_ICE: u64 = 0x3130_3bf9_745f_6665;
const FOOT_HUMAN_ON_GROUND: u64 = 0xccd0_0f6e_99a0_aac2;

#[test]
fn fingerprints_of_two_runs() {
    let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
    let skater = thrown::<f64>("skater", 2.0);
    println!("{profile}: skater on ice, 2 s: {skater:#018x}");
    let human = thrown::<f64>("foot_human", 1.0);
    println!("{profile}: foot human on ground, 1 s: {human:#018x}");
    assert_eq!(skater, SKATER_ON_ICE);
    assert_eq!(human, FOOT_HUMAN_ON_GROUND);
}

/// A snapshot is the state alone: a new simulator that gets it goes on like the old one, and so does the old one itself; lane by
/// lane as well.
#[test]
fn a_restored_snapshot_goes_on_the_same() {
    for name in PRESET_NAMES {
        let (model, world) = (preset(name).unwrap(), world_of(name));
        let mut sim = new::<f64>(&model);
        start(&mut sim, 0, 1);
        let advance = |sim: &mut Simulator<f64>, from: usize| {
            for k in from..from + 600 {
                sway(sim, k);
                step(sim, &world);
            }
            sim.state.fingerprint(0)
        };
        advance(&mut sim, 0);
        let snapshot = sim.state.clone();
        let first = advance(&mut sim, 600);
        sim.state = snapshot.clone();
        sim.state_changed();
        let again = advance(&mut sim, 600);
        let lane = snapshot.lane(&model, 0);
        let [elsewhere, by_lane] = [snapshot, lane].map(|state| {
            let mut other = new::<f64>(&model);
            other.state = state;
            other.state_changed();
            advance(&mut other, 600)
        });
        println!(
            "{name}: 600 steps from a snapshot: {first:#x}, again {again:#x}, elsewhere {elsewhere:#x}, by lane {by_lane:#x}"
        );
        assert!(first == again && first == elsewhere && first == by_lane);
    }
}

/// Every lane of 8 x f32 has the bits of scalar f32, and stays near f64 as long as nothing chaotic happens.
#[test]
fn single_precision_is_near() {
    let (position_bound, joint_bound) = (2e-5, 5e-4);
    for (name, seconds) in [("skater", 1.0), ("foot_human", 0.5)] {
        let (model, world) = (preset(name).unwrap(), world_of(name));
        let (mut single, mut exact) = (new::<F32x8>(&model), new::<f64>(&model));
        let mut one = new::<f32>(&model);
        let (mut position, mut joint) = (0.0_f64, 0.0_f64);
        for k in 0..(seconds * model.step_rate) as usize {
            sway(&mut single, k);
            sway(&mut exact, k);
            sway(&mut one, k);
            step(&mut single, &world);
            step(&mut exact, &world);
            step(&mut one, &world);
            position = position.max(single.state.root_position.lane(5).distance(exact.state.root_position.lane(0)));
            for (a, b) in single.state.joints.iter().zip(&exact.state.joints).skip(1) {
                let d = a.rotation.lane(5).conjugate() * b.rotation.lane(0);
                joint = joint.max(2.0 * d.xyz().length());
            }
        }
        assert_eq!(single.state.fingerprint(5), one.state.fingerprint(0));
        println!(
            "{name}, {seconds} s standing and swaying, 8 x f32 against f64: root {position:.1e} m (bound {position_bound:.0e}), \
             joints {joint:.1e} rad (bound {joint_bound:.0e}); bit-equal to scalar f32"
        );
        assert!(position < position_bound && joint < joint_bound);
    }
}

mod search {
    use super::*;
    use crate::common::pose;
    use bevy_athlete::asset::clip::{MotionClip, Pose};
    use bevy_athlete::contact::World;
    use bevy_athlete::control::ControlPlayer;
    use bevy_athlete::math::Real;
    use bevy_athlete::model::skater;
    use bevy_athlete::train::{ReconstructOptions, Reconstruction, reconstruct};
    use glam::{DQuat, DVec3};

    /// Four tenths of a second: arms up while gliding.
    fn clip() -> MotionClip {
        let model = skater();
        let names: Vec<String> = model.links.iter().skip(1).map(|l| l.name.clone()).collect();
        let arms = pose(&model, &[("bicep_left", [0.0, 0.0, -60.0]), ("bicep_right", [0.0, 0.0, 60.0])]);
        let poses = (0..=4)
            .map(|k| Pose {
                root_position: DVec3::new(0.0, model.rest_root_height(), -0.1 * k as f64),
                root_rotation: DQuat::IDENTITY,
                joints: arms.iter().skip(1).map(|q| DQuat::IDENTITY.slerp(*q, k as f64 / 4.0)).collect(),
            })
            .collect();
        MotionClip { name: "arms".into(), frame_rate: 10.0, joints: names, poses }
    }

    fn search(threads: usize) -> Reconstruction {
        let options = ReconstructOptions { samples: 48, keep: 6, threads, ..Default::default() };
        reconstruct(&skater(), &World::ice(), "ice", &clip(), &options, |_| true).unwrap()
    }

    #[test]
    fn one_and_two_threads_find_the_same_and_it_replays() {
        let (one, two) = (search(1), search(2));
        assert_eq!(one.control, two.control);
        assert_eq!(one.end_fingerprint, two.end_fingerprint);

        // Played by a scalar, and by lane 2 of a wide simulator whose other lanes do the same.
        fn replay<R: Real>(found: &Reconstruction, lane: usize) -> u64 {
            let model = skater();
            let mut sim = new::<R>(&model);
            let mut player = ControlPlayer::new(&found.control, &model).unwrap();
            player.restart(&mut sim);
            while !player.is_finished() {
                player.drive(&mut sim);
                step(&mut sim, &World::ice());
            }
            sim.state.fingerprint(lane)
        }
        let (scalar, wide) = (replay::<f64>(&one, 0), replay::<F64x4>(&one, 2));
        println!(
            "1 and 2 threads: equal controls; the search ended in {:#x}, scalar replay in {scalar:#x}, lane 2 in {wide:#x}",
            one.end_fingerprint
        );
        assert!(scalar == one.end_fingerprint && wide == one.end_fingerprint);

        // Through a file and back.
        let path = std::env::temp_dir().join(format!("athlete-determinism-{}.control.ron", std::process::id()));
        one.control.save(&path).unwrap();
        let loaded = bevy_athlete::control::ReconstructedControl::load(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(replay::<f64>(&Reconstruction { control: loaded, ..one.clone() }, 0), scalar);
    }
}
