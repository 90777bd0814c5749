//! The links of a foot as segments: what the pose controller reads of a model, once.

use super::segments::{BasicPose, MOST_SEGMENTS, SegmentSet};
use crate::asset::Side;
use crate::model::{CharacterModel, Foot, FootKind, JointKind, JointLimits};
use glam::DVec3;

/// A segment stands where, in the zero pose, it reaches within this of the lowest point of its foot, m.
const SOLE: f64 = 0.002;

/// Why a foot cannot be posed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FootError {
    /// The character has no such foot.
    #[error("{character} has {count} feet, so no foot number {index}")]
    NoFoot {
        /// The character.
        character: String,
        /// The number asked for.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A foot that stands on a blade.
    #[error("foot {index} of {character} stands on a blade; a foot of segments stands on a sole")]
    Blade {
        /// The character.
        character: String,
        /// The foot.
        index: usize,
    },
    /// More links than the controller poses.
    #[error("foot {index} of {character} has {found} links, 1 to 8 can be posed")]
    LinkCount {
        /// The character.
        character: String,
        /// The foot.
        index: usize,
        /// Its links.
        found: usize,
    },
    /// Not one tree that hangs on one ankle.
    #[error(
        "link {link} of foot {index} of {character} hangs on none of the foot's links before it: a foot is one tree below its ankle"
    )]
    NoTree {
        /// The character.
        character: String,
        /// The foot.
        index: usize,
        /// The link.
        link: String,
    },
    /// Nothing to stand on.
    #[error("foot {index} of {character} has no contact point, so no sole")]
    NoSole {
        /// The character.
        character: String,
        /// The foot.
        index: usize,
    },
    /// A basic pose that needs segments this foot lacks.
    #[error("foot {index} of {character} has no {missing}, which the pose {pose} stands on")]
    LacksSegments {
        /// The character.
        character: String,
        /// The foot.
        index: usize,
        /// The pose.
        pose: &'static str,
        /// What is missing.
        missing: &'static str,
    },
}

/// One link of a foot.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Name of the link.
    pub name: String,
    /// Index of the link.
    pub link: usize,
    /// Index of the segment it hangs on; its own for the ankle's.
    pub parent: usize,
    /// Its joint in the frame of that segment, m; zero for the ankle's.
    pub offset: DVec3,
    /// How far its sole lies below its joint when it is parallel to the ground, m: the radius r_c of the paper, by segment.
    pub drop: f64,
    /// Whether it stands on the ground in the zero pose.
    pub stands: bool,
    /// Bounds of its joint's rotation vector.
    pub limits: Option<JointLimits>,
    /// Axis of a hinge.
    pub hinge: Option<DVec3>,
    /// Its contact points: centre (link frame) and radius, m, and index in the model.
    pub points: Vec<(DVec3, f64, usize)>,
}

/// A foot, read from the model's links and contact points. Segment 0 is the ankle's.
#[derive(Clone, Debug, PartialEq)]
pub struct FootAnatomy {
    /// Side of the body.
    pub side: Option<Side>,
    segments: Vec<Segment>,
    forward: DVec3,
    character: String,
    index: usize,
}

impl FootAnatomy {
    /// Foot number `index` of a model.
    pub fn of(model: &CharacterModel, index: usize) -> Result<Self, FootError> {
        let character = model.name.clone();
        let Some(foot) = model.feet().get(index) else {
            return Err(FootError::NoFoot { character, index, count: model.feet().len() });
        };
        if matches!(foot.kind, FootKind::Blade(_)) {
            return Err(FootError::Blade { character, index });
        }
        if !(1..=MOST_SEGMENTS).contains(&foot.links.len()) {
            return Err(FootError::LinkCount { character, index, found: foot.links.len() });
        }
        let segments = segments(model, foot).map_err(|link| {
            let link = model.links[link].name.clone();
            FootError::NoTree { character: character.clone(), index, link }
        })?;
        if segments.iter().all(|s| s.points.is_empty()) {
            return Err(FootError::NoSole { character, index });
        }
        let places = model.rest_positions();
        let toe = &model.contact_points[foot.toe];
        let ahead = places[toe.link] + toe.position - places[segments[0].link];
        let forward = DVec3::new(ahead.x, 0.0, ahead.z).try_normalize().unwrap_or(DVec3::NEG_Z);
        // The foot's own long axis where the toe lies to a side: the character faces -Z.
        let forward = if forward.z < -0.5 { DVec3::NEG_Z } else { forward };
        Ok(Self { side: foot.side, segments, forward, character, index })
    }

