//! The mirror image in the ice.
//!
//! The shapes of a link are symmetric to the planes of their own axes, so the mirror image of a shape is the same mesh with
//! its pose mirrored: a second entity below the translucent ice.

use crate::engine::LinkVisual;
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::prelude::*;

/// The image of this entity.
#[derive(Component)]
pub(super) struct ImageOf(Entity);

/// Makes images for shapes that have just appeared (those of the athlete, not of its ghost).
pub(super) fn make_images(
    mut commands: Commands,
    mut materials: ResMut<Assets<StandardMaterial>>,
    shapes: Query<(Entity, &LinkVisual, &Mesh3d, &MeshMaterial3d<StandardMaterial>), Added<LinkVisual>>,
) {
    for (entity, visual, mesh, material) in &shapes {
        if visual.ghost {
            continue;
        }
        let color = materials.get(&material.0).map_or(Color::WHITE, |m| m.base_color);
        // Seen from below and in its own shade: lit evenly and darker than the original.
        let dim = Color::from(color.to_linear() * 0.5).with_alpha(1.0);
        let image = materials.add(StandardMaterial { base_color: dim, unlit: true, ..default() });
        commands.spawn((
            ImageOf(entity),
            Mesh3d(mesh.0.clone()),
            MeshMaterial3d(image),
            Transform::default(),
            NotShadowCaster,
            NotShadowReceiver,
        ));
    }
}

/// Moves every image to where its original is mirrored.
pub(super) fn place_images(
    mut commands: Commands,
    originals: Query<&GlobalTransform, (With<LinkVisual>, Without<ImageOf>)>,
    mut images: Query<(Entity, &ImageOf, &mut Transform, &mut GlobalTransform), Without<LinkVisual>>,
) {
    for (entity, image, mut transform, mut global) in &mut images {
        let Ok(original) = originals.get(image.0) else {
            commands.entity(entity).despawn();
            continue;
        };
        let (_, r, t) = original.to_scale_rotation_translation();
        // M R M with M = diag(1, -1, 1).
        *transform = Transform::from_xyz(t.x, -t.y, t.z).with_rotation(Quat::from_xyzw(-r.x, r.y, -r.z, r.w));
        *global = GlobalTransform::from(*transform);
    }
}
