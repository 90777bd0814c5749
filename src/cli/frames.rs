//! Instants of a performance, for a storyboard.

use crate::model::{LinkTransform, ModelPose};
use crate::sim::{Simulator, link_transforms};
use crate::storyboard::{StoryboardFrame, TouchPoint};
use glam::DVec3;

/// Most instants that are kept: enough for a smooth path of the centre of mass.
const MOST: f64 = 240.0;

/// Keeps instants at even times.
#[derive(Clone, Debug)]
pub struct FrameRecorder {
    interval: f64,
    next: f64,
    ghost: bool,
    frames: Vec<StoryboardFrame>,
}

impl FrameRecorder {
    /// For a performance of so many seconds; `ghost` draws the reference beside the figure.
    pub fn new(seconds: f64, ghost: bool) -> Self {
        Self { interval: (seconds / MOST).max(1.0 / 60.0), next: 0.0, ghost, frames: Vec::new() }
    }

    /// Looks at the simulation after a step; `reference` is the pose it should be in.
    pub fn look(&mut self, sim: &mut Simulator<f64>, reference: &ModelPose) {
        let (time, h) = (sim.state.time, sim.step_seconds());
        // The start, and then whenever the next instant is nearer than half a step.
        if time + 0.5 * h < self.next {
            return;
        }
        self.next += self.interval;
        let model = sim.model().clone();
        let links: Vec<LinkTransform> = link_transforms(sim, 0)
            .into_iter()
            .map(|(position, rotation)| LinkTransform { position, rotation })
            .collect();
        let touch = |(index, point): (usize, &crate::model::ContactPoint)| {
            let force = sim.contact_force(index, 0);
            let link = &links[point.link];
            let position = link.position + link.rotation * point.position - DVec3::Y * point.radius;
            (force.length() > 1e-9).then_some(TouchPoint { position, force })
        };
        let contacts = model.contact_points.iter().enumerate().filter_map(touch).collect();
        let ghost = self.ghost.then(|| {
            let mut out = Vec::with_capacity(links.len());
            reference.link_transforms(&model, &mut out);
            out
        });
        self.frames.push(StoryboardFrame { time, ghost, contacts, ..StoryboardFrame::new(time, links) });
    }

    /// Writes a word below the instants from `time` (s) on.
    pub fn caption_from(&mut self, time: f64, words: &str) {
        for frame in self.frames.iter_mut().filter(|f| f.time >= time) {
            words.clone_into(&mut frame.caption);
        }
    }

    /// The instants so far, in order of time.
    pub fn frames(&self) -> &[StoryboardFrame] {
        &self.frames
    }
}
