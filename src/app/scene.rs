//! A control and what it needs: the same with and without a window.

use crate::contact::World;
use crate::control::{ControlError, ControlPlayer, ReconstructedControl};
use crate::model::{PRESET_NAMES, SharedModel, preset};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

/// The demo's own control, part of the program so that it runs from anywhere.
const STROKING: &str = include_str!("../../assets/skills/skating/stroking/stroking.control.ron");

/// A character, what it performs and what it stands on.
#[derive(Clone, Debug)]
pub struct ControlScene {
    /// The character.
    pub model: SharedModel,
    /// What it performs.
    pub control: Arc<ReconstructedControl>,
    /// What it stands on.
    pub world: World,
}

/// Why there is no scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The control cannot be loaded, or does not fit its character.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The control is for a character that does not come with the crate.
    #[error("the control is for the character `{found}`; valid: {}", PRESET_NAMES.join(", "))]
    Character {
        /// The character it names.
        found: String,
    },
}

impl ControlScene {
    /// The scene of a control file, or of the demo's own control.
    pub fn load(control: Option<&Path>) -> Result<Self, SceneError> {
        let control = match control {
            Some(path) => ReconstructedControl::load(path)?,
            None => ReconstructedControl::from_ron(STROKING, "stroking.control.ron")?,
        };
        let model =
            preset(&control.character).ok_or_else(|| SceneError::Character { found: control.character.clone() })?;
        // Refused here, with a reason, rather than in the window.
        ControlPlayer::new(&control, &model)?;
        let world = if control.world == "ground" { World::ground() } else { World::ice() };
        Ok(Self { model, control: Arc::new(control), world })
    }

    /// The middle of the way on the ground: the rink is laid around it, so that the motion needs no moving and keeps its
    /// bits.
    pub fn middle(&self) -> DVec3 {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for pose in &self.control.clip.poses {
            low = low.min(pose.root_position);
            high = high.max(pose.root_position);
        }
        ((low + high) * 0.5).with_y(0.0)
    }
}
