//! What the scenes need of the command line.

use crate::app::{ControlScene, DemoOptions};
use bevy::prelude::*;

/// Simulated seconds per real second in slow motion.
pub(super) const SLOW: f32 = 0.2;

/// The control of the rink, and the options.
#[derive(Resource)]
pub(super) struct Stage {
    pub control: ControlScene,
    pub options: DemoOptions,
    /// Without a window.
    pub offscreen: bool,
}
