//! A BVH file onto a character, whoever wrote it: the map is given, known or found, and the result is looked at.

use super::import_check::{MotionRefusal, MotionWarning, check_motion, check_size};
use super::{CharacterModel, FindMapError, FoundMap, ImportError, MapWarning, find_map, import_bvh};
use crate::asset::bvh::{Bvh, BvhWarning};
use crate::asset::clip::MotionClip;
use crate::asset::joint_map::JointMap;
use std::fmt;

/// A motion that was imported, and what it was taken for.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedMotion {
    /// The motion.
    pub clip: MotionClip,
    /// The map that was found; `None` where it was given, or one of the built-in ones knows the skeleton.
    pub found: Option<FoundMap>,
    /// What a person should know.
    pub warnings: Vec<ImportWarning>,
}

/// Something that a person should know about an imported motion.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ImportWarning {
    /// About the file.
    File(BvhWarning),
    /// About the map that was found.
    Map(MapWarning),
    /// About what came of it.
    Motion(MotionWarning),
}

impl fmt::Display for ImportWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ImportWarning::File(warning) => warning.fmt(f),
            ImportWarning::Map(warning) => warning.fmt(f),
            ImportWarning::Motion(warning) => warning.fmt(f),
        }
    }
}

/// Why a motion was not imported.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportMotionError {
    /// No map was given, none is known, and none was found.
    #[error(transparent)]
    NoMap(#[from] FindMapError),
    /// The map does not fit file and character.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// What came of it cannot be right.
    #[error(transparent)]
    Refused(#[from] MotionRefusal),
}

/// Puts the motion of a BVH file onto a character: by the map that is given, else the built-in one that knows the skeleton,
/// else the one that [`find_map`] finds.
pub fn import_motion(
    bvh: &Bvh,
    map: Option<&JointMap>,
    model: &CharacterModel,
) -> Result<ImportedMotion, ImportMotionError> {
    let mut warnings: Vec<ImportWarning> = bvh.warnings().iter().cloned().map(ImportWarning::File).collect();
    let known = map.cloned().or_else(|| JointMap::detect(bvh));
    let (map, found) = match known {
        Some(map) => (map, None),
        None => {
            let found = find_map(bvh, model)?;
            warnings.extend(found.warnings.iter().cloned().map(ImportWarning::Map));
            (found.map.clone(), Some(found))
        }
    };
    let clip = import_bvh(bvh, &map, model)?;
    let size = check_size(bvh, &map)?;
    warnings.extend(size.into_iter().chain(check_motion(&clip, model)?).map(ImportWarning::Motion));
    Ok(ImportedMotion { clip, found, warnings })
}
