//! Gives the pushes that were asked for, and gravity as it was set.

use crate::engine::{AthleteBody, BodyStatus};
use crate::math::Vec3 as LaneVec3;
use crate::sim::{ExternalForce, SimulationSettings};
use crate::ui::disturbance::{Pull, PushPlan};
use bevy::math::DVec3;
use bevy::prelude::*;

/// Pushes under way, and gravity where it was changed.
#[derive(Resource, Clone, Debug, Default)]
pub struct ActiveDisturbances {
    pushes: Vec<ActivePush>,
    pull: Option<DVec3>,
}

#[derive(Clone, Copy, Debug)]
struct ActivePush {
    athlete: Entity,
    push: ExternalForce<f64>,
    /// Simulated time that is left, s.
    left: f64,
    /// It is among the body's external forces at the moment.
    given: bool,
}

impl ActiveDisturbances {
    /// Pushes an athlete from the next fixed tick on. The direction is that of its heading at this moment.
    pub fn push(&mut self, athlete: Entity, body: &AthleteBody, plan: &PushPlan) {
        let model = body.model();
        let link = model.link_index(&plan.link).unwrap_or(0);
        let force = plan.force_on(body.simulator().state.root_rotation.lane(0));
        if !(force.is_finite() && plan.seconds > 0.0) {
            return;
        }
        let push =
            ExternalForce { link, position: LaneVec3::splat(model.links[link].com), force: LaneVec3::splat(force) };
        self.pushes.push(ActivePush { athlete, push, left: plan.seconds, given: false });
    }

    /// Sets gravity for all athletes, present and to come, until it is set again.
    pub fn set_pull(&mut self, pull: &Pull) {
        self.pull = Some(pull.acceleration());
    }

    /// Number of pushes under way.
    pub fn pushes(&self) -> usize {
        self.pushes.len()
    }
}

/// Before the step: the pushes act, gravity is as set.
pub(super) fn give(mut active: ResMut<ActiveDisturbances>, mut bodies: Query<&mut AthleteBody>) {
    if active.pushes.is_empty() && active.pull.is_none() {
        return;
    }
    if let Some(gravity) = active.pull {
        for mut body in &mut bodies {
            let settings = *body.simulator().settings();
            if settings.gravity != gravity {
                body.simulator_mut().set_settings(SimulationSettings { gravity, ..settings });
            }
        }
    }
    for push in active.bypass_change_detection().pushes.iter_mut() {
        if let Ok(mut body) = bodies.get_mut(push.athlete)
            && body.status() == BodyStatus::Running
        {
            body.simulator_mut().external.push(push.push);
            push.given = true;
        }
    }
}

/// After the step: takes the pushes back, and ends those that have acted for as long as they should.
pub(super) fn take_back(time: Res<Time>, mut active: ResMut<ActiveDisturbances>, mut bodies: Query<&mut AthleteBody>) {
    if active.pushes.is_empty() {
        return;
    }
    let tick = time.delta_secs_f64();
    active.bypass_change_detection().pushes.retain_mut(|active| {
        let Ok(mut body) = bodies.get_mut(active.athlete) else { return false };
        if std::mem::take(&mut active.given) {
            let external = &mut body.simulator_mut().external;
            let own =
                |f: &ExternalForce<f64>| f.link == active.push.link && f.force.lane(0) == active.push.force.lane(0);
            if let Some(at) = external.iter().rposition(own) {
                external.remove(at);
            }
            active.left -= tick;
        }
        active.left > 1e-9 && body.status() == BodyStatus::Running
    });
}
