//! The plugin that puts athletes on Avian's colliders.

use crate::contact::World as Solids;
use crate::engine::avian::{AthleteSurface, ColliderGround, gather, pushes};
use crate::engine::{Athlete, AthleteSystems, AthleteWorld};
use avian3d::prelude::PhysicsSystems;
use bevy::prelude::*;

/// Athletes on Avian's colliders. Add it after `PhysicsPlugins` and [`AthletePlugins`](crate::engine::AthletePlugins).
///
/// It empties [`AthleteWorld`]: the ground is made of colliders. Solids that you put into that resource afterwards count as well.
/// `PhysicsPlugins` must run in `FixedPostUpdate`, as it does by default.
#[derive(Debug, Default)]
pub struct AthleteAvianPlugin;

impl Plugin for AthleteAvianPlugin {
    fn build(&self, app: &mut App) {
        use AthleteSystems::{Control, ReadWorld, Step, WriteBack};
        app.insert_resource(AthleteWorld(Solids::empty()))
            .register_type::<AthleteSurface>()
            .register_required_components::<Athlete, ColliderGround>()
            .configure_sets(
                FixedPostUpdate,
                (ReadWorld, Control, Step, WriteBack)
                    .after(PhysicsSystems::Prepare)
                    .before(PhysicsSystems::StepSimulation),
            )
            .add_systems(
                FixedPostUpdate,
                (gather::step_on_colliders.in_set(Step), pushes::hand_over_pushes.in_set(WriteBack)),
            );
    }
}
