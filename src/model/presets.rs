//! The characters that come with the crate, built on first use and shared.

use super::{CharacterModel, SharedModel};
use crate::asset::{AssetError, Character};
use std::sync::{Arc, OnceLock};

/// Names of the characters that come with the crate.
pub const PRESET_NAMES: [&str; 5] = ["skater", "foot_human", "two_segment_human", "toes_human", "runner"];

/// File name and text of each, in the order of [`PRESET_NAMES`].
const SOURCES: [(&str, &str); 5] = [
    ("skater.character.ron", include_str!("../../assets/characters/skater.character.ron")),
    ("foot_human.character.ron", include_str!("../../assets/characters/foot_human.character.ron")),
    ("two_segment_human.character.ron", include_str!("../../assets/characters/two_segment_human.character.ron")),
    ("toes_human.character.ron", include_str!("../../assets/characters/toes_human.character.ron")),
    ("runner.character.ron", include_str!("../../assets/characters/runner.character.ron")),
];

/// The skater: 57 degrees of freedom, 50.07 kg, 1.5 m without its blades, 1200 steps/s.
pub fn skater() -> SharedModel {
    built(0)
}

/// The human with feet of five segments: 66 degrees of freedom, 48.5 kg, 1.5 m, 1800 steps/s.
pub fn foot_human() -> SharedModel {
    built(1)
}

/// The same human with feet of two boxes and one hinge, for comparison: 44 degrees of freedom, 48.5 kg, 1.5 m.
pub fn two_segment_human() -> SharedModel {
    built(2)
}

/// The foot human with five toe joints a foot, feet of eight segments: 84 degrees of freedom, 48.5 kg, 1.5 m, 1800 steps/s.
pub fn toes_human() -> SharedModel {
    built(3)
}

/// The runner: 45 degrees of freedom, 68 kg, 1.7 m, 2000 steps/s.
pub fn runner() -> SharedModel {
    built(4)
}

/// The character of this name, if it is one of [`PRESET_NAMES`].
pub fn preset(name: &str) -> Option<SharedModel> {
    PRESET_NAMES.iter().position(|n| *n == name).map(built)
}

/// File name and text of the character of this name, to start one's own from.
pub fn preset_source(name: &str) -> Option<(&'static str, &'static str)> {
    PRESET_NAMES.iter().position(|n| *n == name).map(|index| SOURCES[index])
}

/// The character with this index, built once.
fn built(index: usize) -> SharedModel {
    static MODELS: [OnceLock<SharedModel>; 5] = [const { OnceLock::new() }; 5];
    MODELS[index]
        .get_or_init(|| {
            let (file, text) = SOURCES[index];
            let build = || -> Result<CharacterModel, AssetError> {
                let character = Character::parse(file, text.as_bytes())?;
                Ok(CharacterModel::build(&character)?)
            };
            // The text is part of the program; `tests/core/character_files.rs` builds all of them.
            Arc::new(build().unwrap_or_else(|error| panic!("an embedded character file is wrong: {error}")))
        })
        .clone()
}
