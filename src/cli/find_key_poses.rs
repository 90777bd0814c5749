//! Key pose files by the name of a skill.

use super::skills::skill_file;
use super::{InputError, SKILLS_FOLDER};
use std::path::PathBuf;

const ENDING: &str = ".keyposes.ron";

/// The file at this path, or the key poses of the skill with this name.
pub fn find_key_poses(skill: &str) -> Result<PathBuf, InputError> {
    if skill.ends_with(ENDING) {
        return Ok(PathBuf::from(skill));
    }
    skill_file(skill, ENDING).map_err(|known| {
        let valid = if known.is_empty() { format!("none found in {SKILLS_FOLDER}") } else { known.join(", ") };
        InputError::NoSkill { name: skill.to_owned(), valid }
    })
}
