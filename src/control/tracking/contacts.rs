//! Whether feet touch as the reference's do: heel first where its heel is first.

use crate::control::foot::FootAnatomy;
use crate::control::tracking::Tracker;
use crate::math::{Quat, Real, Vec3};
use crate::model::CharacterModel;
use crate::sim::Simulator;

/// A part of the reference is on the ground below this height, m, and in the air for good above the second.
const HEIGHTS: (f64, f64) = (0.008, 0.03);

/// The parts of all soles, what lies behind the ankle and what lies before it, and the links that carry them.
#[derive(Clone, Debug, Default)]
pub struct SoleParts {
    /// Contact points of each part.
    parts: Vec<Vec<usize>>,
    /// The links of the feet and all above them, each after its parent.
    links: Vec<usize>,
}

impl SoleParts {
    /// Those of a model; feet on blades have none.
    pub fn of(model: &CharacterModel) -> Self {
        let mut parts = Vec::new();
        let mut carries = vec![false; model.links.len()];
        for anatomy in (0..model.feet().len()).filter_map(|foot| FootAnatomy::of(model, foot).ok()) {
            let (rear, front) = anatomy.rear_and_front();
            parts.extend([rear, front].into_iter().filter(|part| !part.is_empty()));
            for segment in anatomy.segments() {
                let mut link = Some(segment.link);
                while let Some(above) = link.filter(|l| !carries[*l]) {
                    carries[above] = true;
                    link = model.links[above].parent;
                }
            }
        }
        Self { parts, links: (0..model.links.len()).filter(|l| carries[*l]).collect() }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }
}

impl<R: Real> Tracker<R> {
    /// How far the parts of the soles are from touching as the reference's do, 0 to 1: a part that touches counts by how far the reference has it
    /// in the air, one that does not touch where the reference's lies on the ground counts whole.
    pub fn contact_error(&self, sim: &Simulator<R>, soles: &SoleParts) -> R {
        let model = sim.model();
        let mut places = vec![(Vec3::zero(), Quat::identity()); model.links.len()];
        for &link in &soles.links {
            places[link] = match model.links[link].parent {
                None => (self.reference_root(), self.reference_rotation()),
                Some(parent) => {
                    let (place, rotation): (Vec3<R>, Quat<R>) = places[parent];
                    let offset = rotation.rotate(Vec3::splat(model.links[link].offset));
                    (place + offset, rotation * self.reference_joint(link))
                }
            };
        }
        let ground = self.support().height;
        let (low, high) = (R::splat(HEIGHTS.0), R::splat(HEIGHTS.1));
        let mut sum = R::zero();
        for part in &soles.parts {
            let (mut lowest, mut load) = (R::splat(1e3), R::zero());
            for &point in part {
                let p = &model.contact_points[point];
                let (place, rotation) = places[p.link];
                let height = (place + rotation.rotate(Vec3::splat(p.position))).y - R::splat(p.radius) - ground;
                lowest = lowest.min(height);
                load += sim.state.contact_impulses[point].length_squared();
            }
            let touches = R::zero().lt(load);
            let early = ((lowest - low) / (high - low)).max(R::zero()).min(R::one());
            let missing = R::select(lowest.lt(low), R::one(), R::zero());
            sum += R::select(touches, early, missing);
        }
        sum * R::splat(1.0 / soles.parts.len().max(1) as f64)
    }
}
