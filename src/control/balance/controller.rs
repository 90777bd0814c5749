//! The balance controller: decisions, held in between, and torques at every step.

mod state;

use super::accelerations::Accelerations;
use super::forces::{ConeForces, ForceWeights, SupportPoint};
use super::hull::Hull;
use super::momentum::{Whole, wished, with_pressure_inside};
use super::settings::{BalanceMethod, BalanceSettings};
use super::stance::{AnkleStance, Stance};
use super::supports::Footing;
use crate::asset::turn::{rotation_vector, twist};
use crate::contact::Terrain;
use crate::control::foot::{BasicPose, FootAnatomy, FootError, SegmentSet};
use crate::dynamics::{
    CentroidalMap, InverseDynamics, LinkConstants, LinkKinematics, State, degrees_of_freedom, generalized_velocity,
    inverse_dynamics_into,
};
use crate::math::{Force, Motion, Quat, Vec3};
use crate::model::SharedModel;
use crate::sim::Simulator;
use glam::{DQuat, DVec2, DVec3};

/// Most segments that stand at a time.
const MOST_SUPPORTS: usize = 16;
/// Rows of a segment: three of its place, three of its rotation.
const SIX: usize = 6;
/// Compliance of the rows of momentum, of a support's place and rotation; weights of tracking are 1.
const MOMENTUM_COMPLIANCE: f64 = 1e-6;
const SUPPORT_COMPLIANCE: f64 = 1e-3;
/// Weight of the root's own acceleration, which nothing tracks.
const ROOT_LINEAR: f64 = 1e-2;
/// Weight of tracking of the joints of segments that stand: the ground holds them.
const STANDING_JOINT: f64 = 0.05;
/// Gain of the way of the wished centre of mass towards the middle of the support, 1/s^2, critically damped.
const GUIDE: f64 = 16.0;
/// Speeds at which ankles rise (m/s) and roll (rad/s) into a stance.
const RISE_SPEED: f64 = 0.05;
const ROLL_SPEED: f64 = 0.25;
/// A stance is stood on once the centre of mass is so near the middle of its support (m) and so slow (m/s), or after so long (s).
const NEAR: f64 = 0.015;
const SLOW: f64 = 0.06;
const LONGEST_SHIFT: f64 = 1.2;

