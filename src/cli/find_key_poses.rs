//! Key pose files by the name of a skill.

use super::InputError;
use std::path::{Path, PathBuf};

/// Folder of the skills that come with the crate, from the working folder: `FAMILY/SKILL/SKILL.keyposes.ron`.
const SKILLS: &str = "assets/skills";
const ENDING: &str = ".keyposes.ron";

fn folders(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(path) else { return Vec::new() };
    let mut found: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| p.is_dir()).collect();
    found.sort();
    found
}

/// The file at this path, or the key poses of the skill with this name.
pub fn find_key_poses(skill: &str) -> Result<PathBuf, InputError> {
    if skill.ends_with(ENDING) {
        return Ok(PathBuf::from(skill));
    }
    let mut known = Vec::new();
    for family in folders(Path::new(SKILLS)) {
        for folder in folders(&family) {
            let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let file = folder.join(format!("{name}{ENDING}"));
            if file.is_file() {
                if name == skill {
                    return Ok(file);
                }
                known.push(name);
            }
        }
    }
    let valid = if known.is_empty() { format!("none found in {SKILLS}") } else { known.join(", ") };
    Err(InputError::NoSkill { name: skill.to_owned(), valid })
}
