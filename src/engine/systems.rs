//! The systems of a fixed tick, and interpolation between ticks.

use crate::engine::arena::Worlds;
use crate::engine::arrival::refuse;
use crate::engine::diagnostics::StepTally;
use crate::engine::event_detector::BodyEvent;
use crate::engine::events::both;
use crate::engine::foot_watch::{FootChange, FootStep};
use crate::engine::ground::OwnGround;
use crate::engine::lane_steps::{AthleteLanes, Due, LaneSimulators, step_all};
use crate::engine::{
    AthleteBody, AthleteFell, AthleteQuarantined, AthleteRefused, AthleteReset, AthleteSettings, AthleteTime,
    BladeEdgeChanged, BodyStatus, ControlFinished, Footstep, GripSlipped, InArena, Landing, LinkId, LinkPoses,
    ObstaclePlanned, ParameterRefused, Placement, QuarantineReason, SkillEnded, SkillRefused, SkillStarted, StepTaken,
    Stumbled, TakeOff,
};
use crate::skill::planner::Obstacle;
use bevy::ecs::system::SystemParam;
use bevy::platform::time::Instant;
use bevy::prelude::*;

/// A reset that was triggered waits for the next fixed tick.
pub(super) fn note_reset(reset: On<AthleteReset>, mut bodies: Query<&mut AthleteBody>) {
    if let Ok(mut body) = bodies.get_mut(reset.entity) {
        body.reset_request = Some(reset.placement);
    }
}

/// Puts back those that are to be.
pub(super) fn reset_bodies(
    mut commands: Commands,
    mut asked: MessageReader<AthleteReset>,
    mut bodies: Query<(Entity, &mut AthleteBody)>,
    mut refusals: MessageWriter<AthleteRefused>,
) {
    for reset in asked.read() {
        if let Ok((_, mut body)) = bodies.get_mut(reset.entity) {
            body.reset_request = Some(reset.placement);
        }
    }
    for (entity, mut body) in &mut bodies {
        let Some(request) = body.reset_request.take() else { continue };
        match request.as_ref().map(Placement::from_transform).transpose() {
            Ok(placement) => {
                if let Some(placement) = placement {
                    body.set_placement(placement);
                }
                body.reset();
            }
            Err(reason) => refuse(&mut commands, &mut refusals, entity, reason),
        }
    }
}

/// Stops those whose `Transform` is no number: whoever wrote it, the athlete is not to be trusted.
pub(super) fn check_transforms(mut athletes: Query<(&mut AthleteBody, &Transform)>) {
    for (mut body, transform) in &mut athletes {
        if !transform.is_finite() && body.status() == BodyStatus::Running {
            body.stop(QuarantineReason::Transform);
        }
    }
}

/// Steps every athlete that has no ground of its own through the tick, on all threads of the compute pool.
pub(super) fn step_bodies(
    time: Res<AthleteTime>,
    worlds: Worlds,
    lanes: Res<AthleteLanes>,
    kept: Local<LaneSimulators>,
    mut tally: ResMut<StepTally>,
    mut athletes: Query<(&mut AthleteBody, &AthleteSettings, Option<&InArena>), Without<OwnGround>>,
) {
    let (begin, dt) = (Instant::now(), time.delta());
    let due: Vec<Due> = athletes
        .iter_mut()
        .filter_map(|(body, settings, arena)| {
            let body = body.into_inner();
            let steps = body.begin_tick(dt, settings);
            (steps > 0).then(|| Due { body, settings, steps, world: worlds.of(arena) })
        })
        .collect();
    tally.bodies = due.len();
    tally.steps = due.iter().map(|d| u64::from(d.steps)).sum();
    if !due.is_empty() {
        step_all(due, lanes.0, &kept);
    }
    tally.quarantined = athletes.iter().filter(|(body, ..)| body.status() == BodyStatus::Quarantined).count();
    tally.milliseconds = begin.elapsed().as_secs_f64() * 1e3;
}

/// Keeps the poses of this tick and the one before.
pub(super) fn write_poses(mut athletes: Query<(&mut AthleteBody, &mut LinkPoses)>) {
    athletes.par_iter_mut().for_each(|(mut body, mut poses)| {
        if body.status() == BodyStatus::Quarantined {
            // The last good pose stays.
            poses.cut();
            return;
        }
        poses.advance();
        body.write_links(&mut poses.current);
        poses.current_time = body.time();
        poses.lag = body.lag();
        if body.take_jump() {
            poses.cut();
        }
    });
}

