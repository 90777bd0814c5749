//! Skills by name or file.

use crate::asset::clip::MotionClip;
use crate::asset::{Course, CourseError};
use crate::cli::{InputError, POLICY_FILE, PolicyFolderError, check_motion, load_character, load_motion_with};
use crate::control::{Policy, PolicyError};
use crate::model::{CharacterModel, ImportedMotion, SharedModel};
use crate::skill::{SkillDefinition, SkillError, TrainedSkill, TrainedSkillError};
use crate::train::ppo::{SkillTask, TaskError};
use std::path::{Path, PathBuf};

/// Folder of the skills that come with the crate, relative to the working folder.
pub const SKILLS_FOLDER: &str = "assets/skills";

/// Why a skill cannot be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SkillInputError {
    /// A motion where a skill is wanted.
    #[error("skill `{name}`: that is a motion; valid: --clip {name}, with --character")]
    Motion {
        /// What was given.
        name: String,
    },
    /// Neither the name of a skill nor a file.
    #[error("skill `{name}`: no such skill; valid: {known}, or the path of a .skill.ron file")]
    NotFound {
        /// What was given.
        name: String,
        /// Names of the skills found.
        known: String,
    },
    /// The skill file is wrong.
    #[error(transparent)]
    Skill(#[from] SkillError),
    /// Character or motion cannot be loaded.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The course is wrong.
    #[error(transparent)]
    Course(CourseError),
    /// The parts do not fit together.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// The policy cannot be read.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// The policy does not fit.
    #[error(transparent)]
    Trained(#[from] TrainedSkillError),
    /// The policy was learnt from another motion.
    #[error(transparent)]
    Folder(Box<PolicyFolderError>),
}

/// The folders in a folder, by name.
fn folders(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(path) else { return Vec::new() };
    let mut found: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| p.is_dir()).collect();
    found.sort();
    found
}

/// `FAMILY/NAME/NAME` + `ending` below [`SKILLS_FOLDER`]; the names that there are, if this one is not.
pub(super) fn skill_file(name: &str, ending: &str) -> Result<PathBuf, Vec<String>> {
    let mut known = Vec::new();
    for folder in folders(Path::new(SKILLS_FOLDER)).iter().flat_map(|family| folders(family)) {
        let stem = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let file = folder.join(format!("{stem}{ending}"));
        if file.is_file() {
            if stem == name {
                return Ok(file);
            }
            known.push(stem);
        }
    }
    Err(known)
}

/// The skill file with this name below [`SKILLS_FOLDER`], or at this path.
pub fn find_skill(name: &str) -> Result<PathBuf, SkillInputError> {
    if name.ends_with(".skill.ron") && Path::new(name).exists() {
        return Ok(PathBuf::from(name));
    }
    if [".bvh", ".clip.ron", ".keyposes.ron"].iter().any(|ending| name.ends_with(ending)) {
        return Err(SkillInputError::Motion { name: name.to_owned() });
    }
    skill_file(name, ".skill.ron").map_err(|known| {
        let known = if known.is_empty() { format!("none found in {SKILLS_FOLDER}") } else { known.join(", ") };
        SkillInputError::NotFound { name: name.to_owned(), known }
    })
}

/// The program file with this name below [`SKILLS_FOLDER`], or at this path.
pub fn find_program(name: &str) -> Option<PathBuf> {
    if name.ends_with(".program.ron") && Path::new(name).exists() {
        return Some(PathBuf::from(name));
    }
    let families = folders(Path::new(SKILLS_FOLDER));
    families.iter().map(|family| family.join(format!("{name}.program.ron"))).find(|p| p.is_file())
}

/// Is told what each motion was taken for, with its file.
pub type TellMotion<'a> = &'a mut dyn FnMut(&Path, &ImportedMotion);

fn read_motion(
    file: &Path,
    map: Option<&Path>,
    model: &CharacterModel,
    tell: TellMotion,
) -> Result<MotionClip, InputError> {
    let motion = load_motion_with(file, map, model)?;
    tell(file, &motion);
    Ok(motion.clip)
}

/// A skill with its motion and its policy, `policy.onnx` beside the skill file.
pub fn load_trained_skill(name: &str, model: &SharedModel) -> Result<TrainedSkill, SkillInputError> {
    load_trained_skill_with(name, model, &mut |_, _| {})
}

/// The same; `tell` hears what the motion was taken for.
pub fn load_trained_skill_with(
    name: &str,
    model: &SharedModel,
    tell: TellMotion,
) -> Result<TrainedSkill, SkillInputError> {
    let file = find_skill(name)?;
    let skill = SkillDefinition::load(&file)?;
    let clip = read_motion(&skill.motion, None, model, tell)?;
    let policy_file = file.with_file_name(POLICY_FILE);
    let policy = Policy::load(&policy_file)?;
    check_motion(&policy, &policy_file, &skill.motion).map_err(|error| SkillInputError::Folder(Box::new(error)))?;
    let course = skill.course.as_ref().map(Course::read).transpose().map_err(SkillInputError::Course)?;
    let trained = TrainedSkill::new(skill, &clip, policy, model)?;
    match course {
        Some(course) => Ok(trained.on_course(&course, model)?),
        None => Ok(trained),
    }
}

/// Makes a skill ready for trials. `map` is the joint map of a `.bvh` motion.
pub fn load_task(skill: &SkillDefinition, map: Option<&Path>) -> Result<SkillTask, SkillInputError> {
    load_task_with(skill, map, &mut |_, _| {})
}

/// The same; `tell` hears what each motion was taken for.
pub fn load_task_with(
    skill: &SkillDefinition,
    map: Option<&Path>,
    tell: TellMotion,
) -> Result<SkillTask, SkillInputError> {
    let model = load_character(&skill.character)?;
    let clip = read_motion(&skill.motion, map, &model, tell)?;
    let mut task = SkillTask::new(skill, model.clone(), &clip)?;
    if let Some(file) = &skill.course {
        task = task.on_course(Course::read(file).map_err(SkillInputError::Course)?)?;
    }
    for file in &skill.after {
        let other = SkillDefinition::load(file)?;
        let clip = read_motion(&other.motion, None, &model, tell)?;
        let mut motion = other.prepare_motion(&clip, &model).map_err(TaskError::from)?;
        if let Some(file) = &other.course {
            let course = Course::read(file).map_err(SkillInputError::Course)?;
            let stands = other.stand_on_course(&mut motion, &course, &other.named_world(), &model);
            stands.map_err(SkillInputError::Course)?;
        }
        task.follow(motion, other.exit_tick());
    }
    Ok(task)
}
