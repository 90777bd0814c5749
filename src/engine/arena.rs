//! Worlds of their own: several grounds in one app.

use crate::contact::World as Surroundings;
use crate::engine::AthleteWorld;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

/// The world of an arena: what those athletes stand on that are in it ([`InArena`]).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_athlete::contact::World as Surroundings;
/// # use bevy_athlete::engine::*;
/// fn spawn(mut commands: Commands, assets: Res<AssetServer>) {
///     let rink = commands.spawn(ArenaWorld(Surroundings::ice())).id();
///     commands.spawn((Athlete(assets.load("embedded://bevy_athlete/skater.character.ron")), InArena(rink)));
/// }
/// ```
#[derive(Component, Clone, Debug, Default, Deref, DerefMut, Reflect)]
#[reflect(opaque)]
#[reflect(Component, Default)]
pub struct ArenaWorld(pub Surroundings);

/// The arena that an athlete is in: an entity with an [`ArenaWorld`]. Without it, or where that entity has none,
/// [`AthleteWorld`] counts.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component)]
pub struct InArena(#[entities] pub Entity);

/// All worlds there are.
#[derive(SystemParam)]
pub(super) struct Worlds<'w, 's> {
    common: Res<'w, AthleteWorld>,
    arenas: Query<'w, 's, &'static ArenaWorld>,
}

impl Worlds<'_, '_> {
    /// What an athlete stands on.
    pub fn of(&self, arena: Option<&InArena>) -> &Surroundings {
        arena.and_then(|arena| self.arenas.get(arena.0).ok()).map_or(&self.common.0, |world| &world.0)
    }
}
