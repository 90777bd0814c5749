//! What a body shall stand on, and how.

use crate::control::foot::{BasicPose, FootAnatomy, FootError, SegmentSet};
use crate::model::CharacterModel;
use glam::{DQuat, DVec3};

/// Why a stance that was asked for cannot be stood in.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StanceError {
    /// A number of feet that is not the character's.
    #[error("{found} feet are asked for; the character has {expected}")]
    Feet {
        /// Feet that were asked for.
        found: usize,
        /// Feet of the character.
        expected: usize,
    },
    /// Nothing to stand on.
    #[error("no segment of any foot is asked to touch; valid: one at least")]
    NothingTouches,
    /// A segment that is not there, or has no sole that reaches the ground.
    #[error("foot {foot}: segment {segment} is asked to touch; valid: {valid}")]
    Segment {
        /// The foot.
        foot: usize,
        /// The segment.
        segment: usize,
        /// Indices and names of those that can.
        valid: String,
    },
    /// An ankle where none can be.
    #[error("foot {foot}: {what} of the ankle is {value}; valid: {low} to {high}")]
    Ankle {
        /// The foot.
        foot: usize,
        /// `rise` (m) or `roll` (rad).
        what: &'static str,
        /// What was asked for.
        value: f64,
        /// Least.
        low: f64,
        /// Most.
        high: f64,
    },
}

/// What one foot does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AnkleStance {
    /// The segments that shall touch; none is a foot in the air.
    pub touch: SegmentSet,
    /// How much higher the ankle is than where the whole sole stands, m.
    pub rise: f64,
    /// Roll of the ankle's link against the ground, rad; positive turns the sole outwards (inside tilt).
    pub roll: f64,
}

impl AnkleStance {
    /// Rises of the ankle that can be asked for, m.
    pub const RISE: (f64, f64) = (0.0, 0.06);
    /// Rolls of the ankle that can be asked for, rad.
    pub const ROLL: (f64, f64) = (-0.3, 0.3);

    /// This with the ankle moved by so much, as far as can be asked for.
    pub fn moved(self, rise: f64, roll: f64) -> Self {
        let within = |x: f64, (low, high): (f64, f64)| x.clamp(low, high);
        Self { rise: within(self.rise + rise, Self::RISE), roll: within(self.roll + roll, Self::ROLL), ..self }
    }

    /// Whether foot number `foot` can be asked for this.
    fn check(&self, foot: usize, anatomy: &FootAnatomy) -> Result<(), StanceError> {
        let standing = anatomy.standing();
        if let Some(segment) = self.touch.iter().find(|&k| !standing.contains(k)) {
            let name = |k: usize| format!("{k} ({})", anatomy.segments()[k].name);
            let valid = standing.iter().map(name).collect::<Vec<_>>().join(", ");
            return Err(StanceError::Segment { foot, segment, valid });
        }
        for (what, value, (low, high)) in [("rise", self.rise, Self::RISE), ("roll", self.roll, Self::ROLL)] {
            if !(low..=high).contains(&value) {
                return Err(StanceError::Ankle { foot, what, value, low, high });
            }
        }
        Ok(())
    }
}

/// What all feet do, and the posture above.
#[derive(Clone, Debug, PartialEq)]
pub struct Stance {
    /// One for each foot of the model.
    pub feet: Vec<AnkleStance>,
    /// Rotation of each joint in the posture, child axes to parent axes; those of the feet are found by the foot pose controller.
    pub posture: Vec<DQuat>,
}

impl Stance {
    /// Both feet in one basic pose, the posture straight with the knees bent by `knee` (rad).
    pub fn basic(model: &CharacterModel, feet: &[FootAnatomy], pose: BasicPose, knee: f64) -> Result<Self, FootError> {
        let mut stance = Self { feet: Vec::new(), posture: bent(model, feet, knee) };
        for foot in feet {
            let touch = foot.set(pose)?;
            let (rise, roll) = match pose {
                BasicPose::Rest => (0.0, 0.0),
                BasicPose::Tiptoe => (0.04, 0.0),
                BasicPose::InsideTilt => (0.0, 0.21),
                BasicPose::OutsideTilt => (0.0, -0.21),
            };
            stance.feet.push(AnkleStance { touch, rise, roll });
        }
        Ok(stance)
    }

