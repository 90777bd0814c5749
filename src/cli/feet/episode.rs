//! One body, one disturbance: did it keep standing.

use crate::contact::{Geometry, Solid, Surface, World};
use crate::control::balance::{Balance, BalanceError, BalanceSettings};
use crate::control::foot::BasicPose;
use crate::math::{RandomStream, Vec3};
use crate::model::{JointKind, SharedModel};
use crate::sim::{ExternalForce, SimulationSettings, Simulator, step};
use crate::storyboard::StoryboardFrame;
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// When the disturbance begins, s.
const BEGIN: f64 = 2.0;
/// How long a foot that circles takes for a quarter, s.
const QUARTER: f64 = 0.75;
/// How long a push lasts, s.
const PUSH: f64 = 0.4;
/// How long a platform's jerk lasts, s.
const JERK: f64 = 0.3;
/// A body whose centre of mass has sunk below this part of its height at the start has fallen.
const SUNK: f64 = 0.75;
/// A trunk that leans by more than this has fallen, rad: 60 degrees.
const LEANT: f64 = 1.05;
/// Number of the random stream of an episode.
const STREAM: u64 = 0x0f00_7b01;

/// What a body stands in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StancePose {
    /// Both feet in a basic pose.
    Basic(BasicPose),
    /// One foot, by its number.
    OneLeg(usize),
    /// Both, of which this one circles about its ankle, a quarter of the way round every 0.75 s.
    Circling(usize),
}

/// What happens to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Disturbance {
    /// Nothing.
    None,
    /// A force (N) on the trunk's centre of mass for 0.4 s, towards this horizontal direction (unit).
    Push {
        /// N.
        force: f64,
        /// Unit, horizontal.
        toward: DVec3,
    },
    /// The ground moves by so much (m) in 0.3 s along a horizontal unit direction, with the least jerk (Flash, Hogan 1985).
    Jerk {
        /// m.
        way: f64,
        /// Unit, horizontal.
        toward: DVec3,
    },
    /// The ground is a fixed ball of this radius (m) below the middle between the feet.
    Ball {
        /// m.
        radius: f64,
    },
    /// The ground sways about a horizontal axis through the middle between the feet.
    Sway {
        /// Largest tilt, rad.
        angle: f64,
        /// 1/s.
        frequency: f64,
        /// Unit, horizontal.
        axis: DVec3,
    },
}

/// One episode.
#[derive(Clone, Copy, Debug)]
pub struct Episode {
    /// Gains and rates.
    pub settings: BalanceSettings,
    /// What it stands in from 2 s on; before that it is at rest.
    pub stance: StancePose,
    /// What happens to it.
    pub disturbance: Disturbance,
    /// How long, s.
    pub seconds: f64,
    /// Back to rest for the last 3 s.
    pub returns: bool,
    /// Friction coefficient of the ground, drawn evenly between these.
    pub friction: (f64, f64),
    /// Standard deviation of every joint at the start, rad.
    pub noise: f64,
}

impl Episode {
    /// At rest with 0.03 rad of joint noise on ground of friction 1.
    pub fn standing(disturbance: Disturbance, seconds: f64) -> Self {
        Self {
            settings: BalanceSettings { steps: 0, ..BalanceSettings::default() },
            stance: StancePose::Basic(BasicPose::Rest),
            disturbance,
            seconds,
            returns: false,
            friction: (1.0, 1.0),
            noise: 0.03,
        }
    }
}

/// How it went.
#[derive(Clone, Debug, Default)]
pub struct EpisodeResult {
    /// When it fell, s.
    pub fell_at: Option<f64>,
    /// Root mean square of the trunk's angular velocity from the disturbance on, rad/s.
    pub trunk_rate: f64,
    /// Largest distance of a foot from where it stood, m, without what the ground moved.
    pub slid: f64,
    /// Contact points that carried, on average from the disturbance on.
    pub carrying: f64,
    /// Instants, where asked for.
    pub frames: Vec<StoryboardFrame>,
    /// Seconds of computing for a second of simulation: of the controller, and of all.
    pub cost: (f64, f64),
}

impl EpisodeResult {
    /// Whether the body stood to the end.
    pub fn held(&self) -> bool {
        self.fell_at.is_none()
    }
}

