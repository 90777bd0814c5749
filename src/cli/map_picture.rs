//! What a map makes of a file, to look at: the source's skeleton as sticks, beside it the character that follows it.
//!
//! A limb that hangs on the wrong joint, a rest pose that was taken for another one, a bone that is turned about itself: in a table
//! they look like any other row, side by side they do not. Sticks have the colour of the link that they drive; what drives nothing,
//! and what follows nothing, is marked.

use crate::asset::bvh::Bvh;
use crate::model::{
    CharacterModel, FoundMap, ImportError, Link, LinkTransform, RestPose, Shape, import_bvh, import_scale,
};
use crate::storyboard::{StoryboardFrame, travel};
use glam::{DQuat, DVec3};

/// Radius of a stick, in heights of the character's root: 2 cm on a grown person.
const STICK: f64 = 0.022;
/// Distance between the two figures, in heights of the character's root.
const APART: f64 = 1.4;
/// Shortest bone that is drawn, m.
const SHORTEST: f64 = 1e-4;

/// Source and character side by side.
#[derive(Clone, Debug)]
pub struct MapPicture {
    /// A body to be drawn and never simulated: a link without a shape in the middle, the character's links, then one for each joint of
    /// the source, called by the link that it drives.
    pub model: CharacterModel,
    /// The pose at zero, where it is one in which a person could stand; then instants of the motion at even times. The source stands
    /// on the left of the camera, the character on the right.
    pub frames: Vec<StoryboardFrame>,
}

/// Draws what a map that was found makes of a file: up to `poses` instants of the motion, seen from `azimuth` (rad, as
/// [`StoryboardOptions`](crate::storyboard::StoryboardOptions) has it).
pub fn map_picture(
    bvh: &Bvh,
    found: &FoundMap,
    model: &CharacterModel,
    poses: usize,
    azimuth: f64,
) -> Result<MapPicture, ImportError> {
    let scale = import_scale(bvh, &found.map, model)?;
    let (drawn, marked) = drawn_model(bvh, found, model, scale);
    let motion = Pairs::new(bvh, found, model, scale)?;
    let last = bvh.frame_count() - 1;
    let count = poses.clamp(1, bvh.frame_count());
    let shown: Vec<usize> = (0..count).map(|k| k * last / (count - 1).max(1)).collect();

    let bodies: Vec<StoryboardFrame> =
        shown.iter().map(|&k| StoryboardFrame::new(0.0, motion.body(k).to_vec())).collect();
    let ahead = travel(&bodies);
    let level = ahead.cross(DVec3::Y) * azimuth.cos() + ahead * azimuth.sin();
    let aside = DVec3::Y.cross(level) * (0.5 * APART * model.rest_root_height());

    let mut frames = Vec::with_capacity(count + 1);
    if found.rest != RestPose::None {
        let mut zero = Pairs::new(&bvh.at_zero(), found, model, scale)?;
        // As the motion begins, however the file has it: one camera looks at all.
        zero.face(motion.heading());
        let caption = format!("all rotations zero: {}", found.rest);
        frames.push(StoryboardFrame { caption, ..StoryboardFrame::new(0.0, zero.side_by_side(0, aside)) });
    }
    for k in shown {
        let links = motion.side_by_side(k, aside);
        frames.push(StoryboardFrame::new(k as f64 * bvh.frame_time(), links));
    }
    for frame in &mut frames {
        frame.marked.clone_from(&marked);
    }
    Ok(MapPicture { model: drawn, frames })
}

