//! From an [`Athlete`] component to a body: waits for files, refuses what cannot be simulated.

use crate::engine::arrival::{arrived, refuse};
use crate::engine::controller::{ControllerAssets, StartedController};
use crate::engine::events::both;
use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteInput, AthleteReady, AthleteRefusal, AthleteRefused,
    AthleteSettings, CharacterAsset, LinkPoses, Placement, Refused,
};
use bevy::prelude::*;

/// Athletes that wait for their body.
type Waiting = (Without<AthleteBody>, Without<Refused>);
type Spawned<'a> = (
    Entity,
    &'a Athlete,
    (&'a Transform, Has<ChildOf>),
    (&'a AthleteController, &'a AthleteInput),
    &'a AthleteSettings,
    &'a mut LinkPoses,
);

/// Gives a body to every athlete whose files have arrived. Where its controller does not fit, it holds.
pub(super) fn build_bodies(
    mut commands: Commands,
    characters: Res<Assets<CharacterAsset>>,
    assets: ControllerAssets,
    places: TransformHelper,
    mut waiting: Query<Spawned, Waiting>,
    mut refusals: MessageWriter<AthleteRefused>,
    mut ready: MessageWriter<AthleteReady>,
) {
    for (entity, athlete, (transform, has_parent), (controller, input), settings, mut poses) in &mut waiting {
        // A child's transform counts from its parent. Without a parent it is the world's as it stands, to the bit.
        let in_world = has_parent.then(|| places.compute_global_transform(entity).ok()).flatten();
        let transform = in_world.map_or(*transform, |place| place.compute_transform());
        let body: Result<Option<AthleteBody>, AthleteRefusal> =
            Placement::from_transform(&transform).and_then(|place| {
                let character = arrived(&characters, &athlete.0, assets.server())?;
                Ok(character.map(|character| AthleteBody::new(character.model.clone(), place)))
            });
        let mut body = match body {
            Ok(None) => continue,
            Ok(Some(body)) => body,
            Err(reason) => {
                commands.entity(entity).insert(Refused(reason.clone()));
                refuse(&mut commands, &mut refusals, entity, reason);
                continue;
            }
        };
        match controller.start(input, &mut body, &assets) {
            Ok(true) => {}
            Ok(false) => continue,
            Err(reason) => {
                body.hold();
                refuse(&mut commands, &mut refusals, entity, reason);
            }
        }
        body.apply_settings(settings);
        body.write_links(&mut poses.current);
        poses.current_time = body.time();
        poses.cut();
        commands.entity(entity).insert((body, StartedController(controller.clone())));
        both(&mut commands, &mut ready, AthleteReady { entity });
    }
}