/// Why an episode cannot be run.
pub type EpisodeError = BalanceError;

/// Runs episode number `number` of a body; `frames` instants a second are kept (0 for none).
pub fn run_episode(
    model: &SharedModel,
    episode: &Episode,
    number: u64,
    frames: f64,
) -> Result<EpisodeResult, EpisodeError> {
    watch_episode(model, episode, number, frames, &mut |_, _| {})
}

/// The same, with every instant shown to `watch`.
pub fn watch_episode(
    model: &SharedModel,
    episode: &Episode,
    number: u64,
    frames: f64,
    watch: &mut dyn FnMut(&mut Simulator<f64>, &Balance),
) -> Result<EpisodeResult, EpisodeError> {
    let mut random = RandomStream::new(number, STREAM);
    let mut sim = Simulator::<f64>::new(model.clone(), SimulationSettings::of(model));
    disturb_joints(&mut sim, &mut random, episode.noise);
    let friction = random.range(episode.friction.0, episode.friction.1.max(episode.friction.0 + 1e-9));
    let surface = Surface { friction, ..Surface::GROUND };
    let mut world = ground(&episode.disturbance, surface);
    put_on_ground(&mut sim, &world);
    let mut balance = Balance::new(model, episode.settings)?;
    balance.begin(&mut sim, &world);

    let h = sim.step_seconds();
    let steps = (episode.seconds / h).round() as usize;
    let start_height = sim.center_of_mass().lane(0).y;
    let every = if frames > 0.0 { ((1.0 / frames / h).round() as usize).max(1) } else { usize::MAX };
    let mut result = EpisodeResult::default();
    let (mut rate, mut rated, mut carrying) = (0.0, 0.0, 0.0);
    let started = std::time::Instant::now();
    let mut controlled = 0.0;
    let change = |seconds: f64| (seconds / h).round() as usize;
    for k in 0..steps {
        let time = k as f64 * h;
        if k == change(BEGIN) && episode.stance != StancePose::Basic(BasicPose::Rest) {
            let stance = match episode.stance {
                StancePose::Basic(pose) => balance.basic(pose)?,
                StancePose::OneLeg(foot) => balance.one_leg(foot)?,
                StancePose::Circling(foot) => balance.circling(foot, 0)?,
            };
            balance.assume(stance)?;
        }
        let leaves = if episode.returns { episode.seconds - 3.0 } else { f64::INFINITY };
        if let StancePose::Circling(foot) = episode.stance
            && k > change(BEGIN)
            && (k - change(BEGIN)).is_multiple_of(change(QUARTER))
            && time < leaves
        {
            balance.assume(balance.circling(foot, (k - change(BEGIN)) / change(QUARTER))?)?;
        }
        if episode.returns && k == change(leaves) {
            let rest = balance.basic(BasicPose::Rest)?;
            balance.assume(rest)?;
        }
        disturb(&mut sim, &mut world, &episode.disturbance, time);
        let before = std::time::Instant::now();
        balance.tick(&mut sim, &world);
        controlled += before.elapsed().as_secs_f64();
        step(&mut sim, &world);
        watch(&mut sim, &balance);
        if k % every == 0 {
            result.frames.push(frame(&mut sim));
        }
        let root = sim.state.root_rotation.lane(0) * DVec3::Y;
        let height = sim.center_of_mass().lane(0).y;
        if !sim.is_sane(0) || height < SUNK * start_height || root.angle_between(DVec3::Y) > LEANT {
            result.fell_at = Some(time);
            break;
        }
        if time > BEGIN {
            let trunk = model.trunk();
            rate += sim.kinematics()[trunk].velocity.angular.lane(0).length_squared();
            carrying += sim.loaded_points(0) as f64;
            rated += 1.0;
        }
    }
    result.trunk_rate = (rate / f64::max(rated, 1.0)).sqrt();
    result.carrying = carrying / f64::max(rated, 1.0);
    let simulated = sim.state.time.max(h);
    result.cost = (controlled / simulated, started.elapsed().as_secs_f64() / simulated);
    Ok(result)
}

