//! Values for the parameters of skills, by name: what a game sets, and what a skill makes of it.

use crate::asset::{StateError, StateReader, StateWriter};
use crate::skill::SkillDefinition;

/// Values for the parameters of skills, by name, each in the unit that the skill file has it in. A parameter that is not among them has
/// the value that the motion was made for ([`SkillDefinition::default_parameters`]).
///
/// ```
/// use bevy_athlete::skill::SkillParameters;
///
/// let wished = SkillParameters::default().with("height", 0.45).with("distance", 3.0);
/// assert_eq!(wished.get("height"), Some(0.45));
/// ```
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "engine", derive(bevy::reflect::Reflect))]
pub struct SkillParameters {
    /// Sorted by name.
    values: Vec<(String, f64)>,
}

/// Two are equal where they have the same names with the same bits.
impl PartialEq for SkillParameters {
    fn eq(&self, other: &Self) -> bool {
        let same = |(a, b): (&(String, f64), &(String, f64))| a.0 == b.0 && a.1.to_bits() == b.1.to_bits();
        self.values.len() == other.values.len() && self.values.iter().zip(&other.values).all(same)
    }
}

impl SkillParameters {
    /// Most of them that a snapshot holds.
    const MOST: usize = 1024;

    /// The same with this value.
    pub fn with(mut self, name: &str, value: f64) -> Self {
        self.set(name, value);
        self
    }
    /// Sets a value. A name that is there already costs no allocation.
    pub fn set(&mut self, name: &str, value: f64) {
        match self.place(name) {
            Ok(at) => self.values[at].1 = value,
            Err(at) => self.values.insert(at, (name.to_owned(), value)),
        }
    }
    /// The value of a name; `None` where it is not set.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.place(name).ok().map(|at| self.values[at].1)
    }
    /// Takes a value out.
    pub fn remove(&mut self, name: &str) -> Option<f64> {
        self.place(name).ok().map(|at| self.values.remove(at).1)
    }
    /// Takes all out.
    pub fn clear(&mut self) {
        self.values.clear();
    }
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
    /// Names and values, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.values.iter().map(|(name, value)| (name.as_str(), *value))
    }

    fn place(&self, name: &str) -> Result<usize, usize> {
        self.values.binary_search_by(|(other, _)| other.as_str().cmp(name))
    }

    /// All of them.
    pub(crate) fn write_state(&self, out: &mut StateWriter) {
        // What would not be read is not written: it is no skill's.
        let kept = || self.iter().filter(|(name, _)| name.len() <= StateReader::MAX_TEXT).take(Self::MOST);
        out.count(kept().count());
        for (name, value) in kept() {
            out.text(name);
            out.number(value);
        }
    }
    /// As they were written.
    pub(crate) fn read_state(from: &mut StateReader) -> Result<Self, StateError> {
        let mut read = Self::default();
        for _ in 0..from.below("number of parameters", Self::MOST + 1)? {
            let name = from.text("name of a parameter")?;
            read.set(&name, from.number("parameter")?);
        }
        Ok(read)
    }
}

/// Why a parameter has not the value that was wished for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "engine", derive(bevy::reflect::Reflect))]
#[non_exhaustive]
pub enum BadParameter {
    /// No skill that may play has one of this name.
    #[error("no skill has it; valid: {}", if known.is_empty() { "none, the skills have no parameters".to_owned() } else { known.join(", ") })]
    Unknown {
        /// The parameters that the skills have.
        known: Vec<String>,
    },
    /// It is out of the skill's range; the nearest end of the range is taken.
    #[error("{value}; valid: {low} to {high}, of which the nearest is taken")]
    OutOfRange {
        /// What was wished for.
        value: f64,
        /// The lowest value.
        low: f64,
        /// The highest value.
        high: f64,
    },
    /// It is no number; the value that the motion was made for is taken.
    #[error("no number; {taken} is taken")]
    NotANumber {
        /// The value that is taken.
        taken: f64,
    },
}

impl SkillDefinition {
    /// The value that each parameter has where nothing else is said: the one that the motion was made for (of the first warp by it), or
    /// the middle of its range.
    pub fn default_parameters(&self) -> Vec<f64> {
        let default = |name: &str, (low, high): (f64, f64)| {
            let neutral = self.warps.iter().find(|warp| warp.parameter == name).map(|warp| warp.neutral);
            neutral.unwrap_or(0.5 * (low + high)).min(high).max(low)
        };
        self.parameters.iter().map(|p| default(&p.name, p.range)).collect()
    }

    /// The values of the parameters under these wishes, in the order of the file; each wish that cannot be met is told with its name.
    pub fn choose_parameters(&self, wished: &SkillParameters, mut tell: impl FnMut(&str, BadParameter)) -> Vec<f64> {
        let mut values = self.default_parameters();
        for (value, parameter) in values.iter_mut().zip(&self.parameters) {
            let (low, high) = parameter.range;
            match wished.get(&parameter.name) {
                None => {}
                Some(wish) if wish.is_finite() => {
                    *value = wish.min(high).max(low);
                    if *value != wish {
                        tell(&parameter.name, BadParameter::OutOfRange { value: wish, low, high });
                    }
                }
                Some(_) => tell(&parameter.name, BadParameter::NotANumber { taken: *value }),
            }
        }
        values
    }
}
