//! Trained policies: a network from an ONNX file, with the contract that says what its numbers mean.

use super::policy_affine::AffineMap;
use super::policy_error::PolicyError;
use super::policy_file::{decode, read_bytes};
use super::policy_graph::{GraphFault, Widths, check_and_clean};
use super::policy_normaliser::take_normaliser;
use crate::asset::card::fingerprint;
use crate::asset::policy_contract::{Normaliser, PolicyContract};
use crate::asset::policy_fit::PolicyUse;
use crate::math::RandomStream;
use crate::model::CharacterModel;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use tract_onnx::pb::ModelProto;
use tract_onnx::prelude::{
    Datum, Framework, InferenceFact, InferenceModelExt, IntoRunnable, Tensor, TractError, TractResult, TypedSimplePlan,
    tvec,
};

/// Largest difference between the network and its golden pair; of numbers beyond 1, relative to them.
pub const GOLDEN_TOLERANCE: f64 = 1e-5;

/// Rows that the network is made ready for, and from how many rows on it pays to fill up to so many. For a fixed number
/// of rows the library is a third faster than for a free one, and nothing has to be made ready in the middle of a game.
const BLOCKS: [(usize, usize); 3] = [(64, 48), (8, 3), (1, 1)];

/// A policy ready to act.
///
/// It remembers nothing between calls: an action depends on its observation alone. Clones share everything; threads may
/// share one.
#[derive(Clone)]
pub struct Policy {
    file: Arc<str>,
    contract: Arc<PolicyContract>,
    fingerprint: Arc<str>,
    /// One for each entry of [`BLOCKS`]; none for an affine policy.
    plans: Arc<[Arc<TypedSimplePlan>]>,
    /// One matrix and an offset, in place of the plans.
    affine: Option<Arc<AffineMap>>,
    /// The normaliser is not in the plans.
    normalises: bool,
    /// Rows of the small block have the bits of rows alone.
    rows_agree: bool,
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
        let normalises = take_normaliser(&mut model, &contract.normaliser);
        let affine = AffineMap::of(&model).map(Arc::new);
        // The check above leaves the library no reason to panic; should it find one, it stays a refusal.
        let plans = match &affine {
            Some(_) => Arc::from(Vec::new()),
            None => catch_unwind(AssertUnwindSafe(|| plans(&model, &widths)))
                .unwrap_or_else(|_| Err(TractError::msg("the inference library panicked")))
                .map_err(|e| network_error(name, &e))?,
        };
        let (contract, fingerprint) = (Arc::new(contract), fingerprint(bytes).into());
        let mut policy = Self { file, contract, fingerprint, plans, affine, normalises, rows_agree: false };
        policy.check_golden()?;
        policy.rows_agree = policy.is_affine() || policy.compare_rows()?;
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

    /// Whether it is one matrix and an offset behind its normaliser.
    pub fn is_affine(&self) -> bool {
        self.affine.is_some()
    }

    /// Name of the file, as given.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Checks that the policy can be played as `played` says; see [`PolicyContract::check_played`].
    pub fn check_played(&self, played: &PolicyUse) -> Result<(), PolicyError> {
        let contract = &*self.contract;
        contract.check_played(played).map_err(|misfit| PolicyError::Misfit {
            file: self.file.to_string(),
            skill: contract.skill.clone(),
            character: contract.character.clone(),
            misfit: Box::new(misfit),
        })
    }

    /// Checks that the policy can be played on a body, whatever the skill: it tells the body's links, and it was learnt with the
    /// same numbers where the contract says with which. A skill's description is compared by
    /// [`SkillDefinition::check_policy`](crate::skill::SkillDefinition::check_policy).
    pub fn check_for(&self, model: &CharacterModel) -> Result<(), PolicyError> {
        let contract = &*self.contract;
        self.check_played(&PolicyUse {
            observation: contract.observation.clone(),
            links: model.links.iter().skip(1).map(|link| link.name.clone()).collect(),
            action_scale: contract.action.scale,
            gain_action: contract.action.gains.clone(),
            control_rate: contract.control_rate,
            gains: contract.gains,
            cyclic: contract.reference.cyclic,
            character_fingerprint: model.fingerprint(),
        })
    }

