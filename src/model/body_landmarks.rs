//! A landmark layout on one character: where each landmark is on its links.

use super::{CharacterModel, Shape};
use crate::asset::clip_edit::other_side;
use crate::asset::landmark_layout::{LandmarkLayout, LandmarkPlace};
use glam::DVec3;

/// A landmark on a character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyLandmark {
    /// Link index.
    pub link: usize,
    /// Place in the link's frame, m.
    pub position: DVec3,
    /// How much it counts.
    pub weight: f64,
}

/// All landmarks of a layout on a character.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyLandmarks {
    /// In the layout's order; `None` where the character has no such place.
    pub points: Vec<Option<BodyLandmark>>,
    /// Standard deviation of each joint's rotation vector about straight, by link, rad.
    pub spread: Vec<DVec3>,
    /// Index of the link on the other side, by link; its own where there is none.
    pub partner: Vec<usize>,
}

/// Why a layout does not fit a character.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyLandmarkError {
    /// A hip or shoulder has no place on the character.
    #[error(
        "layout `{layout}`, landmark `{landmark}`: character `{character}` has none of the links {wanted}; it has {links}"
    )]
    NoPlace {
        /// The layout.
        layout: String,
        /// The landmark.
        landmark: String,
        /// The character.
        character: String,
        /// Links of the landmark's places.
        wanted: String,
        /// Links of the character.
        links: String,
    },
}

/// Standard deviation of a joint that has no range, rad.
const FREE_SPREAD: f64 = 0.5;
/// Standard deviation of a joint as a part of its range.
const SPREAD_OF_RANGE: f64 = 0.3;

/// The box round a link's shapes, link frame: centre and half of the edges, m.
fn bounds(shapes: &[Shape]) -> (DVec3, DVec3) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for shape in shapes {
        let (a, b, half) = match *shape {
            Shape::Sphere { center, radius } => (center, center, DVec3::splat(radius)),
            Shape::Capsule { a, b, radius } => (a, b, DVec3::splat(radius)),
            Shape::Box { center, half_extents, rotation } => {
                let edges = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (rotation * (axis * half_extents)).abs());
                (center, center, edges[0] + edges[1] + edges[2])
            }
        };
        low = low.min(a.min(b) - half);
        high = high.max(a.max(b) + half);
    }
    if low.is_finite() && high.is_finite() {
        ((low + high) / 2.0, (high - low) / 2.0)
    } else {
        (DVec3::ZERO, DVec3::ZERO)
    }
}

impl BodyLandmarks {
    /// Finds the places of a layout on a character. Hips and shoulders must have one.
    pub fn new(layout: &LandmarkLayout, model: &CharacterModel) -> Result<Self, BodyLandmarkError> {
        let find = |entry: &crate::asset::landmark_layout::LandmarkEntry| {
            let (place, link) = entry.at.iter().find_map(|p| Some((p, model.link_index(p.link())?)))?;
            let position = match *place {
                LandmarkPlace::Joint(_) => DVec3::ZERO,
                LandmarkPlace::At(_, position) => position,
                LandmarkPlace::Inside(_, share) => {
                    let (center, half) = bounds(&model.links[link].shapes);
                    center + half * share
                }
            };
            Some(BodyLandmark { link, position, weight: entry.weight })
        };
        let points: Vec<Option<BodyLandmark>> = layout.landmarks.iter().map(find).collect();
        if let Some(index) = layout.trunk().into_iter().find(|&i| points[i].is_none()) {
            let entry = &layout.landmarks[index];
            return Err(BodyLandmarkError::NoPlace {
                layout: layout.name.clone(),
                landmark: entry.name.clone(),
                character: model.name.clone(),
                wanted: entry.at.iter().map(LandmarkPlace::link).collect::<Vec<_>>().join(", "),
                links: model.links.iter().map(|l| l.name.as_str()).collect::<Vec<_>>().join(", "),
            });
        }
        let spread = model.links.iter().map(|link| match (layout.spread.get(&link.name), link.limits) {
            (Some(&(x, y, z)), _) => DVec3::new(x.to_radians(), y.to_radians(), z.to_radians()),
            (None, Some(limits)) => ((limits.high - limits.low) * SPREAD_OF_RANGE).max(DVec3::splat(0.01)),
            (None, None) => DVec3::splat(FREE_SPREAD),
        });
        let partner = model.links.iter().enumerate();
        let partner = partner.map(|(i, link)| model.link_index(&other_side(&link.name)).unwrap_or(i)).collect();
        Ok(Self { points, spread: spread.collect(), partner })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{PRESET_NAMES, preset};

    /// Landmarks stand where they do on a person: left and right mirrored, head over feet, toes before heels.
    #[test]
    fn built_in_layouts_fit_every_preset() {
        for (name, character) in LandmarkLayout::NAMES.iter().flat_map(|n| PRESET_NAMES.map(|c| (n, c))) {
            let (layout, model) = (LandmarkLayout::built_in(name).unwrap(), preset(character).unwrap());
            let body = BodyLandmarks::new(&layout, &model).unwrap();
            let rest = model.rest_positions();
            let place = |i: usize| body.points[i].map(|p| rest[p.link] + p.position);
            let named = |n: &str| place(layout.index(n).unwrap()).unwrap();
            for i in 0..body.points.len() {
                let other = place(layout.partner(i)).map(|p| p * DVec3::new(-1.0, 1.0, 1.0));
                let (Some(here), Some(there)) = (place(i), other) else { continue };
                assert!((here - there).length() < 2e-3, "{name} on {character}, {}", layout.landmarks[i].name);
            }
            assert!(named("left_hip").x < -0.05 && named("left_shoulder").y > named("left_hip").y + 0.3);
            let (wrist, elbow) = (named("left_wrist"), named("left_elbow"));
            assert!((0.15..0.3).contains(&wrist.distance(elbow)), "{character}: {wrist} {elbow}");
            let toe = named(if name.starts_with("smpl") { "left_foot" } else { "left_foot_index" });
            assert!(toe.z < named("left_ankle").z - 0.05, "{character}: {toe}");
        }
    }

    #[test]
    fn a_character_without_hips_is_refused() {
        let layout = LandmarkLayout::built_in("smpl24").unwrap();
        let mut model = (*preset("skater").unwrap()).clone();
        model.links[1].name = "stick".into();
        let message = BodyLandmarks::new(&layout, &model).unwrap_err().to_string();
        assert!(["left_hip", "thigh_left", "skater", "stick"].iter().all(|w| message.contains(w)), "{message}");
    }
}
