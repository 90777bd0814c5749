//! Wrong arguments: the option as it is typed, what was given, what would be valid. One way to say it for all commands.

use super::{InputError, PerformError, PolicyFolderError, SkillInputError};
use std::error::Error;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Exit code of a command that failed.
pub const FAILED: u8 = 1;
/// Exit code of a command that was given wrong arguments.
pub const WRONG_ARGUMENTS: u8 = 2;
/// Exit code of a command that Ctrl-C stopped: 128 and the number of the signal, as shells have it.
pub const STOPPED: u8 = 130;

/// Ctrl-C stopped a command, and there is nothing that it could show; what it saved is named.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped: {0}")]
pub struct Stopped(pub String);

/// An option that cannot be used as it was given.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{option} {found}: valid is {valid}")]
pub struct ArgumentError {
    /// The option as it is typed: `--seconds`.
    pub option: String,
    /// What was given.
    pub found: String,
    /// What would be valid, in words.
    pub valid: String,
}

impl ArgumentError {
    /// An option, what was given, and what would be valid.
    pub fn new(option: impl Display, found: impl Display, valid: impl Display) -> Self {
        Self { option: option.to_string(), found: found.to_string(), valid: valid.to_string() }
    }
}

/// The number of an option, if it lies within bounds; a NaN does not. `unit` is written after the bounds: `s`.
pub fn within<T: PartialOrd + Display + Copy>(
    option: &str,
    value: T,
    bounds: RangeInclusive<T>,
    unit: &str,
) -> Result<T, ArgumentError> {
    if bounds.contains(&value) {
        return Ok(value);
    }
    let valid = format!("{} to {} {unit}", bounds.start(), bounds.end());
    Err(ArgumentError::new(option, value, valid.trim_end()))
}

/// The number of threads: what was asked for, or one for each core.
pub fn threads(asked: Option<usize>) -> Result<usize, ArgumentError> {
    within("--threads", asked.unwrap_or_else(crate::train::default_threads), 1..=256, "")
}

/// The code with which a command ends that failed this way: 2 where an argument was wrong, 130 where Ctrl-C stopped it, else 1.
pub fn exit_code(error: &(dyn Error + 'static)) -> u8 {
    let named = |error: &InputError| {
        matches!(
            error,
            InputError::NoCharacter { .. }
                | InputError::NoSkill { .. }
                | InputError::Kind { .. }
                | InputError::World { .. }
                | InputError::Push { .. }
        )
    };
    let wrong = error.is::<ArgumentError>()
        || error.downcast_ref::<InputError>().is_some_and(named)
        || match error.downcast_ref::<PerformError>() {
            Some(PerformError::Option { .. }) => true,
            Some(PerformError::Input(input)) => named(input),
            _ => false,
        }
        || match error.downcast_ref::<SkillInputError>() {
            Some(SkillInputError::NotFound { .. } | SkillInputError::Motion { .. }) => true,
            Some(SkillInputError::Input(input)) => named(input),
            _ => false,
        }
        || matches!(error.downcast_ref::<PolicyFolderError>(), Some(PolicyFolderError::Input(input)) if named(input));
    if wrong {
        WRONG_ARGUMENTS
    } else if error.is::<Stopped>() {
        STOPPED
    } else {
        FAILED
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_bounds_are_named_with_their_option() {
        assert_eq!(within("--seconds", 3.0, 0.0..=3600.0, "s"), Ok(3.0));
        let error = within("--seconds", f64::NAN, 0.0..=3600.0, "s").unwrap_err();
        assert_eq!(error.to_string(), "--seconds NaN: valid is 0 to 3600 s");
        assert_eq!(threads(Some(0)).unwrap_err().to_string(), "--threads 0: valid is 1 to 256");
        assert_eq!(exit_code(&error), WRONG_ARGUMENTS);
        assert_eq!(exit_code(&std::io::Error::other("disk")), FAILED);
        assert_eq!(exit_code(&Stopped("nothing was found".into())), STOPPED);
        let world = "moon".parse::<crate::cli::WorldSpec>().unwrap_err();
        assert_eq!(exit_code(&world), WRONG_ARGUMENTS);
    }
}
