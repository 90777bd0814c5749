//! What stands around in the scenes.

use crate::app::rink::{RinkPlan, spawn_rink, spawn_sun};
use crate::app::scenery::spawn_scenery;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

/// Makes meshes and materials, and spawns them under a root.
#[derive(SystemParam)]
pub(super) struct Props<'w> {
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
}

impl Props<'_> {
    /// A rink with its middle at `middle`, and the hills around it.
    pub fn rink(&mut self, commands: &mut Commands, root: Entity, middle: Vec3, low: bool) {
        spawn_rink(commands, root, &mut self.meshes, &mut self.materials, RinkPlan { middle });
        spawn_scenery(commands, root, &mut self.meshes, &mut self.materials, middle);
        spawn_sun(commands, root, low);
    }

    /// A wide floor with a grid of lines.
    pub fn hall(&mut self, commands: &mut Commands, root: Entity, low: bool) {
        let mut matte = |color: Color, roughness: f32| {
            self.materials.add(StandardMaterial {
                base_color: color,
                perceptual_roughness: roughness,
                reflectance: 0.2,
                ..default()
            })
        };
        let (floor, line) = (matte(Color::srgb(0.60, 0.64, 0.68), 0.8), matte(Color::srgb(0.50, 0.54, 0.59), 0.9));
        let side = 160.0;
        commands.spawn((
            ChildOf(root),
            Mesh3d(self.meshes.add(Plane3d::default().mesh().size(side, side))),
            MeshMaterial3d(floor),
            Transform::from_xyz(0.0, -0.012, 0.0),
        ));
        let stripe = self.meshes.add(Plane3d::default().mesh().size(side, 0.03));
        for k in -20..=20 {
            let at = 2.0 * k as f32;
            for (place, turn) in [(Vec3::new(0.0, -0.01, at), 0.0), (Vec3::new(at, -0.01, 0.0), 0.5)] {
                commands.spawn((
                    ChildOf(root),
                    Mesh3d(stripe.clone()),
                    MeshMaterial3d(line.clone()),
                    Transform::from_translation(place)
                        .with_rotation(Quat::from_rotation_y(turn * std::f32::consts::PI)),
                ));
            }
        }
        spawn_sun(commands, root, low);
    }

    /// The mesh and the material of a ball, m.
    pub fn ball(&mut self, radius: f32, color: Color) -> (Mesh3d, MeshMaterial3d<StandardMaterial>) {
        let material = StandardMaterial { base_color: color, perceptual_roughness: 0.6, reflectance: 0.3, ..default() };
        (Mesh3d(self.meshes.add(Sphere::new(radius))), MeshMaterial3d(self.materials.add(material)))
    }

    /// The mesh and the material of a block, m.
    pub fn block(&mut self, size: Vec3, color: Color) -> (Mesh3d, MeshMaterial3d<StandardMaterial>) {
        let material =
            StandardMaterial { base_color: color, perceptual_roughness: 0.7, reflectance: 0.25, ..default() };
        (Mesh3d(self.meshes.add(Cuboid::from_size(size))), MeshMaterial3d(self.materials.add(material)))
    }
}
