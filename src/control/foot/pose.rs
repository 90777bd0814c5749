//! The pose of a foot: ankle, joints, and what could not be met.

use super::aim::{arc, frame, least, level};
use super::anatomy::{FootAnatomy, Segment};
use super::ankle::{AnkleMove, Fixed, FixedJoints, Ground, move_ankle, roll_of};
use super::ground::GroundPlane;
use super::segments::{MOST_SEGMENTS, SegmentSet};
use crate::asset::turn::{rotation_by, rotation_vector, twist};
use crate::model::JointLimits;
use glam::{DQuat, DVec3};

/// Heights below the plane that count as touching, m.
const TOUCH: f64 = 1e-4;
/// A tilt below which a sole counts as parallel to the ground, rad: 0.2 degrees.
const PARALLEL: f64 = 0.0035;

/// What is asked of a foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootPoseRequest {
    /// Where the ankle is, world frame, m.
    pub ankle: DVec3,
    /// How the ankle's link is turned in the reference, to world axes.
    pub rotation: DQuat,
    /// Where the foot points in the reference: from the ankle to the toes, world axes, any length (the paper's a).
    pub direction: DVec3,
    /// The segments that shall touch.
    pub touch: SegmentSet,
    /// The ground under the foot.
    pub ground: GroundPlane,
    /// The ground under single segments where it is another plane, as on a ball, by segment.
    pub under: [Option<GroundPlane>; MOST_SEGMENTS],
}

impl FootPoseRequest {
    /// The plane that segment `k` shall lie on.
    fn plane(&self, k: usize) -> GroundPlane {
        self.under.get(k).copied().flatten().unwrap_or(self.ground)
    }

    /// How high over the foot's plane the joint of segment `k` is whose sole lies on its own, m.
    fn joint_height(&self, segments: &[Segment], k: usize) -> f64 {
        let drop = segments[k].drop;
        self.under[k].map_or(drop, |own| self.ground.height(own.point + own.normal * drop))
    }
}

/// Bounds of what the controller may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootPoseOptions {
    /// Most roll about the foot's direction that bringing one joint, or two joints against each other, to the ground may add, rad.
    pub most_roll: f64,
    /// Farthest that the ankle may be moved, m.
    pub most_displacement: f64,
}

impl Default for FootPoseOptions {
    fn default() -> Self {
        Self { most_roll: 3f64.to_radians(), most_displacement: 0.02 }
    }
}

/// Why a segment is not where it was asked to be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FootFault {
    /// Its joint cannot come to the height at which its sole would touch.
    OutOfReach {
        /// Height of the sole over the ground, negative below it, m.
        gap: f64,
    },
    /// Its joint's limits, or a hinge's axis, keep it from lying parallel to the ground.
    JointLimit {
        /// By how much the joint would have to turn further, rad.
        missing: f64,
    },
    /// It was not asked to touch, and lies in the ground.
    DigsIn {
        /// How deep, m.
        depth: f64,
    },
}

/// One segment of the report.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SegmentReport {
    /// Height of the segment's lowest point over the ground, negative below it, m; infinite without points.
    pub gap: f64,
    /// Angle between its sole and the ground, rad.
    pub tilt: f64,
    /// What kept it.
    pub fault: Option<FootFault>,
}

/// What was done and what could not be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FootPoseReport {
    /// Way of the ankle along the ground's normal, m.
    pub displacement: f64,
    /// Rotation of the ankle on top of the reference's, rad.
    pub rotation: f64,
    /// The part of it about the foot's direction, rad.
    pub roll: f64,
    /// Segments that lie on the ground.
    pub touching: SegmentSet,
    /// Segments among them that were not asked to touch, but would have dug in.
    pub added: SegmentSet,
    /// The vector from the ankle to a chosen joint is parallel to the normal: the axis of the smallest rotation was not determined,
    /// and that across the foot was taken.
    pub parallel: bool,
    /// The reference's direction is parallel to the normal: that of the ankle's link was taken.
    pub no_direction: bool,
    /// By segment.
    pub segments: [SegmentReport; MOST_SEGMENTS],
}

impl FootPoseReport {
    /// Whether every chosen segment touches and nothing digs in.
    pub fn is_met(&self) -> bool {
        self.segments.iter().all(|s| s.fault.is_none())
    }
}

/// The pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootPose {
    /// Where the ankle goes, world frame, m.
    pub ankle: DVec3,
    /// How the ankle's link turns, to world axes.
    pub rotation: DQuat,
    /// Target of each segment's joint, child axes to parent axes; entry 0 is unused, the ankle's own joint depends on the shin (see
    /// [`FootPose::ankle_joint`]).
    pub joints: [DQuat; MOST_SEGMENTS],
    /// What was done.
    pub report: FootPoseReport,
}

