//! Which vector instructions the products use.
//!
//! The best that the processor has are found at run time. `ATHLETE_SIMD` asks for others, to compare: `scalar`, `avx2` or
//! `avx512` on x86. AVX2 and AVX-512 give the same bits, so a training may go on under either.

use pulp::Arch;
use std::sync::atomic::{AtomicU8, Ordering};

/// The environment variable that asks for instructions by name.
pub const INSTRUCTIONS_VARIABLE: &str = "ATHLETE_SIMD";

/// Instructions were asked for that this processor or this crate does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{INSTRUCTIONS_VARIABLE}: `{found}` are no vector instructions that can be used here; valid: {valid}")]
pub struct InstructionsError {
    /// What was asked for.
    pub found: String,
    /// Names of those that can be used here.
    pub valid: String,
}

/// The instructions that this processor has, from the slowest on, with their names.
fn known() -> Vec<(&'static str, Arch)> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        let mut known = vec![("scalar", Arch::Scalar)];
        known.extend(pulp::x86::V3::try_new().map(|simd| ("avx2", Arch::V3(simd))));
        known.extend(pulp::x86::V4::try_new().map(|simd| ("avx512", Arch::V4(simd))));
        known
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    vec![("native", Arch::new())]
}

/// Names of the vector instructions that this processor has, from the slowest on.
pub fn known_instructions() -> Vec<&'static str> {
    known().into_iter().map(|(name, _)| name).collect()
}

/// Not chosen yet.
const OPEN: u8 = u8::MAX;
/// The place in [`known`] of the instructions in use.
static CHOSEN: AtomicU8 = AtomicU8::new(OPEN);

/// The place in [`known`] of what is asked for; of the best where nothing is.
fn place_of(asked: Option<&str>) -> Result<u8, InstructionsError> {
    let names = known_instructions();
    let place = match asked {
        Some(asked) => names.iter().position(|name| *name == asked),
        None => names.len().checked_sub(1),
    };
    let valid = || names.join(", ");
    let refused = || InstructionsError { found: asked.unwrap_or_default().to_owned(), valid: valid() };
    place.map(|place| place as u8).ok_or_else(refused)
}

/// Uses the instructions of this name from now on, or the best there are; in all threads.
pub fn use_instructions(name: Option<&str>) -> Result<(), InstructionsError> {
    CHOSEN.store(place_of(name)?, Ordering::Relaxed);
    Ok(())
}

/// What [`INSTRUCTIONS_VARIABLE`] asks for.
fn asked() -> Option<String> {
    std::env::var_os(INSTRUCTIONS_VARIABLE).map(|value| value.to_string_lossy().into_owned()).filter(|v| !v.is_empty())
}

/// The name of the instructions in use, or why those that [`INSTRUCTIONS_VARIABLE`] asks for cannot be; then the best are used.
pub fn instructions() -> Result<&'static str, InstructionsError> {
    if CHOSEN.load(Ordering::Relaxed) == OPEN {
        place_of(asked().as_deref())?;
    }
    Ok(known()[place() as usize].0)
}

fn place() -> u8 {
    match CHOSEN.load(Ordering::Relaxed) {
        OPEN => {
            let best = known().len() as u8 - 1;
            let place = place_of(asked().as_deref()).unwrap_or(best);
            CHOSEN.store(place, Ordering::Relaxed);
            place
        }
        place => place,
    }
}

/// The instructions in use.
pub(super) fn arch() -> Arch {
    let place = place();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        // Detection is cached; nothing is allocated here.
        let avx2 = || pulp::x86::V3::try_new().map(Arch::V3);
        let avx512 = || pulp::x86::V4::try_new().map(Arch::V4);
        match place {
            0 => Arch::Scalar,
            1 => avx2().unwrap_or(Arch::Scalar),
            _ => avx512().unwrap_or(Arch::Scalar),
        }
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    {
        let _ = place;
        Arch::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instructions_that_are_not_there_are_refused_by_name() {
        let names = known_instructions();
        assert_eq!(place_of(None).unwrap() as usize, names.len() - 1, "the best");
        for (place, name) in names.iter().enumerate() {
            assert_eq!(place_of(Some(name)).unwrap() as usize, place);
        }
        let refused = place_of(Some("sse9")).unwrap_err().to_string();
        assert!(
            refused.contains("ATHLETE_SIMD") && refused.contains("`sse9`") && refused.contains(names[0]),
            "{refused}"
        );
    }
}
