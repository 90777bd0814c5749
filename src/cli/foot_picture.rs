//! A foot by itself in its four basic poses, for a storyboard.

use crate::control::foot::{
    BasicPose, FootAnatomy, FootError, FootPose, FootPoseOptions, FootPoseRequest, GroundPlane, foot_pose,
};
use crate::model::{CharacterModel, ContactPoint, JointKind, Link, LinkTransform, Shape};
use crate::storyboard::StoryboardFrame;
use glam::{DQuat, DVec3};

/// Roll of the ankle in the two tilts, rad.
const TILT: f64 = 0.26;
/// How much higher than at rest the ankle is on tiptoe, m.
const RISE: f64 = 0.045;
/// Length of the shin that is drawn, m.
const SHIN: f64 = 0.05;
/// A bone touches where one of its ends lies so near the ground, m.
const TOUCH: f64 = 1e-3;

/// A basic pose of one foot on level ground.
#[derive(Clone, Debug)]
pub struct PosedFoot {
    /// Which.
    pub basic: BasicPose,
    /// The pose that the controller found.
    pub pose: FootPose,
}

/// The four basic poses of a foot; a pose whose segments it lacks is an error.
pub fn basic_poses(foot: &FootAnatomy) -> Result<Vec<PosedFoot>, FootError> {
    // Height of the ankle where the whole sole stands, by the first segment that hangs on it.
    let hanging = foot.segments().iter().skip(1).find(|s| s.stands && s.parent == 0);
    let rest = hanging.map_or(foot.segments()[0].drop, |s| s.drop - s.offset.y);
    let outward = if foot.side == Some(crate::asset::Side::Right) { 1.0 } else { -1.0 };
    let posed = |basic: BasicPose| {
        let (height, roll) = match basic {
            BasicPose::Rest => (rest, 0.0),
            BasicPose::Tiptoe => (rest + RISE, 0.0),
            BasicPose::InsideTilt => (rest, outward * TILT),
            BasicPose::OutsideTilt => (rest, -outward * TILT),
        };
        let rotation = DQuat::from_rotation_z(roll);
        let request = FootPoseRequest {
            under: Default::default(),
            ankle: DVec3::Y * height,
            rotation,
            direction: foot.forward(),
            touch: foot.set(basic)?,
            ground: GroundPlane::LEVEL,
        };
        Ok(PosedFoot { basic, pose: foot_pose(foot, &request, &FootPoseOptions::default()) })
    };
    BasicPose::ALL.into_iter().map(posed).collect()
}

/// A character that is one foot of another, with a piece of the shin: links in the order of the foot's segments.
pub fn foot_alone(model: &CharacterModel, foot: &FootAnatomy) -> CharacterModel {
    let segments = foot.segments();
    let link = |(k, segment): (usize, &crate::control::foot::Segment)| {
        let own = &model.links[segment.link];
        let mut link = Link { parent: (k > 0).then_some(segment.parent), ..own.clone() };
        if k == 0 {
            link.joint = JointKind::Free;
            link.offset = DVec3::ZERO;
            let radius = 0.016;
            link.shapes.push(Shape::Capsule { a: DVec3::Y * 0.01, b: DVec3::Y * SHIN, radius });
        }
        link
    };
    let position = |index: usize| segments.iter().position(|s| s.link == index);
    let points = model.contact_points.iter().filter_map(|p| {
        let link = position(p.link)?;
        Some(ContactPoint { link, ..p.clone() })
    });
    CharacterModel {
        links: segments.iter().enumerate().map(link).collect(),
        contact_points: points.collect(),
        blades: Vec::new(),
        grips: Vec::new(),
        collision_pairs: Vec::new(),
        feet: Vec::new(),
        trunk: 0,
        ..model.clone()
    }
}

/// Instants for a storyboard of [`foot_alone`]: a pose each, its name as the caption, the bones that touch marked.
pub fn foot_frames(alone: &CharacterModel, foot: &FootAnatomy, poses: &[PosedFoot]) -> Vec<StoryboardFrame> {
    let frame = |(k, posed): (usize, &PosedFoot)| {
        let mut links: Vec<LinkTransform> = Vec::new();
        for (k, segment) in foot.segments().iter().enumerate() {
            let place = if k == 0 {
                LinkTransform { position: posed.pose.ankle, rotation: posed.pose.rotation }
            } else {
                let parent = links[segment.parent];
                let position = parent.position + parent.rotation * segment.offset;
                LinkTransform { position, rotation: (parent.rotation * posed.pose.joints[k]).normalize() }
            };
            links.push(place);
        }
        let touches =
            |l: usize, end: DVec3, radius: f64| (links[l].position + links[l].rotation * end).y - radius < TOUCH;
        let mut marked = Vec::new();
        for (l, link) in alone.links.iter().enumerate() {
            for (s, shape) in link.shapes.iter().enumerate() {
                let touching = match *shape {
                    Shape::Capsule { a, b, radius } => touches(l, a, radius) || touches(l, b, radius),
                    Shape::Sphere { center, radius } => touches(l, center, radius),
                    Shape::Box { center, half_extents, rotation } => {
                        let low = center + rotation * (DVec3::NEG_Y * half_extents.y);
                        touches(l, low, 0.0)
                    }
                };
                if touching {
                    marked.push((l, s));
                }
            }
        }
        let caption = posed.basic.name().replace('_', " ");
        StoryboardFrame { marked, caption, ..StoryboardFrame::new(k as f64, links) }
    };
    poses.iter().enumerate().map(frame).collect()
}
