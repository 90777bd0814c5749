//! How the ankle turns, and how far it moves, so that the joints of chosen segments come to their heights.
//!
//! The joints that lie on the ankle's link are fixed against each other, so their heights over the ground are functions of two tilts
//! and the ankle's own height. One joint: the smallest rotation, the ankle stays (equations 1 and 2 of the paper). Two: the smallest
//! rotation that gives them the right difference; three and more: the two tilts that fit best. What height is then left over is the
//! ankle's to move. Joints side by side, as those of single toes, are one row: they count as one joint in their middle, and where
//! nothing else is wanted the foot rolls so that the row lies along the ground.

use super::aim::{Aim, arc, least};
use super::segments::MOST_SEGMENTS;
use crate::asset::turn::{rotation_by, rotation_vector};
use glam::{DMat3, DQuat, DVec3};

/// Joints that lie this near to each other along the foot are a row across it, m.
const ROW: f64 = 0.004;

/// A joint on the ankle's link.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fixed {
    /// From the ankle, world axes, before the ankle turns, m.
    pub arm: DVec3,
    /// Its wanted height, less that of the ankle, m.
    pub height: f64,
}

/// A joint, or the middle of a row of joints.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    middle: Fixed,
    /// Joints in it.
    count: usize,
    /// The two that are farthest from each other.
    ends: [Fixed; 2],
}

impl Row {
    fn of(joint: Fixed) -> Self {
        Self { middle: joint, count: 1, ends: [joint; 2] }
    }
    /// The same row with one joint more.
    fn with(self, joint: Fixed) -> Self {
        let n = self.count as f64;
        let mean = |a: DVec3, b: DVec3| (a * n + b) / (n + 1.0);
        let middle = Fixed {
            arm: mean(self.middle.arm, joint.arm),
            height: (self.middle.height * n + joint.height) / (n + 1.0),
        };
        let [a, b] = self.ends;
        let pairs = [[a, b], [a, joint], [b, joint]];
        let length = |pair: &[Fixed; 2]| pair[0].arm.distance(pair[1].arm);
        let ends = pairs.into_iter().reduce(|x, y| if length(&y) > length(&x) { y } else { x }).unwrap_or(self.ends);
        Self { middle, count: self.count + 1, ends }
    }
}

/// Joints on the ankle's link whose heights are wanted.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FixedJoints {
    rows: [Row; MOST_SEGMENTS],
    count: usize,
}

impl FixedJoints {
    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }
    /// Adds a joint of a foot that points along `ahead` (unit, world axes, before the ankle turns).
    pub(super) fn push(&mut self, joint: Fixed, ahead: DVec3) {
        let (rows, free) = self.rows.split_at_mut(self.count);
        if let Some(row) = rows.iter_mut().find(|row| (row.middle.arm - joint.arm).dot(ahead).abs() < ROW) {
            *row = row.with(joint);
        } else if let Some(place) = free.first_mut() {
            *place = Row::of(joint);
            self.count += 1;
        }
    }
    fn all(&self) -> &[Row] {
        &self.rows[..self.count]
    }
}

/// The plane's normal and where the foot points in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground {
    /// Unit normal.
    pub n: DVec3,
    /// Unit direction of the foot in the plane.
    pub t: DVec3,
}

/// What the ankle does.
#[derive(Clone, Copy, Debug)]
pub(super) struct AnkleMove {
    /// Rotation on top of the reference's, world axes.
    pub rotation: DQuat,
    /// Way along the normal, m.
    pub displacement: f64,
    /// The paper's axis was not determined: the vector to the joint is parallel to the normal.
    pub parallel: bool,
}

/// The part of a rotation that rolls the foot, about the direction it points in, rad.
pub(super) fn roll_of(rotation: DQuat, t: DVec3) -> f64 {
    rotation_vector(rotation).dot(t)
}

