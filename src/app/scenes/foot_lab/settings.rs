//! What the foot lab is set to: by the menu, and as far as it has come.

use crate::engine::BalancePose;
use bevy::math::DVec2;
use bevy::prelude::*;

/// The steepest floor, degrees.
pub(crate) const STEEPEST: f32 = 12.0;
/// The highest lump under a foot, m.
pub(crate) const HIGHEST: f32 = 0.05;
/// The strongest push of the menu, N.
pub(crate) const STRONGEST: f32 = 150.0;

/// What the humans can be told to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// Stand so.
    Pose(BalancePose),
    /// Circle with this foot.
    Circle(usize),
    /// Jump in place, by the trained skill.
    Jump,
}

/// What the menu offers.
pub(crate) const MOTIONS: [(&str, Motion); 9] = [
    ("Both soles", Motion::Pose(BalancePose::Rest)),
    ("Tiptoe", Motion::Pose(BalancePose::Tiptoe)),
    ("Inside tilt", Motion::Pose(BalancePose::InsideTilt)),
    ("Outside tilt", Motion::Pose(BalancePose::OutsideTilt)),
    ("Left leg", Motion::Pose(BalancePose::LeftLeg)),
    ("Right leg", Motion::Pose(BalancePose::RightLeg)),
    ("Left foot circles", Motion::Circle(0)),
    ("Right foot circles", Motion::Circle(1)),
    ("Jump in place", Motion::Jump),
];

/// What they stand on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum LabGround {
    /// A floor that tilts.
    #[default]
    Floor,
    /// A ball each.
    Ball,
}

/// What comes up through the floor under a foot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Lump {
    /// A gentle bump, as wide as the foot is long.
    #[default]
    Bump,
    /// A ball that fits into a hand.
    Ball,
}

impl Lump {
    /// Radius of the sphere it is the top of, m.
    pub fn radius(self) -> f64 {
        match self {
            Self::Bump => 0.12,
            Self::Ball => 0.05,
        }
    }
}

/// What the lab is set to.
#[derive(Resource, Clone, Debug)]
pub(crate) struct FootLab {
    /// Index of the motion; `None` where the feet do as they were told on the contact plate.
    pub motion: Option<usize>,
    /// Ground.
    pub ground: LabGround,
    /// Slope to be reached, degrees: sideways (to the right is down), ahead (ahead is down).
    pub slope: Vec2,
    /// What comes up under a foot.
    pub lump: Lump,
    /// Under which foot: 0 left, 1 right.
    pub under: usize,
    /// How high it shall come, m.
    pub height: f32,
    /// Force of the menu's push, N.
    pub force: f32,
    /// A push that is to be given: where it points against the heading, degrees, 0 forwards, 90 to the left.
    pub push: Option<f64>,
    /// Since the motion was chosen, s.
    pub since: f32,
    /// Slope at present, rad: about x and about z.
    pub now: DVec2,
    /// How high the lump is at present, m.
    pub raised: f64,
}

impl Default for FootLab {
    fn default() -> Self {
        Self {
            motion: Some(0),
            ground: LabGround::default(),
            slope: Vec2::ZERO,
            lump: Lump::default(),
            under: 0,
            height: 0.0,
            force: 40.0,
            push: None,
            since: 0.0,
            now: DVec2::ZERO,
            raised: 0.0,
        }
    }
}

impl FootLab {
    /// Begins a motion.
    pub fn choose(&mut self, motion: usize) {
        (self.motion, self.since) = (Some(motion), 0.0);
        if MOTIONS.get(motion).is_some_and(|(_, motion)| *motion == Motion::Jump) {
            // It was learnt on the level.
            (self.slope, self.height) = (Vec2::ZERO, 0.0);
        }
    }

    /// Whether they stand on a level floor with nothing under a foot.
    pub fn is_level(&self) -> bool {
        self.ground == LabGround::Floor && self.now == DVec2::ZERO && self.raised == 0.0
    }
}
