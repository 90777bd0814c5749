//! Pushes: a force on a link for a while.

use super::input_error::{InputError, VALID_PUSHES};
use crate::math::Vec3;
use crate::model::CharacterModel;
use crate::sim::{ExternalForce, Simulator};
use glam::DVec3;
use std::str::FromStr;

/// A force at the centre of mass of a link, written as `LINK:FX,FY,FZ:START:DURATION`.
#[derive(Clone, Debug, PartialEq)]
pub struct Push {
    /// Name of the link.
    pub link: String,
    /// Force, world axes, N.
    pub force: DVec3,
    /// When it begins, s.
    pub start: f64,
    /// How long it lasts, s.
    pub duration: f64,
}

impl Push {
    /// What can be parsed.
    pub const VALID: &'static str = VALID_PUSHES;

    /// The index of the link, or why there is none.
    pub fn link_index(&self, model: &CharacterModel) -> Result<usize, InputError> {
        model.link_index(&self.link).ok_or_else(|| {
            let names: Vec<&str> = model.links.iter().map(|l| l.name.as_str()).collect();
            InputError::Push {
                found: self.link.clone(),
                reason: format!("{} has no such link, only {}", model.name, names.join(", ")),
            }
        })
    }

    /// Adds the push to the forces of the next step (of length `h`, s) if it acts during it. `link` is its link's index.
    pub(super) fn apply(&self, link: usize, sim: &mut Simulator<f64>, h: f64) {
        // By the middle of the step, so that rounding of the time decides nothing.
        let middle = sim.state.time + 0.5 * h;
        if middle >= self.start && middle < self.start + self.duration {
            let position = Vec3::splat(sim.model().links[link].com);
            sim.external.push(ExternalForce { link, position, force: Vec3::splat(self.force) });
        }
    }
}

impl std::fmt::Display for Push {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { link, force, start, duration } = self;
        write!(f, "{link}:{},{},{}:{start}:{duration}", force.x, force.y, force.z)
    }
}

impl FromStr for Push {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        let bad = |reason: &str| InputError::Push { found: text.to_owned(), reason: reason.to_owned() };
        // From the right, so that a link's name may hold a colon.
        let mut parts = text.rsplitn(4, ':');
        let mut next = || parts.next().ok_or_else(|| bad("four parts with colons between them are needed"));
        let (duration, start, force, link) = (next()?, next()?, next()?, next()?);
        let number = |text: &str, what: &str, limit: f64| {
            let value: f64 = text.trim().parse().map_err(|_| bad(&format!("{what} `{text}` is no number")))?;
            if value.abs() <= limit { Ok(value) } else { Err(bad(&format!("{what} {value} is out of range"))) }
        };
        let components: Vec<f64> =
            force.split(',').map(|part| number(part, "force", 1e5)).collect::<Result<_, InputError>>()?;
        let &[x, y, z] = components.as_slice() else { return Err(bad("the force needs three components")) };
        let (start, duration) = (number(start, "start", 3600.0)?, number(duration, "duration", 3600.0)?);
        if start < 0.0 || duration < 0.0 {
            return Err(bad("times are not negative"));
        }
        Ok(Self { link: link.to_owned(), force: DVec3::new(x, y, z), start, duration })
    }
}
