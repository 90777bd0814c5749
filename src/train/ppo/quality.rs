//! What a policy's motion is like: how smooth, how clean, at what cost.

use crate::contact::{CollisionCapsule, deepest_overlap};
use crate::model::Link;
use crate::sim::Simulator;
use crate::skill::PerformanceSample;
use crate::train::ppo::environment::{Environment, EpisodeStatus};
use crate::train::ppo::evaluate::Actor;
use crate::train::ppo::sampling::StartSampler;
use crate::train::ppo::task::{SkillTask, TARGET_SUBSTEPS};
use glam::DVec3;
use std::sync::Arc;

/// How close to its limit a joint counts as being at it, rad.
const AT_LIMIT: f64 = 0.01;

/// Figures of motion quality over some trials.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct MotionQuality {
    /// Root mean square jerk of the joints, rad/s^3, from their velocities at every decision.
    pub jerk: f64,
    /// The same of the reference motion, rad/s^3.
    pub reference_jerk: f64,
    /// Deepest overlap of links that are not neighbours, m.
    pub overlap: f64,
    /// Root mean square velocity across the blades that are on the ice with both ends, m/s.
    pub slip: f64,
    /// Share of the joints' time at a limit, 0 to 1.
    pub at_limits: f64,
    /// Work of the servos, positive and negative counted alike, for each metre travelled, J/m.
    pub work_per_metre: f64,
    /// Largest torque of a joint in any step, N m.
    pub torque: f64,
    /// Share of the joints' time with a torque of at least 99 % of the joint's limit, 0 to 1.
    pub at_torque_limits: f64,
    /// The torques joint by joint.
    pub joints: Vec<JointLoad>,
}

/// What a joint had to bear, over all steps of some trials.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct JointLoad {
    /// The link that the joint carries.
    pub joint: String,
    /// Largest torque that the joint may have, N m; `None` if it has no limit.
    pub limit: Option<f64>,
    /// Largest torque that it had, servo, extra torque and limit spring together, N m.
    pub peak: f64,
    /// Share of the time with a torque of at least 99 % of the limit, 0 to 1.
    pub at_limit: f64,
}

/// Gathers [`JointLoad`]s step by step.
#[derive(Clone, Debug, Default)]
struct JointLoads {
    /// Largest torque, N m, and steps at the limit, by link.
    links: Vec<(f64, usize)>,
    steps: usize,
}

impl JointLoads {
    fn look(&mut self, sim: &Simulator<f64>) {
        let links = &sim.model().links;
        self.links.resize(links.len(), (0.0, 0));
        self.steps += 1;
        for (i, ((peak, at_limit), link)) in self.links.iter_mut().zip(links).enumerate().skip(1) {
            let torque = sim.joint_torque(i).lane(0).length();
            *peak = peak.max(torque);
            *at_limit += usize::from(torque > 0.99 * link.max_torque);
        }
    }

    fn by_joint(&self, links: &[Link]) -> Vec<JointLoad> {
        let load = |((peak, at_limit), link): (&(f64, usize), &Link)| JointLoad {
            joint: link.name.clone(),
            limit: link.max_torque.is_finite().then_some(link.max_torque),
            peak: *peak,
            at_limit: *at_limit as f64 / self.steps.max(1) as f64,
        };
        self.links.iter().zip(links).skip(1).map(load).collect()
    }
}

#[derive(Default)]
struct Sums {
    jerk: (f64, usize),
    slip: (f64, usize),
    limits: (usize, usize),
    overlap: f64,
    work: f64,
    way: f64,
}

