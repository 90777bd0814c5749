//! Where the touching segments shall be, and their rows of the Jacobian.

use super::stance::AnkleStance;
use crate::asset::Side;
use crate::asset::turn::rotation_by;
use crate::contact::Terrain;
use crate::control::foot::{
    FootAnatomy, FootPose, FootPoseOptions, FootPoseRequest, GroundPlane, MOST_SEGMENTS, SegmentSet, foot_pose,
};
use crate::dynamics::LinkKinematics;
use crate::math::Vec3;
use glam::{DMat3, DQuat, DVec3};

/// Distance below which the ground is looked for under a foot, m.
const REACH: f64 = 1.0;
/// How far a segment may be from where it shall be before that place is drawn along, m.
const LEASH: f64 = 0.01;
/// A point belongs to the sole of its segment where it lies within this of the segment's lowest, m.
const SOLE: f64 = 0.003;

/// The ground under a segment is another plane than that under its ankle where its height or its normal differ by more than this, m and
/// rad, and its own is taken up to these differences: a foot bends over a ball, not down a step.
const OTHER: f64 = 1e-6;
const BEND: (f64, f64) = (0.03, 0.6);

/// Where a segment shall stand: its joint, its axes, world frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Anchor {
    pub place: DVec3,
    pub rotation: DQuat,
}

/// One foot and the ground under it.
#[derive(Clone, Debug)]
pub(super) struct Footing {
    pub anatomy: FootAnatomy,
    /// The ground under it.
    pub ground: GroundPlane,
    /// Where it points, unit, in the plane.
    pub toward: DVec3,
    /// Velocity of the ground, m/s, and its angular velocity, rad/s.
    pub drift: DVec3,
    pub spin: DVec3,
    pub anchors: [Anchor; MOST_SEGMENTS],
    /// The rise and the roll that it has come to.
    pub rise: f64,
    pub roll: f64,
    /// Largest distance of a segment's sole from the ground, m, by segment.
    pub gaps: [f64; MOST_SEGMENTS],
    /// Segments on their way to the ground: those that shall touch and have not touched yet.
    pub coming: SegmentSet,
    /// The pose it shall take.
    pub pose: Option<FootPose>,
}

impl Footing {
    pub(super) fn new(anatomy: FootAnatomy) -> Self {
        Self {
            anatomy,
            ground: GroundPlane::LEVEL,
            toward: DVec3::NEG_Z,
            drift: DVec3::ZERO,
            spin: DVec3::ZERO,
            anchors: [Anchor::default(); MOST_SEGMENTS],
            rise: 0.0,
            roll: 0.0,
            gaps: [0.0; MOST_SEGMENTS],
            coming: SegmentSet::NONE,
            pose: None,
        }
    }

    /// Stands all segments flat on the ground where they are.
    pub(super) fn settle(&mut self, kinematics: &[LinkKinematics<f64>], root: DVec3, terrain: &impl Terrain<f64>) {
        let ankle = &kinematics[self.anatomy.ankle()];
        let at = root + ankle.origin.lane(0);
        self.ground = GroundPlane::under(terrain, at, REACH).unwrap_or(GroundPlane { point: at, normal: DVec3::Y });
        let n = self.ground.normal;
        let ahead = ankle.rotation.lane(0) * self.anatomy.forward();
        self.toward = (ahead - n * ahead.dot(n)).try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
        (self.rise, self.roll) = (0.0, 0.0);
        self.coming = self.anatomy.standing();
        for k in 0..self.anatomy.segments().len() {
            self.gaps[k] = self.gap(k, kinematics, root, terrain);
            self.stand(k, root + kinematics[self.anatomy.segments()[k].link].origin.lane(0), terrain);
        }
    }

    /// Where a segment stands whose joint is at `place`: parallel to the ground under it, its sole on it.
    pub(super) fn stand(&mut self, k: usize, place: DVec3, terrain: &impl Terrain<f64>) {
        let ground = GroundPlane::under(terrain, place, REACH).unwrap_or(self.ground);
        let up = ground.normal * (self.anatomy.segments()[k].drop - ground.height(place));
        self.anchors[k] = Anchor { place: place + up, rotation: self.flat_on(ground.normal) };
    }

    /// From the axes of a foot that stands flat to the world's.
    pub(super) fn flat(&self) -> DQuat {
        self.flat_on(self.ground.normal)
    }

    /// The same on ground with this normal.
    fn flat_on(&self, n: DVec3) -> DQuat {
        let t = (self.toward - n * self.toward.dot(n)).try_normalize().unwrap_or(self.toward);
        let forward = self.anatomy.forward();
        let to = |up: DVec3, along: DVec3| DMat3::from_cols(up.cross(along), up, along);
        (DQuat::from_mat3(&to(n, t)) * DQuat::from_mat3(&to(DVec3::Y, forward)).conjugate()).normalize()
    }

