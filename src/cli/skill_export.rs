//! From what a training left to the files of a skill that a game loads.
//!
//! What belongs together is found out before anything is written: motion and card by the fingerprints that the policy's contract and
//! the card have of them, the body by the contract, and the whole by loading it as a game does.

use super::policy_folder::MAX_MOTION_BYTES;
use super::{InputError, PolicyFolderError, check_motion, load_character, load_motion, skill_of_policy};
use crate::asset::card::{CardError, RobustnessCard};
use crate::asset::clip::ClipError;
use crate::asset::read_file::read_bytes;
use crate::asset::{Character, Course, CourseError};
use crate::control::{Policy, PolicyError};
use crate::model::preset;
use crate::skill::{SkillDefinition, SkillError, TrainedSkill, TrainedSkillError};
use crate::train::ppo::course_file;
use std::path::{Path, PathBuf};

/// The name of the policy in every skill's folder.
pub const POLICY_FILE: &str = "policy.onnx";
/// The name of the card in every skill's folder.
pub const CARD_FILE: &str = "card.json";

/// Why a training gives no skill.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SkillExportError {
    /// The folder tells of no skill.
    #[error(transparent)]
    Folder(#[from] PolicyFolderError),
    /// The policy.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// Motion or character.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The motion cannot be written.
    #[error(transparent)]
    Clip(#[from] ClipError),
    /// The description cannot be written.
    #[error(transparent)]
    Skill(#[from] SkillError),
    /// The course.
    #[error(transparent)]
    Course(Box<CourseError>),
    /// The parts do not fit each other.
    #[error("{}: {source}", policy.display())]
    Parts {
        /// The policy.
        policy: PathBuf,
        /// What does not fit.
        source: Box<TrainedSkillError>,
    },
    /// The card.
    #[error("{}: {source}", file.display())]
    Card {
        /// The card.
        file: PathBuf,
        /// What is wrong with it.
        source: CardError,
    },
    /// The card is of another policy.
    #[error("{}: of the policy {found}; valid: {wanted}, that of {}", file.display(), policy.display())]
    OtherCard {
        /// The card.
        file: PathBuf,
        /// The policy that it is of.
        found: String,
        /// The policy's fingerprint.
        wanted: String,
        /// The policy.
        policy: PathBuf,
    },
    /// No file can be called after the skill.
    #[error("skill `{name}`: no name for files; valid: without / \\ : and more than dots")]
    Name {
        /// The skill.
        name: String,
    },
    /// The description would not be read back as it is.
    #[error("skill {name}: its description is not read back as it was written")]
    Description {
        /// The skill.
        name: String,
    },
}

/// The files of a skill.
#[derive(Clone, Debug)]
pub struct SkillExport {
    /// Name of the skill.
    pub name: String,
    /// Names and contents of the files, in the order in which they are to be written: the policy comes last, so that what finds it
    /// finds the others too.
    pub files: Vec<(String, Vec<u8>)>,
    /// Whether a card is among them.
    pub has_card: bool,
}

fn bytes_of(file: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    read_bytes(file, limit).map_err(|error| InputError::file(file, error.fault))
}

fn name_of(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Reads the skill of the policy in a file, with what lies beside it, and checks that all of it belongs together.
pub fn skill_export(file: &Path) -> Result<SkillExport, SkillExportError> {
    let policy = Policy::load(file)?;
    let skill = skill_of_policy(&policy, file, None)?;
    let name = skill.name.clone();
    if name.contains(['/', '\\', ':', '\0']) || name.chars().all(|c| c == '.') {
        return Err(SkillExportError::Name { name });
    }
    let mut files = Vec::new();

    // The motion as it is where a game reads it, else as a clip.
    check_motion(&policy, file, &skill.motion)?;
    let model = load_character(&skill.character)?;
    let clip = load_motion(&skill.motion, None, &model)?;
    let mut motion = name_of(&skill.motion);
    if motion.ends_with(".clip.ron") || motion.ends_with(".keyposes.ron") {
        files.push((motion.clone(), bytes_of(&skill.motion, MAX_MOTION_BYTES)?));
    } else {
        motion = format!("{name}.clip.ron");
        files.push((motion.clone(), clip.clone().rounded().to_ron()?.into_bytes()));
    }
    let fault = |error| SkillExportError::Course(Box::new(error));
    let course = skill.course.as_ref().map(Course::read).transpose().map_err(fault)?;
    if let Some(course) = &course {
        files.push((course_file(&name), course.to_ron().map_err(fault)?.into_bytes()));
    }
    let mut character = skill.character.clone();
    if preset(&character).is_none() {
        let own = PathBuf::from(&character);
        let named = name_of(&own);
        character = if named.ends_with(".character.ron") { named } else { format!("{name}.character.ron") };
        files.push((character.clone(), bytes_of(&own, Character::MAX_BYTES as u64)?));
    }

    // What came before it mattered to the training alone.
    let described = SkillDefinition {
        motion: motion.into(),
        course: course.as_ref().map(|_| course_file(&name).into()),
        character,
        after: Vec::new(),
        ..skill.clone()
    };
    let text = described.to_ron()?;
    if SkillDefinition::from_ron(&text, &name).ok().as_ref() != Some(&described) {
        return Err(SkillExportError::Description { name });
    }
    files.push((format!("{name}.skill.ron"), text.into_bytes()));

    let card_file = file.with_file_name(CARD_FILE);
    let has_card = card_file.exists();
    if has_card {
        let fault = |source| SkillExportError::Card { file: card_file.clone(), source };
        let card = RobustnessCard::load(&card_file).map_err(fault)?;
        if card.policy != policy.fingerprint() {
            let wanted = policy.fingerprint().to_owned();
            let policy = file.to_path_buf();
            return Err(SkillExportError::OtherCard { file: card_file, found: card.policy, wanted, policy });
        }
        files.push((CARD_FILE.into(), card.to_json().map_err(fault)?.into_bytes()));
    }
    files.push((POLICY_FILE.into(), bytes_of(file, crate::control::MAX_POLICY_BYTES)?));

    // As a game does.
    let parts = |source| SkillExportError::Parts { policy: file.to_path_buf(), source: Box::new(source) };
    let trained = TrainedSkill::new(skill, &clip, policy, &model).map_err(parts)?;
    if let Some(course) = &course {
        trained.on_course(course, &model).map_err(parts)?;
    }
    Ok(SkillExport { name, files, has_card })
}
