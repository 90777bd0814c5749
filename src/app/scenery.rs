//! Snow, trees and hills around the rink.

use crate::app::rink::HALF;
use crate::math::RandomStream;
use bevy::light::NotShadowCaster;
use bevy::prelude::*;

/// Colour of the sky at the horizon, and of the haze in front of far things.
pub(super) const HAZE: Color = Color::srgb(0.74, 0.83, 0.91);

/// Adds the scenery around a rink with its middle at `middle`.
pub(super) fn spawn_scenery(
    commands: &mut Commands,
    root: Entity,
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
    middle: Vec3,
) {
    let mut matte = |color: Color| {
        materials.add(StandardMaterial { base_color: color, perceptual_roughness: 1.0, reflectance: 0.05, ..default() })
    };
    let snow = matte(Color::srgb(0.92, 0.95, 0.98));
    let hill = matte(Color::srgb(0.70, 0.79, 0.87));
    let bark = matte(Color::srgb(0.33, 0.25, 0.20));
    let needles = [
        matte(Color::srgb(0.22, 0.42, 0.36)),
        matte(Color::srgb(0.28, 0.48, 0.39)),
        matte(Color::srgb(0.35, 0.54, 0.47)),
    ];

    // Snow in four strips around the ice, so that it does not lie on it.
    let (wide, far) = (400.0, 400.0);
    for (x, z, width, length) in [
        (0.0, HALF.y + far * 0.5, wide, far),
        (0.0, -HALF.y - far * 0.5, wide, far),
        (HALF.x + wide * 0.5, 0.0, wide, 2.0 * HALF.y),
        (-HALF.x - wide * 0.5, 0.0, wide, 2.0 * HALF.y),
    ] {
        commands.spawn((
            ChildOf(root),
            Mesh3d(meshes.add(Plane3d::default().mesh().size(width, length))),
            MeshMaterial3d(snow.clone()),
            Transform::from_translation(middle + Vec3::new(x, -0.02, z)),
            NotShadowCaster,
        ));
    }

    let mut random = RandomStream::new(2026, 7);
    let mut between = |low: f32, high: f32| low + (high - low) * random.uniform() as f32;
    let cone = meshes.add(Cone { radius: 1.0, height: 1.0 }.mesh().resolution(9).build());
    let trunk = meshes.add(Cylinder::new(0.16, 1.0).mesh().resolution(7).build());
    for k in 0..150 {
        // Around the rink, thinning out with distance.
        let angle = (k as f32 + between(0.0, 0.9)) / 150.0 * std::f32::consts::TAU;
        let away = 1.0 + between(0.0, 1.0).powi(2);
        let place = Vec3::new(angle.cos() * (HALF.x + 7.0) * away, 0.0, angle.sin() * (HALF.y + 8.0) * away);
        if place.x.abs() < HALF.x + 2.5 && place.z.abs() < HALF.y + 2.5 {
            continue;
        }
        let height = between(2.6, 6.5);
        let green = &needles[k % needles.len()];
        let foot = middle + place;
        commands.spawn((
            ChildOf(root),
            Mesh3d(trunk.clone()),
            MeshMaterial3d(bark.clone()),
            Transform::from_translation(foot + Vec3::Y * 0.4).with_scale(Vec3::new(1.0, 0.9, 1.0)),
        ));
        for tier in 0..3 {
            let part = tier as f32 / 3.0;
            let (width, tall) = (height * 0.26 * (1.0 - 0.55 * part), height * 0.48);
            let y = 0.6 + height * 0.27 * tier as f32 + tall * 0.5;
            commands.spawn((
                ChildOf(root),
                Mesh3d(cone.clone()),
                MeshMaterial3d(if tier == 2 && k % 3 == 0 { snow.clone() } else { green.clone() }),
                Transform::from_translation(foot + Vec3::Y * y)
                    .with_rotation(Quat::from_rotation_y(angle * 7.0))
                    .with_scale(Vec3::new(width, tall, width)),
            ));
        }
    }
    let peak = meshes.add(Cone { radius: 1.0, height: 1.0 }.mesh().resolution(7).build());
    for k in 0..22 {
        let angle = (k as f32 + between(0.0, 0.7)) / 22.0 * std::f32::consts::TAU;
        let (distance, height, width) = (between(120.0, 180.0), between(14.0, 42.0), between(35.0, 65.0));
        commands.spawn((
            ChildOf(root),
            Mesh3d(peak.clone()),
            MeshMaterial3d(hill.clone()),
            Transform::from_translation(
                middle + Vec3::new(angle.cos() * distance, height * 0.5 - 1.0, angle.sin() * distance),
            )
            .with_rotation(Quat::from_rotation_y(angle * 3.0))
            .with_scale(Vec3::new(width, height, width)),
            NotShadowCaster,
        ));
    }
}
