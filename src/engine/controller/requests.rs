//! Wishes and requests, handed to the bodies.

use crate::engine::events::both;
use crate::engine::{AthleteBody, AthleteController, AthleteInput, AthleteSettings, AthleteTargets, SkillRefused};
use crate::skill::NoEntry;
use bevy::prelude::*;

/// Asks an athlete that is steered ([`AthleteController::Steer`]) for a skill, once, as soon as it can begin. The answer is
/// [`SkillStarted`](super::super::SkillStarted) when it does, or [`SkillRefused`] with the reason. When it would begin can be asked
/// before: [`AthleteBody::entry`].
///
/// Trigger it or write it as a message; it acts in the next [`AthleteSystems::Control`](super::super::AthleteSystems::Control).
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Eq, Reflect)]
pub struct PerformSkill {
    /// The athlete.
    pub entity: Entity,
    /// Name of the skill.
    pub skill: String,
}

impl PerformSkill {
    /// Asks for a skill by its name.
    pub fn new(entity: Entity, skill: impl Into<String>) -> Self {
        Self { entity, skill: skill.into() }
    }
}

/// A request that was triggered waits for the next fixed tick.
pub(in crate::engine) fn note_request(
    request: On<PerformSkill>,
    mut commands: Commands,
    mut bodies: Query<&mut AthleteBody>,
    mut refusals: MessageWriter<SkillRefused>,
) {
    note(&request, &mut commands, &mut bodies, &mut refusals);
}

/// Requests that were written as messages.
pub(in crate::engine) fn hear_requests(
    mut requests: MessageReader<PerformSkill>,
    mut commands: Commands,
    mut bodies: Query<&mut AthleteBody>,
    mut refusals: MessageWriter<SkillRefused>,
) {
    for request in requests.read() {
        note(request, &mut commands, &mut bodies, &mut refusals);
    }
    for mut body in &mut bodies {
        if !body.requests.is_empty() {
            body.answer_requests();
        }
    }
}

fn note(
    request: &PerformSkill,
    commands: &mut Commands,
    bodies: &mut Query<&mut AthleteBody>,
    refusals: &mut MessageWriter<SkillRefused>,
) {
    let PerformSkill { entity, skill } = request.clone();
    match bodies.get_mut(entity) {
        Ok(mut body) => body.requests.push(skill),
        Err(_) => both(commands, refusals, SkillRefused { entity, time: 0.0, skill, reason: NoEntry::NotSimulated }),
    }
}

/// Targets, wishes and changed settings of users.
pub(in crate::engine) fn hand_over_inputs(
    mut athletes: Query<(
        &mut AthleteBody,
        &AthleteController,
        &AthleteInput,
        Ref<AthleteSettings>,
        Option<&AthleteTargets>,
    )>,
) {
    for (mut body, controller, input, settings, targets) in &mut athletes {
        if settings.is_changed() {
            body.apply_settings(&settings);
        }
        if let (AthleteController::External, Some(targets)) = (controller, targets) {
            body.take_targets(targets);
        }
        // Only what is new is told: a body is not marked as changed for nothing.
        if body.director().is_some_and(|director| !input.is(director.input()))
            && let Some(director) = body.director_mut()
        {
            director.set_input(input.checked());
        }
    }
}