/// Turns every joint by a random rotation vector.
fn disturb_joints(sim: &mut Simulator<f64>, random: &mut RandomStream, noise: f64) {
    let model = sim.model().clone();
    for (i, link) in model.links.iter().enumerate().skip(1) {
        let r = DVec3::new(random.normal(), random.normal(), random.normal()) * noise;
        let r = match link.joint {
            JointKind::Hinge { axis } => axis * axis.dot(r),
            _ => r,
        };
        sim.state.joints[i].rotation.set_lane(0, DQuat::from_scaled_axis(r));
    }
    sim.state_changed();
}

/// Moves the body straight down or up until its lowest point touches.
fn put_on_ground(sim: &mut Simulator<f64>, world: &World) {
    use crate::contact::Terrain;
    let model = sim.model().clone();
    for _ in 0..4 {
        let root = sim.state.root_position.lane(0);
        let links = sim.kinematics();
        let gap = |p: &crate::model::ContactPoint| {
            let k = &links[p.link];
            let at = root + k.origin.lane(0) + k.rotation.lane(0) * p.position;
            world.query(Vec3::<f64>::splat(at)).distance - p.radius
        };
        let lowest = model.contact_points.iter().map(gap).fold(f64::INFINITY, f64::min);
        sim.state.root_position.set_lane(0, root - DVec3::Y * lowest);
        sim.state_changed();
    }
}

/// The world of a disturbance.
fn ground(disturbance: &Disturbance, surface: Surface) -> World {
    match *disturbance {
        Disturbance::Ball { radius } => {
            let ball = Geometry::Sphere { center: DVec3::Y * -radius, radius };
            World { solids: vec![Solid::fixed(ball, surface)] }
        }
        Disturbance::Sway { axis, .. } => {
            World { solids: vec![Solid::tilted_plane(DVec3::ZERO, axis, 0.0, 0.0, surface)] }
        }
        _ => World::plane(surface),
    }
}

/// What acts on the body, and how the ground moves, in the step that begins at `time`.
fn disturb(sim: &mut Simulator<f64>, world: &mut World, disturbance: &Disturbance, time: f64) {
    sim.external.clear();
    let after = time - BEGIN;
    match *disturbance {
        Disturbance::Push { force, toward } if (0.0..PUSH).contains(&after) => {
            let trunk = sim.model().trunk();
            let position = Vec3::<f64>::splat(sim.model().links[trunk].com);
            sim.external.push(ExternalForce { link: trunk, position, force: Vec3::<f64>::splat(toward * force) });
        }
        Disturbance::Jerk { way, toward } => {
            let s = (after / JERK).clamp(0.0, 1.0);
            // x = 10 s^3 - 15 s^4 + 6 s^5, of which this is the rate.
            let rate = 30.0 * s * s * (1.0 - s) * (1.0 - s) / JERK;
            for solid in &mut world.solids {
                solid.linear_velocity = toward * (way * rate);
            }
        }
        Disturbance::Sway { angle, frequency, axis } if after > 0.0 => {
            // It begins gently: the amplitude grows over one period.
            let phase = TAU * frequency * after;
            let grown = (after * frequency).min(1.0);
            let growing = if grown < 1.0 { frequency } else { 0.0 };
            let tilt = angle * grown * phase.sin();
            let rate = angle * (grown * TAU * frequency * phase.cos() + growing * phase.sin());
            for solid in &mut world.solids {
                *solid = Solid::tilted_plane(DVec3::ZERO, axis, tilt, rate, solid.surface);
            }
        }
        _ => {}
    }
}

/// The present instant.
fn frame(sim: &mut Simulator<f64>) -> StoryboardFrame {
    let root = sim.state.root_position.lane(0);
    let links = sim.kinematics().iter().map(|k| crate::model::LinkTransform {
        position: root + k.origin.lane(0),
        rotation: DQuat::from_mat3(&k.rotation.lane(0)),
    });
    let links: Vec<_> = links.collect();
    let model = sim.model().clone();
    let contacts = model.contact_points.iter().enumerate().filter_map(|(index, p)| {
        let force = sim.contact_force(index, 0);
        let link = &links[p.link];
        let position = link.position + link.rotation * p.position;
        (force.length() > 1e-6).then_some(crate::storyboard::TouchPoint { position, force })
    });
    let contacts = contacts.collect();
    StoryboardFrame { contacts, ..StoryboardFrame::new(sim.state.time, links) }
}
