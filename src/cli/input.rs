//! Characters and motions by name or file.

use super::InputError;
use crate::asset::bvh::Bvh;
use crate::asset::clip::MotionClip;
use crate::asset::joint_map::JointMap;
use crate::asset::{AssetError, Character};
use crate::model::{CharacterModel, ImportedMotion, KeyPoses, PRESET_NAMES, SharedModel, import_motion, preset};
use std::path::Path;
use std::sync::Arc;

/// The preset of this name, or the character in the file at this path.
pub fn load_character(name: &str) -> Result<SharedModel, InputError> {
    if let Some(model) = preset(name) {
        return Ok(model);
    }
    // A folder or a device is there all the same: what is wrong with it is said by who reads it.
    if !Path::new(name).exists() {
        return Err(InputError::NoCharacter { name: name.to_owned(), valid: PRESET_NAMES.join(", ") });
    }
    let character = Character::read(name)?;
    Ok(Arc::new(CharacterModel::build(&character).map_err(AssetError::from)?))
}

/// The motion in a `.bvh` file (put onto the character as `map` says, by default the built-in map that knows the
/// skeleton, else one that is found), in a clip file (`.clip.ron`) or in key poses (`.keyposes.ron`), named after the file and
/// checked against the character.
pub fn load_motion(file: &Path, map: Option<&Path>, model: &CharacterModel) -> Result<MotionClip, InputError> {
    load_motion_with(file, map, model).map(|motion| motion.clip)
}

/// The same with the map that was found and what a person should know.
pub fn load_motion_with(file: &Path, map: Option<&Path>, model: &CharacterModel) -> Result<ImportedMotion, InputError> {
    let (mut found, mut warnings) = (None, Vec::new());
    let ending = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let clip = match ending.as_str() {
        "bvh" => {
            let bvh = Bvh::load(file).map_err(|e| InputError::file(file, e))?;
            let map = map.map(|path| JointMap::load(path).map_err(|e| InputError::file(path, e))).transpose()?;
            let imported = import_motion(&bvh, map.as_ref(), model)
                .map_err(|source| InputError::Motion { file: file.to_path_buf(), source: Box::new(source) })?;
            (found, warnings) = (imported.found, imported.warnings);
            let mut clip = imported.clip;
            if let Some(stem) = file.file_stem() {
                clip.name = stem.to_string_lossy().into_owned();
            }
            clip
        }
        "ron" if file.to_string_lossy().ends_with(".keyposes.ron") => {
            let poses = KeyPoses::load(file).map_err(|e| InputError::file(file, e))?;
            poses.to_clip(model).map_err(|e| InputError::file(file, e))?
        }
        "ron" => MotionClip::load(file).map_err(|e| InputError::file(file, e))?,
        _ => return Err(InputError::Kind { file: file.to_path_buf() }),
    };
    clip.to_model(model).map_err(|e| InputError::file(file, e))?;
    Ok(ImportedMotion { clip, found, warnings })
}
