//! What the stick for thumbs says.

use bevy::prelude::*;

/// Where the player points: arrow keys, left sticks and the thumb together; to the right and up.
pub(super) fn player_stick(keys: &ButtonInput<KeyCode>, gamepads: &Query<&Gamepad>, thumb: &ThumbStick) -> Vec2 {
    let axis = |more: KeyCode, less: KeyCode| f32::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)));
    let arrows = Vec2::new(axis(KeyCode::ArrowRight, KeyCode::ArrowLeft), axis(KeyCode::ArrowUp, KeyCode::ArrowDown));
    arrows + gamepads.iter().map(Gamepad::left_stick).sum::<Vec2>() + thumb.value
}

/// The direction over the ground that a stick means to who looks through a camera; its length is the stick's.
pub(super) fn over_ground(camera: &GlobalTransform, stick: Vec2) -> Vec3 {
    let ahead = camera.forward().as_vec3().with_y(0.0).normalize_or_zero();
    ahead * stick.y + Vec3::new(-ahead.z, 0.0, ahead.x) * stick.x
}

/// What the thumb says.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ThumbStick {
    /// A finger has been seen.
    pub shown: bool,
    /// To the right and up, each from -1 to 1; zero while it is let go.
    pub value: Vec2,
}
