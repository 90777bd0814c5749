//! Trained policies: a network from an ONNX file, with the contract that says what its numbers mean.

use super::policy_error::PolicyError;
use super::policy_file::{decode, read_bytes};
use super::policy_graph::{GraphFault, Widths, check_and_clean};
use crate::asset::card::fingerprint;
use crate::asset::policy_contract::PolicyContract;
use crate::model::CharacterModel;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Mutex};
use tract_onnx::pb::ModelProto;
use tract_onnx::prelude::{
    Datum, Framework, InferenceFact, InferenceModelExt, IntoRunnable, Tensor, ToDim, TractResult, TypedSimplePlan,
    TypedSimpleState, tvec,
};

/// Largest difference between the network and its golden pair; of numbers beyond 1, relative to them.
pub const GOLDEN_TOLERANCE: f64 = 1e-5;

/// A policy ready to act.
///
/// It remembers nothing between calls: an action depends on its observation alone. Clones share the weights.
pub struct Policy {
    file: Arc<str>,
    contract: Arc<PolicyContract>,
    fingerprint: Arc<str>,
    plan: Arc<TypedSimplePlan>,
    /// Never locked: `act` has it exclusively. The mutex only makes the policy shareable, which the library's state is not.
    state: Mutex<Option<TypedSimpleState>>,
}

impl Policy {
    /// Reads a policy file and checks everything that does not depend on the character.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, PolicyError> {
        let path = path.as_ref();
        Self::from_bytes(&read_bytes(path)?, &path.display().to_string())
    }

    /// A policy from the bytes of a file, checked like [`Policy::load`]; `name` is for messages.
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Self, PolicyError> {
        let file: Arc<str> = name.into();
        let (mut model, contract) = decode(bytes, name)?;
        let widths = check_and_clean(&mut model).map_err(|fault| match fault {
            GraphFault::Place { place, reason } => PolicyError::Graph { file: name.to_owned(), place, reason },
            GraphFault::NotFinite { tensor, index, value } => {
                PolicyError::NotFinite { file: name.to_owned(), tensor, index, value }
            }
        })?;
        for (end, network, layout) in [
            ("observation", widths.observation, contract.observation_size()),
            ("action", widths.action, contract.action_size()),
        ] {
            if network != layout {
                return Err(PolicyError::Size { file: name.to_owned(), end, network, layout });
            }
        }
        // The check above leaves the library no reason to panic; should it find one, it stays a refusal.
        let plan = catch_unwind(AssertUnwindSafe(|| plan(&model, &widths)))
            .unwrap_or_else(|_| Err(tract_onnx::prelude::TractError::msg("the inference library panicked")))
            .map_err(|e| network_error(name, &e))?;
        let fingerprint = fingerprint(bytes).into();
        let mut policy = Self { file, contract: Arc::new(contract), fingerprint, plan, state: Mutex::new(None) };
        policy.check_golden()?;
        Ok(policy)
    }

    /// What the file says about itself.
    pub fn contract(&self) -> &PolicyContract {
        &self.contract
    }

    /// [`fingerprint`] of the file, as robustness cards name it.
    pub fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    /// Name of the file, as given.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Checks that the policy was made for this character.
    pub fn check_for(&self, model: &CharacterModel) -> Result<(), PolicyError> {
        let contract = &*self.contract;
        if contract.character != model.name {
            return Err(PolicyError::Character {
                file: self.file.to_string(),
                found: contract.character.clone(),
                wanted: model.name.clone(),
            });
        }
        let joints = || model.links.iter().filter(|l| l.parent.is_some()).map(|l| l.name.as_str());
        match contract.action.links.iter().find(|link| !joints().any(|j| j == *link)) {
            Some(link) => Err(PolicyError::Link {
                file: self.file.to_string(),
                link: link.clone(),
                character: model.name.clone(),
                valid: joints().collect::<Vec<_>>().join(", "),
            }),
            None => Ok(()),
        }
    }

    /// The actions for `rows` observations, one after the other in `observations`, as one row each in `out`: the network's means,
    /// before the contract's scale.
    ///
    /// A row whose observation holds a number that is not finite gets an action of NaN, which no clamp inside the network can hide; other rows
    /// are not affected. The last bits of an action depend on the processor, and on whether it was asked for alone or among others.
    pub fn act(&mut self, observations: &[f32], rows: usize, out: &mut Vec<f32>) -> Result<(), PolicyError> {
        let size = self.contract.observation_size();
        if rows.checked_mul(size) != Some(observations.len()) {
            let (file, found) = (self.file.to_string(), observations.len());
            return Err(PolicyError::Rows { file, found, rows, size });
        }
        out.clear();
        if rows == 0 {
            return Ok(());
        }
        self.run(observations, rows, out).map_err(|e| network_error(&self.file, &e))?;
        let actions = out.chunks_exact_mut(self.contract.action_size());
        for (observation, action) in observations.chunks_exact(size).zip(actions) {
            if !observation.iter().all(|v| v.is_finite()) {
                action.fill(f32::NAN);
            }
        }
        Ok(())
    }

    fn run(&mut self, observations: &[f32], rows: usize, out: &mut Vec<f32>) -> TractResult<()> {
        let slot = self.state.get_mut().unwrap_or_else(|poisoned| poisoned.into_inner());
        let state = match slot {
            Some(state) => state,
            None => slot.insert(self.plan.spawn()?),
        };
        let input = Tensor::from_shape(&[rows, observations.len() / rows], observations)?;
        let result = state.run(tvec![input.into()])?;
        out.extend_from_slice(result[0].try_as_plain_ram()?.as_slice::<f32>()?);
        Ok(())
    }

    fn check_golden(&mut self) -> Result<(), PolicyError> {
        let contract = self.contract.clone();
        let mut found = Vec::new();
        self.act(&contract.golden.observation, 1, &mut found)?;
        for (index, (found, expected)) in found.into_iter().zip(contract.golden.action.iter().copied()).enumerate() {
            let difference = (f64::from(found) - f64::from(expected)).abs();
            let tolerance = GOLDEN_TOLERANCE * f64::from(expected).abs().max(1.0);
            // Not `>`, which a NaN would pass.
            if !(difference <= tolerance) {
                let file = self.file.to_string();
                return Err(PolicyError::Golden { file, index, found, expected, difference, tolerance });
            }
        }
        Ok(())
    }
}

/// The checked model, made ready for any number of rows.
fn plan(model: &ModelProto, widths: &Widths) -> TractResult<Arc<TypedSimplePlan>> {
    let model = tract_onnx::onnx().model_for_proto_model(model)?;
    let rows = model.sym("batch").to_dim();
    let input = InferenceFact::dt_shape(f32::datum_type(), tvec![rows, widths.observation.to_dim()]);
    model.with_input_fact(0, input)?.into_optimized()?.into_runnable()
}

fn network_error(file: &str, error: &tract_onnx::prelude::TractError) -> PolicyError {
    PolicyError::Network { file: file.to_owned(), reason: format!("{error:#}").chars().take(500).collect() }
}

impl Clone for Policy {
    fn clone(&self) -> Self {
        Self {
            file: self.file.clone(),
            contract: self.contract.clone(),
            fingerprint: self.fingerprint.clone(),
            plan: self.plan.clone(),
            state: Mutex::new(None),
        }
    }
}

impl std::fmt::Debug for Policy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Policy").field("file", &self.file).field("contract", &self.contract).finish_non_exhaustive()
    }
}
