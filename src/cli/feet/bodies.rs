//! The feet that are compared.

use crate::model::{CharacterModel, SharedModel, foot_human, toes_human, two_segment_human};
use std::sync::Arc;

/// Points added between two corners of a sole.
const BETWEEN: usize = 3;

/// A body of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeetBody {
    /// Feet of five segments.
    Multi,
    /// Feet of two boxes.
    Two,
    /// Feet of two boxes with points along all edges of the soles: the paper's control.
    TwoMorePoints,
    /// Feet of eight segments: the five with a joint for every toe.
    Toes,
}

impl FeetBody {
    /// All four.
    pub const ALL: [FeetBody; 4] = [Self::Multi, Self::Two, Self::TwoMorePoints, Self::Toes];

    /// The body.
    pub fn model(self) -> SharedModel {
        match self {
            Self::Multi => foot_human(),
            Self::Two => two_segment_human(),
            Self::TwoMorePoints => Arc::new(with_more_points(&two_segment_human())),
            Self::Toes => toes_human(),
        }
    }
}

/// The same body with this armature (kg m^2) on every joint of its feet beyond the ankle.
pub fn with_foot_armature(model: &CharacterModel, armature: f64) -> CharacterModel {
    let mut geared = model.clone();
    for foot in model.feet() {
        for &link in &foot.links {
            // The ankle's link hangs on none of the foot's.
            if model.links[link].parent.is_some_and(|p| foot.links.contains(&p)) {
                geared.links[link].armature = armature;
            }
        }
    }
    geared
}

/// The same body with three more points on each edge between two corners of a sole.
fn with_more_points(model: &CharacterModel) -> CharacterModel {
    let mut more = model.clone();
    more.name = format!("{}_more_points", model.name);
    for foot in model.feet() {
        for &link in &foot.links {
            let own: Vec<_> = model.contact_points.iter().filter(|p| p.link == link).collect();
            for (k, a) in own.iter().enumerate() {
                for b in &own[k + 1..] {
                    let way = b.position - a.position;
                    // An edge runs along or across the foot, a diagonal does neither.
                    if way.x.abs() > 1e-3 && way.z.abs() > 1e-3 {
                        continue;
                    }
                    for n in 1..=BETWEEN {
                        let mut point = (*a).clone();
                        point.position += way * (n as f64 / (BETWEEN + 1) as f64);
                        point.name = format!("{}_{}_{n}", a.name, b.name);
                        more.contact_points.push(point);
                    }
                }
            }
        }
    }
    more
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_points_lie_on_the_edges_of_the_same_sole() {
        let (few, many) = (FeetBody::Two.model(), FeetBody::TwoMorePoints.model());
        // Four edges on each of two boxes of two feet.
        assert_eq!(many.contact_points.len(), few.contact_points.len() + 4 * 4 * BETWEEN);
        let extent = |m: &CharacterModel, link: usize| {
            let own = m.contact_points.iter().filter(move |p| p.link == link);
            own.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.position.z), b.max(p.position.z)))
        };
        for &link in &few.feet()[0].links {
            assert_eq!(extent(&few, link), extent(&many, link));
        }
    }
}
