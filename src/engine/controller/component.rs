//! What users say about what an athlete does.

use crate::control::balance::{AnkleStance, Balance, BalanceError, BalanceSettings, Stance};
use crate::control::foot::BasicPose;
use crate::engine::{ControlAsset, ProgramAsset, SkillAsset};
use crate::model::SharedModel;
use crate::skill::{DirectorInput, SkillParameters};
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

/// What tells the joints of an athlete where to go. Change it at any time: what is new starts from its beginning, with the
/// athlete put into its first pose, once its files have arrived. What does not fit the athlete is refused
/// ([`AthleteRefused`](super::super::AthleteRefused) says why), and it holds.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub enum AthleteController {
    /// Hold the present targets: at spawn, the zero pose of the character file.
    #[default]
    Hold,
    /// Take the targets from the component [`AthleteTargets`] in every fixed tick.
    External,
    /// Play a control from its first pose on.
    Play(Handle<ControlAsset>),
    /// Perform a trained skill, over and over if it repeats, at the speed and with the turn of [`AthleteInput`].
    Skill {
        /// The skill.
        skill: Handle<SkillAsset>,
    },
    /// Perform a program: one skill after the other.
    Program(Handle<ProgramAsset>),
    /// Stand, by control of momentum, without a policy: from where the body is, in this pose of its feet. Another pose is gone over to.
    Balance(BalancePose),
    /// Run where [`AthleteInput`] says, and over what is in the way: boxes, steps, ways down and gaps, wherever they are. The step planner picks
    /// the running speeds ahead of an obstacle and the skill that clears it; [`ObstaclePlanned`](super::super::ObstaclePlanned) tells what it is up to.
    Course {
        /// How it runs: a skill with a gait.
        run: Handle<SkillAsset>,
        /// What clears obstacles: skills whose files say what they clear.
        skills: Vec<Handle<SkillAsset>>,
    },
    /// Go where [`AthleteInput`] says: straight skills on straight ways, curving ones on curves, others on request
    /// ([`PerformSkill`](super::PerformSkill)).
    Steer {
        /// The skills that may be used; it begins with the first.
        skills: Vec<Handle<SkillAsset>>,
    },
}