/// Why a character cannot be balanced.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BalanceError {
    /// A foot that cannot be posed.
    #[error(transparent)]
    Foot(#[from] FootError),
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
    footings: Vec<Footing>,
    stance: Stance,
    next: Option<Stance>,
    /// Time that the weight has been on its way to the next stance, s.
    shifting: f64,
    /// Where the pelvis faces.
    heading: DQuat,
    /// Height of the centre of mass over the middle of the support in the posture, m.
    height: f64,
    guide: (DVec3, DVec3),
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
            footings: feet.into_iter().map(Footing::new).collect(),
            stance,
            next: None,
            shifting: 0.0,
            heading: DQuat::IDENTITY,
            height: 0.0,
            guide: (DVec3::ZERO, DVec3::ZERO),
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
        self.next = Some(stance);
        self.shifting = 0.0;
        Ok(())
    }

    /// What has to happen before a step: a decision where one is due, and torques.
    pub fn tick(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>) {
        self.observe(sim);
        if self.steps_left == 0 {
            let rate = sim.settings().rate;
            self.held_steps = ((rate / self.settings.rate).round() as u32).max(1);
            self.steps_left = self.held_steps;
            self.decide(sim, terrain, f64::from(self.held_steps) / rate);
        }
        self.command(sim);
        self.advance();
    }

    /// Looks at the body.
    fn observe(&mut self, sim: &mut Simulator<f64>) {
        self.kinematics.copy_from_slice(sim.kinematics());
    }

    fn advance(&mut self) {
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

    /// One decision: what is wished, what the ground can give, what joints do.
    fn decide(&mut self, sim: &mut Simulator<f64>, terrain: &impl Terrain<f64>, seconds: f64) {
        let root = sim.state.root_position.lane(0);
        self.decided_at = root;
        for (footing, stance) in self.footings.iter_mut().zip(&self.stance.feet) {
            footing.look(&self.kinematics, root, terrain, stance.touch, seconds);
        }
        let whole = self.whole(sim);
        self.go_over(&whole, root, terrain, seconds);
        for (footing, stance) in self.footings.iter_mut().zip(&self.stance.feet) {
            footing.rise += (stance.rise - footing.rise).clamp(-RISE_SPEED * seconds, RISE_SPEED * seconds);
            footing.roll += (stance.roll - footing.roll).clamp(-ROLL_SPEED * seconds, ROLL_SPEED * seconds);
            footing.shape(stance);
        }

        // Where the centre of mass shall be.
        let hull = self.hull(&self.stance);
        let goal_hull = self.next.as_ref().map_or(hull, |next| self.hull(next));
        let ground = self.ground_height();
        let middle = goal_hull.middle().unwrap_or(DVec2::new(whole.com.x, -whole.com.z));
        let standing = self.footings.iter().zip(&self.stance.feet).filter(|(_, s)| !s.touch.is_empty());
        let rise = standing.map(|(f, _)| f.rise).fold(0.0, f64::max);
        let goal = DVec3::new(middle.x, ground + self.height + rise, -middle.y);
        let (place, pace) = self.guide;
        let push = (goal - place) * GUIDE - pace * (2.0 * GUIDE.sqrt());
        let pace = pace + push * seconds;
        self.guide = (place + pace * seconds, pace);
        let (place, pace) = self.guide;

        // What the ground shall give.
        let mut wish = wished(&whole, &self.settings, place, pace, push);
        self.probe = BalanceProbe {
            com: whole.com,
            target: place,
            wished_force: wish.force,
            wished_moment: wish.moment,
            ..BalanceProbe::default()
        };
        self.gather_points(root, terrain);
        self.forces.build(self.settings.friction, self.settings.margin);
        let weights = match self.settings.method {
            BalanceMethod::Cones => ForceWeights { force: 1.0, moment: self.settings.moment_weight },
            BalanceMethod::Pressure => {
                wish = with_pressure_inside(wish, &whole, &self.settings, &hull, ground);
                ForceWeights { force: 1.0, moment: 100.0 }
            }
        };
        let com = whole.com - root;
        let lever = com - self.forces.middle();
        let (force, moment) = self.forces.solve(wish.force, wish.moment + lever.cross(wish.force), weights);
        if self.settings.method == BalanceMethod::Cones || self.forces.points().is_empty() {
            wish.force = force;
            wish.moment = moment - lever.cross(force);
        }
        (self.probe.force, self.probe.moment) = (force, moment - lever.cross(force));
        self.probe.points = self.forces.points().len();

        // What joints do.
        self.map.update(&self.constants, &self.kinematics, Vec3::<f64>::splat(com));
        self.track(sim);
        self.fill_system(root, &whole, wish.force + whole.mass * whole.gravity, wish.moment);
        self.system.solve();
        self.accelerations.copy_from_slice(&self.system.solution);
        generalized_velocity(&self.constants, &self.kinematics, &sim.state, &mut self.planned);
    }

    /// The body as a whole.
    fn whole(&self, sim: &mut Simulator<f64>) -> Whole {
        let mass = self.model.mass();
        let momentum = sim.total_momentum();
        let lean = |link: usize| {
            let now = self.kinematics[link].rotation.lane(0);
            let wanted = self.heading;
            rotation_vector(wanted * DQuat::from_mat3(&now).conjugate())
        };
        Whole {
            mass,
            com: sim.center_of_mass().lane(0),
            velocity: momentum.linear.lane(0) / mass,
            spin: momentum.angular.lane(0),
            inertia: sim.total_inertia().to_mat3().lane(0),
            lean: 0.5 * (lean(0) + lean(self.model.trunk())),
            gravity: sim.settings().gravity,
        }
    }

    /// Steps onto the next stance once the weight is where it can be borne.
    fn go_over(&mut self, whole: &Whole, root: DVec3, terrain: &impl Terrain<f64>, seconds: f64) {
        let Some(next) = &self.next else { return };
        self.shifting += seconds;
        let middle = self.hull(next).middle().unwrap_or(DVec2::ZERO);
        let off = DVec2::new(whole.com.x, -whole.com.z) - middle;
        let pace = DVec2::new(whole.velocity.x, whole.velocity.z);
        if (off.length() < NEAR && pace.length() < SLOW) || self.shifting > LONGEST_SHIFT {
            let Some(next) = self.next.take() else { return };
            for ((footing, before), after) in self.footings.iter_mut().zip(&self.stance.feet).zip(&next.feet) {
                for k in after.touch.iter().filter(|&k| !before.touch.contains(k)) {
                    let link = footing.anatomy.segments()[k].link;
                    footing.stand(k, root + self.kinematics[link].origin.lane(0), terrain);
                }
            }
            self.stance = next;
        }
    }

    /// The hull of what touches in a stance.
    fn hull(&self, stance: &Stance) -> Hull {
        let feet = self.footings.iter().zip(&stance.feet);
        Hull::of(feet.flat_map(|(f, s)| f.touching_places(s.touch)).map(|p| DVec2::new(p.x, -p.z)))
    }

    /// Mean height of the ground where the body stands.
    fn ground_height(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for p in self.footings.iter().zip(&self.stance.feet).flat_map(|(f, s)| f.touching_places(s.touch)) {
            sum += p.y;
            count += 1.0;
        }
        if count > 0.0 {
            sum / count
        } else {
            self.footings.iter().map(|f| f.ground.point.y).sum::<f64>() / self.footings.len() as f64
        }
    }

    /// The points that carry.
    fn gather_points(&mut self, root: DVec3, terrain: &impl Terrain<f64>) {
        self.forces.clear();
        for (footing, stance) in self.footings.iter().zip(&self.stance.feet) {
            let segments = footing.anatomy.segments();
            for segment in stance.touch.iter().filter_map(|k| segments.get(k)) {
                let k = &self.kinematics[segment.link];
                for &(position, radius, index) in &segment.points {
                    let center = k.origin.lane(0) + k.rotation.lane(0) * position;
                    let hit = terrain.query(Vec3::<f64>::splat(root + center));
                    if hit.distance - radius < self.settings.contact {
                        let normal = hit.normal.lane(0);
                        self.forces.push(SupportPoint {
                            link: segment.link,
                            index,
                            place: center - normal * radius,
                            normal,
                        });
                    }
                }
            }
        }
    }

    /// Accelerations towards the posture, and their weights.
    fn track(&mut self, sim: &Simulator<f64>) {
        let gain = self.settings.tracking;
        let damping = 2.0 * gain.sqrt();
        for i in 0..self.model.links.len() {
            self.targets[i] = self.posture_of(i);
        }
        let system = &mut self.system;
        system.track.fill(0.0);
        system.weights.fill(1.0);
        system.weights[..3].fill(ROOT_LINEAR);
        let now = sim.state.root_rotation.lane(0);
        let spin = now.conjugate() * sim.state.root_velocity.angular.lane(0);
        let turn = rotation_vector(now.conjugate() * self.heading) * gain - spin * damping;
        system.track[3..6].copy_from_slice(&turn.to_array());
        for i in 1..self.model.links.len() {
            let joint = &sim.state.joints[i];
            let q = joint.rotation.lane(0);
            let turn = rotation_vector(q.conjugate() * self.targets[i]) * gain - joint.velocity.lane(0) * damping;
            let at = self.dof_of[i];
            match self.constants[i].hinge {
                Some(axis) => system.track[at] = axis.lane(0).dot(turn),
                None => system.track[at..at + 3].copy_from_slice(&turn.to_array()),
            }
        }
        for (footing, stance) in self.footings.iter().zip(&self.stance.feet) {
            for segment in stance.touch.iter().filter_map(|k| footing.anatomy.segments().get(k)) {
                let at = self.dof_of[segment.link];
                let count = if self.constants[segment.link].hinge.is_some() { 1 } else { 3 };
                system.weights[at..at + count].fill(STANDING_JOINT);
            }
        }
    }

    /// Rotation of a joint in the posture; those of a foot as foot pose control has them.
    fn posture_of(&self, link: usize) -> DQuat {
        for (footing, stance) in self.footings.iter().zip(&self.stance.feet) {
            if stance.touch.is_empty() {
                continue;
            }
            let Some(k) = footing.anatomy.segments().iter().position(|s| s.link == link) else { continue };
            let Some(pose) = &footing.pose else { continue };
            if k > 0 {
                return pose.joints[k];
            }
            let Some(shin) = self.model.links[link].parent else { continue };
            let Some(thigh) = self.model.links[shin].parent else { continue };
            let above = self.heading * self.stance.posture[thigh] * self.stance.posture[shin];
            return pose.ankle_joint(&footing.anatomy, above.normalize()).0;
        }
        self.stance.posture[link]
    }

    /// The rows of momentum and support.
    fn fill_system(&mut self, root: DVec3, whole: &Whole, force: DVec3, moment: DVec3) {
        // Accelerations that links have while no generalised velocity changes: J' v of every joint.
        inverse_dynamics_into(
            &self.constants,
            &self.kinematics,
            Motion::zero(),
            &self.still,
            Vec3::zero(),
            &[],
            &mut self.inverse,
        );
        let supports: usize = self.stance.feet.iter().map(|f| f.touch.len()).sum::<usize>().min(MOST_SUPPORTS);
        let system = &mut self.system;
        system.begin(SIX * (1 + supports));
        // Momentum, as accelerations of the centre of mass and of a body that turns as one.
        let inertia = whole.inertia.to_cols_array();
        let turning = (inertia[0] + inertia[4] + inertia[8]) / 3.0;
        let rate = self.map.rate();
        system.wish[..3].copy_from_slice(&((force - rate.force.lane(0)) / whole.mass).to_array());
        system.wish[3..6].copy_from_slice(&((moment - rate.moment.lane(0)) / turning).to_array());
        system.compliance[..6].fill(MOMENTUM_COMPLIANCE);
        for (dof, column) in self.map.columns().iter().enumerate() {
            let (linear, angular) = (column.force.lane(0) / whole.mass, column.moment.lane(0) / turning);
            for k in 0..3 {
                system.set(k, dof, linear[k]);
                system.set(3 + k, dof, angular[k]);
            }
        }
        // Supports: equation 7.
        let (gain, damping) = (self.settings.support, 2.0 * self.settings.support.sqrt());
        let mut row = SIX;
        for (footing, stance) in self.footings.iter().zip(&self.stance.feet) {
            for k in stance.touch.iter().filter(|&k| k < footing.anatomy.segments().len()) {
                if row + SIX > SIX * (1 + supports) {
                    return;
                }
                let link = footing.anatomy.segments()[k].link;
                let at = &self.kinematics[link];
                let anchor = &footing.anchors[k];
                let place = root + at.origin.lane(0);
                let rotation = DQuat::from_mat3(&at.rotation.lane(0));
                let drift = footing.drift;
                let velocity = at.velocity;
                let turn = rotation_vector(anchor.rotation * rotation.conjugate());
                let linear = gain * (anchor.place - place) - damping * (velocity.linear.lane(0) - drift);
                let angular = gain * turn - damping * (velocity.angular.lane(0) - footing.spin);
                let coasting = self.inverse.accelerations()[link];
                let wishes = [linear - coasting.linear.lane(0), angular - coasting.angular.lane(0)];
                for (part, wish) in wishes.iter().enumerate() {
                    system.wish[row + 3 * part..][..3].copy_from_slice(&wish.to_array());
                }
                system.compliance[row..][..6].fill(SUPPORT_COMPLIANCE);
                for k in 0..3 {
                    system.set(row + k, k, 1.0);
                }
                let mut above = link;
                loop {
                    let own = &self.kinematics[above];
                    let axes = match self.constants[above].hinge {
                        Some(axis) => ([axis.lane(0), DVec3::ZERO, DVec3::ZERO], 1),
                        None => ([DVec3::X, DVec3::Y, DVec3::Z], 3),
                    };
                    for (j, axis) in axes.0[..axes.1].iter().enumerate() {
                        let axis = own.rotation.lane(0) * *axis;
                        let moved = axis.cross(at.origin.lane(0) - own.origin.lane(0));
                        let dof = self.dof_of[above] + j;
                        for k in 0..3 {
                            system.set(row + k, dof, moved[k]);
                            system.set(row + 3 + k, dof, axis[k]);
                        }
                    }
                    if above == 0 {
                        break;
                    }
                    above = self.constants[above].parent;
                }
                row += SIX;
            }
        }
    }

    /// Torques for the present state, by inverse dynamics under the held accelerations and forces of the ground, into the commands.
    fn command(&mut self, sim: &mut Simulator<f64>) {
        let h = sim.step_seconds();
        self.external.fill(Force::zero());
        let gone = sim.state.root_position.lane(0) - self.decided_at;
        for (point, force) in self.forces.forces() {
            let arm = point.place - gone - self.kinematics[point.link].origin.lane(0);
            self.external[point.link] += Force::at(Vec3::<f64>::splat(arm), Vec3::<f64>::splat(force));
        }
        let a = &self.accelerations;
        let three = |at: usize| Vec3::new(a[at], a[at + 1], a[at + 2]);
        let root = Motion { linear: three(0), angular: self.kinematics[0].rotation.mul_vec(three(3)) };
        for i in 1..self.constants.len() {
            let at = self.dof_of[i];
            self.joints[i] = self.constants[i].hinge.map_or_else(|| three(at), |axis| axis * a[at]);
        }
        let gravity = Vec3::<f64>::splat(sim.settings().gravity);
        inverse_dynamics_into(
            &self.constants,
            &self.kinematics,
            root,
            &self.joints,
            gravity,
            &self.external,
            &mut self.inverse,
        );
        let rest = self.inverse.root();
        self.probe.residual = rest.force.lane(0).length().max(rest.moment.lane(0).length());
        for (v, a) in self.planned.iter_mut().zip(&self.accelerations) {
            *v += a * h;
        }
        let State { joints, .. } = &sim.state;
        for (i, joint) in joints.iter().enumerate().skip(1) {
            let at = self.dof_of[i];
            let planned = |at: usize| Vec3::new(self.planned[at], self.planned[at + 1], self.planned[at + 2]);
            let command = &mut sim.commands[i];
            command.rotation = Quat::<f64> { v: joint.rotation.v, w: joint.rotation.w };
            command.velocity = self.constants[i].hinge.map_or_else(|| planned(at), |axis| axis * self.planned[at]);
            command.kp = 0.0;
            command.kd = self.settings.damping * self.model.links[i].gains.kd;
            command.torque = self.inverse.torques()[i];
        }
    }
}