/// The body that is drawn, and the shapes on it that drive or follow nothing, by link and number.
fn drawn_model(
    bvh: &Bvh,
    found: &FoundMap,
    model: &CharacterModel,
    scale: f64,
) -> (CharacterModel, Vec<(usize, usize)>) {
    let radius = STICK * model.rest_root_height();
    let plain = |name: String, shapes: Vec<Shape>| Link { name, shapes, mass: 0.0, ..model.links[0].clone() };
    let driven_by = |joint: &str| found.rows.iter().find(|row| row.joints.iter().any(|j| j == joint));
    let mut drawn = model.clone();
    let mut marked = Vec::new();
    drawn.links.insert(0, plain("middle".into(), Vec::new()));
    drawn.blades.iter_mut().for_each(|blade| blade.link += 1);
    drawn.contact_points.iter_mut().for_each(|point| point.link += 1);
    for (k, link) in drawn.links.iter().enumerate().skip(1) {
        if !found.rows.iter().any(|row| row.link == link.name) {
            marked.extend((0..link.shapes.len()).map(|shape| (k, shape)));
        }
    }
    for (j, joint) in bvh.joints().iter().enumerate() {
        let below = (j + 1..bvh.joints().len()).filter(|&c| bvh.joints()[c].parent == Some(j));
        // Position channels take the place of the offset, in some files of all joints.
        let ends = below.map(|c| bvh.local_transform(c, 0).position).chain(joint.end_sites.iter().copied());
        let sticks = ends.map(|end| end * scale).filter(|end| end.length() > SHORTEST);
        let shapes: Vec<Shape> = sticks.map(|b| Shape::Capsule { a: DVec3::ZERO, b, radius }).collect();
        let row = driven_by(&joint.name);
        if row.is_none() {
            marked.extend((0..shapes.len()).map(|shape| (drawn.links.len(), shape)));
        }
        drawn.links.push(plain(row.map_or_else(|| joint.name.clone(), |row| row.link.clone()), shapes));
    }
    (drawn, marked)
}

/// Places of the character's links and of the source's joints, frame by frame, world frame.
struct Pairs {
    frames: Vec<(Vec<LinkTransform>, Vec<LinkTransform>)>,
}

impl Pairs {
    /// The source's pelvis lies where the character's root is.
    fn new(bvh: &Bvh, found: &FoundMap, model: &CharacterModel, scale: f64) -> Result<Self, ImportError> {
        let clip = import_bvh(bvh, &found.map, model)?.to_model(model)?;
        let world = found.map.world_rotation();
        let pelvis = found.map.root.joints.last().and_then(|name| bvh.joint_index(name)).unwrap_or(0);
        let frames = clip.poses().iter().enumerate().map(|(k, pose)| {
            let mut body = Vec::with_capacity(model.links.len());
            pose.link_transforms(model, &mut body);
            let joints = bvh.world_transforms(k);
            let (from, to) = (joints[pelvis].position, body[0].position);
            let sticks = joints.iter().map(|joint| LinkTransform {
                position: to + world * (joint.position - from) * scale,
                rotation: (world * joint.rotation).normalize(),
            });
            let sticks = sticks.collect();
            (body, sticks)
        });
        Ok(Self { frames: frames.collect() })
    }

    fn body(&self, k: usize) -> &[LinkTransform] {
        &self.frames[k].0
    }

    /// Which way the character faces in the first frame: angle from +Z about the vertical, rad.
    fn heading(&self) -> f64 {
        let ahead = self.body(0)[0].rotation * DVec3::NEG_Z;
        ahead.x.atan2(ahead.z)
    }

    /// Turns all frames about the vertical so that the first one faces this way.
    fn face(&mut self, heading: f64) {
        let turn = DQuat::from_rotation_y(heading - self.heading());
        for (body, sticks) in &mut self.frames {
            let center = body[0].position;
            for place in body.iter_mut().chain(sticks) {
                place.position = center + turn * (place.position - center);
                place.rotation = turn * place.rotation;
            }
        }
    }

    /// The links of the drawn body: the middle, the character to one side, the source to the other.
    fn side_by_side(&self, k: usize, aside: DVec3) -> Vec<LinkTransform> {
        let (body, sticks) = &self.frames[k];
        let moved = |by: DVec3| move |p: &LinkTransform| LinkTransform { position: p.position + by, ..*p };
        let character = body.iter().map(moved(aside));
        std::iter::once(body[0]).chain(character).chain(sticks.iter().map(moved(-aside))).collect()
    }
}