/// Poses of the feet that a body stands in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
pub enum BalancePose {
    /// On both soles.
    #[default]
    Rest,
    /// On the toes.
    Tiptoe,
    /// On heels and medial toes.
    InsideTilt,
    /// On heels and the lateral parts.
    OutsideTilt,
    /// On the left foot.
    LeftLeg,
    /// On the right foot.
    RightLeg,
    /// One foot circles about its ankle, heel lifted, while the other stands: this is one quarter of the way round. Another quarter every 0.75 s is a
    /// circle in three seconds.
    Circling {
        /// The foot, by its number in the character.
        foot: usize,
        /// Which quarter; they repeat after four.
        quarter: usize,
    },
    /// Each foot, by its number in the character, on the segments that it is asked to, with its ankle where it is asked to be.
    Feet(#[reflect(ignore)] [AnkleStance; 2]),
}

impl BalancePose {
    /// The stance of a character in this pose.
    pub fn stance(self, model: &SharedModel) -> Result<Stance, BalanceError> {
        let balance = Balance::new(model, BalanceSettings::default())?;
        match self {
            Self::Rest => balance.basic(BasicPose::Rest),
            Self::Tiptoe => balance.basic(BasicPose::Tiptoe),
            Self::InsideTilt => balance.basic(BasicPose::InsideTilt),
            Self::OutsideTilt => balance.basic(BasicPose::OutsideTilt),
            Self::LeftLeg => balance.one_leg(0),
            Self::RightLeg => balance.one_leg(1),
            Self::Circling { foot, quarter } => balance.circling(foot, quarter),
            Self::Feet(feet) => balance.asked(&feet),
        }
    }
}

impl AthleteController {
    /// One skill.
    pub fn skill(skill: Handle<SkillAsset>) -> Self {
        Self::Skill { skill }
    }
    /// A run over obstacles.
    pub fn course(run: Handle<SkillAsset>, skills: impl IntoIterator<Item = Handle<SkillAsset>>) -> Self {
        Self::Course { run, skills: skills.into_iter().collect() }
    }
    /// Skills by wish, beginning with the first.
    pub fn steer(skills: impl IntoIterator<Item = Handle<SkillAsset>>) -> Self {
        Self::Steer { skills: skills.into_iter().collect() }
    }
}

/// What is wished of an athlete. [`AthleteController`] says who listens to what.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_athlete::engine::AthleteInput;
/// // Over the box ahead, which is 45 cm high and three metres away.
/// let input = AthleteInput::towards(Vec3::NEG_Z).with("height", 0.45).with("distance", 3.0);
/// ```
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct AthleteInput {
    /// Where to go ([`AthleteController::Steer`], and [`AthleteController::Skill`] with a gait): a direction over the ground, world
    /// frame; its length does not matter, zero is as it comes.
    pub direction: Vec3,
    /// How fast ([`AthleteController::Skill`], [`AthleteController::Steer`]): mean speed, m/s; `None` is that of the skill's
    /// motion.
    pub speed: Option<f32>,
    /// How the way turns ([`AthleteController::Skill`]), rad/s, positive to the left.
    pub turn: f32,
    /// Values for the parameters of its skills, by name ([`AthleteController::Skill`], [`AthleteController::Program`],
    /// [`AthleteController::Steer`]), such as the height of an obstacle: they move the reference, and the policy sees them. They count
    /// from the next decision on. A value out of a skill's range is brought into it, and a name that no skill has is left aside; both are
    /// told ([`ParameterRefused`](super::super::ParameterRefused)).
    pub parameters: SkillParameters,
}

impl AthleteInput {
    /// Fastest speed that can be asked for, m/s.
    const FASTEST: f32 = 30.0;
    /// Fastest turn that can be asked for, rad/s.
    const TIGHTEST: f32 = 2.0;

    /// Towards a direction over the ground, world frame.
    pub fn towards(direction: Vec3) -> Self {
        Self { direction, ..Self::default() }
    }
    /// At a mean speed, m/s.
    pub fn at(self, speed: f32) -> Self {
        Self { speed: Some(speed), ..self }
    }
    /// With a parameter of its skills, in the unit of the skill file.
    pub fn with(self, parameter: &str, value: f64) -> Self {
        Self { parameters: self.parameters.with(parameter, value), ..self }
    }

    /// With what is no number, or beyond what can be, brought back. Parameters have ranges of their own.
    pub(super) fn checked(&self) -> DirectorInput {
        let (direction, speed, turn) = self.bounded();
        DirectorInput { direction, speed, turn, parameters: self.parameters.clone() }
    }

    /// Whether this is what has been told.
    pub(super) fn is(&self, told: &DirectorInput) -> bool {
        (told.direction, told.speed, told.turn) == self.bounded() && told.parameters == self.parameters
    }

    /// Direction, speed (m/s) and turn (rad/s) within what can be.
    fn bounded(&self) -> (DVec3, Option<f64>, f64) {
        let bounded = |x: f32, low: f32, high: f32| if x.is_finite() { f64::from(x.clamp(low, high)) } else { 0.0 };
        let direction = if self.direction.is_finite() { self.direction.as_dvec3() } else { DVec3::ZERO };
        let speed = self.speed.map(|speed| bounded(speed, 0.0, Self::FASTEST));
        (direction, speed, bounded(self.turn, -Self::TIGHTEST, Self::TIGHTEST))
    }
}

/// Joint targets set by you. They are read in [`AthleteSystems::Control`](super::super::AthleteSystems::Control), so write them
/// in `FixedUpdate`.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct AthleteTargets {
    /// Target rotation of each link against its parent by link index, child axes to parent axes; entry 0 is unused. Links
    /// beyond the end keep their target.
    pub rotations: Vec<DQuat>,
    /// Target angular velocity of each link against its parent by link index, child axes, rad/s; zero beyond the end.
    pub velocities: Vec<DVec3>,
}
