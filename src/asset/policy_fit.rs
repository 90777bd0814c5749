//! Whether a policy's contract is what would be played.
//!
//! One comparison for the command line, for training and for a game: whoever plays a policy says what it would play in a
//! [`PolicyUse`], and the first difference is named. Names of skill and character do not matter, the numbers do.

use crate::asset::policy_contract::{CONTRACT_VERSION, GainAction, ObservationBlock, PolicyContract};

/// What would be played with a policy: by the skill's description and the body.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyUse {
    /// What the policy would be shown, block after block.
    pub observation: Vec<ObservationBlock>,
    /// Names of the links that would be told, three numbers each, in order.
    pub links: Vec<String>,
    /// Factor on every number of the action, rad.
    pub action_scale: f64,
    /// Joints whose gains would be told.
    pub gain_action: Option<GainAction>,
    /// Actions per second.
    pub control_rate: f64,
    /// Stiffness (N m/rad) and damping (N m s/rad) of all servos; `None` for those of the character file.
    pub gains: Option<(f64, f64)>,
    /// Whether the motion that is followed begins again at its end.
    pub cyclic: bool,
    /// [`fingerprint`](crate::model::CharacterModel::fingerprint) of the body.
    pub character_fingerprint: u64,
}

/// The first field of a contract that is not what would be played.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field} is {found}; valid: {valid}")]
pub struct PolicyMisfit {
    /// The field: `action.scale`.
    pub field: String,
    /// What the contract says.
    pub found: String,
    /// What would be played.
    pub valid: String,
}

fn misfit(field: impl ToString, found: impl ToString, valid: impl ToString) -> Result<(), PolicyMisfit> {
    Err(PolicyMisfit { field: field.to_string(), found: found.to_string(), valid: valid.to_string() })
}

/// A fingerprint as contracts write it: 16 hexadecimal digits.
pub fn fingerprint_text(fingerprint: u64) -> String {
    format!("{fingerprint:016x}")
}

impl PolicyContract {
    /// Checks that the policy can be played as `played` says: all that it was learnt with is there and is the same.
    pub fn check_played(&self, played: &PolicyUse) -> Result<(), PolicyMisfit> {
        self.check_numbers(played)?;
        if self.control_rate != played.control_rate {
            let text = |rate: f64| format!("{rate} actions per second");
            return misfit("control_rate", text(self.control_rate), text(played.control_rate));
        }
        if self.gains != played.gains {
            let text = |gains: Option<(f64, f64)>| match gains {
                Some((kp, kd)) => format!("{kp} N m/rad, {kd} N m s/rad"),
                None => "null (those of the character)".into(),
            };
            return misfit("gains", text(self.gains), text(played.gains));
        }
        if self.reference.cyclic != played.cyclic {
            return misfit("reference.cyclic", self.reference.cyclic, played.cyclic);
        }
        match &self.character_fingerprint {
            Some(found) if *found != fingerprint_text(played.character_fingerprint) => {
                let valid = format!("{}, that of this body", fingerprint_text(played.character_fingerprint));
                misfit("character_fingerprint", found, valid)
            }
            _ => Ok(()),
        }
    }

    /// Checks that observation and action mean the same numbers: what a training that goes on from the policy needs. Rates,
    /// gains, body and motion may be others.
    pub fn check_numbers(&self, played: &PolicyUse) -> Result<(), PolicyMisfit> {
        if self.version != CONTRACT_VERSION {
            return misfit("version", self.version, CONTRACT_VERSION);
        }
        let block = |block: Option<&ObservationBlock>| match block {
            Some(block) => format!("`{}` of {} numbers", block.name, block.size),
            None => "no block".into(),
        };
        for k in 0..self.observation.len().max(played.observation.len()) {
            let (found, valid) = (self.observation.get(k), played.observation.get(k));
            let key = |block: &ObservationBlock| (block.name.clone(), block.size);
            if found.map(key) != valid.map(key) {
                return misfit(format!("observation[{k}]"), block(found), block(valid));
            }
        }
        let links = &self.action.links;
        let link = |name: Option<&String>| name.map_or("no link".to_owned(), |name| format!("`{name}`"));
        for k in 0..links.len().max(played.links.len()) {
            let (found, valid) = (links.get(k), played.links.get(k));
            if found != valid {
                return misfit(format!("action.links[{k}]"), link(found), link(valid));
            }
        }
        if self.action.scale != played.action_scale {
            let text = |scale: f64| format!("{scale} rad");
            return misfit("action.scale", text(self.action.scale), text(played.action_scale));
        }
        if self.action.gains != played.gain_action {
            let text = |gains: &Option<GainAction>| match gains {
                Some(GainAction { links, factor }) => format!("a factor of {factor} on {}", links.join(", ")),
                None => "none".into(),
            };
            return misfit("action.gains", text(&self.action.gains), text(&played.gain_action));
        }
        Ok(())
    }
}