    /// Its segments, the ankle's first, each after the one it hangs on.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Index of the ankle's link.
    pub fn ankle(&self) -> usize {
        self.segments[0].link
    }

    /// The direction of every segment in its own frame: where the foot points in the zero pose (unit, horizontal there).
    pub fn forward(&self) -> DVec3 {
        self.forward
    }

    /// All segments that stand in the zero pose.
    pub fn standing(&self) -> SegmentSet {
        self.pick(|s| s.stands)
    }

    /// The segments of a basic pose, found from where soles lie about the ankle; no name of a link counts.
    pub fn set(&self, pose: BasicPose) -> Result<SegmentSet, FootError> {
        let lacks = |missing| FootError::LacksSegments {
            character: self.character.clone(),
            index: self.index,
            pose: pose.name(),
            missing,
        };
        let some = |set: SegmentSet, missing| if set.is_empty() { Err(lacks(missing)) } else { Ok(set) };
        let heel = || some(self.pick_placed(|s, at| s.stands && at.z > 0.0), "segment behind the ankle");
        let join = |a: SegmentSet, b: SegmentSet| b.iter().fold(a, SegmentSet::with);
        match pose {
            BasicPose::Rest => some(self.standing(), "segment that stands"),
            BasicPose::Tiptoe => some(self.toes(), "toe segment ahead of the ankle"),
            BasicPose::InsideTilt => Ok(join(heel()?, some(self.to_side(true), "medial segment ahead of the ankle")?)),
            BasicPose::OutsideTilt => {
                Ok(join(heel()?, some(self.to_side(false), "lateral segment ahead of the ankle")?))
            }
        }
    }

    /// The contact points that lie behind the ankle in the zero pose, and those before it, by index in the model.
    pub fn rear_and_front(&self) -> (Vec<usize>, Vec<usize>) {
        let (mut rear, mut front) = (Vec::new(), Vec::new());
        for (k, segment) in self.segments.iter().enumerate() {
            let joint = self.joint_place(k);
            for (at, _, index) in &segment.points {
                let ahead = (joint + *at).dot(self.forward) >= 0.0;
                if ahead { &mut front } else { &mut rear }.push(*index);
            }
        }
        (rear, front)
    }

    /// Segments ahead of the ankle that nothing hangs on.
    fn toes(&self) -> SegmentSet {
        let leaf =
            |link: usize| !self.segments.iter().enumerate().any(|(k, s)| k > 0 && self.segments[s.parent].link == link);
        self.pick_placed(|s, at| s.stands && at.z < 0.0 && leaf(s.link))
    }

