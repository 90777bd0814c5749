//! From a trained policy to a file, and from a file back to trials.

use crate::asset::dense_layers::{Activation as LayerActivation, DenseLayer, DenseLayers};
use crate::asset::policy_contract::{
    ActionLayout, ActionMeaning, CONTRACT_VERSION, GoldenPair, Normaliser, PolicyContract, ReferenceFile,
};
use crate::asset::policy_fit::fingerprint_text;
use crate::control::Policy;
use crate::skill::SkillDefinition;
use crate::train::export_onnx::{ExportError, policy_bytes};
use crate::train::nn::{Activation, Activations, Network};
use crate::train::ppo::evaluate::Actor;
use crate::train::ppo::task::SkillTask;
use crate::train::ppo::trainer::{Trained, Trainer};

/// The layers of a network, for export.
impl From<&Network> for DenseLayers {
    fn from(network: &Network) -> Self {
        let layer = |k| DenseLayer { weights: network.weights(k).to_vec(), bias: network.bias(k).to_vec() };
        Self {
            sizes: network.sizes().to_vec(),
            activation: match network.activation() {
                Activation::Tanh => LayerActivation::Tanh,
                Activation::Elu => LayerActivation::Elu,
            },
            layers: (0..network.layers()).map(layer).collect(),
        }
    }
}

/// Layers and contract of a trained policy, for [`save_policy`](crate::train::save_policy). `motion_file` is the name of the clip
/// that will lie beside it. Parameters are rounded to half precision, 11 bits: a hundredth of the exploration that they were learnt
/// under, and half the download.
pub fn trained_policy(task: &SkillTask, trained: &Trained, motion_file: &str) -> (DenseLayers, PolicyContract) {
    let normalizer = &trained.normalizer;
    // An observation with something to see: two deviations to either side, turn about.
    let golden: Vec<f32> = (normalizer.shift.iter().zip(&normalizer.scale).enumerate())
        .map(|(k, (shift, scale))| shift + (if k % 2 == 0 { 2.0 } else { -2.0 }) / scale)
        .collect();
    let mut seen = golden.clone();
    normalizer.apply(&mut seen);
    let mut actor = trained.actor.clone();
    for parameter in actor.parameters_mut() {
        let rounded = half::f16::from_f32(*parameter).to_f32();
        *parameter = if rounded.is_finite() { rounded } else { *parameter };
    }
    let action = actor.forward(&mut Activations::default(), &seen, 1).to_vec();
    // Paths are those of the machine that trained: motion and course are beside the policy, what came before is of no use any more.
    let course = task.skill.course.as_ref().map(|_| course_file(&task.skill.name).into());
    let settings = SkillDefinition { motion: motion_file.into(), course, after: Vec::new(), ..task.skill.clone() };
    let contract = PolicyContract {
        version: CONTRACT_VERSION,
        crate_version: env!("CARGO_PKG_VERSION").into(),
        character: task.model.name.clone(),
        character_fingerprint: Some(fingerprint_text(task.model.fingerprint())),
        skill: task.skill.name.clone(),
        skill_settings: serde_json::to_string(&settings).unwrap_or_default(),
        control_rate: task.skill.control_rate,
        simulation_rate: task.settings.rate,
        observation: task.layout.blocks.clone(),
        normaliser: Normaliser {
            mean: normalizer.shift.clone(),
            scale: normalizer.scale.clone(),
            clip: normalizer.clip,
        },
        action: ActionLayout {
            meaning: ActionMeaning::ReferenceOffset,
            scale: task.skill.action_scale,
            links: task.model.links.iter().skip(1).map(|l| l.name.clone()).collect(),
            gains: task.skill.gain_action.clone(),
        },
        reference: ReferenceFile { file: motion_file.into(), fingerprint: None, cyclic: task.skill.cyclic },
        gains: task.skill.gains,
        golden: GoldenPair { observation: golden, action },
    };
    (DenseLayers::from(&actor), contract)
}

impl Trainer {
    /// The file of the policy as it is now, in memory, read back and checked as [`save_policy`](crate::train::save_policy) does.
    /// `motion_file` is the name of the clip that will lie beside it. Before the first iteration it tells whether what will be learnt
    /// can be written: layers, layout and contract do not change.
    pub fn policy_file(&self, motion_file: &str) -> Result<Vec<u8>, ExportError> {
        let (layers, contract) = trained_policy(self.task(), &self.present(), motion_file);
        let bytes = policy_bytes(&layers, &contract)?;
        Policy::from_bytes(&bytes, &self.task().skill.name)?;
        Ok(bytes)
    }
}

/// Name of the course that lies beside the policy of a skill.
pub fn course_file(skill: &str) -> String {
    format!("{skill}.course.ron")
}

/// A policy read from its file acts as in a game: raw observations through tract. Rows that it refuses get no action.
impl Actor for Policy {
    type Scratch = Vec<f32>;
    fn act<'a>(&'a self, scratch: &'a mut Vec<f32>, observations: &'a mut [f32], rows: usize) -> &'a [f32] {
        scratch.clear();
        if Policy::act(self, observations, rows, scratch).is_err() {
            scratch.clear();
            scratch.resize(rows * self.contract().action_size(), 0.0);
        }
        // A lane that has gone bad sees NaN and is told nothing.
        scratch.iter_mut().filter(|a| !a.is_finite()).for_each(|a| *a = 0.0);
        scratch
    }
}
