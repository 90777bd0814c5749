//! What mirror images of rows of numbers are made of.

/// Where a number comes from, and its sign.
pub(super) type Source = (usize, f32);

/// The signs of a vector's image.
pub(super) const VECTOR: [f32; 3] = [-1.0, 1.0, 1.0];
/// The signs of the image of a rotation vector, or of an angular velocity.
pub(super) const TURN: [f32; 3] = [1.0, -1.0, -1.0];
