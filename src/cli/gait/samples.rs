//! A skill walks over level ground and is measured.

use crate::contact::{Surface, World};
use crate::control::PolicyError;
use crate::control::foot::{BasicPose, FootAnatomy, FootError};
use crate::control::tracking::Heading;
use crate::math::RandomStream;
use crate::model::{GRAVITY, SharedModel};
use crate::sim::{SimulationSettings, Simulator, step};
use crate::skill::{Director, DirectorInput, Disturbance, PELVIS};
use glam::DVec3;

/// Measurements per second, about: a whole number of steps lies between two.
pub const SAMPLE_RATE: f64 = 200.0;

/// How to walk.
#[derive(Clone, Copy, Debug)]
pub struct GaitTask {
    /// Commanded speed, m/s.
    pub speed: f64,
    /// Time before the first measurement, s.
    pub settle: f64,
    /// Measured time, s.
    pub seconds: f64,
    /// Errors of the start.
    pub disturbance: Disturbance,
    /// Seed of the start.
    pub seed: u64,
}

/// Why a gait cannot be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GaitError {
    /// The character's feet have no segments that can be told apart.
    #[error(transparent)]
    Foot(#[from] FootError),
    /// Not two feet, one on each side.
    #[error("{character} has {count} feet; valid: a character with two, one on each side")]
    Feet {
        /// The character.
        character: String,
        /// How many.
        count: usize,
    },
    /// The policy gave no numbers.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// It did not walk to the end.
    #[error("{character} fell after {seconds:.1} s at {speed} m/s")]
    Fell {
        /// The character.
        character: String,
        /// When, s.
        seconds: f64,
        /// Commanded speed, m/s.
        speed: f64,
    },
    /// Too few strides.
    #[error("{found} strides in {seconds} s; valid: {wanted} or more, in a longer time or with a gait that steps")]
    Strides {
        /// How many.
        found: usize,
        /// Measured time, s.
        seconds: f64,
        /// How many are needed.
        wanted: usize,
    },
}

/// What is measured of one foot. Means over the steps since the sample before for forces and moments, else the instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FootGait {
    /// Force of the ground, body weights: to the right, up, and ahead, of the way that is walked.
    pub force: DVec3,
    /// The vertical part of it that the segments behind the ankle take, body weights.
    pub heel: f64,
    /// Where the force acts along the sole, 0 at the heel's rear end, 1 at the toes' front end; the contact points' places are those of the foot at
    /// rest, so a heel that rises does not move it. `None` without load.
    pub pressure: Option<f64>,
    /// Where it acts in the world, m; zero without load.
    pub center: DVec3,
    /// Moment of the ankle's joint, N m for a kilogram of the body; positive where it presses the toes down.
    pub ankle_moment: f64,
    /// Angle of the ankle, degrees, positive where the toes are up.
    pub ankle: f64,
    /// Angle of the medial toes against what they hang on, degrees, positive where they are up.
    pub toes: f64,
    /// Stiffness of each joint of the foot as a multiple of the character's, in the order of [`GaitRecording::joints`].
    pub gains: Vec<f64>,
}

/// An instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GaitSample {
    /// s.
    pub time: f64,
    /// Left and right.
    pub feet: [FootGait; 2],
    /// Velocity of the centre of mass over the ground, m/s.
    pub velocity: DVec3,
    /// Power that all joints give or take, the sum of sizes, W.
    pub power: f64,
}

/// A walk.
#[derive(Clone, Debug)]
pub struct GaitRecording {
    /// Samples at equal times.
    pub samples: Vec<GaitSample>,
    /// Samples per second.
    pub rate: f64,
    /// Mass of the body, kg.
    pub mass: f64,
    /// Joints of the left foot whose stiffness is told.
    pub joints: Vec<String>,
}

