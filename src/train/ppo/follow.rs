//! Lets the trials of a skill begin as the policy of the skill before it really leaves its motion.

use crate::asset::dense_layers::DenseLayers;
use crate::asset::policy_contract::PolicyContract;
use crate::control::tracking::Heading;
use crate::math::Real;
use crate::skill::{SteerOptions, Transition, TrialRow};
use crate::train::nn::Network;
use crate::train::ppo::environment::{Environment, EpisodeStatus};
use crate::train::ppo::error::TrainError;
use crate::train::ppo::evaluate::{Actor, MeanActor};
use crate::train::ppo::handover::HandOver;
use crate::train::ppo::normalizer::Normalizer;
use crate::train::ppo::rollout::Lanes;
use crate::train::ppo::sampling::StartSampler;
use crate::train::ppo::task::SkillTask;
use glam::DQuat;
use std::sync::Arc;

/// Bodies that are looked for.
const BODIES: usize = 192;
/// A motion that repeats is played for so long before it is left, s.
const WARM_UP: f64 = 2.0;
/// Bodies that are taken from one trial of it.
const FROM_ONE: usize = 3;
/// A body whose root is higher or lower than the reference's by more than this is on its way to a fall, m.
const FALLING: f64 = 0.1;
/// Part of its trials that begin as what comes before it is left, where that is known.
const AFTER: f64 = 0.5;
/// One that is steered is told another of the speeds so often, s, and turns by so much, rad/s: a planner hurries, brakes and steers.
const COMMANDS: (f64, f64) = (0.4, 2.0);
const TURN: f64 = 0.2;
/// Longest time in which bodies are looked for, s of every lane.
const LONGEST: f64 = 120.0;

/// Lets the trials of `task` that follow its `k`-th predecessor (see [`SkillTask::follow`]) begin as the policy of that skill, `other`, leaves it: at
/// speeds at which `task` begins, which change on the way; half of its own trials begin as what `other` follows is left. Gives how many bodies were found; with none they begin in the pose of its motion, as before.
pub fn follow_policy(
    task: &mut SkillTask,
    k: usize,
    other: &SkillTask,
    layers: &DenseLayers,
    contract: &PolicyContract,
) -> Result<usize, TrainError> {
    let differs =
        |what: &str, found: String, expected: String| TrainError::Start { what: what.into(), found, expected };
    let misfit = contract.check_numbers(&other.skill.policy_use(&other.model));
    misfit.map_err(|e| differs(&e.field, e.found, e.valid))?;
    let actor = Network::try_from(layers);
    let actor = actor.map_err(|e| differs("network", e.to_string(), "layers of a policy".into()))?;
    let known = &contract.normaliser;
    let normalizer = Normalizer::fixed(known.mean.clone(), known.scale.clone(), known.clip);
    let mut other = other.trial(&TrialRow::named("followed"))?;
    let episode = &mut other.skill.episode;
    let steered = episode.steer.take().is_some();
    episode.after_share = if other.before.is_empty() { 0.0 } else { AFTER };
    if other.motion.cycle().is_some() {
        let began = &task.skill.episode;
        (episode.speed, episode.start_speed, episode.start) = (began.start_speed.or(began.speed), None, None);
        episode.steer = steered.then_some(SteerOptions { every: COMMANDS, turn: TURN });
    }
    let other = Arc::new(other.at_play_rate()?);
    let Some(before) = task.before.get_mut(k) else { return Ok(0) };
    let bodies = record::<Lanes, _>(&other, &MeanActor(&actor, &normalizer), before.transition, k as u64);
    before.bodies = bodies.into();
    Ok(before.bodies.len())
}

/// The body of a lane, turned so that its reference goes along -Z.
fn body_of<R: Real>(env: &Environment<R>, lane: usize) -> HandOver {
    let (state, support) = (&env.sim.state, env.tracker.support());
    let way = Heading::<f64>::towards(env.tracker.way().lane(lane));
    let turn: DQuat = Heading::ahead().relative_to(way).to_quat().lane(0);
    HandOver {
        height: state.root_position.y.lane(lane) - support.height.lane(lane),
        rotation: turn * state.root_rotation.lane(lane),
        joints: state.joints.iter().map(|j| j.rotation.lane(lane)).collect(),
        linear: turn * (state.root_velocity.linear.lane(lane) - support.velocity.lane(lane)),
        angular: turn * state.root_velocity.angular.lane(lane),
        joint_velocities: state.joints.iter().map(|j| j.velocity.lane(lane)).collect(),
        targets: env.sim.commands.iter().map(|c| c.rotation.lane(lane)).collect(),
    }
}

/// Plays a task until [`BODIES`] bodies have been at the tick at which it is left; fewer, or none, where its policy does not get there.
fn record<R: Real, A: Actor>(task: &Arc<SkillTask>, actor: &A, transition: Transition, seed: u64) -> Vec<HandOver> {
    let cyclic = task.motion.cycle().is_some();
    let starts = StartSampler::uniform(task.motion.last(), cyclic);
    let mut env = Environment::<R>::new(task.clone(), seed, 0x4841_0000, &starts);
    let (mut scratch, mut rows) = (A::Scratch::default(), vec![0.0; R::LANES * task.layout.size()]);
    let rate = task.skill.control_rate;
    let mut age = vec![0usize; R::LANES];
    let mut taken = vec![0usize; R::LANES];
    let mut found = Vec::new();
    let last = task.motion.last().max(1);
    for _ in 0..(LONGEST * rate) as usize {
        env.observe(&mut rows);
        let actions = actor.act(&mut scratch, &mut rows, R::LANES).to_vec();
        for (lane, outcome) in env.tick(&actions).into_iter().enumerate() {
            age[lane] += 1;
            let passed = (env.tracker.tick(lane) + last - transition.leave % last) % last;
            let leaves = if cyclic {
                age[lane] as f64 > WARM_UP * rate && passed < task.motion.most_ticks()
            } else {
                env.tracker.tick(lane) == transition.leave
            };
            let off = env.sim.state.root_position.y.lane(lane) - env.tracker.reference_root().y.lane(lane);
            if leaves && off.abs() < FALLING && outcome.status != EpisodeStatus::Terminated {
                found.push(body_of(&env, lane));
                taken[lane] += 1;
            }
            if outcome.status != EpisodeStatus::Running || taken[lane] == if cyclic { FROM_ONE } else { 1 } {
                env.reset(lane, &starts);
                (age[lane], taken[lane]) = (0, 0);
            }
        }
        if found.len() >= BODIES {
            break;
        }
    }
    found
}
