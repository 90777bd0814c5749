//! The skill that a policy is of, from what lies in its folder.

use super::{InputError, load_character};
use crate::asset::policy_contract::ContractError;
use crate::asset::read_file::read_bytes;
use crate::control::{Policy, PolicyError};
use crate::skill::{SkillDefinition, SkillError};
use std::path::{Path, PathBuf};

/// Largest file of a motion, bytes.
pub(super) const MAX_MOTION_BYTES: u64 = 256 << 20;

/// Why a policy's folder tells of no skill.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PolicyFolderError {
    /// The description.
    #[error(transparent)]
    Skill(#[from] SkillError),
    /// The policy.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// The settings in its contract.
    #[error(transparent)]
    Contract(#[from] ContractError),
    /// The character.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Another motion lies beside the policy than it was learnt from.
    #[error("{}: fingerprint {found}; valid: {wanted}, the motion that {} was learnt from", motion.display(), policy.display())]
    OtherMotion {
        /// The file of the motion.
        motion: PathBuf,
        /// Its fingerprint.
        found: String,
        /// That of the contract.
        wanted: String,
        /// The policy.
        policy: PathBuf,
    },
}

/// The description of the skill in a policy's folder, where there is one; of several nobody can say which is meant.
pub fn skill_beside(policy: &Path) -> Option<PathBuf> {
    let folder = policy.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).ok()?;
    let mut found = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.to_string_lossy().ends_with(".skill.ron"));
    let first = found.next()?;
    found.next().is_none().then_some(first)
}

/// The skill of a policy that was read from `file`: as the description beside it has it, which may have changed since the training,
/// else as its contract has, on the motion that it was learnt from. On `character` (a preset or a file) where one is given.
pub fn skill_of_policy(
    policy: &Policy,
    file: &Path,
    character: Option<&str>,
) -> Result<SkillDefinition, PolicyFolderError> {
    let mut skill = match skill_beside(file) {
        Some(described) => {
            let skill = SkillDefinition::load(&described)?;
            check_motion(policy, file, &skill.motion)?;
            skill
        }
        None => {
            check_motion(policy, file, &file.with_file_name(&policy.contract().reference.file))?;
            described_by(policy, file, character)?
        }
    };
    if let Some(name) = character {
        name.clone_into(&mut skill.character);
    }
    Ok(skill)
}

/// The skill as a policy's contract describes it, its motion and its course beside the policy.
fn described_by(policy: &Policy, file: &Path, character: Option<&str>) -> Result<SkillDefinition, PolicyFolderError> {
    let contract = policy.contract();
    // What the contract says of the body is in its settings, or else the name.
    let own = match (character, contract.skill_settings.is_empty()) {
        (Some(name), _) => name.to_owned(),
        (None, true) => contract.character.clone(),
        (None, false) => contract.parse_skill_settings::<SkillDefinition>()?.character,
    };
    let skill = SkillDefinition::of_contract(contract, &*load_character(&own)?)?;
    let motion = file.with_file_name(&contract.reference.file);
    let course = skill.course.as_ref().map(|course| file.with_file_name(course));
    Ok(SkillDefinition { motion, course, ..skill })
}

/// Checks that a motion is the one that a policy was learnt from. Where the contract has no fingerprint, or names another file, nobody
/// can tell.
pub fn check_motion(policy: &Policy, file: &Path, motion: &Path) -> Result<(), PolicyFolderError> {
    let reference = &policy.contract().reference;
    let Some(wanted) = reference.fingerprint.clone() else { return Ok(()) };
    let bytes = read_bytes(motion, MAX_MOTION_BYTES).map_err(|error| InputError::file(motion, error.fault))?;
    match reference.other_than(motion, &bytes) {
        None => Ok(()),
        Some(found) => {
            let (motion, policy) = (motion.to_path_buf(), file.to_path_buf());
            Err(PolicyFolderError::OtherMotion { motion, found, wanted, policy })
        }
    }
}
