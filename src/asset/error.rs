//! Typed errors of loading: each names the file, the place in it, the value found and what would be valid.

use thiserror::Error;

/// Why a file could not become data.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AssetError {
    /// The file could not be read.
    #[error("{file}: cannot be read: {reason}")]
    Read {
        /// File name as given.
        file: String,
        /// The operating system's reason.
        reason: String,
    },
    /// The file is larger than any sensible one.
    #[error("{file}: {bytes} bytes; valid: at most {limit} bytes")]
    TooLarge {
        /// File name as given.
        file: String,
        /// Size found, bytes.
        bytes: u64,
        /// Largest size, bytes.
        limit: u64,
    },
    /// The bytes are not UTF-8 text.
    #[error("{file}: byte {at} is not UTF-8 text")]
    NotText {
        /// File name as given.
        file: String,
        /// Offset of the first bad byte.
        at: usize,
    },
    /// The text is not the format, or a field is missing, unknown or of the wrong type.
    #[error("{file}:{line}:{column}: {reason}")]
    Syntax {
        /// File name as given.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong and what was expected.
        reason: String,
    },
    /// The text is well formed but describes no possible character.
    #[error(transparent)]
    Character(#[from] CharacterError),
}

/// Why a description is not a possible character.
///
/// `part` says what kind of entry is at fault (`link`, `contact point`, `blade`, `grip`, `character`), `name` which one.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CharacterError {
    /// A field holds a value outside its range.
    #[error("{file}: {part} `{name}`: {field} is {value}; valid: {valid}")]
    Value {
        /// File name as given.
        file: Box<str>,
        /// Kind of entry.
        part: &'static str,
        /// Name of the entry.
        name: Box<str>,
        /// Field of the entry.
        field: &'static str,
        /// Value found.
        value: Box<str>,
        /// What would be valid.
        valid: Box<str>,
    },
    /// Two entries of one kind have the same name.
    #[error("{file}: {part} `{name}`: name is used by entries {first} and {second}; valid: a name used once")]
    Duplicate {
        /// File name as given.
        file: Box<str>,
        /// Kind of entry.
        part: &'static str,
        /// The name.
        name: Box<str>,
        /// Position of the first entry, from 1.
        first: usize,
        /// Position of the second entry, from 1.
        second: usize,
    },
    /// A link names a parent that does not exist.
    #[error("{file}: link `{link}`: parent is `{parent}`; valid: {valid}")]
    UnknownParent {
        /// File name as given.
        file: Box<str>,
        /// The link.
        link: Box<str>,
        /// The parent it names.
        parent: Box<str>,
        /// What would be valid.
        valid: Box<str>,
    },
    /// A contact point, blade, grip or exclusion names a link that does not exist.
    #[error("{file}: {part} `{name}`: link is `{link}`; valid: {valid}")]
    UnknownLink {
        /// File name as given.
        file: Box<str>,
        /// Kind of entry.
        part: &'static str,
        /// Name of the entry.
        name: Box<str>,
        /// The link it names.
        link: Box<str>,
        /// What would be valid.
        valid: Box<str>,
    },
    /// Following parents leads back to the start.
    #[error("{file}: link `{link}`: parent chain is a cycle ({chain}); valid: every chain of parents ends at the root")]
    Cycle {
        /// File name as given.
        file: Box<str>,
        /// A link on the cycle.
        link: Box<str>,
        /// The names along the cycle.
        chain: Box<str>,
    },
    /// There is no link without a parent, or more than one.
    #[error("{file}: {count} links without a parent ({roots}); valid: exactly one, the root")]
    Roots {
        /// File name as given.
        file: Box<str>,
        /// How many there are.
        count: usize,
        /// Their names.
        roots: Box<str>,
    },
    /// No solid body has this inertia.
    #[error(
        "{file}: link `{link}`: inertia has principal moments {} kg m^2; valid: all three positive, \
         none above the sum of the other two", moments(.principal)
    )]
    Inertia {
        /// File name as given.
        file: Box<str>,
        /// The link.
        link: Box<str>,
        /// Principal moments found, ascending, kg m^2.
        principal: [f64; 3],
    },
    /// A list is longer than any sensible one, or empty where it may not be.
    #[error("{file}: {count} {what}; valid: {valid}")]
    Count {
        /// File name as given.
        file: Box<str>,
        /// What the list holds.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// What would be valid.
        valid: Box<str>,
    },
}

/// Principal moments in a readable number of digits.
fn moments(principal: &[f64; 3]) -> String {
    format!("({:.4e}, {:.4e}, {:.4e})", principal[0], principal[1], principal[2])
}
