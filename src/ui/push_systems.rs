//! What the disturbance panel asks for, handed to the engine: pushes as forces on the athlete, gravity for all of them.

use crate::engine::{AthleteBody, AthleteForce, LinkId};
use crate::sim::SimulationSettings;
use crate::ui::disturbance::{Pull, PushPlan};
use bevy::math::DVec3;
use bevy::prelude::*;

impl PushPlan {
    /// The push as a force on an athlete, for its [`AthleteForces`](crate::engine::AthleteForces). The direction is that of
    /// its heading at this moment. `None` if it is no push.
    pub fn on(&self, body: &AthleteBody) -> Option<AthleteForce> {
        let model = body.model();
        let link = LinkId::of(model, &self.link).unwrap_or_default();
        let force = self.force_on(body.simulator().state.root_rotation.lane(0));
        let pushes = force.is_finite() && self.seconds > 0.0;
        pushes.then(|| AthleteForce {
            link,
            position: model.links[link.index()].com,
            force,
            seconds: Some(self.seconds),
        })
    }
}

/// Gravity for all athletes, present and to come, once it was set.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct WorldPull(Option<DVec3>);

impl WorldPull {
    /// Sets gravity until it is set again.
    pub fn set(&mut self, pull: &Pull) {
        self.0 = Some(pull.acceleration());
    }
}

/// Before the step: gravity is as set.
pub(super) fn apply_pull(pull: Res<WorldPull>, mut bodies: Query<&mut AthleteBody>) {
    let Some(gravity) = pull.0 else { return };
    for mut body in &mut bodies {
        let settings = *body.simulator().settings();
        if settings.gravity != gravity {
            body.simulator_mut().set_settings(SimulationSettings { gravity, ..settings });
        }
    }
}
