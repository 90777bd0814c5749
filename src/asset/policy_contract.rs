//! What a policy file says about itself: what goes in, what comes out, what it was trained for.
//!
//! The contract is JSON, kept in the metadata of the ONNX file under [`CONTRACT_KEY`]; `docs/book/policies.md` goes through
//! it field by field. Any trainer can write one.

use crate::asset::card::fingerprint;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::collections::BTreeSet;
use std::path::Path;

/// Key of the contract among the metadata properties of an ONNX file.
pub const CONTRACT_KEY: &str = "bevy_athlete";

/// The format version that this crate writes and reads.
pub const CONTRACT_VERSION: u32 = 1;

/// Longest contract, bytes of JSON.
pub const MAX_CONTRACT_BYTES: usize = 8 << 20;

/// Most numbers in an observation.
pub const MAX_OBSERVATION: usize = 65_536;

/// Most links in an action.
pub const MAX_ACTION_LINKS: usize = 1000;

/// A named run of numbers in the observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservationBlock {
    /// Name, used once: `phase`, `links`.
    pub name: String,
    /// How many numbers.
    pub size: usize,
    /// One line: what they are, with unit and frame.
    pub meaning: String,
}

/// Takes raw observations to the network's scale: `clamp((raw - mean) scale, -clip, clip)`, number by number.
///
/// The same numbers are in the graph, which takes raw observations; here they are for those who go on training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Normaliser {
    /// Subtracted, one for each number of the observation, in its unit.
    pub mean: Vec<f32>,
    /// Multiplied: one over the standard deviation, in one over its unit.
    pub scale: Vec<f32>,
    /// Bound on the size of the result.
    pub clip: f32,
}

/// What the numbers of an action do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ActionMeaning {
    /// Three numbers turn a joint's target away from the reference pose: with o = scale times the numbers, target =
    /// reference times the rotation by `2 atan(|o| / 2)` about o (axes of the child link); for small o its rotation vector, rad.
    #[serde(rename = "offset o on the reference pose's joint target: a turn by 2 atan(|o| / 2) about o, child axes")]
    ReferenceOffset,
}

impl ActionMeaning {
    /// The sentence that stands in the file.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::ReferenceOffset => {
                "offset o on the reference pose's joint target: a turn by 2 atan(|o| / 2) about o, child axes"
            }
        }
    }
}

/// The order and the meaning of the numbers of an action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActionLayout {
    /// What they do.
    pub meaning: ActionMeaning,
    /// Factor on every number, rad.
    pub scale: f64,
    /// Names of the links, three numbers each, in this order.
    pub links: Vec<String>,
    /// Joints whose gains it sets; none by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gains: Option<GainAction>,
}

/// Joints whose servo gains an action sets: its last numbers, one for each, from -1 to 1. The stiffness is multiplied by `factor` to that power, the
/// damping by the root of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainAction {
    /// Names of the links.
    pub links: Vec<String>,
    /// Largest factor on the stiffness, 1 to 100; the smallest is its reciprocal.
    pub factor: f64,
}

impl GainAction {
    /// What cannot be used: the field, what it holds, and what would be valid.
    pub(crate) fn fault(&self) -> Option<(&'static str, String, &'static str)> {
        if self.links.is_empty() || self.links.len() > MAX_ACTION_LINKS {
            return Some(("links", format!("{} links", self.links.len()), "1 to 1000 links"));
        }
        if let Some(name) = first_bad_name(self.links.iter()) {
            return Some(("links", format!("a link named `{}`", shortened(name)), "names, each used once"));
        }
        (!(1.0..=100.0).contains(&self.factor)).then(|| ("factor", self.factor.to_string(), "1 to 100"))
    }
}

/// The motion that the policy follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceFile {
    /// Name of the clip file, which lies in the policy's own folder.
    pub file: String,
    /// [`fingerprint`] of that file. A policy without one may lie beside any file of the name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
    /// Whether it begins again at its end.
    pub cyclic: bool,
}

impl ReferenceFile {
    /// The fingerprint of a motion that is another one than this; `None` where it is the same, or where nobody can tell: without a fingerprint
    /// here, or for a file of another name. Carriage returns, which a checkout may have put in, do not count.
    pub fn other_than(&self, motion: &Path, bytes: &[u8]) -> Option<String> {
        let wanted = self.fingerprint.as_ref().filter(|_| motion.file_name() == Some(self.file.as_ref()))?;
        let plain: Vec<u8> = bytes.iter().copied().filter(|b| *b != b'\r').collect();
        Some(fingerprint(&plain)).filter(|found| found != wanted)
    }
}

/// One raw observation and what the trainer's own network makes of it: the action's mean, before its scale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoldenPair {
    /// Raw observation.
    pub observation: Vec<f32>,
    /// The network's output.
    pub action: Vec<f32>,
}

