//! What a policy is shown of a course is the course that its own lane stands on, and the parameters are those that it was built from: a
//! mix-up of lanes would teach a vault over the neighbour's box. And what is learnt on courses whose solids move is the same for any number of
//! threads.

use bevy_athlete::asset::Course;
use bevy_athlete::asset::clip::{MotionClip, Pose};
use bevy_athlete::control::terms::ObservationTerm;
use bevy_athlete::math::{F32x8, Real};
use bevy_athlete::model::{ContactPoint, ModelPose, PRESET_NAMES, SharedModel, preset};
use bevy_athlete::skill::{SkillDefinition, SkillParameter, SkillWarp, WarpDirection};
use bevy_athlete::train::ppo::{Environment, SkillTask, StartSampler, TrainOptions, Trainer};
use std::sync::Arc;

const BOX: &str = r#"(
    name: "box",
    parameters: [(name: "height", range: (0.1, 0.6)), (name: "distance", range: (0.0, 9.0), default: 1.0)],
    ground: (friction: 0.8),
    solids: [Box(ahead: "distance", depth: 0.4, width: 2.0, height: "height")],
)"#;

fn standing(model: &SharedModel) -> MotionClip {
    let joints: Vec<String> = model.links.iter().skip(1).map(|l| l.name.clone()).collect();
    let pose = Pose {
        root_position: glam::DVec3::Y * model.rest_root_height(),
        root_rotation: glam::DQuat::IDENTITY,
        joints: vec![glam::DQuat::IDENTITY; joints.len()],
    };
    MotionClip { name: "standing".into(), frame_rate: 30.0, joints, poses: vec![pose; 31] }
}

fn skill(character: &str) -> SkillDefinition {
    let mut skill = SkillDefinition::imitate_alone("stand", character, "stand.clip.ron", "ground");
    skill.parameters = vec![SkillParameter { name: "height".into(), range: (0.2, 0.5) }];
    skill.observe = vec![ObservationTerm::Parameters, ObservationTerm::HeightScan { distances: vec![0.5, 1.2, 2.0] }];
    (skill.episode.joint_noise, skill.episode.velocity_noise, skill.episode.joint_velocity_noise) = (0.0, 0.0, 0.0);
    skill
}

#[test]
fn every_lane_sees_its_own_box() {
    for name in PRESET_NAMES {
        let model = preset(name).unwrap();
        let task = SkillTask::new(&skill(name), model.clone(), &standing(&model)).unwrap();
        let task = Arc::new(task.on_course(Course::parse("box.course.ron", BOX.as_bytes()).unwrap()).unwrap());
        let starts = StartSampler::uniform(task.motion.last(), false);
        let mut env = Environment::<F32x8>::new(task.clone(), 7, 1, &starts);
        let size = task.layout.size();
        let mut rows = vec![0.0_f32; F32x8::LANES * size];
        let nothing = vec![0.0; F32x8::LANES * task.action_size()];
        let mut heights = Vec::new();
        for _ in 0..3 {
            env.observe(&mut rows);
            for row in rows.chunks_exact(size) {
                let [parameter, near, on, behind] = row[size - 4..] else { unreachable!() };
                let height = 0.35 + 0.15 * parameter;
                heights.push(height);
                let apart = [near, on - height, behind].map(f32::abs);
                assert!(apart.iter().all(|e| *e < 1e-4), "{name}: {near} {on} {behind} of a box of {height}");
            }
            env.tick(&nothing);
            (0..F32x8::LANES).for_each(|lane| env.reset(lane, &starts));
        }
        let (low, high) = heights.iter().fold((1.0_f32, 0.0_f32), |(a, b), h| (a.min(*h), b.max(*h)));
        assert!(low < 0.3 && high > 0.4, "{name}: drawn from {low} to {high}");
    }
}

/// The same box, under the place where the motion stands.
const UNDER: &str = r#"(
    name: "block",
    parameters: [(name: "height", range: (0.1, 0.6))],
    ground: (friction: 0.8),
    solids: [Box(ahead: -1, depth: 2, width: 2, height: "height")],
)"#;

