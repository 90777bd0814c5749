//! The systems of a fixed tick, and interpolation between ticks.

use crate::engine::diagnostics::StepTally;
use crate::engine::ground::OwnGround;
use crate::engine::lane_steps::{AthleteLanes, Due, LaneSimulators, step_all};
use crate::engine::performer::Performer;
use crate::engine::poses::to_transform;
use crate::engine::spawn::refuse;
use crate::engine::watch::Happening;
use crate::engine::{
    AthleteBody, AthleteController, AthleteFell, AthleteQuarantined, AthleteRefused, AthleteReset, AthleteSettings,
    AthleteTargets, AthleteWorld, BladeEdgeChanged, BodyStatus, ControlFinished, Landing, LinkPoses, Placement,
    QuarantineReason, SkatingProgram, SkillController, SkillEnded, SkillStarted, Steering, TakeOff,
};
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

/// Targets of users and changed settings.
pub(super) fn read_wishes(
    mut athletes: Query<(&mut AthleteBody, &AthleteController, Ref<AthleteSettings>, Option<&AthleteTargets>)>,
) {
    for (mut body, controller, settings, targets) in &mut athletes {
        if settings.is_changed() {
            body.apply_settings(&settings);
        }
        if let (AthleteController::External, Some(targets)) = (controller, targets) {
            body.take_targets(targets);
        }
    }
}

/// Speeds, directions and requests for trained skills.
pub(super) fn read_skill_wishes(
    mut athletes: Query<(&mut AthleteBody, Option<&SkillController>, Option<&mut Steering>), Without<SkatingProgram>>,
) {
    for (mut body, controller, steering) in &mut athletes {
        // Only what is there is told: a body is not marked as changed for nothing.
        if controller.is_none() && steering.is_none() {
            continue;
        }
        match (body.performer_mut(), controller, steering) {
            (Some(Performer::Steered { wish, .. }), _, Some(mut steering)) => {
                let begun = steering.perform.is_some() && wish.perform.is_none() && !steering.is_changed();
                if begun {
                    steering.bypass_change_detection().perform = None;
                } else {
                    wish.perform.clone_from(&steering.perform);
                }
                wish.direction = steering.direction.as_dvec3();
                wish.speed = finite(steering.speed);
            }
            (Some(Performer::Skill { speed, steering, .. }), Some(controller), _) => {
                *speed = controller.speed.map(finite);
                *steering = finite_turn(controller.steering);
            }
            _ => {}
        }
    }
}

/// A speed that can be asked for, m/s.
fn finite(speed: f32) -> f64 {
    if speed.is_finite() { f64::from(speed).clamp(0.0, 30.0) } else { 0.0 }
}

/// A turn that can be asked for, rad/s.
fn finite_turn(rate: f32) -> f64 {
    if rate.is_finite() { f64::from(rate).clamp(-2.0, 2.0) } else { 0.0 }
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
    time: Res<Time>,
    surroundings: Res<AthleteWorld>,
    lanes: Res<AthleteLanes>,
    kept: Local<LaneSimulators>,
    mut tally: ResMut<StepTally>,
    mut athletes: Query<(&mut AthleteBody, &AthleteSettings), Without<OwnGround>>,
) {
    let (begin, dt) = (Instant::now(), time.delta());
    let due: Vec<Due> = athletes
        .iter_mut()
        .filter_map(|(body, settings)| {
            let body = body.into_inner();
            let steps = body.begin_tick(dt, settings);
            (steps > 0).then_some(Due { body, settings, steps })
        })
        .collect();
    tally.bodies = due.len();
    tally.steps = due.iter().map(|d| u64::from(d.steps)).sum();
    if !due.is_empty() {
        step_all(due, lanes.0, &surroundings.0, &kept);
    }
    tally.quarantined = athletes.iter().filter(|(body, _)| body.status() == BodyStatus::Quarantined).count();
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
    take_offs: MessageWriter<'w, TakeOff>,
    landings: MessageWriter<'w, Landing>,
    falls: MessageWriter<'w, AthleteFell>,
    ends: MessageWriter<'w, ControlFinished>,
    starts: MessageWriter<'w, SkillStarted>,
    skill_ends: MessageWriter<'w, SkillEnded>,
    quarantines: MessageWriter<'w, AthleteQuarantined>,
}

/// Tells what happened in the tick, athlete by athlete, in the order it happened.
pub(super) fn tell(mut commands: Commands, mut athletes: Query<(Entity, &mut AthleteBody)>, mut writers: Writers) {
    /// As a message and as an entity event.
    fn both<E>(commands: &mut Commands, writer: &mut MessageWriter<E>, event: E)
    where
        E: Message + Clone,
        for<'a> E: EntityEvent<Trigger<'a>: Default>,
    {
        writer.write(event.clone());
        commands.trigger(event);
    }
    for (entity, mut body) in &mut athletes {
        if body.happened.is_empty() {
            continue;
        }
        for happening in body.happened.drain(..) {
            let c = &mut commands;
            match happening {
                Happening::Edge { time, blade, from, to } => {
                    both(c, &mut writers.edges, BladeEdgeChanged { entity, time, blade, from, to });
                }
                Happening::TakeOff { time, velocity } => {
                    both(c, &mut writers.take_offs, TakeOff { entity, time, velocity });
                }
                Happening::Landing { time, airtime, velocity, height, turns } => {
                    both(c, &mut writers.landings, Landing { entity, time, airtime, velocity, height, turns });
                }
                Happening::SkillStarted { time, skill } => {
                    both(c, &mut writers.starts, SkillStarted { entity, time, skill });
                }
                Happening::SkillEnded { time, skill } => {
                    both(c, &mut writers.skill_ends, SkillEnded { entity, time, skill });
                }
                Happening::Fell { time, link } => both(c, &mut writers.falls, AthleteFell { entity, time, link }),
                Happening::Finished { time } => both(c, &mut writers.ends, ControlFinished { entity, time }),
                Happening::Quarantined { time, reason } => {
                    warn!("athlete {entity} is stopped at {time:.4} s: {reason}; AthleteReset starts it anew");
                    both(c, &mut writers.quarantines, AthleteQuarantined { entity, time, reason });
                }
            }
        }
    }
}

/// Poses for this frame, and the athlete's transform: that of its root link.
pub(super) fn interpolate_poses(
    fixed: Res<Time<Fixed>>,
    mut athletes: Query<(&mut LinkPoses, &mut Transform, &AthleteSettings), With<AthleteBody>>,
) {
    let (overstep, timestep) = (fixed.overstep_fraction_f64(), fixed.timestep());
    athletes.par_iter_mut().for_each(|(mut poses, mut transform, settings)| {
        poses.interpolate(settings.interpolate.then_some(overstep), timestep);
        if let Some(root) = poses.interpolated.first() {
            *transform = to_transform(root);
        }
    });
}
