//! A skill's description and the contract of its policy: one check that both say the same.

use crate::asset::policy_contract::{ContractError, PolicyContract};
use crate::asset::policy_fit::PolicyUse;
#[cfg(feature = "policy")]
use crate::control::{Policy, PolicyError};
use crate::model::CharacterModel;
use crate::skill::SkillDefinition;

impl SkillDefinition {
    /// What a policy would be shown and told where this skill is played on a body.
    pub fn policy_use(&self, model: &CharacterModel) -> PolicyUse {
        PolicyUse {
            observation: self.layout(model).blocks,
            links: model.links.iter().skip(1).map(|link| link.name.clone()).collect(),
            action_scale: self.action_scale,
            gain_action: self.gain_action.clone(),
            control_rate: self.control_rate,
            gains: self.gains,
            cyclic: self.cyclic,
            character_fingerprint: model.fingerprint(),
        }
    }

    /// Checks that a policy can play this skill on a body: wherever skill file and contract both say a number, they agree. The
    /// names of skill and character do not matter.
    #[cfg(feature = "policy")]
    pub fn check_policy(&self, policy: &Policy, model: &CharacterModel) -> Result<(), PolicyError> {
        policy.check_played(&self.policy_use(model))
    }

    /// The skill that a contract describes: its own settings, or, where there are none, a motion that is imitated alone with the
    /// contract's numbers, on ice by a body with blades, on the ground by others. The motion is
    /// the contract's reference, a file in the policy's folder.
    pub fn of_contract(contract: &PolicyContract, model: &CharacterModel) -> Result<Self, ContractError> {
        let motion = &contract.reference.file;
        if !contract.skill_settings.is_empty() {
            let skill: Self = contract.parse_skill_settings()?;
            return Ok(Self { motion: motion.into(), ..skill });
        }
        let world = if model.blades.is_empty() { "ground" } else { "ice" };
        let mut skill = Self::imitate_alone(&contract.skill, &contract.character, motion, world);
        if contract.reference.cyclic {
            skill.repeat(false);
        }
        skill.control_rate = contract.control_rate;
        skill.action_scale = contract.action.scale;
        skill.gains = contract.gains;
        skill.gain_action.clone_from(&contract.action.gains);
        Ok(skill)
    }
}
