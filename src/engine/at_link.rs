//! Entities that follow a link.

use crate::engine::{AthleteBody, LinkId, LinkPoses};
use bevy::platform::collections::HashSet;
use bevy::prelude::*;

/// Makes a child of an athlete follow a link: something in its hand, a light on its head, an ear. Its `Transform` is written in
/// `PostUpdate`, before transforms are propagated.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_athlete::engine::*;
/// fn spawn(mut commands: Commands, assets: Res<AssetServer>) {
///     // A hand's breadth before the forehead.
///     let lamp = AtLink::new("head").with_place(Transform::from_xyz(0.0, 0.1, -0.1));
///     commands.spawn((Athlete(assets.load("embedded://bevy_athlete/skater.character.ron")), children![lamp]));
/// }
/// ```
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
#[require(Transform)]
pub struct AtLink {
    /// Name of the link.
    pub link: String,
    /// Place in the link's frame (see the character's file), m.
    pub place: Transform,
}

impl AtLink {
    /// At the link's joint.
    pub fn new(link: impl Into<String>) -> Self {
        Self { link: link.into(), place: Transform::IDENTITY }
    }
    /// At a place in the link's frame, m.
    pub fn with_place(self, place: Transform) -> Self {
        Self { place, ..self }
    }
}

/// Puts followers to their links, relative to their athlete, whose own place is that of its root link.
pub(super) fn follow_links(
    athletes: Query<(&AthleteBody, &LinkPoses)>,
    mut followers: Query<(Entity, &AtLink, &ChildOf, &mut Transform), Without<AthleteBody>>,
    mut lost: Local<HashSet<Entity>>,
) {
    for (entity, follower, parent, mut transform) in &mut followers {
        let Ok((body, poses)) = athletes.get(parent.parent()) else { continue };
        let Some(link) = body.link(&follower.link) else {
            if lost.insert(entity) {
                let names: Vec<&str> = body.model().links.iter().map(|l| l.name.as_str()).collect();
                warn!(
                    "{entity} is to follow the link `{}`, which is not there; valid: {}",
                    follower.link,
                    names.join(", ")
                );
            }
            continue;
        };
        let root = poses.link(LinkId::ROOT);
        let relative = root.rotation.inverse() * (poses.link(link).translation - root.translation);
        let rotation = (root.rotation.inverse() * poses.link(link).rotation).normalize();
        let place = Transform::from_translation(relative).with_rotation(rotation) * follower.place;
        transform.set_if_neq(place);
    }
}