impl FootPose {
    /// Target of the ankle's joint under a shin that is turned so (to world axes), within the joint's limits, and the rotation that
    /// those keep back, rad.
    pub fn ankle_joint(&self, foot: &FootAnatomy, shin: DQuat) -> (DQuat, f64) {
        let ankle = &foot.segments()[0];
        constrained((shin.conjugate() * self.rotation).normalize(), ankle.hinge, ankle.limits)
    }
}

/// The pose of a foot. Allocates nothing.
pub fn foot_pose(foot: &FootAnatomy, request: &FootPoseRequest, options: &FootPoseOptions) -> FootPose {
    let n = request.ground.normal;
    // Equation 3.
    let own = request.rotation * foot.forward();
    let asked = level(request.direction, n);
    let t = asked.or_else(|| level(own, n)).unwrap_or_else(|| n.any_orthonormal_vector());
    let ground = Ground { n, t };

    // What would dig in is stood on: it joins the set, and the pose is found anew.
    let mut touch = request.touch;
    loop {
        let mut pose = within_limits(foot, request, options, ground, touch);
        let digging = (1..foot.segments().len())
            .find(|&k| !touch.contains(k) && foot.segments()[k].stands && pose.report.segments[k].gap < -TOUCH);
        match digging {
            Some(k) => touch = touch.with(k),
            None => {
                lift(foot, request, options, touch, &mut pose);
                pose.report.no_direction = asked.is_none();
                for k in touch.iter().filter(|&k| !request.touch.contains(k)) {
                    pose.report.added = pose.report.added.with(k);
                }
                return pose;
            }
        }
    }
}