#[test]
fn a_disturbed_start_stands_on_the_step_of_its_own_lane() {
    let model = preset("runner").unwrap();
    let mut clip = standing(&model);
    clip.poses.iter_mut().for_each(|pose| pose.root_position.y += 0.35);
    let mut skill = skill("runner");
    let warp = SkillWarp {
        parameter: "height".into(),
        neutral: 0.35,
        direction: WarpDirection::Up,
        profile: vec![(0.0, 1.0)],
    };
    (skill.warps, skill.episode.joint_noise) = (vec![warp], 0.1);
    let task = SkillTask::new(&skill, model.clone(), &clip).unwrap();
    let task = Arc::new(task.on_course(Course::parse("block.course.ron", UNDER.as_bytes()).unwrap()).unwrap());
    let starts = StartSampler::uniform(task.motion.last(), false);
    let mut env = Environment::<F32x8>::new(task.clone(), 11, 1, &starts);
    let size = task.layout.size();
    let mut rows = vec![0.0_f32; F32x8::LANES * size];
    let (mut places, mut apart) = (Vec::new(), 0.0_f64);
    env.observe(&mut rows);
    for (lane, row) in rows.chunks_exact(size).enumerate() {
        let height = 0.35 + 0.15 * f64::from(row[size - 4]);
        let state = &env.sim.state;
        let pose = ModelPose {
            root_position: state.root_position.lane(lane),
            root_rotation: state.root_rotation.lane(lane),
            joints: state.joints.iter().map(|joint| joint.rotation.lane(lane)).collect(),
        };
        pose.link_transforms(&model, &mut places);
        let bottom = |p: &ContactPoint| (places[p.link].position + places[p.link].rotation * p.position).y - p.radius;
        let lowest = model.contact_points.iter().map(bottom).fold(f64::INFINITY, f64::min);
        assert!((lowest - height).abs() < 1e-3, "lane {lane}: the lowest point is at {lowest} on a box of {height}");
        apart = apart.max((height - 0.35).abs());
    }
    assert!(apart > 0.05, "boxes as high as the motion's own prove nothing: {apart}");
}

#[test]
fn parameters_that_cannot_be_are_refused_by_their_place() {
    let model = preset("runner").unwrap();
    let refused = |change: &dyn Fn(&mut SkillDefinition), words: &[&str]| {
        let mut skill = skill("runner");
        change(&mut skill);
        let course = Course::parse("box.course.ron", BOX.as_bytes()).unwrap();
        let made = SkillTask::new(&skill, model.clone(), &standing(&model)).and_then(|task| task.on_course(course));
        let message = made.expect_err("refused").to_string();
        assert!(words.iter().all(|w| message.contains(w)), "{message}");
    };
    refused(&|s| s.parameters[0].range = (0.5, 0.2), &["parameters", "height from 0.5 to 0.2"]);
    refused(&|s| s.parameters[0].range = (0.2, 3.0), &["height", "3"]);
    refused(&|s| s.parameters.push(s.parameters[0].clone()), &["parameters", "`height`"]);
    refused(&|s| s.observe.push(ObservationTerm::Phase), &["observe", "phase"]);
    let text = r#"(name: "x", character: "runner", motion: "m.clip.ron",
        warps: [(parameter: "width", neutral: 0.5, direction: Up, profile: [(0, 0)])])"#;
    let message = SkillDefinition::from_ron(text, "x.skill.ron").unwrap_err().to_string();
    assert!(message.contains("warps") && message.contains("`width`"), "{message}");
}

/// A box that comes and goes in front of the feet, and one that lies on the way of the arms: what is learnt depends on both.
const MOVING: &str = r#"(
    name: "moving",
    parameters: [(name: "height", range: (0.1, 0.6)), (name: "speed", range: (0.2, 0.6))],
    ground: (friction: 0.8),
    solids: [
        Box(ahead: 0.3, depth: 0.4, width: 2.0, height: "height", motion: Cross(by: (0, 0, -0.4), speed: "speed")),
        Box(ahead: -0.3, depth: 0.6, width: 0.6, height: 0.05, motion: Sway(along: (1, 0, 0), amplitude: 0.2, frequency: 1)),
    ],
)"#;

#[test]
fn one_and_two_threads_learn_the_same_on_courses_that_move() {
    let model = preset("runner").unwrap();
    let learn = |threads: usize, course: &str| {
        let mut skill = skill("runner");
        (skill.training_rate, skill.episode.seconds) = (Some(240.0), 0.5);
        let task = SkillTask::new(&skill, model.clone(), &standing(&model)).unwrap();
        let task = task.on_course(Course::parse("moving.course.ron", course.as_bytes()).unwrap()).unwrap();
        let options = TrainOptions {
            threads,
            env_batches: 2,
            ticks: 24,
            minibatch: 512,
            hidden: vec![24, 16],
            evaluation_trials: 16,
            evaluate_every: 2,
            ..TrainOptions::default()
        };
        let mut trainer = Trainer::new(task, options).unwrap();
        (0..2).for_each(|_| _ = trainer.iterate());
        let present = trainer.present();
        (present.actor.parameters().to_vec(), present.normalizer.clone(), trainer.best().unwrap().evaluation)
    };
    let (one, two) = (learn(1, MOVING), learn(2, MOVING));
    assert!(one == two, "the number of threads shows");
    // It is the course that was learnt on: with boxes at rest something else is.
    let at_rest = MOVING.replace(r#"speed: "speed")"#, r#"speed: 0.001)"#);
    assert!(at_rest != MOVING && learn(1, &at_rest).0 != one.0, "the boxes do not matter");
}
