//! What training is rewarded for, and what it is ended by.

use serde::{Deserialize, Serialize};

/// Weights of the reward's terms, and how fast each falls with its error: `weight * exp(-sharpness * error)`. The weights
/// add up to one at a perfect imitation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RewardScales {
    /// Mean squared joint angle, 1/rad^2.
    pub pose: (f64, f64),
    /// Mean squared joint velocity, s^2/rad^2.
    pub velocity: (f64, f64),
    /// Mean squared distance of the end links, 1/m^2.
    pub ends: (f64, f64),
    /// Squared angle of the root, 1/rad^2.
    pub root: (f64, f64),
    /// Squared height of the centre of mass, 1/m^2.
    pub height: (f64, f64),
    /// Squared velocity of the centre of mass, s^2/m^2.
    pub com_velocity: (f64, f64),
    /// Squared distance of the root, 1/m^2.
    pub place: (f64, f64),
    /// Mean squared angle of the feet's joints, ankles included, 1/rad^2; none by default. In `pose` joints count by the mass that they
    /// carry, so feet hardly do.
    pub feet: (f64, f64),
    /// How far the parts of the soles are from touching as the motion's do, 0 to 1; none by default. With it a foot comes down heel first
    /// where the motion's does.
    pub contacts: (f64, f64),
    /// Taken off: mean square of the action.
    pub effort: f64,
}

impl Default for RewardScales {
    fn default() -> Self {
        Self {
            pose: (0.30, 10.0),
            velocity: (0.05, 0.3),
            ends: (0.15, 60.0),
            root: (0.15, 6.0),
            height: (0.10, 80.0),
            com_velocity: (0.15, 4.0),
            place: (0.10, 8.0),
            feet: (0.0, 6.0),
            contacts: (0.0, 3.0),
            effort: 0.01,
        }
    }
}

/// When a trial in training ends early.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TerminationLimits {
    /// Height of the centre of mass against the reference's, m.
    pub height: f64,
    /// Angle of the root, rad.
    pub root: f64,
    /// Root mean square joint angle, rad.
    pub pose: f64,
    /// Distance of the root, m.
    pub place: f64,
    /// Nothing but blades (and feet) may touch the ground.
    pub touch: bool,
    /// A blade that the motion has in the air may not touch the ice, from [`SETTLE`](crate::skill::SETTLE) on.
    pub free_foot: bool,
    /// A blade that the motion has on the ice for good may not be without contact at two decisions in a row, from
    /// [`SETTLE`](crate::skill::SETTLE) on.
    pub standing_foot: bool,
    /// Angle by which a character that drags its reference along may have turned its reference round since the trial began, rad; `None` is no
    /// limit. Without one, a character that never turns is followed by a reference that never does either.
    pub turn: Option<f64>,
}

impl Default for TerminationLimits {
    fn default() -> Self {
        Self {
            height: 0.25,
            root: 1.0,
            pose: 0.7,
            place: 1.5,
            touch: true,
            free_foot: false,
            standing_foot: false,
            turn: None,
        }
    }
}
