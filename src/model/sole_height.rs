//! How high the soles of a clip are: floating and penetration, and the shift that puts a clip on the ground.

use super::{CharacterModel, Shape};
use crate::asset::clip::{ClipError, MotionClip};
use glam::DVec3;

/// Heights of the lowest sole point over a clip; the ground is at y = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct SoleHeights {
    /// Lowest sole point of each pose, m.
    pub heights: Vec<f64>,
    /// Lowest over the clip, m: below zero is penetration.
    pub lowest: f64,
    /// Time of the lowest, s from the start.
    pub lowest_time: f64,
    /// Link of the lowest.
    pub lowest_link: String,
    /// Highest over the clip, m: how far the body leaves the ground, or floats.
    pub highest: f64,
    /// Mean over the clip, m.
    pub mean: f64,
}

/// A sphere on a link.
struct SolePoint {
    link: usize,
    position: DVec3,
    radius: f64,
}

/// Contact points of the marked links; where they have none, corners and ends of their shapes; else their joints.
fn sole_points(model: &CharacterModel, marked: &[bool]) -> Vec<SolePoint> {
    let contacts = model.contact_points.iter().filter(|c| marked.get(c.link).copied().unwrap_or(false));
    let mut points: Vec<SolePoint> =
        contacts.map(|c| SolePoint { link: c.link, position: c.position, radius: c.radius }).collect();
    if points.is_empty() {
        for (link, _) in marked.iter().enumerate().filter(|(_, m)| **m) {
            for shape in &model.links[link].shapes {
                let mut add = |position, radius| points.push(SolePoint { link, position, radius });
                match *shape {
                    Shape::Sphere { center, radius } => add(center, radius),
                    Shape::Capsule { a, b, radius } => {
                        add(a, radius);
                        add(b, radius);
                    }
                    Shape::Box { center, half_extents, rotation } => {
                        for corner in 0..8 {
                            let sign = |bit: i32| if corner & bit == 0 { -1.0 } else { 1.0 };
                            add(center + rotation * (half_extents * DVec3::new(sign(1), sign(2), sign(4))), 0.0);
                        }
                    }
                }
            }
        }
    }
    if points.is_empty() {
        let links = marked.iter().enumerate().filter(|(_, m)| **m);
        points.extend(links.map(|(link, _)| SolePoint { link, position: DVec3::ZERO, radius: 0.0 }));
    }
    points
}

impl MotionClip {
    /// Heights of the lowest point of the links given (with all links below them; none means the whole body), from the
    /// character's contact points, or its shapes where those links have none.
    pub fn sole_heights(&self, model: &CharacterModel, links: &[&str]) -> Result<SoleHeights, ClipError> {
        let clip = self.to_model(model)?;
        let mut marked = vec![links.is_empty(); model.links.len()];
        for &name in links {
            let Some(link) = model.link_index(name) else {
                let links: Vec<&str> = model.links.iter().map(|l| l.name.as_str()).collect();
                return Err(ClipError::UnknownJoint {
                    clip: self.name.clone(),
                    joint: name.to_owned(),
                    character: model.name.clone(),
                    links: links.join(", "),
                });
            };
            marked[link] = true;
        }
        for link in 1..model.links.len() {
            marked[link] |= model.links[link].parent.is_some_and(|p| marked[p]);
        }
        let points = sole_points(model, &marked);

        let mut heights = Vec::with_capacity(clip.poses().len());
        let (mut lowest, mut lowest_pose, mut lowest_link) = (f64::INFINITY, 0, 0);
        let mut places = Vec::new();
        for (index, pose) in clip.poses().iter().enumerate() {
            pose.link_transforms(model, &mut places);
            let mut height = f64::INFINITY;
            for point in &points {
                let place = places[point.link];
                let y = (place.position + place.rotation * point.position).y - point.radius;
                height = height.min(y);
                if y < lowest {
                    (lowest, lowest_pose, lowest_link) = (y, index, point.link);
                }
            }
            heights.push(height);
        }
        Ok(SoleHeights {
            lowest,
            lowest_time: lowest_pose as f64 / self.frame_rate,
            lowest_link: model.links[lowest_link].name.clone(),
            highest: heights.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            mean: heights.iter().sum::<f64>() / heights.len() as f64,
            heights,
        })
    }

    /// The clip with its root lifted where the body would be below y = 0, and the largest lift, m. The lift fades in
    /// and out over 0.15 s around each dip, so that it adds no jerk. A captured body that is thinner than the
    /// character rolls deeper than the character can.
    pub fn lifted_clear(&self, model: &CharacterModel) -> Result<(Self, f64), ClipError> {
        const FADE: f64 = 0.15;
        let heights = self.sole_heights(model, &[])?.heights;
        let reach = (FADE * self.frame_rate).ceil() as usize;
        let mut lifted = self.clone();
        let mut largest = 0.0_f64;
        for (i, pose) in lifted.poses.iter_mut().enumerate() {
            let around = i.saturating_sub(reach)..(i + reach + 1).min(heights.len());
            let lift = around
                .map(|j| {
                    let x: f64 = i.abs_diff(j) as f64 / (reach + 1) as f64;
                    (-heights[j]).max(0.0) * (1.0 - x * x).powi(2)
                })
                .fold(0.0, f64::max);
            pose.root_position.y += lift;
            largest = largest.max(lift);
        }
        Ok((lifted, largest))
    }

    /// Height of the lowest point of the whole body over the clip, m.
    pub fn lowest_point(&self, model: &CharacterModel) -> Result<f64, ClipError> {
        Ok(self.sole_heights(model, &[])?.lowest)
    }

    /// The clip shifted up or down so that the lowest sole point over the clip lies on y = 0, with the heights found
    /// before the shift. `links` as in [`MotionClip::sole_heights`].
    pub fn grounded(&self, model: &CharacterModel, links: &[&str]) -> Result<(Self, SoleHeights), ClipError> {
        self.grounded_at(model, links, 0.0)
    }

    /// The clip shifted up or down so that a fraction of its poses (0 to 1) reaches below y = 0, with the heights found
    /// before the shift. In captured clips single poses dip far below the rest: put on the ground by its lowest point,
    /// such a clip floats.
    pub fn grounded_at(
        &self,
        model: &CharacterModel,
        links: &[&str],
        fraction: f64,
    ) -> Result<(Self, SoleHeights), ClipError> {
        let heights = self.sole_heights(model, links)?;
        Ok((self.raised(-heights.quantile(fraction)), heights))
    }
}

impl SoleHeights {
    /// The height below which a fraction (0 to 1) of the poses lies, m.
    pub fn quantile(&self, fraction: f64) -> f64 {
        let mut sorted = self.heights.clone();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        let index = (fraction.clamp(0.0, 1.0) * last as f64).round() as usize;
        sorted.get(index.min(last)).copied().unwrap_or(self.lowest)
    }
}