    /// One foot circles about its ankle (Park, Yu, Lee 2018, Section 6) while the other stands: its heel is lifted, and all its toes, the medial, all, the
    /// lateral ones carry in turn; `quarter` counts those four.
    pub fn circling(
        model: &CharacterModel,
        feet: &[FootAnatomy],
        foot: usize,
        knee: f64,
        quarter: usize,
    ) -> Result<Self, FootError> {
        let mut stance = Self::basic(model, feet, BasicPose::Rest, knee)?;
        let Some((anatomy, own)) = feet.get(foot).zip(stance.feet.get_mut(foot)) else { return Ok(stance) };
        let toes = anatomy.set(BasicPose::Tiptoe)?;
        let (medial, lateral) = (anatomy.set(BasicPose::InsideTilt)?, anatomy.set(BasicPose::OutsideTilt)?);
        let (touch, roll) = match quarter % 4 {
            1 => (toes.both(medial), 0.15),
            3 => (toes.both(lateral), -0.15),
            _ => (toes, 0.0),
        };
        *own = AnkleStance { touch, rise: 0.04, roll };
        Ok(stance)
    }

    /// On foot number `standing` alone, the others lifted by the hip and the knee.
    pub fn one_leg(
        model: &CharacterModel,
        feet: &[FootAnatomy],
        standing: usize,
        knee: f64,
    ) -> Result<Self, FootError> {
        let mut stance = Self::basic(model, feet, BasicPose::Rest, knee)?;
        for (index, foot) in feet.iter().enumerate().filter(|(i, _)| *i != standing) {
            stance.feet[index].touch = SegmentSet::NONE;
            stance.lift(model, foot);
        }
        Ok(stance)
    }

    /// Each foot as it is asked, the posture straight with the knees bent by `knee` (rad); a foot that shall touch with nothing is lifted.
    pub fn asked(
        model: &CharacterModel,
        feet: &[FootAnatomy],
        asked: &[AnkleStance],
        knee: f64,
    ) -> Result<Self, StanceError> {
        if asked.len() != feet.len() {
            return Err(StanceError::Feet { found: asked.len(), expected: feet.len() });
        }
        for (index, (own, foot)) in asked.iter().zip(feet).enumerate() {
            own.check(index, foot)?;
        }
        if asked.iter().all(|own| own.touch.is_empty()) {
            return Err(StanceError::NothingTouches);
        }
        let mut stance = Self { feet: asked.to_vec(), posture: bent(model, feet, knee) };
        for (_, foot) in asked.iter().zip(feet).filter(|(own, _)| own.touch.is_empty()) {
            stance.lift(model, foot);
        }
        Ok(stance)
    }

    /// Lifts a foot by the hip and the knee.
    fn lift(&mut self, model: &CharacterModel, foot: &FootAnatomy) {
        if let Some((thigh, shin)) = leg(model, foot) {
            self.posture[thigh] = DQuat::from_xyzw(0.25, 0.0, 0.0, 1.0).normalize();
            self.posture[shin] = DQuat::from_xyzw(-0.4, 0.0, 0.0, 1.0).normalize();
        }
    }
}

/// The two links above a foot.
fn leg(model: &CharacterModel, foot: &FootAnatomy) -> Option<(usize, usize)> {
    let shin = model.links[foot.ankle()].parent?;
    let thigh = model.links[shin].parent?;
    Some((thigh, shin))
}

/// The zero pose with bent knees, ankles and hips so that trunk and soles stay level.
fn bent(model: &CharacterModel, feet: &[FootAnatomy], knee: f64) -> Vec<DQuat> {
    let turn = |angle: f64| crate::asset::turn::rotation_by(DVec3::X * angle);
    let mut posture = vec![DQuat::IDENTITY; model.links.len()];
    for foot in feet {
        if let Some((thigh, shin)) = leg(model, foot) {
            posture[thigh] = turn(0.5 * knee);
            posture[shin] = turn(-knee);
            posture[foot.ankle()] = turn(0.5 * knee);
        }
    }
    posture
}
