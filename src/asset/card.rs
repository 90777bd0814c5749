//! Robustness cards: how often a policy succeeded, under what, with how much doubt. Written by the evaluator, never by
//! hand.

use super::read_file::read_text;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The format version that this crate writes and reads.
pub const CARD_VERSION: u32 = 1;

/// Largest card, bytes.
pub const MAX_CARD_BYTES: u64 = 1 << 20;

/// One kind of trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CardRow {
    /// Name, used once: `no pushes`, `200 N`.
    pub name: String,
    /// Trials made; all count.
    pub trials: u64,
    /// Trials that met the skill's own rule.
    pub successes: u64,
    /// Lower bound of the success rate, 95 % by [`wilson_interval`].
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

impl CardRow {
    /// A row with its interval.
    pub fn new(name: impl Into<String>, trials: u64, successes: u64) -> Self {
        let (low, high) = wilson_interval(successes, trials);
        Self { name: name.into(), trials, successes, low, high }
    }

    /// Share of the trials that succeeded; NaN without trials.
    pub fn rate(&self) -> f64 {
        self.successes as f64 / self.trials as f64
    }
}

/// What an evaluation found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobustnessCard {
    /// Format version, [`CARD_VERSION`].
    pub version: u32,
    /// The skill.
    pub skill: String,
    /// The character.
    pub character: String,
    /// [`fingerprint`] of the policy file.
    pub policy: String,
    /// Version of this crate.
    pub crate_version: String,
    /// Seed of the trials.
    pub seed: u64,
    /// Trials in all rows together.
    pub trials: u64,
    /// One row for each kind of trial.
    pub rows: Vec<CardRow>,
    /// Figures of motion quality by name, the unit in the name: `slip_m_per_s`.
    pub quality: BTreeMap<String, f64>,
    /// The command that made this card.
    pub command: String,
}

/// Why a card was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CardError {
    /// The file could not be read or written.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The text is not JSON, or a field is missing, unknown or of the wrong type.
    #[error("card, line {line}, column {column}: {reason}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong and what was expected.
        reason: String,
    },
    /// Numbers that no evaluation gives, or a missing name.
    #[error("card: {place}: {found}; valid: {valid}")]
    Value {
        /// Row or field.
        place: String,
        /// What it holds.
        found: String,
        /// What would be valid.
        valid: String,
    },
}

fn refuse(place: impl ToString, found: impl ToString, valid: impl ToString) -> Result<(), CardError> {
    Err(CardError::Value { place: place.to_string(), found: found.to_string(), valid: valid.to_string() })
}

/// The name in [`RobustnessCard::quality`] of a row's mean reward of a decision.
pub(crate) fn reward_name(row: &str) -> String {
    format!("reward_per_step, {row}")
}

impl RobustnessCard {
    /// Share of the trials of all rows that succeeded; NaN without trials.
    pub fn rate(&self) -> f64 {
        self.rows.iter().map(|row| row.successes).sum::<u64>() as f64 / self.trials as f64
    }

    /// Mean reward of a decision over the trials of all rows; `None` where a row's was not measured.
    pub fn reward_per_step(&self) -> Option<f64> {
        let rewards = self.rows.iter().map(|row| Some(row.trials as f64 * self.quality.get(&reward_name(&row.name))?));
        Some(rewards.sum::<Option<f64>>()? / self.trials as f64)
    }

