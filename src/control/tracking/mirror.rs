//! The mirror image of a motion and of a policy: what was learnt to one side can be performed to the other.
//!
//! The image is that in the plane x = 0 of the frame at hand: places and velocities change the sign of x, rotation vectors
//! and angular velocities that of y and z, and links change sides by their names.

use crate::asset::clip_edit::other_side;
use crate::control::tracking::{ObservationLayout, TrackedMotion};
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

/// Where a number comes from, and its sign.
type Source = (usize, f32);

/// Lets a policy see the mirror image and mirrors what it says.
#[derive(Clone, Debug)]
pub struct PolicyMirror {
    inputs: Vec<Source>,
    outputs: Vec<Source>,
}

/// The signs of a vector's image, and of a rotation vector's.
const VECTOR: [f32; 3] = [-1.0, 1.0, 1.0];
const TURN: [f32; 3] = [1.0, -1.0, -1.0];

impl PolicyMirror {
    /// For a character, of what a [`Tracker`](super::Tracker) observes and is told.
    pub fn of(model: &CharacterModel) -> Self {
        let links = mirror_links(model);
        let joints = model.links.len() - 1;
        let mut inputs: Vec<Source> = (0..ObservationLayout::of(model).size()).map(|i| (i, 1.0)).collect();
        let mut at = TrackedMotion::PHASES;
        let mut signed = |at: &mut usize, signs: &[f32]| {
            for sign in signs {
                inputs[*at].1 = *sign;
                *at += 1;
            }
        };
        signed(&mut at, &VECTOR); // up
        signed(&mut at, &[1.0]); // root_height
        signed(&mut at, &VECTOR); // root_velocity
        signed(&mut at, &TURN); // root_spin
        signed(&mut at, &TURN); // root_turn
        signed(&mut at, &VECTOR); // com_velocity_error
        signed(&mut at, &[1.0, -1.0]); // heading
        signed(&mut at, &VECTOR); // offset
        signed(&mut at, &[1.0]); // speed
        let mut sided = |at: &mut usize, signs: [f32; 3]| {
            for i in 0..joints {
                for k in 0..6 {
                    inputs[*at + 6 * i + k] = (*at + 6 * (links[i + 1] - 1) + k, signs[k % 3]);
                }
            }
            *at += 6 * joints;
        };
        sided(&mut at, VECTOR); // links
        let blades = at;
        at += 2 * model.blades.len();
        sided(&mut at, TURN); // joints
        for (k, blade) in model.blades.iter().enumerate() {
            let other = model.blades.iter().position(|b| b.link == links[blade.link]).unwrap_or(k);
            for end in 0..2 {
                inputs[blades + 2 * k + end].0 = blades + 2 * other + end;
            }
        }
        let output = |i: usize| (3 * (links[i / 3 + 1] - 1) + i % 3, TURN[i % 3]);
        Self { inputs, outputs: (0..3 * joints).map(output).collect() }
    }

    /// The image of what was observed, into `out`.
    pub fn observation(&self, seen: &[f64], out: &mut Vec<f32>) {
        out.extend(self.inputs.iter().map(|(i, sign)| seen[*i] as f32 * sign));
    }

    /// The image of an action, in place; `spare` is work space.
    pub fn action(&self, action: &mut Vec<f32>, spare: &mut Vec<f32>) {
        spare.clear();
        spare.extend(self.outputs.iter().map(|(i, sign)| action[*i] * sign));
        core::mem::swap(action, spare);
    }
}