/// What is known of a foot beforehand.
struct Known {
    anatomy: FootAnatomy,
    /// The toes, by their segment.
    toes: Option<usize>,
    /// Contact points, their places along the sole (0 to 1), and whether they are behind the ankle.
    points: Vec<(usize, f64, bool)>,
}

impl Known {
    fn of(model: &SharedModel, index: usize) -> Result<Self, GaitError> {
        let anatomy = FootAnatomy::of(model, index)?;
        let places = model.rest_positions();
        let ahead = anatomy.forward();
        let along = |link: usize, at: DVec3| (places[link] + at).dot(ahead);
        let all = || anatomy.segments().iter().flat_map(|s| s.points.iter().map(move |p| (s.link, *p)));
        let rear = all().map(|(link, (at, r, _))| along(link, at) - r).fold(f64::INFINITY, f64::min);
        let front = all().map(|(link, (at, r, _))| along(link, at) + r).fold(f64::NEG_INFINITY, f64::max);
        let (behind, _) = anatomy.rear_and_front();
        let point = |(link, (at, _, k)): (usize, (DVec3, f64, usize))| {
            (k, (along(link, at) - rear) / (front - rear).max(1e-6), behind.contains(&k))
        };
        let points = all().map(point).collect();
        // The medial ones of several.
        let toes = anatomy.set(BasicPose::Tiptoe).ok();
        let medial = anatomy.set(BasicPose::InsideTilt).ok();
        let toes = toes.and_then(|toes| {
            let inner = toes.iter().find(|k| medial.is_some_and(|m| m.contains(*k)));
            inner.or_else(|| toes.iter().next())
        });
        Ok(Self { anatomy, toes: toes.filter(|k| *k != 0), points })
    }
}

/// How far a direction of a segment is raised out of the level of what it hangs on, degrees.
fn raised(q: glam::DQuat, ahead: DVec3) -> f64 {
    let turned = q * ahead;
    turned.y.atan2(turned.dot(ahead)).to_degrees()
}

/// Walks by the first skill of a director, straight on over level ground, and measures. Nothing is left out: a fall is an error.
pub fn record_gait(director: &mut Director, model: &SharedModel, task: &GaitTask) -> Result<GaitRecording, GaitError> {
    let sides = [crate::asset::Side::Left, crate::asset::Side::Right];
    let index = |side| model.feet().iter().position(|f| f.side == Some(side));
    let (Some(left), Some(right)) = (index(sides[0]), index(sides[1])) else {
        return Err(GaitError::Feet { character: model.name.clone(), count: model.feet().len() });
    };
    let feet = [Known::of(model, left)?, Known::of(model, right)?];
    let world = World::plane(Surface::GROUND);
    let rate = director.simulation_rate(model);
    let settings = SimulationSettings { rate, ..SimulationSettings::of(model) };
    let mut sim = Simulator::<f64>::new(model.clone(), settings);
    let input = DirectorInput { direction: DVec3::NEG_Z, speed: Some(task.speed), ..DirectorInput::default() };
    director.set_input(input);
    director.begin(&mut sim, Heading::ahead(), DVec3::ZERO);
    task.disturbance.apply(&mut sim.state, 0, &mut RandomStream::new(task.seed, 0x6761_6974));
    sim.state_changed();

    let per = (rate / SAMPLE_RATE).round().max(1.0) as usize;
    let weight = model.mass() * GRAVITY;
    let joints: Vec<usize> = feet[0].anatomy.segments().iter().map(|s| s.link).collect();
    let mut recording = GaitRecording {
        samples: Vec::new(),
        rate: rate / per as f64,
        mass: model.mass(),
        joints: joints.iter().map(|link| model.links[*link].name.clone()).collect(),
    };
    let steps = ((task.settle + task.seconds) * rate) as usize;
    let mut sums = Sums::default();
    for n in 1..=steps {
        director.drive(&mut sim, &world)?;
        step(&mut sim, &world);
        director.after_step(&mut sim, &world);
        if !sim.is_sane(0) || sim.state.root_position.y < PELVIS {
            return Err(GaitError::Fell { character: model.name.clone(), seconds: sim.state.time, speed: task.speed });
        }
        if (n as f64) < task.settle * rate {
            continue;
        }
        sums.add(&mut sim, &feet);
        if n % per == 0 {
            recording.samples.push(sums.take(&mut sim, &feet, weight));
        }
    }
    Ok(recording)
}