    /// Checks that the counts fit each other and the intervals fit the counts.
    pub fn check(&self) -> Result<(), CardError> {
        if self.version != CARD_VERSION {
            return refuse("version", self.version, format!("{CARD_VERSION}, the one this program reads"));
        }
        for (place, text) in [
            ("skill", &self.skill),
            ("character", &self.character),
            ("policy", &self.policy),
            ("crate_version", &self.crate_version),
            ("command", &self.command),
        ] {
            if text.trim().is_empty() {
                return refuse(place, "empty", "a text");
            }
        }
        if self.rows.is_empty() {
            return refuse("rows", "none", "at least one");
        }
        let mut names = BTreeSet::new();
        for row in &self.rows {
            let place = format!("row `{}`", row.name);
            if row.name.trim().is_empty() || !names.insert(row.name.as_str()) {
                return refuse(place, "blank or there twice", "a name used once");
            }
            if row.trials == 0 || row.successes > row.trials {
                let found = format!("{} successes in {} trials", row.successes, row.trials);
                return refuse(place, found, "at least one trial, no more successes than trials");
            }
            let (low, high) = wilson_interval(row.successes, row.trials);
            // Not `>`, which a NaN would pass.
            if !((row.low - low).abs() <= 1e-9 && (row.high - high).abs() <= 1e-9) {
                return refuse(place, format!("{} to {}", row.low, row.high), format!("{low} to {high}"));
            }
        }
        let sum = self.rows.iter().fold(0u64, |sum, row| sum.saturating_add(row.trials));
        if sum != self.trials {
            return refuse("trials", self.trials, format!("{sum}, the sum of the rows"));
        }
        match self.quality.iter().find(|(name, value)| name.trim().is_empty() || !value.is_finite()) {
            Some((name, value)) => refuse(format!("quality `{name}`"), value, "a name and a finite number"),
            None => Ok(()),
        }
    }

    /// Reads a card from JSON and checks it.
    pub fn from_json(text: &str) -> Result<Self, CardError> {
        let card: Self = serde_json::from_str(text).map_err(|e| CardError::Syntax {
            line: e.line(),
            column: e.column(),
            reason: e.to_string(),
        })?;
        card.check()?;
        Ok(card)
    }

    /// The card as JSON, readable, after a check.
    pub fn to_json(&self) -> Result<String, CardError> {
        self.check()?;
        serde_json::to_string_pretty(self).map(|text| text + "\n").map_err(|e| CardError::Syntax {
            line: e.line(),
            column: e.column(),
            reason: e.to_string(),
        })
    }

    /// Reads a card file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, CardError> {
        let path = path.as_ref();
        let failed = |reason: String| CardError::File { path: path.to_path_buf(), reason };
        Self::from_json(&read_text(path, MAX_CARD_BYTES).map_err(|e| failed(e.fault.to_string()))?)
    }

    /// Writes a card file.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), CardError> {
        let path = path.as_ref();
        std::fs::write(path, self.to_json()?)
            .map_err(|e| CardError::File { path: path.to_path_buf(), reason: e.to_string() })
    }
}

/// The 95 % confidence interval of a success rate: the score interval of Wilson 1927, "Probable inference, the law of
/// succession, and statistical inference". Where the plain interval p +- z sqrt(p (1 - p) / n) claims certainty at 0 or
/// n successes, this one does not.
///
/// With p = successes / n and z = 1.95996 the bounds are (p + z^2/2n -+ z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n),
/// both in \[0, 1\]. Without trials nothing is known: (0, 1). More successes than trials count as all.
pub fn wilson_interval(successes: u64, trials: u64) -> (f64, f64) {
    /// The normal distribution's 97.5 % point.
    const Z: f64 = 1.959_963_984_540_054;
    if trials == 0 {
        return (0.0, 1.0);
    }
    let n = trials as f64;
    let p = successes.min(trials) as f64 / n;
    let z2 = Z * Z / n;
    let center = (p + 0.5 * z2) / (1.0 + z2);
    let half = (Z / (1.0 + z2)) * (p * (1.0 - p) / n + 0.25 * z2 / n).sqrt();
    // At the ends the exact bounds are 0 and 1; rounding must not say otherwise.
    let low = if successes == 0 { 0.0 } else { (center - half).max(0.0) };
    let high = if successes >= trials { 1.0 } else { (center + half).min(1.0) };
    (low, high)
}

/// A file's fingerprint: length and 64-bit FNV-1a hash (Fowler, Noll, Vo 1991) as text. It tells files apart; it is no
/// seal against a forger.
pub fn fingerprint(bytes: &[u8]) -> String {
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
    format!("fnv1a64-{}-{hash:016x}", bytes.len())
}
