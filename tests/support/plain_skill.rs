//! A skill that needs no training: a body that stands, and a policy that says nothing. What it is shown can be looked at.
#![allow(dead_code, reason = "each test file uses its part")]

use bevy_athlete::asset::clip::{MotionClip, Pose};
use bevy_athlete::asset::dense_layers::{Activation, DenseLayer, DenseLayers};
use bevy_athlete::asset::policy_contract::{
    ActionLayout, ActionMeaning, CONTRACT_VERSION, GoldenPair, Normaliser, PolicyContract, ReferenceFile,
};
use bevy_athlete::control::Policy;
use bevy_athlete::control::terms::ObservationTerm;
use bevy_athlete::model::CharacterModel;
use bevy_athlete::skill::{SkillDefinition, SkillParameter, SkillWarp, TrainedSkill, WarpDirection};
use bevy_athlete::train::policy_bytes;
use glam::{DQuat, DVec3};

/// How far ahead [`jump_over`] looks, m.
pub const AHEAD: [f64; 3] = [0.5, 1.2, 2.0];

/// The zero pose for a second.
pub fn standing(model: &CharacterModel) -> MotionClip {
    let joints: Vec<String> = model.links.iter().skip(1).map(|l| l.name.clone()).collect();
    let pose = Pose {
        root_position: DVec3::Y * model.rest_root_height(),
        root_rotation: DQuat::IDENTITY,
        joints: vec![DQuat::IDENTITY; joints.len()],
    };
    MotionClip { name: "standing".into(), frame_rate: 30.0, joints, poses: vec![pose; 31] }
}

/// A standing that is warped as if it went over something: `height` (0.4 to 0.6 m, 0.5 in the motion as it is) lifts it from 0.3 s
/// on, `distance` (1 to 5 m, 2 in the motion) moves it ahead, and `mood` (0 to 1) does nothing. Its policy sees all three, and the
/// heights ahead.
pub fn jump_over(model: &CharacterModel) -> SkillDefinition {
    let mut skill = SkillDefinition::imitate_alone("jump_over", &model.name, "standing.clip.ron", "ground");
    let parameter = |name: &str, range| SkillParameter { name: name.into(), range };
    skill.parameters =
        vec![parameter("height", (0.4, 0.6)), parameter("distance", (1.0, 5.0)), parameter("mood", (0.0, 1.0))];
    let warp = |parameter: &str, neutral, direction, profile: &[(f64, f64)]| SkillWarp {
        parameter: parameter.into(),
        neutral,
        direction,
        profile: profile.to_vec(),
    };
    skill.warps = vec![
        warp("height", 0.5, WarpDirection::Up, &[(0.1, 0.0), (0.3, 1.0)]),
        warp("distance", 2.0, WarpDirection::Ahead, &[(0.0, 0.0), (0.2, 1.0)]),
    ];
    skill.observe = vec![ObservationTerm::Parameters, ObservationTerm::HeightScan { distances: AHEAD.to_vec() }];
    skill
}

/// A policy for a skill of a body that leaves the reference as it is.
pub fn silent_policy(skill: &SkillDefinition, model: &CharacterModel) -> Policy {
    let played = skill.policy_use(model);
    let (inputs, outputs) = (played.observation.iter().map(|b| b.size).sum(), 3 * played.links.len());
    let layer = |from: usize, to: usize| DenseLayer { weights: vec![0.0; from * to], bias: vec![0.0; to] };
    let layers = DenseLayers {
        sizes: vec![inputs, 4, outputs],
        activation: Activation::Relu,
        layers: vec![layer(inputs, 4), layer(4, outputs)],
    };
    let contract = PolicyContract {
        version: CONTRACT_VERSION,
        crate_version: "bevy_athlete test".into(),
        character: model.name.clone(),
        character_fingerprint: None,
        skill: skill.name.clone(),
        skill_settings: String::new(),
        control_rate: played.control_rate,
        simulation_rate: skill.simulation_rate(model),
        observation: played.observation,
        normaliser: Normaliser { mean: vec![0.0; inputs], scale: vec![1.0; inputs], clip: 10.0 },
        action: ActionLayout {
            meaning: ActionMeaning::ReferenceOffset,
            scale: played.action_scale,
            links: played.links,
            gains: played.gain_action,
        },
        reference: ReferenceFile { file: "standing.clip.ron".into(), fingerprint: None, cyclic: played.cyclic },
        gains: played.gains,
        golden: GoldenPair { observation: vec![0.5; inputs], action: vec![0.0; outputs] },
    };
    let bytes = policy_bytes(&layers, &contract).expect("a policy");
    Policy::from_bytes(&bytes, "silent.onnx").expect("a policy")
}

/// A skill with that policy, made for the body.
pub fn silent(skill: SkillDefinition, model: &CharacterModel) -> TrainedSkill {
    let policy = silent_policy(&skill, model);
    TrainedSkill::new(skill, &standing(model), policy, model).expect("a skill")
}

/// What a policy of [`jump_over`] sees of the parameters, and of the heights ahead.
pub fn seen(observation: &[f32]) -> ([f32; 3], [f32; 3]) {
    let [a, b, c, x, y, z] = observation[observation.len() - 6..] else { panic!("it has seen nothing") };
    ([a, b, c], [x, y, z])
}
