//! Trained skills and programs as assets.

use crate::asset::Course;
use crate::asset::clip::MotionClip;
use crate::control::Policy;
use crate::engine::{LoadError, SkillMisfit};
use crate::model::{CharacterModel, KeyPoses, preset};
use crate::skill::{ProgramDefinition, SkillDefinition, TrainedSkill};
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, AssetPath, LoadContext};
use bevy::prelude::*;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// A skill that was learnt: its description (`*.skill.ron`), from the same folder `policy.onnx`, and the motion and the course that it
/// names.
///
/// It is made for a body when it is given to one ([`SkillAsset::bind`]): whether it fits is a matter of the body's joints, not of its
/// name. Bodies that are alike share what was made.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct SkillAsset {
    name: String,
    /// What it is made from; `None` where it was made elsewhere.
    files: Option<Arc<SkillFiles>>,
    /// What was made, by the fingerprint of the model.
    bound: Arc<Mutex<Vec<(u64, Arc<TrainedSkill>)>>>,
}

/// A skill as its files have it.
#[derive(Clone, Debug)]
struct SkillFiles {
    definition: SkillDefinition,
    motion: SkillMotion,
    policy: Policy,
    /// The obstacles that it was learnt on.
    course: Option<Course>,
}

#[derive(Clone, Debug)]
enum SkillMotion {
    Clip(MotionClip),
    KeyPoses(KeyPoses),
}

impl SkillAsset {
    /// From its parts. `motion` is a clip; see [`SkillAsset::from_key_poses`] for one that is written down in poses.
    pub fn new(definition: SkillDefinition, motion: MotionClip, policy: Policy) -> Self {
        Self::of_files(SkillFiles { definition, motion: SkillMotion::Clip(motion), policy, course: None })
    }

    /// From its parts, with a motion that is written down in poses.
    pub fn from_key_poses(definition: SkillDefinition, motion: KeyPoses, policy: Policy) -> Self {
        Self::of_files(SkillFiles { definition, motion: SkillMotion::KeyPoses(motion), policy, course: None })
    }

    /// The same, learnt on these obstacles: its motion knows where it stands on them. One that was made elsewhere stays as it is.
    pub fn on_course(self, course: Course) -> Self {
        match self.files {
            Some(files) => Self::of_files(SkillFiles { course: Some(course), ..SkillFiles::clone(&files) }),
            None => self,
        }
    }

    /// One that was made for a body elsewhere, such as by a training that still runs. It fits bodies like that one alone.
    pub fn made_for(model: &CharacterModel, skill: Arc<TrainedSkill>) -> Self {
        let name = skill.name().to_owned();
        Self { name, files: None, bound: Arc::new(Mutex::new(vec![(model.fingerprint(), skill)])) }
    }

    fn of_files(files: SkillFiles) -> Self {
        let name = files.definition.name.clone();
        Self { name, files: Some(Arc::new(files)), bound: Arc::default() }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The skill, made for a body. Made once for all bodies that are alike.
    pub fn bind(&self, model: &CharacterModel) -> Result<Arc<TrainedSkill>, SkillMisfit> {
        let fingerprint = model.fingerprint();
        let mut bound = self.bound.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, made)) = bound.iter().find(|(of, _)| *of == fingerprint) {
            return Ok(made.clone());
        }
        let (skill, character) = (self.name.clone(), model.name.clone());
        let Some(files) = &self.files else { return Err(SkillMisfit::OtherBody { skill, character }) };
        let from_poses;
        let clip = match &files.motion {
            SkillMotion::Clip(clip) => clip,
            SkillMotion::KeyPoses(poses) => match poses.to_clip(model) {
                Ok(clip) => {
                    from_poses = clip;
                    &from_poses
                }
                Err(source) => {
                    return Err(SkillMisfit::Motion { skill, character, source: Box::new(source) });
                }
            },
        };
        let made = TrainedSkill::new(files.definition.clone(), clip, files.policy.clone(), model);
        let made = match &files.course {
            Some(course) => made.and_then(|made| made.on_course(course, model)),
            None => made,
        };
        let made =
            Arc::new(made.map_err(|source| SkillMisfit::Parts { skill, character, source: Box::new(source) })?);
        bound.push((fingerprint, made.clone()));
        Ok(made)
    }
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
    context.read_asset_bytes(path).await.map_err(|source| LoadError::Part { file, source: Box::new(source) })
}

fn beside(context: &LoadContext<'_>, file: &Path) -> AssetPath<'static> {
    let folder = context.path().path().parent().unwrap_or(Path::new(""));
    AssetPath::from_path_buf(folder.join(file)).with_source(context.path().source().clone_owned())
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
        let definition = SkillDefinition::from_ron(&text_of(reader, &file).await?, &file)?;
        let path = beside(context, &definition.motion);
        let file = path.to_string();
        let bytes = bytes_of(context, path).await?;
        let text = String::from_utf8_lossy(&bytes);
        let motion = if file.ends_with(".keyposes.ron") {
            SkillMotion::KeyPoses(KeyPoses::from_ron(&text, &file)?)
        } else {
            let clip = MotionClip::from_ron(&text);
            SkillMotion::Clip(clip.map_err(|source| LoadError::Clip { file: file.clone(), source: Box::new(source) })?)
        };
        let path = beside(context, Path::new("policy.onnx"));
        let name = path.to_string();
        let policy = Policy::from_bytes(&bytes_of(context, path).await?, &name)?;
        let reference = &policy.contract().reference;
        if let Some(found) = reference.other_than(&definition.motion, &bytes) {
            let wanted = reference.fingerprint.clone().unwrap_or_default();
            return Err(LoadError::OtherMotion { file, found, wanted });
        }
        let course = match &definition.course {
            Some(file) => {
                let path = beside(context, file);
                let name = path.to_string();
                let course = Course::parse(&name, &bytes_of(context, path).await?);
                Some(course.map_err(|source| LoadError::Course(Box::new(source)))?)
            }
            None => None,
        };
        let likely = preset(&definition.character);
        let skill = SkillAsset::of_files(SkillFiles { definition, motion, policy, course });
        if let Some(model) = likely {
            // Made here, aside, for the body that most likely performs it. What does not fit is told when it is given to a body.
            let _ = skill.bind(&model);
        }
        Ok(skill)
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
        let program = ProgramDefinition::from_ron(&text, &file)?;
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