/// Measures `trials` trials of a judged task, one after the other, in f64.
pub fn motion_quality<A: Actor>(task: &Arc<SkillTask>, actor: &A, trials: usize, seed: u64) -> MotionQuality {
    let motion = &task.motion;
    let starts = StartSampler::uniform(motion.last(), motion.cycle().is_some());
    let capsules = CollisionCapsule::all(&task.model);
    let part = 1.0 / (task.skill.control_rate * TARGET_SUBSTEPS as f64);
    let (mut sums, mut scratch) = (Sums::default(), A::Scratch::default());
    let mut row = vec![0.0; task.layout.size()];
    let mut loads = JointLoads::default();
    for trial in 0..trials {
        let mut env = Environment::<f64>::new(task.clone(), seed, 0x7175_0000 + trial as u64, &starts);
        let mut velocities: Vec<Vec<DVec3>> = vec![joint_velocities(&env.sim)];
        loop {
            env.observe(&mut row);
            let actions = actor.act(&mut scratch, &mut row, 1).to_vec();
            let outcomes = env.tick_with(&actions, |sim, part_ends| {
                loads.look(sim);
                if part_ends {
                    look(sim, &capsules, part, &mut sums);
                }
            });
            velocities.push(joint_velocities(&env.sim));
            if outcomes[0].status != EpisodeStatus::Running {
                break;
            }
        }
        add_jerk(&velocities, task.skill.control_rate, &mut sums.jerk);
        add_slip(env.samples(0), &mut sums.slip);
    }
    let reference: Vec<Vec<DVec3>> = (0..=motion.last()).map(|k| motion.tick(k).velocity.joints.clone()).collect();
    let mut reference_jerk = (0.0, 0);
    add_jerk(&reference, task.skill.control_rate, &mut reference_jerk);
    let joints = loads.by_joint(&task.model.links);
    let mean = |(sum, count): (f64, usize)| sum / count.max(1) as f64;
    MotionQuality {
        jerk: mean(sums.jerk).sqrt(),
        reference_jerk: mean(reference_jerk).sqrt(),
        overlap: sums.overlap,
        slip: mean(sums.slip).sqrt(),
        at_limits: sums.limits.0 as f64 / sums.limits.1.max(1) as f64,
        work_per_metre: sums.work / sums.way.max(1e-9),
        torque: joints.iter().fold(0.0, |most, j| most.max(j.peak)),
        at_torque_limits: joints.iter().map(|j| j.at_limit).sum::<f64>() / joints.len().max(1) as f64,
        joints,
    }
}

fn joint_velocities(sim: &Simulator<f64>) -> Vec<DVec3> {
    sim.state.joints.iter().map(|j| j.velocity.lane(0)).collect()
}

/// Squared second differences of the joints' velocities.
fn add_jerk(velocities: &[Vec<DVec3>], rate: f64, sum: &mut (f64, usize)) {
    for w in velocities.windows(3) {
        for ((a, b), c) in w[0].iter().zip(&w[1]).zip(&w[2]).skip(1) {
            sum.0 += ((*a - *b * 2.0 + *c) * rate * rate).length_squared();
            sum.1 += 1;
        }
    }
}

/// Squared velocities across the blades, from their places.
fn add_slip(samples: &[PerformanceSample], sum: &mut (f64, usize)) {
    for w in samples.windows(2) {
        for (a, b) in w[0].feet.iter().zip(&w[1].feet) {
            if a.lean.is_some() && b.lean.is_some() && a.pressed && b.pressed {
                let across = (a.ahead() + b.ahead()).normalize_or_zero().cross(DVec3::Y);
                let velocity = (b.middle() - a.middle()) / (w[1].time - w[0].time).max(1e-9);
                sum.0 += velocity.dot(across).powi(2);
                sum.1 += 1;
            }
        }
    }
}

/// One look at the simulation, `part` seconds after the last.
fn look(sim: &mut Simulator<f64>, capsules: &[Option<CollisionCapsule>], part: f64, sums: &mut Sums) {
    let model = sim.model().clone();
    for (i, link) in model.links.iter().enumerate().skip(1) {
        let torque = sim.joint_torque(i).lane(0);
        sums.work += torque.dot(sim.state.joints[i].velocity.lane(0)).abs() * part;
        if let Some(limits) = &link.limits {
            let angle = sim.state.joints[i].rotation.to_rotation_vector().lane(0);
            let near = (angle - limits.low).min_element().min((limits.high - angle).min_element()) < AT_LIMIT;
            sums.limits.0 += usize::from(near);
            sums.limits.1 += 1;
        }
    }
    sums.way += (sim.state.root_velocity.linear.lane(0) * DVec3::new(1.0, 0.0, 1.0)).length() * part;
    sums.overlap = sums.overlap.max(deepest_overlap(&model, capsules, sim.kinematics(), 0));
}
