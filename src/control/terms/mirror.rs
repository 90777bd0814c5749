//! The mirror image of what a policy sees and says, put together from its terms.

use super::image::{Source, TURN};
use crate::control::terms::ObservationLayout;
use crate::control::tracking::mirror_links;
use crate::model::CharacterModel;

/// Lets a policy see the mirror image and mirrors what it says.
#[derive(Clone, Debug)]
pub struct PolicyMirror {
    inputs: Vec<Source>,
    outputs: Vec<Source>,
}

impl PolicyMirror {
    /// For a character, of what a [`Tracker`](crate::control::tracking::Tracker) with the standard terms observes and is told.
    pub fn of(model: &CharacterModel) -> Self {
        Self::new(model, &ObservationLayout::of(model))
    }

    /// For a character and the layout of its observation.
    pub fn new(model: &CharacterModel, layout: &ObservationLayout) -> Self {
        let links = mirror_links(model);
        let joints = model.links.len() - 1;
        let mut inputs = Vec::with_capacity(layout.size());
        for (term, block) in layout.terms.iter().zip(&layout.blocks) {
            let at = inputs.len();
            inputs.extend((at..at + block.size).map(|i| (i, 1.0)));
            term.mirror(model, &links, &mut inputs[at..]);
        }
        let output = |i: usize| (3 * (links[i / 3 + 1] - 1) + i % 3, TURN[i % 3]);
        let told = &layout.gains.links;
        // A joint whose image has no gains of its own keeps its own.
        let gains = told.iter().enumerate().map(|(k, link)| {
            let image = told.iter().position(|other| *other == links[*link]).unwrap_or(k);
            (3 * joints + image, 1.0)
        });
        let outputs = (0..3 * joints).map(output).chain(gains).collect();
        Self { inputs, outputs }
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
