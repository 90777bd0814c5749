//! Windows of a motion: what it should achieve meanwhile, as written into a key pose file.
//!
//! Yu, Park, Lee 2019, "Figure Skating Simulation from Video", Section 6.1: a skill is cut into two to five windows of 0.2 to
//! 0.5 s, each with objectives and weights; equation numbers below are those of the paper. What each objective measures, and
//! the scale of error at which it costs 1, is in `train::objectives`.

use crate::asset::Side;
use serde::{Deserialize, Serialize};

/// What can be brought above or below the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BodyPart {
    /// The head.
    Head,
    /// The left blade.
    BladeLeft,
    /// The right blade.
    BladeRight,
}

/// What is asked of the motion in a window. World axes: Y up, the motion starts towards -Z.
///
/// `weight` is 1 by default; with `at_end` the objective counts at the end of the window only, instead of all through it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub enum Objective {
    /// The blade on the ice with both ends (7).
    BladeOnGround {
        side: Side,
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// The centre of mass at this height, m (8).
    COMHeight {
        height: f64,
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// The centre of mass as high as possible (9).
    MaxCOMHeight {
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// A part of the body above or below the centre of mass (10).
    OnCOM {
        part: BodyPart,
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// As much angular momentum about the vertical as possible, turning to this side (11).
    MaxAngularMomentum {
        to: Side,
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// The centre of mass as fast upwards as possible (12).
    MaxVelocity {
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// The centre of mass at this velocity, m/s (13).
    COMVelocity {
        velocity: (f64, f64, f64),
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// The pelvis's X axis, to the athlete's right, in this direction (14); a vector of any length.
    PelvisHeading {
        direction: (f64, f64, f64),
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// The joints and the attitude of the root as in the key poses (15).
    TrackPose {
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// The joints as fast as in the key poses. Not in the paper: without it limbs that matter little swing about.
    TrackVelocity {
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
    /// The root where the key poses have it. Not in the paper, whose key poses have no place in the world.
    TrackPath {
        #[serde(default = "one")]
        weight: f64,
        #[serde(default)]
        at_end: bool,
    },
}

fn one() -> f64 {
    1.0
}

/// Largest weight.
const MAX_WEIGHT: f64 = 1e6;

impl Objective {
    /// How much it counts, and whether at the end of the window only.
    pub fn weight(&self) -> (f64, bool) {
        use Objective as O;
        match *self {
            O::BladeOnGround { weight, at_end, .. }
            | O::COMHeight { weight, at_end, .. }
            | O::MaxCOMHeight { weight, at_end }
            | O::OnCOM { weight, at_end, .. }
            | O::MaxAngularMomentum { weight, at_end, .. }
            | O::MaxVelocity { weight, at_end }
            | O::COMVelocity { weight, at_end, .. }
            | O::PelvisHeading { weight, at_end, .. }
            | O::TrackPose { weight, at_end }
            | O::TrackVelocity { weight, at_end }
            | O::TrackPath { weight, at_end } => (weight, at_end),
        }
    }

    /// A few words for reports, such as `BladeOnGround left`.
    pub fn label(&self) -> String {
        use Objective as O;
        let words = match self {
            O::BladeOnGround { side, .. } => format!("BladeOnGround {}", side.name()),
            O::COMHeight { height, .. } => format!("COMHeight {height} m"),
            O::MaxCOMHeight { .. } => "MaxCOMHeight".into(),
            O::OnCOM { part, .. } => format!("OnCOM {part:?}"),
            O::MaxAngularMomentum { to, .. } => format!("MaxAngularMomentum {}", to.name()),
            O::MaxVelocity { .. } => "MaxVelocity".into(),
            O::COMVelocity { velocity: (x, y, z), .. } => format!("COMVelocity {x} {y} {z}"),
            O::PelvisHeading { direction: (x, y, z), .. } => format!("PelvisHeading {x} {y} {z}"),
            O::TrackPose { .. } => "TrackPose".into(),
            O::TrackVelocity { .. } => "TrackVelocity".into(),
            O::TrackPath { .. } => "TrackPath".into(),
        };
        if self.weight().1 { words + " at the end" } else { words }
    }

    /// The objective of the motion seen in a mirror that swaps left and right.
    pub fn mirrored(mut self) -> Self {
        use Objective as O;
        match &mut self {
            O::BladeOnGround { side, .. } | O::MaxAngularMomentum { to: side, .. } => *side = side.other(),
            O::OnCOM { part, .. } => {
                *part = match part {
                    BodyPart::Head => BodyPart::Head,
                    BodyPart::BladeLeft => BodyPart::BladeRight,
                    BodyPart::BladeRight => BodyPart::BladeLeft,
                }
            }
            O::COMVelocity { velocity, .. } => velocity.0 = -velocity.0,
            // The mirror image of an axis to the right points left: it is turned round once more.
            O::PelvisHeading { direction: (_, y, z), .. } => (*y, *z) = (-*y, -*z),
            O::COMHeight { .. } | O::MaxCOMHeight { .. } | O::MaxVelocity { .. } => {}
            O::TrackPose { .. } | O::TrackVelocity { .. } | O::TrackPath { .. } => {}
        }
        self
    }

    /// What is wrong with its numbers: what was found, and what would be valid.
    pub(crate) fn fault(&self) -> Option<(String, &'static str)> {
        let (weight, _) = self.weight();
        if !(0.0..=MAX_WEIGHT).contains(&weight) {
            return Some((format!("weight {weight}"), "a weight of 0 to 1e6"));
        }
        match *self {
            Objective::COMHeight { height, .. } if !(0.0..=10.0).contains(&height) => {
                Some((format!("height {height}"), "0 to 10 m"))
            }
            Objective::COMVelocity { velocity: (x, y, z), .. }
                if ![x, y, z].iter().all(|v| (-30.0..=30.0).contains(v)) =>
            {
                Some((format!("velocity {x}, {y}, {z}"), "each component -30 to 30 m/s"))
            }
            Objective::PelvisHeading { direction: (x, y, z), .. }
                if !(1e-6..=1e6).contains(&(x * x + y * y + z * z)) =>
            {
                Some((format!("direction {x}, {y}, {z}"), "a vector that is not zero"))
            }
            _ => None,
        }
    }
}

/// A part of a motion with its objectives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// Length, s. The windows of a file are as long together as its poses.
    pub seconds: f64,
    /// What is asked meanwhile.
    #[serde(default)]
    pub objectives: Vec<Objective>,
}

/// How the windows of a file are optimised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OptimizeRecord {
    /// Candidates in a generation. The lanes of a core take four at a time.
    pub population: usize,
    /// First standard deviation of the offsets to the targets of the hips and the trunk, rad; lighter joints get less.
    pub sigma: f64,
    /// Generations for each pair of windows.
    pub iterations: u64,
    /// Seed of all random streams.
    pub seed: u64,
    /// Largest distance between the knots of the offsets, s.
    pub knot_spacing: f64,
    /// Gains of all servos (kp N m/rad, kd N m s/rad) in place of the character's: a jump needs stiffer ones.
    pub gains: Option<(f64, f64)>,
    /// Weight of `TrackPose` in windows that do not name it.
    pub track_pose: f64,
    /// Weight of `TrackVelocity` in windows that do not name it.
    pub track_velocity: f64,
    /// Weight of `TrackPath` in windows that do not name it.
    pub track_path: f64,
}

impl Default for OptimizeRecord {
    fn default() -> Self {
        Self {
            population: 16,
            sigma: 0.1,
            iterations: 400,
            seed: 1,
            knot_spacing: 0.15,
            gains: None,
            track_pose: 1.0,
            track_velocity: 1.0,
            track_path: 1.0,
        }
    }
}

impl OptimizeRecord {
    /// What is wrong with its numbers: field, what was found, and what would be valid.
    pub(crate) fn fault(&self) -> Option<(&'static str, String, &'static str)> {
        if !(4..=4096).contains(&self.population) {
            return Some(("population", self.population.to_string(), "4 to 4096"));
        }
        if !(1e-6..=3.0).contains(&self.sigma) {
            return Some(("sigma", self.sigma.to_string(), "0.000001 to 3 rad"));
        }
        if self.iterations > 1_000_000 {
            return Some(("iterations", self.iterations.to_string(), "0 to 1000000"));
        }
        if !(0.02..=2.0).contains(&self.knot_spacing) {
            return Some(("knot_spacing", self.knot_spacing.to_string(), "0.02 to 2 s"));
        }
        if let Some((kp, kd)) = self.gains
            && !((0.0..=1e5).contains(&kp) && (0.0..=1e4).contains(&kd))
        {
            return Some(("gains", format!("{kp}, {kd}"), "0 to 100000 N m/rad and 0 to 10000 N m s/rad"));
        }
        for (field, weight) in
            [("track_pose", self.track_pose), ("track_velocity", self.track_velocity), ("track_path", self.track_path)]
        {
            if !(0.0..=MAX_WEIGHT).contains(&weight) {
                return Some((field, weight.to_string(), "0 to 1e6"));
            }
        }
        None
    }
}
