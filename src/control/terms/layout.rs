//! The order of the numbers that a policy sees.

use crate::asset::policy_contract::ObservationBlock;
use crate::control::terms::{GainTerm, ObservationTerm};
use crate::model::CharacterModel;

/// The terms of an observation and their blocks, in order. The heading frame is the world turned about the vertical so that the root
/// faces -Z; heights count from what carries the body.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservationLayout {
    /// The terms; those without a number for this character are left out.
    pub terms: Vec<ObservationTerm>,
    /// The block of each.
    pub blocks: Vec<ObservationBlock>,
    /// Number of the skill's parameters.
    pub parameters: usize,
    /// Joints whose gains the policy sets, by its last numbers.
    pub gains: GainTerm,
}

impl ObservationLayout {
    /// The layout of [`ObservationTerm::STANDARD`] for a character.
    pub fn of(model: &CharacterModel) -> Self {
        Self::new(model, &[], 0)
    }

    /// The standard terms and then `more`, for a character and a skill with so many parameters.
    pub fn new(model: &CharacterModel, more: &[ObservationTerm], parameters: usize) -> Self {
        let all: Vec<_> = ObservationTerm::STANDARD.iter().chain(more).cloned().collect();
        Self::from_terms(model, &all, parameters)
    }

    /// These terms, for a character and a skill with so many parameters.
    pub fn from_terms(model: &CharacterModel, all: &[ObservationTerm], parameters: usize) -> Self {
        let terms: Vec<_> = all.iter().filter(|t| t.size(model, parameters) > 0).cloned().collect();
        let block = |t: &ObservationTerm| ObservationBlock {
            name: t.name().into(),
            size: t.size(model, parameters),
            meaning: t.meaning().into(),
        };
        Self { blocks: terms.iter().map(block).collect(), terms, parameters, gains: GainTerm::default() }
    }

    /// With gains that the policy sets.
    pub fn with_gains(self, gains: GainTerm) -> Self {
        Self { gains, ..self }
    }

    /// Numbers of an action: three for each link but the root, and one for each joint whose gains are set.
    pub fn action_size(&self, model: &CharacterModel) -> usize {
        3 * (model.links.len() - 1) + self.gains.links.len()
    }

    /// Numbers in all.
    pub fn size(&self) -> usize {
        self.blocks.iter().map(|b| b.size).sum()
    }
}