    /// Segments ahead of the ankle on the medial or the lateral side of the middle of those soles; none of a foot that has only
    /// one there, or is on no side. Beside a heel one joint on the ankle's link comes to the ground where the foot is tilted: of those on
    /// that side the outermost, with what hangs on it.
    fn to_side(&self, medial: bool) -> SegmentSet {
        let ahead = |s: &Segment, at: DVec3| s.stands && at.z < 0.0;
        let (mut sum, mut count) = (0.0, 0.0);
        for (k, segment) in self.segments.iter().enumerate() {
            let at = self.place(k);
            if ahead(segment, at) {
                sum += segment.points.iter().map(|p| p.0.x + at.x - self.middle(k).x).sum::<f64>();
                count += segment.points.len() as f64;
            }
        }
        let inward = match self.side {
            Some(Side::Left) => 1.0,
            Some(Side::Right) => -1.0,
            None => return SegmentSet::NONE,
        };
        let middle = sum / f64::max(count, 1.0);
        let out = if medial { inward } else { -inward };
        let side = self.pick_placed(|s, at| ahead(s, at) && (at.x - middle) * out > 1e-6);
        let on_ankle = side.iter().filter(|&k| self.segments[k].parent == 0);
        let edge = on_ankle.max_by(|&a, &b| (self.place(a).x * out).total_cmp(&(self.place(b).x * out)));
        let inner = |k: usize| self.segments[k].parent == 0 && Some(k) != edge;
        side.iter().filter(|&k| !inner(k)).fold(SegmentSet::NONE, SegmentSet::with)
    }

    /// Middle of a segment's points, its own frame.
    fn middle(&self, k: usize) -> DVec3 {
        let points = &self.segments[k].points;
        points.iter().map(|p| p.0).sum::<DVec3>() / (points.len().max(1) as f64)
    }

    /// Middle of a segment's points about the ankle in the zero pose, m.
    fn place(&self, k: usize) -> DVec3 {
        self.middle(k) + self.joint_place(k)
    }

    /// A segment's joint about the ankle in the zero pose, m.
    fn joint_place(&self, mut k: usize) -> DVec3 {
        let mut at = DVec3::ZERO;
        while k != 0 {
            at += self.segments[k].offset;
            k = self.segments[k].parent;
        }
        at
    }

    fn pick(&self, chosen: impl Fn(&Segment) -> bool) -> SegmentSet {
        self.pick_placed(|s, _| chosen(s))
    }

    fn pick_placed(&self, chosen: impl Fn(&Segment, DVec3) -> bool) -> SegmentSet {
        let all = self.segments.iter().enumerate();
        all.filter(|(k, s)| chosen(s, self.place(*k))).fold(SegmentSet::NONE, |set, (k, _)| set.with(k))
    }
}

/// The links of a foot as segments, or the link that hangs on none of those before it.
fn segments(model: &CharacterModel, foot: &Foot) -> Result<Vec<Segment>, usize> {
    let places = model.rest_positions();
    let bottom = |link: usize, p: DVec3, radius: f64| places[link].y + p.y - radius;
    let floor = model.foot_points(foot).map(|p| &model.contact_points[p]);
    let floor = floor.map(|p| bottom(p.link, p.position, p.radius)).fold(f64::INFINITY, f64::min);
    let mut segments: Vec<Segment> = Vec::with_capacity(foot.links.len());
    for &index in &foot.links {
        let link = &model.links[index];
        let parent = segments.iter().position(|s| Some(s.link) == link.parent);
        if parent.is_none() && !segments.is_empty() {
            return Err(index);
        }
        let own = model.contact_points.iter().enumerate().filter(|(_, p)| p.link == index);
        let points: Vec<(DVec3, f64, usize)> = own.map(|(k, p)| (p.position, p.radius, k)).collect();
        let lowest = points.iter().map(|p| p.0.y - p.1).fold(f64::INFINITY, f64::min);
        segments.push(Segment {
            name: link.name.clone(),
            link: index,
            parent: parent.unwrap_or(0),
            offset: if parent.is_some() { link.offset } else { DVec3::ZERO },
            drop: if points.is_empty() { 0.0 } else { -lowest },
            stands: points.iter().any(|p| bottom(index, p.0, p.1) < floor + SOLE),
            limits: link.limits,
            hinge: match link.joint {
                JointKind::Hinge { axis } => Some(axis),
                JointKind::Ball | JointKind::Free => None,
            },
            points,
        });
    }
    Ok(segments)
}