/// One writer for each kind of event.
#[derive(SystemParam)]
pub(super) struct Writers<'w> {
    edges: MessageWriter<'w, BladeEdgeChanged>,
    footsteps: MessageWriter<'w, Footstep>,
    steps: MessageWriter<'w, StepTaken>,
    stumbles: MessageWriter<'w, Stumbled>,
    take_offs: MessageWriter<'w, TakeOff>,
    landings: MessageWriter<'w, Landing>,
    falls: MessageWriter<'w, AthleteFell>,
    slips: MessageWriter<'w, GripSlipped>,
    ends: MessageWriter<'w, ControlFinished>,
    starts: MessageWriter<'w, SkillStarted>,
    skill_ends: MessageWriter<'w, SkillEnded>,
    skill_refusals: MessageWriter<'w, SkillRefused>,
    parameters: MessageWriter<'w, ParameterRefused>,
    plans: MessageWriter<'w, ObstaclePlanned>,
    quarantines: MessageWriter<'w, AthleteQuarantined>,
}

/// Tells what happened in the tick, athlete by athlete, in the order it happened.
pub(super) fn emit(mut commands: Commands, mut athletes: Query<(Entity, &mut AthleteBody)>, mut writers: Writers) {
    for (entity, mut body) in &mut athletes {
        if body.events.is_empty() {
            continue;
        }
        for event in body.events.drain(..) {
            let c = &mut commands;
            match event {
                BodyEvent::Edge { time, blade, from, to } => {
                    both(c, &mut writers.edges, BladeEdgeChanged { entity, time, blade, from, to });
                }
                BodyEvent::Foot(FootChange { time, foot, side, phase, force, impulse, place, material, slip }) => {
                    let step = Footstep { entity, time, foot, side, phase, force, impulse, place, material, slip };
                    both(c, &mut writers.footsteps, step);
                }
                BodyEvent::Step(FootStep { time, foot, side, from, to, airtime }) => {
                    both(c, &mut writers.steps, StepTaken { entity, time, foot, side, from, to, airtime });
                }
                BodyEvent::Stumbled { time, cause } => {
                    both(c, &mut writers.stumbles, Stumbled { entity, time, cause });
                }
                BodyEvent::TakeOff { time, velocity } => {
                    both(c, &mut writers.take_offs, TakeOff { entity, time, velocity });
                }
                BodyEvent::Landing { time, airtime, velocity, height, turns } => {
                    both(c, &mut writers.landings, Landing { entity, time, airtime, velocity, height, turns });
                }
                BodyEvent::SkillStarted { time, skill } => {
                    both(c, &mut writers.starts, SkillStarted { entity, time, skill });
                }
                BodyEvent::SkillEnded { time, skill } => {
                    both(c, &mut writers.skill_ends, SkillEnded { entity, time, skill });
                }
                BodyEvent::SkillRefused { time, skill, reason } => {
                    both(c, &mut writers.skill_refusals, SkillRefused { entity, time, skill, reason });
                }
                BodyEvent::Parameter { time, skill, parameter, reason } => {
                    warn!("athlete {entity}: {skill}: parameter {parameter}: {reason}");
                    both(c, &mut writers.parameters, ParameterRefused { entity, time, skill, parameter, reason });
                }
                BodyEvent::Plan { time, obstacle, plan } => {
                    let Obstacle { kind, distance, height, depth, .. } = obstacle;
                    let (skill, refusal) =
                        plan.map_or_else(|refusal| (None, Some(refusal)), |skill| (Some(skill), None));
                    let planned = ObstaclePlanned { entity, time, kind, distance, height, depth, skill, refusal };
                    both(c, &mut writers.plans, planned);
                }
                BodyEvent::GripSlipped { time, grip } => {
                    both(c, &mut writers.slips, GripSlipped { entity, time, grip });
                }
                BodyEvent::Fell { time, link } => {
                    both(c, &mut writers.falls, AthleteFell { entity, time, link: LinkId::at(link) });
                }
                BodyEvent::Finished { time } => both(c, &mut writers.ends, ControlFinished { entity, time }),
                BodyEvent::Quarantined { time, reason } => {
                    warn!("athlete {entity} is stopped at {time:.4} s: {reason}; AthleteReset starts it anew");
                    both(c, &mut writers.quarantines, AthleteQuarantined { entity, time, reason });
                }
            }
        }
    }
}