    /// Looks at the ground again after `seconds`: anchors go along with it, and are drawn after segments that slid; a segment whose sole
    /// is further than `contact` (m) from the ground has its anchor straight below.
    pub(super) fn look(
        &mut self,
        kinematics: &[LinkKinematics<f64>],
        root: DVec3,
        terrain: &impl Terrain<f64>,
        seconds: f64,
        contact: f64,
    ) {
        let at = root + kinematics[self.anatomy.ankle()].origin.lane(0);
        let Some(ground) = GroundPlane::under(terrain, at, REACH) else { return };
        let below = at - ground.normal * ground.height(at);
        (self.drift, self.spin) = motion_of(terrain, below, ground.normal, self.toward);
        self.ground = ground;
        let n = ground.normal;
        self.toward = (self.toward - n * self.toward.dot(n)).try_normalize().unwrap_or(self.toward);
        for k in 0..self.anatomy.segments().len() {
            self.gaps[k] = self.gap(k, kinematics, root, terrain);
            if self.gaps[k] < contact {
                self.coming = self.coming.without(k);
            }
            let joint = root + kinematics[self.anatomy.segments()[k].link].origin.lane(0);
            let mut place = if self.gaps[k] < contact { self.anchors[k].place + self.drift * seconds } else { joint };
            let slid = joint - place;
            let slid = slid - n * slid.dot(n);
            if slid.length() > LEASH {
                place += slid * (1.0 - LEASH / slid.length());
            }
            self.stand(k, place, terrain);
        }
    }

    /// Largest distance of the points of a segment's sole from the ground, m; the arch, which never comes down, does not count.
    fn gap(&self, k: usize, kinematics: &[LinkKinematics<f64>], root: DVec3, terrain: &impl Terrain<f64>) -> f64 {
        let segment = &self.anatomy.segments()[k];
        let at = &kinematics[segment.link];
        let sole = segment.points.iter().filter(|p| segment.drop + p.0.y - p.1 < SOLE);
        let gap = |p: &(DVec3, f64, usize)| {
            let center = root + at.origin.lane(0) + at.rotation.lane(0) * p.0;
            terrain.query(Vec3::<f64>::splat(center)).distance - p.1
        };
        sole.map(gap).fold(0.0, f64::max)
    }

    /// The segments among `touch` whose soles are nearer to the ground than `soon`, m.
    pub(super) fn near(&self, touch: SegmentSet, soon: f64) -> SegmentSet {
        let near = touch.iter().filter(|&k| self.gaps[k] < soon);
        near.fold(SegmentSet::NONE, SegmentSet::with)
    }

    /// Height of the ankle over the ground where the whole sole stands, m.
    pub(super) fn flat_height(&self) -> f64 {
        let ankle = &self.anatomy.segments()[0];
        let height = self.anatomy.segments().iter().find(|s| s.stands && s.parent == 0 && s.link != ankle.link);
        height.map_or(ankle.drop, |s| s.drop - s.offset.y)
    }

    /// The pose that foot pose control asks for: the ankle as high above a flat sole's as the stance has come to.
    pub(super) fn shape(&mut self, stance: &AnkleStance) {
        let height = self.flat_height();
        let inward = if self.anatomy.side == Some(Side::Right) { -1.0 } else { 1.0 };
        let forward = self.anatomy.forward();
        let rotation = (self.flat() * rotation_by(-forward * (-inward * self.roll))).normalize();
        let mut under = [None; MOST_SEGMENTS];
        for (k, under) in under.iter_mut().enumerate().take(self.anatomy.segments().len()).skip(1) {
            *under = self.other_ground(k);
        }
        let request = FootPoseRequest {
            under,
            ankle: self.ground.point + self.ground.normal * (height + self.rise),
            rotation,
            direction: self.toward,
            touch: stance.touch,
            ground: self.ground,
        };
        self.pose = Some(foot_pose(&self.anatomy, &request, &FootPoseOptions::default()));
    }

    /// The ground that segment `k` shall stand on where that is not the foot's.
    fn other_ground(&self, k: usize) -> Option<GroundPlane> {
        let anchor = self.anchors[k];
        let normal = anchor.rotation * DVec3::Y;
        let own = GroundPlane { point: anchor.place - normal * self.anatomy.segments()[k].drop, normal };
        let (off, bend) = (self.ground.height(own.point).abs(), (normal - self.ground.normal).length());
        ((off > OTHER || bend > OTHER) && off < BEND.0 && bend < BEND.1).then_some(own)
    }

    /// Places, seen from above, at which the points of these segments touch where they shall stand, world frame, m.
    pub(super) fn touching_places(&self, touch: SegmentSet) -> impl Iterator<Item = DVec3> + '_ {
        let segments = self.anatomy.segments();
        touch.iter().filter(move |&k| k < segments.len()).flat_map(move |k| {
            let anchor = self.anchors[k];
            let n = anchor.rotation * DVec3::Y;
            let sole = segments[k].points.iter().filter(move |p| segments[k].drop + p.0.y - p.1 < SOLE);
            sole.map(move |p| anchor.place + anchor.rotation * p.0 - n * p.1)
        })
    }
}

/// Velocity (m/s) and angular velocity (rad/s) of the ground at a point of it, from the velocities there, ahead and aside.
fn motion_of(terrain: &impl Terrain<f64>, at: DVec3, n: DVec3, toward: DVec3) -> (DVec3, DVec3) {
    /// How far ahead and aside, m.
    const ASIDE: f64 = 0.05;
    let t = (toward - n * toward.dot(n)).try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
    let b = n.cross(t);
    let velocity = |p: DVec3| terrain.query(Vec3::<f64>::splat(p)).velocity.lane(0);
    let drift = velocity(at);
    let (ahead, aside) = ((velocity(at + t * ASIDE) - drift) / ASIDE, (velocity(at + b * ASIDE) - drift) / ASIDE);
    // w x t = ahead, w x b = aside.
    (drift, t * aside.dot(n) - b * ahead.dot(n) + n * ahead.dot(b))
}