/// Sums over the steps since the last sample.
#[derive(Default)]
struct Sums {
    count: f64,
    /// Force, that on points behind the ankle, place along the sole times load, place in the world times load, moment.
    feet: [(DVec3, f64, f64, DVec3, f64); 2],
    power: f64,
}

impl Sums {
    fn add(&mut self, sim: &mut Simulator<f64>, feet: &[Known; 2]) {
        self.count += 1.0;
        let model = sim.model().clone();
        let root = sim.state.root_position.lane(0);
        for (sum, foot) in self.feet.iter_mut().zip(feet) {
            for (point, along, behind) in &foot.points {
                let force = sim.contact_force(*point, 0);
                if force == DVec3::ZERO {
                    continue;
                }
                let p = &model.contact_points[*point];
                let link = &sim.kinematics()[p.link];
                let place = root + link.origin.lane(0) + link.rotation.lane(0) * p.position;
                sum.0 += force;
                sum.1 += if *behind { force.y } else { 0.0 };
                sum.2 += force.y * along;
                sum.3 += place * force.y;
            }
            let ankle = foot.anatomy.ankle();
            let torque = sim.joint_torque(ankle).lane(0);
            let rotation = sim.kinematics()[ankle].rotation.lane(0);
            let ahead = rotation * foot.anatomy.forward();
            let right = (ahead * DVec3::new(1.0, 0.0, 1.0)).normalize_or(DVec3::NEG_Z).cross(DVec3::Y);
            // A turn about the right axis raises the toes.
            sum.4 -= (rotation * torque).dot(right);
        }
        let joints = sim.state.joints.iter().map(|j| j.velocity.lane(0)).collect::<Vec<_>>();
        self.power +=
            joints.iter().enumerate().skip(1).map(|(k, w)| sim.joint_torque(k).lane(0).dot(*w).abs()).sum::<f64>();
    }

    fn take(&mut self, sim: &mut Simulator<f64>, feet: &[Known; 2], weight: f64) -> GaitSample {
        let Sums { count, feet: sums, power } = std::mem::take(self);
        let model = sim.model().clone();
        let velocity = sim.total_momentum().linear.lane(0) / model.mass();
        let way = (velocity * DVec3::new(1.0, 0.0, 1.0)).normalize_or(DVec3::NEG_Z);
        let right = way.cross(DVec3::Y);
        let of = |k: usize| {
            let (foot, (force, heel, along, place, moment)) = (&feet[k], sums[k]);
            let mean = force / count / weight;
            let rotation = |link: usize| sim.state.joints[link].rotation.lane(0);
            let ahead = foot.anatomy.forward();
            let segments = foot.anatomy.segments();
            let gain = |link: usize| sim.commands[link].kp / model.links[link].gains.kp.max(1e-9);
            FootGait {
                force: DVec3::new(mean.dot(right), mean.y, mean.dot(way)),
                heel: heel / count / weight,
                pressure: (force.y > 0.0).then(|| along / force.y),
                center: if force.y > 0.0 { place / force.y } else { DVec3::ZERO },
                ankle_moment: moment / count / model.mass(),
                ankle: raised(rotation(foot.anatomy.ankle()), ahead),
                toes: foot.toes.map_or(0.0, |k| raised(rotation(segments[k].link), ahead)),
                gains: segments.iter().map(|s| gain(s.link)).collect(),
            }
        };
        GaitSample { time: sim.state.time, feet: [of(0), of(1)], velocity, power: power / count }
    }
}
