//! What the stick for thumbs says.

use bevy::prelude::*;

/// What the thumb says.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ThumbStick {
    /// A finger has been seen.
    pub shown: bool,
    /// To the right and up, each from -1 to 1; zero while it is let go.
    pub value: Vec2,
}
