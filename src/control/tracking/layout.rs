//! The order of the numbers that a policy sees.

use crate::asset::policy_contract::ObservationBlock;
use crate::control::tracking::TrackedMotion;
use crate::model::CharacterModel;

/// The blocks of an observation, in order. The heading frame is the world turned about the vertical so that the root
/// faces -Z.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservationLayout {
    /// The blocks.
    pub blocks: Vec<ObservationBlock>,
}

impl ObservationLayout {
    /// The layout of [`Tracker::observe`](super::Tracker::observe) for a character.
    pub fn of(model: &CharacterModel) -> Self {
        let joints = model.links.len() - 1;
        let block =
            |name: &str, size, meaning: &str| ObservationBlock { name: name.into(), size, meaning: meaning.into() };
        Self {
            blocks: vec![
                block("phase", TrackedMotion::PHASES, "place in the motion, hat functions in [0, 1]"),
                block("up", 3, "world's up, root axes"),
                block("root_height", 1, "m above the world's origin"),
                block("root_velocity", 3, "m/s, heading frame"),
                block("root_spin", 3, "rad/s, heading frame"),
                block("root_turn", 3, "rotation vector from the root to the reference's, root axes, rad"),
                block(
                    "com_velocity_error",
                    3,
                    "wanted minus present velocity of the centre of mass, heading frame, m/s",
                ),
                block("heading", 2, "cosine and sine of the turn from the root's heading to the reference's"),
                block("offset", 3, "from the root to the reference's, heading frame, m, level parts cut at 1 m"),
                block("speed", 1, "commanded speed, m/s"),
                block(
                    "links",
                    6 * joints,
                    "origin (m) and velocity (m/s) against the root, heading frame, link by link",
                ),
                block("blades", 2 * model.blades.len(), "height of toe and heel, m, cut at -0.1 and 0.5"),
                block(
                    "joints",
                    6 * joints,
                    "rotation vector to the next reference (rad) and velocity (rad/s), child axes, joint by joint",
                ),
            ],
        }
    }

    /// Numbers in all.
    pub fn size(&self) -> usize {
        self.blocks.iter().map(|b| b.size).sum()
    }
}
