//! What happens to athletes. Each type is a [`Message`] (read it with a `MessageReader`) and an entity event (observe it
//! with `app.add_observer` or `entity.observe`); both arrive in the fixed tick it happened in.

use crate::contact::BladeEdge;
use crate::engine::{AthleteRefusal, LinkId, QuarantineReason};
use crate::skill::planner::{ObstacleKind, Refusal};
use crate::skill::{BadParameter, NoEntry};
use bevy::math::DVec3;
use bevy::prelude::*;

/// Asks for an athlete to be put back to the start of its control, at rest where it holds a pose. Lifts a quarantine.
/// Trigger it or write it as a message; it acts in the next [`AthleteSystems::Control`](super::AthleteSystems::Control).
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct AthleteReset {
    /// The athlete.
    pub entity: Entity,
    /// A new place to start from, in the world; `None` keeps the one it has.
    pub placement: Option<Transform>,
}

impl AthleteReset {
    /// Back to the start, where it was spawned.
    pub fn new(entity: Entity) -> Self {
        Self { entity, placement: None }
    }
    /// To the start of its control at another place in the world.
    pub fn at(entity: Entity, placement: Transform) -> Self {
        Self { entity, placement: Some(placement) }
    }
}

/// An athlete has its body: its files have arrived, and from the coming steps on it moves. `AthleteBody` is there when it is told.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Eq, Reflect)]
pub struct AthleteReady {
    /// The athlete.
    pub entity: Entity,
}

/// A blade changed its edge and stayed on the new one for 10 ms.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct BladeEdgeChanged {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time of the change since the start of the control, s.
    pub time: f64,
    /// Index of the blade in the character.
    pub blade: usize,
    /// The edge before.
    pub from: BladeEdge,
    /// The edge now.
    pub to: BladeEdge,
}

/// The last contact with the world was lost, and nothing touched it again for 20 ms.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct TakeOff {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time of the last contact, s.
    pub time: f64,
    /// Velocity of the centre of mass when the take-off was certain, world axes, m/s.
    pub velocity: DVec3,
}

/// The first contact after a [`TakeOff`].
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct Landing {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time of the contact, s.
    pub time: f64,
    /// Time since the last contact before, s.
    pub airtime: f64,
    /// Velocity of the centre of mass, world axes, m/s.
    pub velocity: DVec3,
    /// Rise of the root link since the last contact, m.
    pub height: f64,
    /// Turns about the vertical since then, positive to the left (counter-clockwise from above).
    pub turns: f64,
}

/// A trained skill has begun; the one before has ended.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct SkillStarted {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time, s.
    pub time: f64,
    /// Name of the skill.
    pub skill: String,
}

/// A trained skill has ended: another one begins, or it, or the program it is part of, is over.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct SkillEnded {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time, s.
    pub time: f64,
    /// Name of the skill.
    pub skill: String,
}

/// A skill that was asked for ([`PerformSkill`](super::PerformSkill)) will not begin.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct SkillRefused {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time, s.
    pub time: f64,
    /// Name of the skill.
    pub skill: String,
    /// Why.
    pub reason: NoEntry,
}

/// A parameter of a skill has not the value that was wished for ([`AthleteInput::parameters`](super::AthleteInput::parameters)). Told when
/// the skill begins, or when the wish is new.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct ParameterRefused {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time, s.
    pub time: f64,
    /// Name of the skill that plays.
    pub skill: String,
    /// Name of the parameter.
    pub parameter: String,
    /// Why, and what is taken in its place.
    pub reason: BadParameter,
}

/// An athlete on a course ([`AthleteController::Course`](super::AthleteController::Course)) has seen the next obstacle, or thinks otherwise of it: which skill will
/// clear it, or why it stops before it.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct ObstaclePlanned {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time, s.
    pub time: f64,
    /// What it is.
    pub kind: ObstacleKind,
    /// From the athlete to its beginning, m.
    pub distance: f64,
    /// Height against the ground before it, m; of a way down and a gap negative.
    pub height: f64,
    /// Length along the way, m; as far as is seen where it goes on.
    pub depth: f64,
    /// The skill that will clear it.
    pub skill: Option<String>,
    /// Why none will.
    pub refusal: Option<Refusal>,
}

/// The trunk or the head touches the world, and the centre of mass is below half its standing height above it. Told once
/// until the athlete is up again or is reset.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct AthleteFell {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time, s.
    pub time: f64,
    /// The link that touched.
    pub link: LinkId,
}

/// A grip slipped open: what it held pulled harder than it can hold, or the solid that it held is gone.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct GripSlipped {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time, s.
    pub time: f64,
    /// Index of the grip in the character.
    pub grip: usize,
}

/// The control has been played, the skill or the program performed to its end; the last targets are held.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct ControlFinished {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time, s.
    pub time: f64,
}

/// An athlete went bad, or something that it was given is no number: it is stopped at its last good
/// pose. The others go on. [`AthleteReset`] starts it anew.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq, Reflect)]
pub struct AthleteQuarantined {
    /// The athlete.
    pub entity: Entity,
    /// Simulated time at which it was stopped, s.
    pub time: f64,
    /// Why.
    pub reason: QuarantineReason,
}

/// An athlete, a new controller or a new placement was refused.
#[derive(Message, EntityEvent, Clone, Debug, Reflect)]
#[reflect(opaque)]
pub struct AthleteRefused {
    /// The athlete.
    pub entity: Entity,
    /// Why.
    pub reason: AthleteRefusal,
}

/// Tells an event as a message and as an entity event.
pub(super) fn both<E>(commands: &mut Commands, writer: &mut MessageWriter<E>, event: E)
where
    E: Message + Clone,
    for<'a> E: EntityEvent<Trigger<'a>: Default>,
{
    writer.write(event.clone());
    commands.trigger(event);
}