    /// The actions for `rows` observations, one after the other in `observations`, as one row each in `out`: the
    /// network's means, before the contract's scale.
    ///
    /// A row whose observation holds a number that is not finite gets an action of NaN, which no clamp inside the
    /// network can hide; other rows are not affected. The last bits of an action depend on the processor, and on
    /// whether it was asked for alone or among others.
    pub fn act(&self, observations: &[f32], rows: usize, out: &mut Vec<f32>) -> Result<(), PolicyError> {
        self.act_by(|left| self.block_for(left), observations, rows, out)
    }

    /// [`Policy::act`] with the bits that every action has alone: together where that makes no difference on this
    /// machine, else one by one.
    #[cfg(feature = "engine")]
    pub(crate) fn act_each(&self, observations: &[f32], rows: usize, out: &mut Vec<f32>) -> Result<(), PolicyError> {
        let small = |left: usize| if self.rows_agree { left.min(BLOCKS[1].0) } else { 1 };
        self.act_by(|left| self.block_for(small(left)), observations, rows, out)
    }

    /// Whether both are the same policy, read from the same file.
    #[cfg(feature = "engine")]
    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.contract, &other.contract)
    }

    /// A number that tells it from other policies in memory.
    pub(crate) fn address(&self) -> usize {
        Arc::as_ptr(&self.contract).addr()
    }

    fn act_by<'a>(
        &'a self,
        block_for: impl Fn(usize) -> (&'a Arc<TypedSimplePlan>, usize),
        observations: &[f32],
        rows: usize,
        out: &mut Vec<f32>,
    ) -> Result<(), PolicyError> {
        let size = self.contract.observation_size();
        if rows.checked_mul(size) != Some(observations.len()) {
            let (file, found) = (self.file.to_string(), observations.len());
            return Err(PolicyError::Rows { file, found, rows, size });
        }
        out.clear();
        if rows == 0 {
            return Ok(());
        }
        match &self.affine {
            Some(affine) => self.run_affine(affine, observations, out),
            None => self.run(block_for, observations, rows, out).map_err(|e| network_error(&self.file, &e))?,
        }
        let actions = out.chunks_exact_mut(self.contract.action_size());
        for (observation, action) in observations.chunks_exact(size).zip(actions) {
            if !observation.iter().all(|v| v.is_finite()) {
                action.fill(f32::NAN);
            }
        }
        Ok(())
    }

    fn run<'a>(
        &self,
        block_for: impl Fn(usize) -> (&'a Arc<TypedSimplePlan>, usize),
        observations: &[f32],
        rows: usize,
        out: &mut Vec<f32>,
    ) -> TractResult<()> {
        let (size, width) = (self.contract.observation_size(), self.contract.action_size());
        let mut done = 0;
        while done < rows {
            let left = rows - done;
            let (plan, block) = block_for(left);
            let taken = left.min(block);
            let part = &observations[done * size..(done + taken) * size];
            let mut input = Tensor::zero::<f32>(&[block, size])?;
            self.prepare(part, &mut input.try_as_plain_ram_mut()?.as_slice_mut::<f32>()?[..taken * size]);
            let result = plan.run(tvec![input.into()])?;
            out.extend_from_slice(&result[0].try_as_plain_ram()?.as_slice::<f32>()?[..taken * width]);
            done += taken;
        }
        Ok(())
    }

    fn run_affine(&self, affine: &AffineMap, observations: &[f32], out: &mut Vec<f32>) {
        let (size, width) = (self.contract.observation_size(), self.contract.action_size());
        for raw in observations.chunks_exact(size) {
            // The end of the result is the work space: nothing is allocated once it has grown.
            let start = out.len();
            out.resize(start + width + size, 0.0);
            let (action, row) = out[start..].split_at_mut(width);
            self.prepare(raw, row);
            affine.apply(row, action);
            out.truncate(start + width);
        }
    }

    /// What the plans take for these observations.
    fn prepare(&self, observations: &[f32], out: &mut [f32]) {
        if !self.normalises {
            out.copy_from_slice(observations);
            return;
        }
        let Normaliser { mean, scale, clip } = &self.contract.normaliser;
        for (row, out) in observations.chunks_exact(mean.len()).zip(out.chunks_exact_mut(mean.len())) {
            for (((out, seen), mean), scale) in out.iter_mut().zip(row).zip(mean).zip(scale) {
                *out = ((seen - mean) * scale).max(-clip).min(*clip);
            }
        }
    }

    /// Whether a block gives every row the bits that it has alone. Kernels for one row and for several may sum in
    /// different orders, depending on the processor; where they do, hundreds of sums do not agree by chance.
    fn compare_rows(&self) -> Result<bool, PolicyError> {
        let rows = BLOCKS[1].0;
        let mut random = RandomStream::new(1, 0);
        let golden = &self.contract.golden.observation;
        let observations: Vec<f32> =
            (0..rows).flat_map(|_| golden.iter()).map(|v| v + random.normal() as f32).collect();
        let (mut together, mut alone) = (Vec::new(), Vec::new());
        self.act(&observations, rows, &mut together)?;
        for (observation, action) in
            observations.chunks_exact(golden.len()).zip(together.chunks_exact(self.contract.action_size()))
        {
            self.act(observation, 1, &mut alone)?;
            if !alone.iter().map(|v| v.to_bits()).eq(action.iter().map(|v| v.to_bits())) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The plan for the next of `left` rows, and its number of rows.
    fn block_for(&self, left: usize) -> (&Arc<TypedSimplePlan>, usize) {
        let k = BLOCKS.iter().position(|(_, least)| left >= *least).unwrap_or(BLOCKS.len() - 1);
        (&self.plans[k], BLOCKS[k].0)
    }

    fn check_golden(&self) -> Result<(), PolicyError> {
        let contract = &*self.contract;
        let mut found = Vec::new();
        self.act(&contract.golden.observation, 1, &mut found)?;
        for (index, (found, expected)) in found.into_iter().zip(contract.golden.action.iter().copied()).enumerate() {
            let difference = (f64::from(found) - f64::from(expected)).abs();
            let tolerance = GOLDEN_TOLERANCE * f64::from(expected).abs().max(1.0);
            if difference.is_nan() || difference > tolerance {
                let file = self.file.to_string();
                return Err(PolicyError::Golden { file, index, found, expected, difference, tolerance });
            }
        }
        Ok(())
    }
}

/// The checked model, made ready for each of [`BLOCKS`].
fn plans(model: &ModelProto, widths: &Widths) -> TractResult<Arc<[Arc<TypedSimplePlan>]>> {
    let model = tract_onnx::onnx().model_for_proto_model(model)?;
    let plan = |(rows, _): (usize, usize)| {
        let input = InferenceFact::dt_shape(f32::datum_type(), [rows, widths.observation]);
        let model = model.clone().with_input_fact(0, input)?.into_optimized()?;
        let shape = &model.output_fact(0)?.shape;
        if shape.as_concrete() != Some(&[rows, widths.action]) {
            return Err(TractError::msg(format!("{rows} observations give actions of shape {shape:?}")));
        }
        model.into_runnable()
    };
    BLOCKS.into_iter().map(plan).collect()
}

fn network_error(file: &str, error: &TractError) -> PolicyError {
    PolicyError::Network { file: file.to_owned(), reason: format!("{error:#}").chars().take(500).collect() }
}

impl std::fmt::Debug for Policy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Policy").field("file", &self.file).field("contract", &self.contract).finish_non_exhaustive()
    }
}
