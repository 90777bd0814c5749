//! The mirror image of a motion: what was learnt to one side can be performed to the other.
//!
//! The image is that in the plane x = 0 of the frame at hand: places and velocities change the sign of x, rotation vectors
//! and angular velocities that of y and z, and links change sides by their names.

use crate::asset::clip_edit::other_side;
use crate::model::CharacterModel;
use glam::{DQuat, DVec3};

/// The image of a place or a velocity.
pub(super) fn image(v: DVec3) -> DVec3 {
    DVec3::new(-v.x, v.y, v.z)
}

/// The image of an angular velocity or a rotation vector.
pub(super) fn image_of_turn(v: DVec3) -> DVec3 {
    DVec3::new(v.x, -v.y, -v.z)
}

/// The image of a rotation.
pub(super) fn image_of_rotation(q: DQuat) -> DQuat {
    DQuat::from_xyzw(q.x, -q.y, -q.z, q.w)
}

/// For each link the one on the other side of the body, by index; a link in the middle is its own.
pub fn mirror_links(model: &CharacterModel) -> Vec<usize> {
    let links = model.links.iter().enumerate();
    links.map(|(i, link)| model.link_index(&other_side(&link.name)).unwrap_or(i)).collect()
}
