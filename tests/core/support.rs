//! Heights and velocities count from what carries the body: a motion that was learnt on level ground at rest sees and does the same on a
//! raised floor and on one that moves. A policy would not know what to do with what it never saw.

use bevy_athlete::contact::{Geometry, Solid, Surface, World};
use bevy_athlete::control::terms::{ObservationLayout, ObservationTerm, PolicyMirror};
use bevy_athlete::control::tracking::{Heading, TrackedMotion, Tracker, TrackerOptions};
use bevy_athlete::model::{PRESET_NAMES, SharedModel, preset};
use bevy_athlete::sim::{SimulationSettings, Simulator, step};
use glam::DVec3;
use std::sync::Arc;

/// A floor at a height that slides along at a velocity.
fn floor(height: f64, velocity: DVec3) -> World {
    let plane = Geometry::Plane { point: DVec3::Y * height, normal: DVec3::Y };
    let solid = Solid { linear_velocity: velocity, ..Solid::fixed(plane, Surface::GROUND) };
    World { solids: vec![solid] }
}

/// A motion in which the body stands with bent knees and sways.
fn motion(model: &SharedModel) -> Arc<TrackedMotion> {
    use bevy_athlete::asset::clip::{MotionClip, Pose};
    let joints: Vec<String> = model.links.iter().skip(1).map(|l| l.name.clone()).collect();
    let poses = (0..60).map(|k| {
        let phase = f64::from(k) / 10.0;
        Pose {
            root_position: DVec3::new(0.0, model.rest_root_height(), 0.0),
            root_rotation: glam::DQuat::IDENTITY,
            joints: joints.iter().map(|_| glam::DQuat::from_rotation_x(0.04 * phase.sin())).collect(),
        }
    });
    let clip = MotionClip { name: "sway".into(), frame_rate: 30.0, joints: joints.clone(), poses: poses.collect() };
    Arc::new(TrackedMotion::once(&clip, model, 30.0, 1.0).unwrap())
}

/// What is seen at each of twenty decisions of the motion on such a floor.
fn seen_on(model: &SharedModel, height: f64, velocity: DVec3) -> Vec<Vec<f64>> {
    let motion = motion(model);
    let more = [
        ObservationTerm::FootPlaces,
        ObservationTerm::FootForces,
        ObservationTerm::HeightScan { distances: vec![0.3, 1.0] },
    ];
    let layout = Arc::new(ObservationLayout::new(model, &more, 0));
    let settings = SimulationSettings { rate: 1200.0, ..SimulationSettings::of(model) };
    let mut sim = Simulator::<f64>::new(model.clone(), settings);
    let mut tracker =
        Tracker::new(motion, TrackerOptions { max_reference_drift: Some(0.3), ..Default::default() }, layout);
    tracker.begin_at(&mut sim, 0, 0, 0.0, Heading::ahead(), DVec3::Y * height);
    let linear = sim.state.root_velocity.linear.lane(0) + velocity;
    sim.state.root_velocity.linear.set_lane(0, linear);
    sim.state_changed();
    tracker.set_support(0, height, velocity);
    let world = floor(height, velocity);
    (0..20)
        .map(|_| {
            tracker.act(|_| bevy_athlete::math::Vec3::zero());
            for part in 1..=4 {
                tracker.command(&mut sim, f64::from(part) / 4.0);
                (0..10).for_each(|_| step(&mut sim, &world));
            }
            tracker.sense(&mut sim, &world);
            tracker.advance(&sim);
            let mut row = Vec::new();
            tracker.observe(&mut sim, &mut row);
            row
        })
        .collect()
}

fn farthest(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_raised_floor_is_seen_as_the_level_one() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let (level, raised) = (seen_on(&model, 0.0, DVec3::ZERO), seen_on(&model, 0.5, DVec3::ZERO));
        let apart = farthest(&level, &raised);
        // Rounding at another height: the rates of toes of 20 g show it most.
        assert!(apart < 1e-5, "{name}: {apart}");
    }
}

#[test]
fn a_moving_floor_is_seen_as_one_at_rest() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let (rest, moving) = (seen_on(&model, 0.0, DVec3::ZERO), seen_on(&model, 0.0, DVec3::new(0.6, 0.0, -0.8)));
        let apart = farthest(&rest, &moving);
        assert!(apart < 1e-6, "{name}: {apart}");
    }
}

#[test]
fn the_layout_has_no_empty_block_and_its_mirror_image_is_its_own_inverse() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let more = [
            ObservationTerm::FootPlaces,
            ObservationTerm::FootForces,
            ObservationTerm::Parameters,
            ObservationTerm::HeightScan { distances: vec![0.5, 1.0, 2.0] },
        ];
        let layout = ObservationLayout::new(&model, &more, 2);
        assert!(layout.blocks.iter().all(|b| b.size > 0), "{name}");
        let mirror = PolicyMirror::new(&model, &layout);
        let seen: Vec<f64> = (0..layout.size()).map(|k| 0.25 + k as f64).collect();
        let (mut once, mut twice) = (Vec::new(), Vec::new());
        mirror.observation(&seen, &mut once);
        assert_eq!(once.len(), seen.len(), "{name}");
        let once: Vec<f64> = once.iter().map(|v| f64::from(*v)).collect();
        mirror.observation(&once, &mut twice);
        assert!(twice.iter().zip(&seen).all(|(a, b)| f64::from(*a) == *b), "{name}");
        assert!(once.iter().zip(&seen).any(|(a, b)| a != b), "{name}");
    }
}