/// The pose in which the segments `touch` are brought to the ground. Where one joint would have to turn beyond its limits for it, the
/// ankle turns less and moves for the rest: as far as it can turn, by halving.
fn within_limits(
    foot: &FootAnatomy,
    request: &FootPoseRequest,
    options: &FootPoseOptions,
    ground: Ground,
    touch: SegmentSet,
) -> FootPose {
    let at = |part: f64| posed(foot, request, options, ground, touch, part);
    let limited =
        |pose: &FootPose| pose.report.segments.iter().any(|s| matches!(s.fault, Some(FootFault::JointLimit { .. })));
    let whole = at(1.0);
    if !limited(&whole) {
        return whole;
    }
    let mut best = at(0.0);
    if limited(&best) {
        return whole;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..10 {
        let middle = 0.5 * (low + high);
        let pose = at(middle);
        if limited(&pose) {
            high = middle;
        } else {
            (low, best) = (middle, pose);
        }
    }
    best
}

/// The pose in which the ankle makes the part `part` of its turn.
fn posed(
    foot: &FootAnatomy,
    request: &FootPoseRequest,
    options: &FootPoseOptions,
    ground: Ground,
    touch: SegmentSet,
    part: f64,
) -> FootPose {
    let Ground { n, t } = ground;
    let segments = foot.segments();
    let ankle_height = request.ground.height(request.ankle);
    let ahead = request.rotation * foot.forward();
    let mut joints = FixedJoints::default();
    for k in touch.iter().filter(|&k| k > 0 && k < segments.len() && segments[k].parent == 0) {
        let height = request.joint_height(segments, k) - ankle_height;
        joints.push(Fixed { arm: request.rotation * segments[k].offset, height }, ahead);
    }
    // Where only segments are chosen that hang on others, the ankle aims with the first of those, its parent's joint straight.
    if joints.is_empty() {
        let far = touch.iter().find(|&k| k > 0 && k < segments.len());
        if let Some(k) = far.filter(|&k| segments[segments[k].parent].parent == 0) {
            let arm = request.rotation * (segments[segments[k].parent].offset + segments[k].offset);
            joints.push(Fixed { arm, height: request.joint_height(segments, k) - ankle_height }, ahead);
        }
    }
    let sole = touch.contains(0).then(|| (request.rotation * DVec3::Y, segments[0].drop - ankle_height));
    let AnkleMove { rotation, displacement, parallel } = move_ankle(&joints, sole, ground, options.most_roll, part);
    let displacement = displacement.clamp(-options.most_displacement, options.most_displacement);

    let mut pose = FootPose {
        ankle: request.ankle + n * displacement,
        rotation: (rotation * request.rotation).normalize(),
        joints: [DQuat::IDENTITY; MOST_SEGMENTS],
        report: FootPoseReport {
            displacement,
            rotation: rotation_vector(rotation).length(),
            roll: roll_of(rotation, t),
            parallel,
            ..FootPoseReport::default()
        },
    };
    let mut place = [(pose.ankle, pose.rotation); MOST_SEGMENTS];
    for (k, segment) in segments.iter().enumerate() {
        let mut missing = 0.0;
        if k > 0 {
            let (origin, parent) = place[segment.parent];
            let origin = origin + parent * segment.offset;
            let world = if touch.contains(k) {
                let own = request.plane(k).normal;
                Some(frame(DVec3::Y, foot.forward(), own, level(t, own).unwrap_or(t)))
            } else {
                towards_child(request, segments, k, touch, (origin, parent), ground)
                    .or_else(|| flattened(foot, k, parent, request.ground.height(origin), ground))
            };
            if let Some(world) = world {
                let wanted = (parent.conjugate() * world).normalize();
                (pose.joints[k], missing) = constrained(wanted, segment.hinge, segment.limits);
            }
            place[k] = (origin, (parent * pose.joints[k]).normalize());
        }
        let report = measured(segment, place[k], &request.plane(k));
        pose.report.segments[k] = report;
        if touch.contains(k) && missing > PARALLEL {
            pose.report.segments[k].fault = Some(FootFault::JointLimit { missing });
        }
    }
    pose
}

/// How a segment that is not chosen turns so that one that hangs on it and is comes to its height; `origin` is its joint, `parent` how
/// the segment that it hangs on is turned.
fn towards_child(
    request: &FootPoseRequest,
    segments: &[Segment],
    k: usize,
    touch: SegmentSet,
    (origin, parent): (DVec3, DQuat),
    Ground { n, t }: Ground,
) -> Option<DQuat> {
    let child = (1..segments.len()).find(|&c| segments[c].parent == k && touch.contains(c))?;
    let arm = parent * segments[child].offset;
    let height = request.joint_height(segments, child) - request.ground.height(origin);
    Some(least(arm, n, height, t).rotation * parent)
}

/// Parallel to the ground, for a segment that is not chosen and would dig in as it is but not so.
fn flattened(foot: &FootAnatomy, k: usize, parent: DQuat, height: f64, Ground { n, t }: Ground) -> Option<DQuat> {
    let segment = &foot.segments()[k];
    let lowest = segment.points.iter().map(|p| height + n.dot(parent * p.0) - p.1).fold(f64::INFINITY, f64::min);
    (lowest < -TOUCH && height > segment.drop - TOUCH).then(|| {
        let along = level(parent * foot.forward(), n).unwrap_or(t);
        frame(DVec3::Y, foot.forward(), n, along)
    })
}

/// Raises a foot that lies in the ground where limits kept it from lying on it, and names what is then wrong.
fn lift(
    foot: &FootAnatomy,
    request: &FootPoseRequest,
    options: &FootPoseOptions,
    touch: SegmentSet,
    pose: &mut FootPose,
) {
    let count = foot.segments().len();
    let report = &mut pose.report;
    let lowest = report.segments[..count].iter().map(|s| s.gap).fold(f64::INFINITY, f64::min);
    let room = options.most_displacement - report.displacement;
    let up = if lowest < -TOUCH { (-lowest).min(room.max(0.0)) } else { 0.0 };
    pose.ankle += request.ground.normal * up;
    report.displacement += up;
    for k in 0..count {
        let segment = &mut report.segments[k];
        segment.gap += up;
        let chosen = touch.contains(k);
        if segment.gap < -TOUCH && !chosen {
            segment.fault = Some(FootFault::DigsIn { depth: -segment.gap });
        } else if segment.gap.abs() > TOUCH && chosen && segment.fault.is_none() {
            segment.fault = Some(FootFault::OutOfReach { gap: segment.gap });
        }
        if segment.gap.abs() <= TOUCH && segment.tilt <= PARALLEL {
            report.touching = report.touching.with(k);
        }
    }
}

/// Where a segment is over the ground.
fn measured(segment: &Segment, (origin, rotation): (DVec3, DQuat), ground: &GroundPlane) -> SegmentReport {
    let lowest = segment.points.iter().map(|p| ground.height(origin + rotation * p.0) - p.1);
    let tilt = rotation_vector(arc(rotation * DVec3::Y, ground.normal)).length();
    SegmentReport { gap: lowest.fold(f64::INFINITY, f64::min), tilt, fault: None }
}

/// The joint rotation nearest to the wanted one that hinge and limits allow, and the angle between the two, rad.
fn constrained(wanted: DQuat, hinge: Option<DVec3>, limits: Option<JointLimits>) -> (DQuat, f64) {
    let mut q = hinge.map_or(wanted, |axis| twist(wanted, axis));
    if let Some(limits) = limits {
        let r = rotation_vector(q);
        let within = r.clamp(limits.low, limits.high);
        if within != r {
            q = rotation_by(within);
        }
    }
    (q, rotation_vector(q.conjugate() * wanted).length())
}
