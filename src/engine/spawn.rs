//! From an [`Athlete`] component to a body: waits for files, refuses what cannot be simulated.

use crate::engine::{
    Athlete, AthleteBody, AthleteController, AthleteRefusal, AthleteRefused, AthleteSettings, CharacterAsset,
    ControlAsset, LinkPoses, Placement, Refused,
};
use bevy::asset::LoadState;
use bevy::prelude::*;

/// Athletes that wait for their body.
type Waiting = (Without<AthleteBody>, Without<Refused>);
type Spawned<'a> = (Entity, &'a Athlete, &'a Transform, &'a AthleteController, &'a AthleteSettings, &'a mut LinkPoses);

/// Gives a body to every athlete whose files have arrived.
pub(super) fn build_bodies(
    mut commands: Commands,
    characters: Res<Assets<CharacterAsset>>,
    controls: Res<Assets<ControlAsset>>,
    server: Option<Res<AssetServer>>,
    mut waiting: Query<Spawned, Waiting>,
    mut refusals: MessageWriter<AthleteRefused>,
) {
    let server = server.as_deref();
    for (entity, athlete, transform, controller, settings, mut poses) in &mut waiting {
        let built: Result<Option<AthleteBody>, AthleteRefusal> = (|| {
            let placement = Placement::from_transform(transform)?;
            let Some(character) = arrived(&characters, &athlete.0, server)? else { return Ok(None) };
            let mut body = AthleteBody::new(character.model.clone(), placement);
            if let AthleteController::Play(handle) = controller {
                let Some(control) = arrived(&controls, handle, server)? else { return Ok(None) };
                body.play(control.control.clone()).map_err(|e| AthleteRefusal::Control { message: e.to_string() })?;
            }
            body.apply_settings(settings);
            Ok(Some(body))
        })();
        match built {
            Ok(None) => {}
            Ok(Some(mut body)) => {
                body.write_links(&mut poses.current);
                poses.current_time = body.time();
                poses.cut();
                commands.entity(entity).insert((body, Playing(controller.clone())));
            }
            Err(reason) => {
                commands.entity(entity).insert(Refused(reason.clone()));
                refuse(&mut commands, &mut refusals, entity, reason);
            }
        }
    }
}

/// The controller a body has taken over.
#[derive(Component, Clone)]
pub(super) struct Playing(AthleteController);

/// Hands changed controllers to their bodies, once their files have arrived.
pub(super) fn change_controllers(
    mut commands: Commands,
    controls: Res<Assets<ControlAsset>>,
    server: Option<Res<AssetServer>>,
    mut athletes: Query<(Entity, &AthleteController, &mut Playing, &mut AthleteBody)>,
    mut refusals: MessageWriter<AthleteRefused>,
) {
    for (entity, wanted, mut playing, mut body) in &mut athletes {
        match (wanted, &playing.0) {
            (AthleteController::Play(new), AthleteController::Play(old)) if new == old => {}
            (AthleteController::Play(new), _) => {
                let started = match arrived(&controls, new, server.as_deref()) {
                    Ok(None) => continue,
                    Ok(Some(control)) => body
                        .play(control.control.clone())
                        .map_err(|e| AthleteRefusal::Control { message: e.to_string() }),
                    Err(reason) => Err(reason),
                };
                playing.0 = wanted.clone();
                if let Err(reason) = started {
                    body.hold();
                    refuse(&mut commands, &mut refusals, entity, reason);
                }
            }
            (AthleteController::Hold, AthleteController::Hold)
            | (AthleteController::External, AthleteController::External) => {}
            (AthleteController::Hold | AthleteController::External, _) => {
                body.hold();
                playing.0 = wanted.clone();
            }
        }
    }
}

/// The asset; `None` while it is on its way.
fn arrived<'a, A: Asset>(
    assets: &'a Assets<A>,
    handle: &Handle<A>,
    server: Option<&AssetServer>,
) -> Result<Option<&'a A>, AthleteRefusal> {
    if let Some(asset) = assets.get(handle) {
        return Ok(Some(asset));
    }
    match server.map(|s| s.load_state(handle)) {
        Some(LoadState::Failed(error)) => Err(AthleteRefusal::Load { message: error.to_string() }),
        _ => Ok(None),
    }
}

/// Tells everybody: the log, readers and observers.
pub(super) fn refuse(
    commands: &mut Commands,
    refusals: &mut MessageWriter<AthleteRefused>,
    entity: Entity,
    reason: AthleteRefusal,
) {
    error!("athlete {entity} is refused: {reason}");
    let refused = AthleteRefused { entity, reason };
    refusals.write(refused.clone());
    commands.trigger(refused);
}