/// What the ankle does for these joints. Where the sole of the ankle's own link shall stand, `sole` is its normal (world axes, before
/// the ankle turns) and the height it lacks: it decides alone. Of the rotation that one joint asks for, the ankle makes the part
/// `part` (0 to 1) and moves for the rest.
pub(super) fn move_ankle(
    joints: &FixedJoints,
    sole: Option<(DVec3, f64)>,
    ground: Ground,
    most_roll: f64,
    part: f64,
) -> AnkleMove {
    let Ground { n, t } = ground;
    if let Some((normal, height)) = sole {
        return AnkleMove { rotation: arc(normal, n), displacement: height, parallel: false };
    }
    match joints.all() {
        [] => AnkleMove { rotation: DQuat::IDENTITY, displacement: 0.0, parallel: false },
        [row] => {
            let one = row.middle;
            let Aim { rotation, missing, parallel } = match row.count {
                1 => bounded(one.arm, one.height, ground, most_roll),
                _ => levelled(row, ground, most_roll),
            };
            if part >= 1.0 {
                return AnkleMove { rotation, displacement: missing, parallel };
            }
            let rotation = rotation_by(rotation_vector(rotation) * part);
            AnkleMove { rotation, displacement: one.height - n.dot(rotation * one.arm), parallel }
        }
        [a, b] => {
            let (a, b) = (&a.middle, &b.middle);
            let Aim { rotation, parallel, .. } = bounded(a.arm - b.arm, a.height - b.height, ground, most_roll);
            let left = |j: &Fixed| j.height - n.dot(rotation * j.arm);
            AnkleMove { rotation, displacement: 0.5 * (left(a) + left(b)), parallel }
        }
        many => fitted(many, n, t),
    }
}

/// The smallest rotation that brings a vector to a height; where it would roll the foot by more than `most_roll`, that roll and for
/// the rest the smallest rotation about the axis across the foot.
fn bounded(arm: DVec3, height: f64, Ground { n, t }: Ground, most_roll: f64) -> Aim {
    let aim = least(arm, n, height, t);
    let roll = roll_of(aim.rotation, t);
    if roll.abs() <= most_roll {
        return aim;
    }
    let rolled = rotation_by(t * most_roll.copysign(roll));
    let across = n.cross(t);
    let turned = rolled * arm;
    let pitched = least(turned - across * turned.dot(across), n, height, t);
    Aim { rotation: pitched.rotation * rolled, ..pitched }
}

/// The roll, of at most `most_roll`, that gives both ends of a row their heights against each other, and then the smallest rotation about
/// the axis across the foot that brings its middle to its height.
fn levelled(row: &Row, Ground { n, t }: Ground, most_roll: f64) -> Aim {
    let [a, b] = row.ends;
    let roll = roll_of(least(b.arm - a.arm, n, b.height - a.height, t).rotation, t).clamp(-most_roll, most_roll);
    let rolled = rotation_by(t * roll);
    let across = n.cross(t);
    let turned = rolled * row.middle.arm;
    let pitched = least(turned - across * turned.dot(across), n, row.middle.height, t);
    Aim { rotation: pitched.rotation * rolled, ..pitched }
}

/// Two tilts and a height that fit best, by Gauss-Newton steps: with w a small rotation in the plane, a joint's height changes by
/// `w . (arm x n)`.
fn fitted(rows: &[Row], n: DVec3, t: DVec3) -> AnkleMove {
    /// Steps: each squares the error of a tilt that begins below a radian.
    const STEPS: usize = 6;
    /// Keeps the system regular where all joints lie in a line, m^2.
    const DAMPING: f64 = 1e-9;
    let across = n.cross(t);
    let mut rotation = DQuat::IDENTITY;
    let mut displacement = 0.0;
    for _ in 0..STEPS {
        let mut normal_matrix = DMat3::from_diagonal(DVec3::new(DAMPING, DAMPING, 0.0));
        let mut right = DVec3::ZERO;
        for joint in rows.iter().map(|row| &row.middle) {
            let arm = rotation * joint.arm;
            let slope = arm.cross(n);
            let row = DVec3::new(slope.dot(across), slope.dot(t), 1.0);
            normal_matrix += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
            right += row * (joint.height - n.dot(arm));
        }
        let step = normal_matrix.inverse() * right;
        displacement = step.z;
        let tilt = across * step.x + t * step.y;
        rotation = (rotation_by(tilt * (1.0 / tilt.length().max(1.0))) * rotation).normalize();
    }
    AnkleMove { rotation, displacement, parallel: false }
}
