//! Forces on an athlete from outside: pushes, pulls, wind.

use crate::engine::{AthleteBody, AthleteTime, LinkId};
use crate::math::Vec3 as LaneVec3;
use crate::sim::ExternalForce;
use bevy::math::DVec3;
use bevy::prelude::*;

/// One force on a link.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct AthleteForce {
    /// The link.
    pub link: LinkId,
    /// Where it acts, link frame, m.
    pub position: DVec3,
    /// Force, world axes, N.
    pub force: DVec3,
    /// How much longer it acts, s of the athletes' time ([`AthleteTime`](super::AthleteTime)); whole fixed ticks. `None` acts until you take it out.
    pub seconds: Option<f64>,
}

/// The forces that act on an athlete, in every fixed tick until they end or are taken out. Every athlete has it; add to it at
/// any time. A link that does not exist, or a force that is no number, does nothing.
///
/// ```no_run
/// # use bevy::{math::DVec3, prelude::*};
/// # use bevy_athlete::engine::*;
/// fn shove(mut forces: Query<&mut AthleteForces>) {
///     for mut forces in &mut forces {
///         forces.0.push(AthleteForce { link: LinkId::ROOT, position: DVec3::ZERO, force: DVec3::X * 200.0, seconds: Some(0.1) });
///     }
/// }
/// ```
#[derive(Component, Clone, Debug, Default, PartialEq, Deref, DerefMut, Reflect)]
#[reflect(Component, Default)]
pub struct AthleteForces(pub Vec<AthleteForce>);

impl AthleteForce {
    fn external(&self) -> ExternalForce<f64> {
        ExternalForce {
            link: self.link.index(),
            position: LaneVec3::splat(self.position),
            force: LaneVec3::splat(self.force),
        }
    }

    fn acts_on(&self, body: &AthleteBody) -> bool {
        self.link.index() < body.model().links.len() && self.position.is_finite() && self.force.is_finite()
    }
}

/// Before the steps of a tick.
pub(super) fn give_forces(mut athletes: Query<(&mut AthleteBody, &AthleteForces)>) {
    for (mut body, forces) in &mut athletes {
        for force in forces.iter() {
            if force.acts_on(&body) {
                body.simulator_mut().external.push(force.external());
            }
        }
    }
}

/// After them: takes out what was given, and ends what has acted for long enough.
pub(super) fn take_forces(time: Res<AthleteTime>, mut athletes: Query<(&mut AthleteBody, &mut AthleteForces)>) {
    let tick = time.delta().as_secs_f64();
    for (mut body, mut forces) in &mut athletes {
        if forces.is_empty() {
            continue;
        }
        for force in forces.iter() {
            let given = force.external();
            let same = |other: &ExternalForce<f64>| {
                other.link == given.link
                    && other.position.lane(0) == given.position.lane(0)
                    && other.force.lane(0) == given.force.lane(0)
            };
            let external = &mut body.simulator_mut().external;
            if let Some(at) = external.iter().rposition(same) {
                external.remove(at);
            }
        }
        forces.bypass_change_detection().retain_mut(|force| match &mut force.seconds {
            Some(left) => {
                *left -= tick;
                *left > 1e-9
            }
            None => true,
        });
    }
}
