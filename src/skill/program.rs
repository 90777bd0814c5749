//! Program files: one skill after the other.

use crate::asset::read_file::read_text;
use crate::skill::GraphError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A program, as saved in a `*.program.ron` file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgramDefinition {
    /// Its name.
    pub name: String,
    /// The character that performs it.
    pub character: String,
    /// What is performed, in order.
    pub elements: Vec<ProgramElement>,
}

/// One element of a program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgramElement {
    /// Name of the skill.
    pub skill: String,
    /// Shortest time, s, of a skill that repeats; it goes on to where the next element can begin. A skill that ends is
    /// performed once.
    #[serde(default)]
    pub seconds: f64,
    /// Commanded mean speed, m/s; by default the one at its beginning.
    #[serde(default)]
    pub speed: Option<f64>,
    /// Turns the way of a skill that repeats by so much, degrees per second, positive to the left.
    #[serde(default)]
    pub steering: f64,
}

/// Why a program cannot be performed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProgramError {
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The text is not a program.
    #[error("{}: not a program: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Where and why.
        message: String,
    },
    /// A value cannot be used.
    #[error("program {program}: {place}: {found}; valid: {valid}")]
    Value {
        /// The program.
        program: String,
        /// Element and field.
        place: String,
        /// What it holds.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// Its skills make no graph.
    #[error("program {program}: {source}")]
    Graph {
        /// The program.
        program: String,
        /// Why.
        source: GraphError,
    },
}

/// Largest file of a program, bytes.
const MAX_PROGRAM_BYTES: u64 = 1 << 20;

impl ProgramDefinition {
    /// Reads a file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ProgramError> {
        let path = path.as_ref();
        let text =
            read_text(path, MAX_PROGRAM_BYTES).map_err(|e| ProgramError::Io { path: path.into(), source: e.into() })?;
        Self::from_ron(&text, path)
    }

    /// Reads text; `path` is for messages.
    pub fn from_ron(text: &str, path: impl AsRef<Path>) -> Result<Self, ProgramError> {
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let program: Self = options
            .from_str(text)
            .map_err(|e| ProgramError::Syntax { path: path.as_ref().into(), message: e.to_string() })?;
        program.validate()?;
        Ok(program)
    }

    /// Whether every number can be used.
    pub fn validate(&self) -> Result<(), ProgramError> {
        if self.elements.is_empty() {
            return self.refuse("elements", "none", "at least one");
        }
        for (k, e) in self.elements.iter().enumerate() {
            let place = |field: &str| format!("element {} ({}), {field}", k + 1, e.skill);
            if !(0.0..=3600.0).contains(&e.seconds) {
                return self.refuse(&place("seconds"), e.seconds, "0 to 3600 s");
            }
            if e.speed.is_some_and(|v| !(0.0..=30.0).contains(&v)) {
                return self.refuse(&place("speed"), format!("{:?}", e.speed), "0 to 30 m/s");
            }
            if !(-90.0..=90.0).contains(&e.steering) {
                return self.refuse(&place("steering"), e.steering, "-90 to 90 degrees per second");
            }
        }
        Ok(())
    }

    fn refuse(&self, place: &str, found: impl ToString, valid: &str) -> Result<(), ProgramError> {
        let (program, place) = (self.name.clone(), place.to_owned());
        Err(ProgramError::Value { program, place, found: found.to_string(), valid: valid.to_owned() })
    }
}
