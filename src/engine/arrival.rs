//! Files that arrive, and what is told of those that do not fit.

use crate::engine::{AthleteRefusal, AthleteRefused};
use bevy::asset::LoadState;
use bevy::prelude::*;

/// The asset; `None` while it is on its way.
pub(super) fn arrived<'a, A: Asset>(
    assets: &'a Assets<A>,
    handle: &Handle<A>,
    server: Option<&AssetServer>,
) -> Result<Option<&'a A>, AthleteRefusal> {
    if let Some(asset) = assets.get(handle) {
        return Ok(Some(asset));
    }
    match server.map(|s| s.load_state(handle)) {
        Some(LoadState::Failed(error)) => Err(AthleteRefusal::Load(error)),
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
