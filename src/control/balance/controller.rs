//! The balance controller: decisions, held in between, and torques at every step.

mod capture;
mod decision;
mod state;
mod system;
mod torques;

use super::accelerations::Accelerations;
use super::forces::ConeForces;
use super::settings::BalanceSettings;
use super::stance::{AnkleStance, Stance, StanceError};
use super::supports::Footing;
use crate::asset::turn::twist;
use crate::contact::Terrain;
use crate::control::foot::{BasicPose, FootAnatomy, FootError, SegmentSet};
use crate::dynamics::{CentroidalMap, InverseDynamics, LinkConstants, LinkKinematics, degrees_of_freedom};
use crate::math::{Force, Vec3};
use crate::model::SharedModel;
use crate::sim::Simulator;
use glam::{DQuat, DVec3};

/// Most segments that stand at a time.
const MOST_SUPPORTS: usize = 16;
/// Rows of a segment: three of its place, three of its rotation.
const SIX: usize = 6;

/// How long the landing of the start may take, s.
const LANDING: f64 = 0.5;

/// Why a character cannot be balanced.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BalanceError {
    /// A foot that cannot be posed.
    #[error(transparent)]
    Foot(#[from] FootError),
    /// A stance that nobody can stand in.
    #[error(transparent)]
    Asked(#[from] StanceError),
    /// No feet.
    #[error("{character} has no feet to stand on")]
    NoFeet {
        /// The character.
        character: String,
    },
    /// A number of feet that is not the character's.
    #[error("the stance has {found} feet and {joints} joints, {character} {expected} and {expected_joints}")]
    Stance {
        /// The character.
        character: String,
        /// Feet of the stance.
        found: usize,
        /// Joints of the stance.
        joints: usize,
        /// Feet of the character.
        expected: usize,
        /// Joints of the character.
        expected_joints: usize,
    },
}

/// What the last decision saw and wished, for reports.
#[derive(Clone, Copy, Debug, Default)]
pub struct BalanceProbe {
    /// Centre of mass and where it was wished, world frame, m.
    pub com: DVec3,
    /// The wished place.
    pub target: DVec3,
    /// The wished force of the ground, N, and what the friction cones gave of it.
    pub wished_force: DVec3,
    /// What they gave.
    pub force: DVec3,
    /// The wished moment about the centre of mass, N m, and what they gave of it.
    pub wished_moment: DVec3,
    /// What they gave.
    pub moment: DVec3,
    /// Points that carried.
    pub points: usize,
    /// What is left of the root's wrench after the torques: zero where accelerations and forces agree, N and N m.
    pub residual: f64,
}

/// Keeps a body standing. Made once for a character; [`Balance::begin`] starts from where a body stands, [`Balance::tick`] goes before
/// every step.
#[derive(Clone, Debug)]
pub struct Balance {
    model: SharedModel,
    settings: BalanceSettings,
    constants: Vec<LinkConstants<f64>>,
    dof_of: Vec<usize>,
    /// Whether a link is one of a foot's, the ankle's included.
    of_foot: Vec<bool>,
    /// Whether it is the first of them, which hangs on the shin.
    is_ankle: Vec<bool>,
    footings: Vec<Footing>,
    stance: Stance,
    next: Option<Stance>,
    /// Time that the weight has been on its way to the next stance, s.
    shifting: f64,
    /// Time left for the landing of the start, s.
    fresh: f64,
    /// Where the pelvis faces.
    heading: DQuat,
    /// Height of the centre of mass over the middle of the support in the posture, m.
    height: f64,
    guide: (DVec3, DVec3),
    capture: capture::Capture,
    steps_left: u32,
    held_steps: u32,
    /// Where the root was at the last decision: what the places of the forces count from, world frame, m.
    decided_at: DVec3,
    accelerations: Vec<f64>,
    planned: Vec<f64>,
    probe: BalanceProbe,
    // Work space.
    kinematics: Vec<LinkKinematics<f64>>,
    map: CentroidalMap<f64>,
    system: Accelerations,
    forces: ConeForces,
    inverse: InverseDynamics<f64>,
    external: Vec<Force<f64>>,
    joints: Vec<Vec3<f64>>,
    targets: Vec<DQuat>,
    still: Vec<Vec3<f64>>,
}

impl Balance {
    /// A controller for a character.
    pub fn new(model: &SharedModel, settings: BalanceSettings) -> Result<Self, BalanceError> {
        let count = model.feet().len();
        if count == 0 {
            return Err(BalanceError::NoFeet { character: model.name.clone() });
        }
        let feet = (0..count).map(|f| FootAnatomy::of(model, f)).collect::<Result<Vec<_>, _>>()?;
        let stance = Stance::basic(model, &feet, BasicPose::Rest, settings.knee)?;
        let constants = LinkConstants::<f64>::of(model);
        let dof = degrees_of_freedom(&constants);
        let mut dof_of = Vec::with_capacity(constants.len());
        let mut at = 3;
        for c in &constants {
            dof_of.push(at);
            at += if c.hinge.is_some() { 1 } else { 3 };
        }
        let links = model.links.len();
        Ok(Self {
            settings,
            dof_of,
            of_foot: (0..links).map(|i| model.feet().iter().any(|f| f.links.contains(&i))).collect(),
            is_ankle: (0..links).map(|i| feet.iter().any(|f| f.ankle() == i)).collect(),
            footings: feet.into_iter().map(Footing::new).collect(),
            stance,
            next: None,
            shifting: 0.0,
            fresh: 0.0,
            heading: DQuat::IDENTITY,
            height: 0.0,
            guide: (DVec3::ZERO, DVec3::ZERO),
            capture: capture::Capture::default(),
            steps_left: 0,
            held_steps: 1,
            decided_at: DVec3::ZERO,
            accelerations: vec![0.0; dof],
            planned: vec![0.0; dof],
            probe: BalanceProbe::default(),
            kinematics: vec![LinkKinematics::default(); links],
            map: CentroidalMap::new(&constants),
            system: Accelerations::new(dof, SIX * (1 + MOST_SUPPORTS)),
            forces: ConeForces::new(model.contact_points.len()),
            inverse: InverseDynamics::new(links),
            external: vec![Force::zero(); links],
            joints: vec![Vec3::zero(); links],
            targets: vec![DQuat::IDENTITY; links],
            still: vec![Vec3::zero(); links],
            constants,
            model: model.clone(),
        })
    }

    /// The settings.
    pub fn settings(&self) -> &BalanceSettings {
        &self.settings
    }
    /// What the last decision saw.
    pub fn probe(&self) -> &BalanceProbe {
        &self.probe
    }
    /// The feet as segments, in the model's order.
    pub fn feet(&self) -> impl Iterator<Item = &FootAnatomy> {
        self.footings.iter().map(|f| &f.anatomy)
    }
    /// Segments that foot `index` stands on.
    pub fn touch(&self, index: usize) -> SegmentSet {
        self.stance.feet.get(index).map_or(SegmentSet::NONE, |f| f.touch)
    }
    /// A stance on a basic pose with both feet.
    pub fn basic(&self, pose: BasicPose) -> Result<Stance, BalanceError> {
        let feet: Vec<FootAnatomy> = self.feet().cloned().collect();
        Ok(Stance::basic(&self.model, &feet, pose, self.settings.knee)?)
    }
    /// A stance on one foot.
    pub fn one_leg(&self, standing: usize) -> Result<Stance, BalanceError> {
        let feet: Vec<FootAnatomy> = self.feet().cloned().collect();
        Ok(Stance::one_leg(&self.model, &feet, standing, self.settings.knee)?)
    }

    /// A stance of one foot that circles about its ankle, see [`Stance::circling`].
    pub fn circling(&self, foot: usize, quarter: usize) -> Result<Stance, BalanceError> {
        let feet: Vec<FootAnatomy> = self.feet().cloned().collect();
        Ok(Stance::circling(&self.model, &feet, foot, self.settings.knee, quarter)?)
    }

    /// A stance in which each foot does as it is asked, see [`Stance::asked`].
    pub fn asked(&self, feet: &[AnkleStance]) -> Result<Stance, BalanceError> {
        let anatomies: Vec<FootAnatomy> = self.feet().cloned().collect();
        Ok(Stance::asked(&self.model, &anatomies, feet, self.settings.knee)?)
    }

    /// Starts from where the body stands: all that stands in the zero pose is its support.
    pub fn begin(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) {
        self.kinematics.copy_from_slice(sim.kinematics());
        let root = sim.state.root_position.lane(0);
        for footing in &mut self.footings {
            footing.settle(&self.kinematics, root, terrain);
        }
        for (stance, footing) in self.stance.feet.iter_mut().zip(&self.footings) {
            *stance = AnkleStance { touch: footing.anatomy.standing(), ..AnkleStance::default() };
        }
        self.next = None;
        self.capture = capture::Capture::default();
        self.fresh = LANDING;
        self.heading = twist(sim.state.root_rotation.lane(0), DVec3::Y);
        self.height = self.posture_height();
        let com = sim.center_of_mass().lane(0);
        self.guide = (com, DVec3::ZERO);
        self.steps_left = 0;
    }

    /// Goes over to another stance: the weight first, then the feet.
    pub fn assume(&mut self, stance: Stance) -> Result<(), BalanceError> {
        if stance.feet.len() != self.footings.len() || stance.posture.len() != self.model.links.len() {
            return Err(BalanceError::Stance {
                character: self.model.name.clone(),
                found: stance.feet.len(),
                joints: stance.posture.len(),
                expected: self.footings.len(),
                expected_joints: self.model.links.len(),
            });
        }
        // The weight goes on on its way where only an ankle is asked to go elsewhere.
        let touches = |a: &Stance| a.feet.iter().map(|f| f.touch).eq(stance.feet.iter().map(|f| f.touch));
        if !self.next.as_ref().is_some_and(touches) {
            self.shifting = 0.0;
        }
        self.next = Some(stance);
        Ok(())
    }

    /// What has to happen before a step: a decision where one is due, and torques.
    pub fn tick(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) {
        self.kinematics.copy_from_slice(sim.kinematics());
        if self.steps_left == 0 {
            let rate = sim.settings().rate;
            self.held_steps = ((rate / self.settings.rate).round() as u32).max(1);
            self.steps_left = self.held_steps;
            self.decide(sim, terrain, f64::from(self.held_steps) / rate);
        }
        self.command(sim);
        self.steps_left -= 1;
    }

    /// Height of the centre of mass over the soles in the posture, m.
    fn posture_height(&self) -> f64 {
        let mut place: Vec<(DVec3, DQuat)> = Vec::with_capacity(self.model.links.len());
        let (mut sum, mut lowest) = (0.0, f64::INFINITY);
        for (i, link) in self.model.links.iter().enumerate() {
            let at = link.parent.map_or((DVec3::ZERO, DQuat::IDENTITY), |p| {
                let (origin, rotation) = place[p];
                (origin + rotation * link.offset, (rotation * self.stance.posture[i]).normalize())
            });
            sum += link.mass * (at.0 + at.1 * link.com).y;
            for p in self.model.contact_points.iter().filter(|p| p.link == i) {
                lowest = lowest.min((at.0 + at.1 * p.position).y - p.radius);
            }
            place.push(at);
        }
        sum / self.model.mass() - lowest
    }
}
