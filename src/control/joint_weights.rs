//! How much the joints count in a comparison of poses.

use crate::model::CharacterModel;

/// How much each joint counts: by the fourth root of the part of the body's mass that it carries; one entry per link.
pub fn joint_weights(model: &CharacterModel) -> Vec<f64> {
    let mut carried: Vec<f64> = model.links.iter().map(|l| l.mass).collect();
    for i in (1..model.links.len()).rev() {
        if let Some(p) = model.links[i].parent {
            carried[p] += carried[i];
        }
    }
    let total = carried[0];
    carried.iter().map(|m| (m / total).sqrt().sqrt()).collect()
}
