//! Contract: a recorded clip is the motion that was simulated.
//!
//! Poses on a step are those of the step, bit for bit, in the lane that was asked for and after a file's round trip; poses
//! between steps lie between their neighbours; and what cannot be kept is refused before anything is simulated. Clips that
//! are a step off, or come from another lane, would look right and make every figure drawn from them wrong.

use bevy_athlete::asset::clip::{ClipError, MAX_POSES, MotionClip};
use bevy_athlete::contact::World;
use bevy_athlete::control::MotionRecorder;
use bevy_athlete::math::{F64x4, Real};
use bevy_athlete::model::{SharedModel, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::{DQuat, DVec3};

/// Thrown up from 2 m, turning, each lane sideways at a speed of its own; nothing is touched.
fn thrown<R: Real>(model: &SharedModel) -> Simulator<R> {
    let mut sim = Simulator::<R>::new(model.clone(), SimulationSettings::of(model));
    let joints = vec![DQuat::IDENTITY; model.links.len()];
    let still = vec![DVec3::ZERO; model.links.len()];
    for lane in 0..R::LANES {
        sim.state.set_pose(lane, DVec3::Y * 2.0, DQuat::IDENTITY, &joints);
        sim.state.set_velocity(lane, DVec3::new(1.0 + lane as f64, 3.0, 0.0), DVec3::new(0.3, 0.7, 0.1), &still);
    }
    sim.state_changed();
    sim
}

/// The poses of every step as (root, first joint), and the clip.
fn record<R: Real>(model: &SharedModel, lane: usize, rate: f64, steps: usize) -> (Vec<(DVec3, DQuat)>, MotionClip) {
    let mut sim = thrown::<R>(model);
    let mut recorder = MotionRecorder::new(lane, rate, steps as f64 / model.step_rate).unwrap();
    let mut seen = Vec::new();
    for k in 0..=steps {
        if k > 0 {
            step(&mut sim, &World::empty());
        }
        recorder.look(&sim);
        seen.push((sim.state.root_position.lane(lane), sim.state.joints[1].rotation.lane(lane)));
    }
    (seen, recorder.into_clip("thrown", model).unwrap())
}

#[test]
fn poses_on_steps_have_the_bits_of_the_steps() {
    let model = preset("skater").unwrap();
    for lane in [0, 2] {
        let (seen, clip) = record::<F64x4>(&model, lane, 30.0, 600);
        assert_eq!((clip.poses.len(), clip.frame_rate, clip.joints.len()), (16, 30.0, model.links.len() - 1));
        let read = MotionClip::from_ron(&clip.to_ron().unwrap()).unwrap();
        for (k, (pose, read)) in clip.poses.iter().zip(&read.poses).enumerate() {
            assert_eq!((pose.root_position, pose.joints[0]), seen[40 * k], "lane {lane}, pose {k}");
            assert_eq!(pose, read, "lane {lane}, pose {k} after a file");
        }
        let travelled = clip.poses[15].root_position.x;
        println!("lane {lane}: 16 poses bit-equal to steps 0, 40 ... 600; {travelled:.3} m sideways");
        assert!(travelled > 0.45 * (1.0 + lane as f64));
    }
    let clip = record::<f64>(&model, 0, 1.0, 30).1;
    assert_eq!(clip.poses.len(), 1);
}

/// 2000 steps a second hold no 30th of a second: the pose is mixed from both neighbours.
#[test]
fn poses_between_steps_lie_between_them() {
    let model = preset("runner").unwrap();
    let (seen, clip) = record::<f64>(&model, 0, 30.0, 1000);
    assert_eq!(clip.poses.len(), 16);
    let mut worst: f64 = 0.0;
    for (k, pose) in clip.poses.iter().enumerate() {
        let at = k as f64 * model.step_rate / 30.0;
        let step = (at as usize).min(999);
        let ((p, q), (next_p, next_q)) = (seen[step], seen[step + 1]);
        worst = worst.max(pose.root_position.distance(p.lerp(next_p, at - step as f64)));
        let apart = pose.joints[0].conjugate() * q.slerp(next_q, at - step as f64);
        worst = worst.max(2.0 * apart.xyz().length());
    }
    println!("largest distance from the mix of the neighbouring steps {worst:.1e} m or rad, allowed 1e-9");
    assert!(worst < 1e-9);
    // More poses than steps: several between two steps.
    let clip = record::<f64>(&preset("skater").unwrap(), 0, 1000.0, 120).1;
    assert_eq!(clip.poses.len(), 101);
    assert!(clip.poses.windows(2).all(|w| w[1].root_position.x > w[0].root_position.x));
}

#[test]
fn what_cannot_be_kept_is_refused() {
    for rate in [0.0, -30.0, f64::NAN, f64::INFINITY, 1001.0] {
        let refused = MotionRecorder::new(0, rate, 1.0).unwrap_err();
        assert!(matches!(refused, ClipError::Option { option: "rate", .. }), "{refused}");
        assert!(refused.to_string().contains("1 to 1000"), "{refused}");
    }
    let refused = MotionRecorder::new(0, 1000.0, 3600.0).unwrap_err();
    assert!(matches!(refused, ClipError::TooLarge { what: "poses", limit: MAX_POSES, .. }), "{refused}");

    let model = preset("skater").unwrap();
    let unseen = MotionRecorder::new(0, 30.0, 1.0).unwrap().into_clip("unseen", &model).unwrap_err();
    assert!(matches!(unseen, ClipError::NoPoses { .. }), "{unseen}");
    let mut sim = thrown::<f64>(&model);
    sim.state.root_position.x = f64::NAN;
    let mut recorder = MotionRecorder::new(0, 30.0, 1.0).unwrap();
    recorder.look(&sim);
    let bad = recorder.into_clip("bad", &model).unwrap_err();
    assert!(matches!(bad, ClipError::Value { pose: 0, .. }), "{bad}");
}
