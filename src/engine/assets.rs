//! Characters and controls as assets.

use crate::asset::Character;
use crate::control::ReconstructedControl;
use crate::engine::{LoadError, ProgramAsset, ProgramLoader, SkillAsset, SkillLoader};
use crate::model::{CharacterModel, PRESET_NAMES, SharedModel, preset, preset_source};
use bevy::asset::io::Reader;
use bevy::asset::io::embedded::EmbeddedAssetRegistry;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A character, validated and built.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct CharacterAsset {
    /// The model, shared by all athletes of this character.
    pub model: SharedModel,
}

impl CharacterAsset {
    /// One of the characters that come with the crate: `skater`, `foot_human`, `two_segment_human`, `toes_human` or `runner`.
    pub fn preset(name: &str) -> Option<Self> {
        preset(name).map(|model| Self { model })
    }
}

/// An open-loop control: a clip and the offsets that make the simulation follow it.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct ControlAsset {
    /// The control as saved, in the character's own frame.
    pub control: Arc<ReconstructedControl>,
}

impl From<ReconstructedControl> for ControlAsset {
    fn from(control: ReconstructedControl) -> Self {
        Self { control: Arc::new(control) }
    }
}

/// An asset that is made of one whole file.
pub trait FileAsset: Asset + Sized {
    /// What the name of such a file ends in, without the leading dot.
    const ENDING: &'static str;

    /// Reads the content of a file. `file` is its path for messages.
    fn parse(file: &str, bytes: &[u8]) -> Result<Self, LoadError>;
}

impl FileAsset for CharacterAsset {
    const ENDING: &'static str = "character.ron";

    fn parse(file: &str, bytes: &[u8]) -> Result<Self, LoadError> {
        let character = Character::parse(file, bytes)?;
        let model = CharacterModel::build(&character).map_err(|e| LoadError::Character(e.into()))?;
        Ok(Self { model: Arc::new(model) })
    }
}

impl FileAsset for ControlAsset {
    const ENDING: &'static str = "control.ron";

    fn parse(file: &str, bytes: &[u8]) -> Result<Self, LoadError> {
        // Bytes that are not text cannot be a control; the parser says where it stops making sense.
        let text = String::from_utf8_lossy(bytes);
        let control = ReconstructedControl::from_ron(&text, file);
        Ok(control.map_err(|e| LoadError::Control { file: file.to_owned(), source: Box::new(e) })?.into())
    }
}

/// Loads `*.character.ron` as [`CharacterAsset`] and `*.control.ron` as [`ControlAsset`].
#[derive(TypePath)]
pub struct FileLoader<A: FileAsset>(PhantomData<fn() -> A>);

impl<A: FileAsset> Default for FileLoader<A> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<A: FileAsset> AssetLoader for FileLoader<A> {
    type Asset = A;
    type Settings = ();
    type Error = LoadError;

    async fn load(&self, reader: &mut dyn Reader, _: &(), context: &mut LoadContext<'_>) -> Result<A, LoadError> {
        let file = context.path().to_string();
        let mut bytes = Vec::new();
        match reader.read_to_end(&mut bytes).await {
            Ok(_) => A::parse(&file, &bytes),
            Err(source) => Err(LoadError::Read { file, source }),
        }
    }

    fn extensions(&self) -> &[&str] {
        &[A::ENDING]
    }
}

/// Asset types, their loaders, and the characters of the crate as `embedded://bevy_athlete/NAME.character.ron`; with the feature
/// `skills` the skating skills as `embedded://bevy_athlete/skills/skating/NAME/NAME.skill.ron`, and their short program.
///
/// Without an `AssetPlugin` before it (a server that adds its own files to nothing) only the types are missing: add
/// `AssetPlugin` first.
#[derive(Debug, Default)]
pub struct AthleteAssetPlugin;

impl Plugin for AthleteAssetPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<CharacterAsset>()
            .init_asset::<ControlAsset>()
            .init_asset::<SkillAsset>()
            .init_asset::<ProgramAsset>()
            .init_asset_loader::<SkillLoader>()
            .init_asset_loader::<ProgramLoader>()
            .init_asset_loader::<FileLoader<CharacterAsset>>()
            .init_asset_loader::<FileLoader<ControlAsset>>();
        if let Some(embedded) = app.world().get_resource::<EmbeddedAssetRegistry>() {
            for (file, text) in PRESET_NAMES.iter().filter_map(|name| preset_source(name)) {
                let path = Path::new("bevy_athlete").join(file);
                embedded.insert_asset(PathBuf::from(file), &path, text.as_bytes());
            }
            #[cfg(feature = "skills")]
            for (file, bytes) in super::embedded_skills::files() {
                embedded.insert_asset(PathBuf::from(file), &Path::new("bevy_athlete").join(file), bytes);
            }
        }
    }
}