/// Everything that has to fit before a policy may drive a character.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolicyContract {
    /// Format version, [`CONTRACT_VERSION`].
    pub version: u32,
    /// Version of this crate, or name and version of the program, that wrote the file.
    pub crate_version: String,
    /// Name of the character.
    pub character: String,
    /// The character's numbers as one, see [`fingerprint`](crate::model::CharacterModel::fingerprint), in 16 hexadecimal digits.
    /// A policy without one is compared by links and observation alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub character_fingerprint: Option<String>,
    /// Name of the skill.
    pub skill: String,
    /// The skill's own settings: JSON text, or nothing. See [`PolicyContract::parse_skill_settings`].
    pub skill_settings: String,
    /// Actions per second.
    pub control_rate: f64,
    /// Simulation steps per second in training, a whole multiple of `control_rate`.
    pub simulation_rate: f64,
    /// The observation, block after block.
    pub observation: Vec<ObservationBlock>,
    /// Between the raw observation and the first layer.
    pub normaliser: Normaliser,
    /// The action.
    pub action: ActionLayout,
    /// The motion that is followed.
    pub reference: ReferenceFile,
    /// Stiffness (N m/rad) and damping (N m s/rad) of all servos; `None` takes those of the character file.
    // Without this a file that lacks the field would be read as one that says null.
    #[serde(deserialize_with = "Option::deserialize")]
    pub gains: Option<(f64, f64)>,
    /// Checked against the network whenever the file is loaded.
    pub golden: GoldenPair,
}

/// Why a contract was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContractError {
    /// The text is not JSON, or a field is missing, unknown or of the wrong type.
    #[error("contract, line {line}, column {column}: {reason}")]
    Syntax {
        /// Line of the JSON text, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong and what was expected.
        reason: String,
    },
    /// A field has a value that cannot be used.
    #[error("contract: {field} is {found}; valid: {valid}")]
    Value {
        /// The field.
        field: String,
        /// What it holds.
        found: String,
        /// What would be valid.
        valid: String,
    },
}

impl ContractError {
    fn syntax(error: &serde_json::Error) -> Self {
        let text = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        let reason = text.strip_suffix(&place).unwrap_or(&text).to_owned();
        Self::Syntax { line: error.line(), column: error.column(), reason }
    }
}

fn refuse<T>(field: &str, found: impl ToString, valid: impl ToString) -> Result<T, ContractError> {
    Err(ContractError::Value { field: field.to_owned(), found: found.to_string(), valid: valid.to_string() })
}

impl PolicyContract {
    /// Reads a contract from JSON and checks everything that needs neither the network nor the character.
    pub fn from_json(text: &str) -> Result<Self, ContractError> {
        if text.len() > MAX_CONTRACT_BYTES {
            return refuse("length", format!("{} bytes", text.len()), format!("at most {MAX_CONTRACT_BYTES} bytes"));
        }
        /// Read first: a later version may have fields that this one does not know.
        #[derive(Deserialize)]
        struct Versioned {
            version: u32,
        }
        let versioned: Versioned = serde_json::from_str(text).map_err(|e| ContractError::syntax(&e))?;
        check_version(versioned.version)?;
        let contract: Self = serde_json::from_str(text).map_err(|e| ContractError::syntax(&e))?;
        contract.check()?;
        Ok(contract)
    }

    /// The contract as one line of JSON.
    pub fn to_json(&self) -> Result<String, ContractError> {
        self.check()?;
        serde_json::to_string(self).map_err(|e| ContractError::syntax(&e))
    }

    /// Numbers in an observation.
    pub fn observation_size(&self) -> usize {
        self.observation.iter().map(|b| b.size).fold(0, usize::saturating_add)
    }

    /// Numbers in an action: three for each link, and one for each joint whose gains it sets.
    pub fn action_size(&self) -> usize {
        self.action.links.len() * 3 + self.action.gains.as_ref().map_or(0, |g| g.links.len())
    }

    /// The skill's own settings as a type of the skill's own.
    pub fn parse_skill_settings<T: DeserializeOwned>(&self) -> Result<T, ContractError> {
        serde_json::from_str(&self.skill_settings).map_err(|e| ContractError::Value {
            field: "skill_settings".into(),
            found: e.to_string(),
            valid: format!("the settings of the skill {}", self.skill),
        })
    }

