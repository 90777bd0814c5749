//! Why a course file is refused: each error names the file, the place in it, the value found and what would be valid.

use crate::asset::AssetError;
use thiserror::Error;

/// Why a file or a choice of parameters makes no course.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CourseError {
    /// The file could not become data.
    #[error(transparent)]
    File(#[from] AssetError),
    /// A number is out of its range, with these values of the parameters.
    #[error("{file}: {place}: {field} is {value}; valid: {valid}")]
    Value {
        /// File name as given.
        file: Box<str>,
        /// Which part of the course, such as `solid 2 (Box)`.
        place: Box<str>,
        /// Field of it.
        field: &'static str,
        /// Value found.
        value: Box<str>,
        /// What would be valid.
        valid: Box<str>,
    },
    /// A parameter or material that there is not.
    #[error("{file}: {place}: {field} `{name}` is unknown; valid: {valid}")]
    Name {
        /// File name as given.
        file: Box<str>,
        /// Which part of the course.
        place: Box<str>,
        /// What is named.
        field: &'static str,
        /// The name.
        name: Box<str>,
        /// What would be valid.
        valid: Box<str>,
    },
    /// A name that is used twice.
    #[error("{file}: {what} `{name}` comes twice; valid: a name used once")]
    Duplicate {
        /// File name as given.
        file: Box<str>,
        /// What it names.
        what: &'static str,
        /// The name.
        name: Box<str>,
    },
    /// A list is longer than any sensible one.
    #[error("{file}: {count} {what}; valid: at most {most}")]
    Count {
        /// File name as given.
        file: Box<str>,
        /// What the list holds.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// Most.
        most: usize,
    },
    /// Parts that do not go together.
    #[error("{file}: {place}: {reason}; valid: {valid}")]
    Together {
        /// File name as given.
        file: Box<str>,
        /// Which part of the course.
        place: Box<str>,
        /// What is wrong.
        reason: &'static str,
        /// What would be valid.
        valid: &'static str,
    },
}
