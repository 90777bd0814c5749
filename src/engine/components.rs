//! What users put on entities, and the world resource.

use crate::contact::World as Surroundings;
use crate::engine::{AthleteController, AthleteForces, AthleteInput, AthleteSettings, CharacterAsset, LinkPoses};
use bevy::prelude::*;

/// Spawns an athlete: the character it is.
///
/// Everything else comes by required components; replace those you want different. In a scene of Bevy's `bsn!` the character is named by its
/// path: `bsn! { Athlete("embedded://bevy_athlete/skater.character.ron") }`.
#[derive(Component, Clone, Debug, Reflect, FromTemplate)]
#[reflect(Component)]
#[require(Transform, AthleteController, AthleteInput, AthleteForces, AthleteSettings, LinkPoses)]
#[cfg_attr(feature = "render", require(Visibility, crate::engine::AthleteLook))]
pub struct Athlete(pub Handle<CharacterAsset>);

/// What athletes stand on: level ground at y = 0 unless you replace it, with [`AthleteWorld::ice`] for one. Athletes in an
/// arena of their own ([`InArena`](super::InArena)) stand on that. Move solids in
/// [`AthleteSystems::ReadWorld`](super::AthleteSystems::ReadWorld).
#[derive(Resource, Clone, Debug, Deref, DerefMut, Reflect)]
#[reflect(opaque)]
#[reflect(Resource, Default)]
pub struct AthleteWorld(pub Surroundings);

impl Default for AthleteWorld {
    fn default() -> Self {
        Self::ground()
    }
}

impl AthleteWorld {
    /// Level ground at y = 0.
    pub fn ground() -> Self {
        Self(Surroundings::ground())
    }
    /// Level ice at y = 0.
    pub fn ice() -> Self {
        Self(Surroundings::ice())
    }
}
