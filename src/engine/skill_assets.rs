//! Trained skills and programs as assets.

use crate::asset::clip::MotionClip;
use crate::control::Policy;
use crate::engine::LoadError;
use crate::model::{CharacterModel, KeyPoses, SharedModel, preset};
use crate::skill::{ProgramDefinition, SkillDefinition, TrainedSkill};
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, AssetPath, LoadContext};
use bevy::prelude::*;
use std::path::Path;
use std::sync::Arc;

/// A skill that was learnt: its description (`*.skill.ron`), and from the same folder its motion and `policy.onnx`.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct SkillAsset {
    /// The skill, ready to be performed.
    pub skill: Arc<TrainedSkill>,
    /// Name of its character.
    pub character: String,
}

/// A program (`*.program.ron`) with its skills, each from `NAME/NAME.skill.ron` beside the program.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct ProgramAsset {
    /// The program.
    pub program: ProgramDefinition,
    /// Its skills, once each, in order of appearance.
    #[dependency]
    pub skills: Vec<Handle<SkillAsset>>,
}

/// Loads [`SkillAsset`].
#[derive(Default, TypePath)]
pub struct SkillLoader;

/// Loads [`ProgramAsset`].
#[derive(Default, TypePath)]
pub struct ProgramLoader;

async fn text_of(reader: &mut dyn Reader, file: &str) -> Result<String, LoadError> {
    let mut bytes = Vec::new();
    match reader.read_to_end(&mut bytes).await {
        Ok(_) => Ok(String::from_utf8_lossy(&bytes).into_owned()),
        Err(source) => Err(LoadError::Read { file: file.to_owned(), source }),
    }
}

/// The bytes of another file of the skill; a change of it loads the skill again.
async fn bytes_of(context: &mut LoadContext<'_>, path: AssetPath<'static>) -> Result<Vec<u8>, LoadError> {
    let file = path.to_string();
    context.read_asset_bytes(path).await.map_err(|e| LoadError::Skill { file, message: e.to_string() })
}

fn beside(context: &LoadContext<'_>, file: &Path) -> AssetPath<'static> {
    let folder = context.path().path().parent().unwrap_or(Path::new(""));
    AssetPath::from_path_buf(folder.join(file)).with_source(context.path().source().clone_owned())
}

fn fault(file: &str, error: impl ToString) -> LoadError {
    LoadError::Skill { file: file.to_owned(), message: error.to_string() }
}

impl AssetLoader for SkillLoader {
    type Asset = SkillAsset;
    type Settings = ();
    type Error = LoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<SkillAsset, LoadError> {
        let file = context.path().to_string();
        let definition =
            SkillDefinition::from_ron(&text_of(reader, &file).await?, &file).map_err(|e| fault(&file, e))?;
        let model: SharedModel = match preset(&definition.character) {
            Some(model) => model,
            None => {
                let path = format!("characters/{}.character.ron", definition.character);
                let bytes = bytes_of(context, AssetPath::from(path.clone())).await?;
                let character = crate::asset::Character::parse(&path, &bytes)?;
                Arc::new(CharacterModel::build(&character).map_err(|e| LoadError::Character(e.into()))?)
            }
        };
        let path = beside(context, &definition.motion);
        let motion = path.to_string();
        let text = String::from_utf8_lossy(&bytes_of(context, path).await?).into_owned();
        let clip = if motion.ends_with(".keyposes.ron") {
            KeyPoses::from_ron(&text, &motion).and_then(|p| p.to_clip(&model)).map_err(|e| fault(&motion, e))?
        } else {
            MotionClip::from_ron(&text).map_err(|e| fault(&motion, e))?
        };
        let path = beside(context, Path::new("policy.onnx"));
        let name = path.to_string();
        let policy = Policy::from_bytes(&bytes_of(context, path).await?, &name).map_err(|e| fault(&name, e))?;
        let character = definition.character.clone();
        let skill = TrainedSkill::new(definition, &clip, policy, &model).map_err(|e| fault(&file, e))?;
        Ok(SkillAsset { skill: Arc::new(skill), character })
    }

    fn extensions(&self) -> &[&str] {
        &["skill.ron"]
    }
}

impl AssetLoader for ProgramLoader {
    type Asset = ProgramAsset;
    type Settings = ();
    type Error = LoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<ProgramAsset, LoadError> {
        let file = context.path().to_string();
        let text = text_of(reader, &file).await?;
        let program = ProgramDefinition::from_ron(&text, &file).map_err(|e| fault(&file, e))?;
        let mut names: Vec<&str> = Vec::new();
        for element in &program.elements {
            if !names.contains(&element.skill.as_str()) {
                names.push(&element.skill);
            }
        }
        let paths: Vec<_> =
            names.iter().map(|name| beside(context, Path::new(&format!("{name}/{name}.skill.ron")))).collect();
        let skills = paths.into_iter().map(|path| context.load(path)).collect();
        Ok(ProgramAsset { program, skills })
    }

    fn extensions(&self) -> &[&str] {
        &["program.ron"]
    }
}