    /// Checks everything that needs neither the network nor the character.
    pub fn check(&self) -> Result<(), ContractError> {
        check_version(self.version)?;
        for (field, name) in
            [("crate_version", &self.crate_version), ("character", &self.character), ("skill", &self.skill)]
        {
            if name.trim().is_empty() || name.len() > 200 {
                return refuse(field, format!("`{}`", shortened(name)), "1 to 200 bytes of text");
            }
        }
        if !self.skill_settings.is_empty()
            && let Err(error) = serde_json::from_str::<serde::de::IgnoredAny>(&self.skill_settings)
        {
            return refuse("skill_settings", error, "JSON text, or nothing");
        }
        let hexadecimal =
            |text: &String| text.len() == 16 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        if let Some(text) = self.character_fingerprint.as_ref().filter(|text| !hexadecimal(text)) {
            return refuse("character_fingerprint", format!("`{}`", shortened(text)), "16 hexadecimal digits");
        }
        self.check_rates()?;
        self.check_observation()?;
        self.check_action()?;
        let file = &self.reference.file;
        if file.trim().is_empty() || file.starts_with('.') || file.contains(['/', '\\', ':', '\0']) || file.len() > 200
        {
            return refuse(
                "reference.file",
                format!("`{}`", shortened(file)),
                "the name of a file in the policy's folder",
            );
        }
        if let Some(text) = self.reference.fingerprint.as_ref().filter(|t| t.trim().is_empty() || t.len() > 200) {
            return refuse("reference.fingerprint", format!("`{}`", shortened(text)), "1 to 200 bytes of text");
        }
        if let Some((kp, kd)) = self.gains
            && !(kp.is_finite() && kd.is_finite() && kp >= 0.0 && kd >= 0.0)
        {
            return refuse("gains", format!("({kp}, {kd})"), "two finite numbers, not negative");
        }
        numbers("golden.observation", &self.golden.observation, self.observation_size(), f32::is_finite, "finite")?;
        numbers("golden.action", &self.golden.action, self.action_size(), f32::is_finite, "finite")
    }

    fn check_rates(&self) -> Result<(), ContractError> {
        let (control, simulation) = (self.control_rate, self.simulation_rate);
        if !(1.0..=2000.0).contains(&control) {
            return refuse("control_rate", control, "1 to 2000 per second");
        }
        if !(control..=20_000.0).contains(&simulation) {
            return refuse("simulation_rate", simulation, format!("{control} (the control rate) to 20000 per second"));
        }
        let steps = simulation / control;
        if (steps - steps.round()).abs() > 1e-9 * steps {
            return refuse("simulation_rate", simulation, format!("a whole multiple of the control rate {control}"));
        }
        Ok(())
    }

    fn check_observation(&self) -> Result<(), ContractError> {
        if let Some(name) = first_bad_name(self.observation.iter().map(|b| &b.name)) {
            return refuse("observation", format!("a block named `{}`", shortened(name)), "names, each used once");
        }
        if let Some(block) = self.observation.iter().find(|b| b.size == 0) {
            return refuse("observation", format!("block `{}` of size 0", block.name), "at least 1");
        }
        let size = self.observation_size();
        if !(1..=MAX_OBSERVATION).contains(&size) {
            return refuse("observation", format!("{size} numbers"), format!("1 to {MAX_OBSERVATION}"));
        }
        let Normaliser { mean, scale, clip } = &self.normaliser;
        numbers("normaliser.mean", mean, size, f32::is_finite, "finite")?;
        numbers("normaliser.scale", scale, size, |v| v.is_finite() && v > 0.0, "finite and positive")?;
        if !(clip.is_finite() && *clip > 0.0) {
            return refuse("normaliser.clip", clip, "finite and positive");
        }
        Ok(())
    }

    fn check_action(&self) -> Result<(), ContractError> {
        let ActionLayout { scale, links, gains, .. } = &self.action;
        if let Some((field, found, valid)) = gains.as_ref().and_then(GainAction::fault) {
            return refuse(&format!("action.gains.{field}"), found, valid);
        }
        if !(scale.is_finite() && *scale > 0.0 && *scale <= 10.0) {
            return refuse("action.scale", scale, "above 0, at most 10 rad");
        }
        if !(1..=MAX_ACTION_LINKS).contains(&links.len()) {
            return refuse("action.links", format!("{} links", links.len()), format!("1 to {MAX_ACTION_LINKS}"));
        }
        if let Some(name) = first_bad_name(links.iter()) {
            return refuse("action.links", format!("a link named `{}`", shortened(name)), "names, each used once");
        }
        Ok(())
    }
}

fn check_version(version: u32) -> Result<(), ContractError> {
    if version != CONTRACT_VERSION {
        return refuse("version", version, format!("{CONTRACT_VERSION}, the one this program reads"));
    }
    Ok(())
}

/// A name that is blank, overlong, or there for the second time.
fn first_bad_name<'a>(names: impl Iterator<Item = &'a String>) -> Option<&'a String> {
    let mut seen = BTreeSet::new();
    names.into_iter().find(|name| name.trim().is_empty() || name.len() > 200 || !seen.insert(name.as_str()))
}

/// The beginning of a text that may be anything.
fn shortened(text: &str) -> String {
    text.chars().take(60).collect()
}

fn numbers(field: &str, values: &[f32], size: usize, good: fn(f32) -> bool, valid: &str) -> Result<(), ContractError> {
    if values.len() != size {
        return refuse(field, format!("{} numbers", values.len()), format!("{size}, as the layout says"));
    }
    match values.iter().position(|v| !good(*v)) {
        Some(k) => refuse(&format!("{field}[{k}]"), values[k], valid),
        None => Ok(()),
    }
}
