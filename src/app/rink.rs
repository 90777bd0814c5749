//! The rink: ice with markings, boards, the sun.

use bevy::asset::RenderAssetUsages;
use bevy::light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap, NotShadowCaster};
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use std::f32::consts::{FRAC_PI_2, TAU};

/// Half of the rink's width (x) and length (z), m: 30 by 60 m.
pub(super) const HALF: Vec2 = Vec2::new(15.0, 30.0);
/// Radius of its corners, m.
const CORNER: f32 = 8.5;
/// Height of the boards, m.
const BOARDS: f32 = 1.07;

/// Where a rink goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct RinkPlan {
    /// Middle of the ice, world frame, m.
    pub middle: Vec3,
}

/// Adds ice, markings, boards and light.
pub(super) fn spawn_rink(
    commands: &mut Commands,
    root: Entity,
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
    plan: RinkPlan,
) {
    let at = |x: f32, y: f32, z: f32| Transform::from_translation(plan.middle + Vec3::new(x, y, z));
    let flat = Quat::from_rotation_x(-FRAC_PI_2);

    // The ice is a thin translucent sheet, so that mirror images show through; below it, what gives it its colour.
    commands.spawn((
        ChildOf(root),
        Mesh3d(meshes.add(rounded_floor(HALF, CORNER))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgba(0.72, 0.87, 0.98, 0.80),
            alpha_mode: AlphaMode::Blend,
            perceptual_roughness: 0.18,
            reflectance: 0.55,
            // Drawn before the ghost, which stands on it.
            depth_bias: -1000.0,
            ..default()
        })),
        at(0.0, -0.003, 0.0),
        NotShadowCaster,
    ));
    commands.spawn((
        ChildOf(root),
        Mesh3d(meshes.add(Plane3d::default().mesh().size(2.0 * HALF.x + 8.0, 2.0 * HALF.y + 8.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.52, 0.72, 0.88),
            unlit: true,
            ..default()
        })),
        at(0.0, -2.6, 0.0),
        NotShadowCaster,
    ));

    let mut paint = |color: Color| {
        materials.add(StandardMaterial { base_color: color, perceptual_roughness: 0.35, reflectance: 0.4, ..default() })
    };
    let red = paint(Color::srgb(0.84, 0.42, 0.44));
    let blue = paint(Color::srgb(0.36, 0.55, 0.83));
    let mut mark = |mesh: Mesh, material: &Handle<StandardMaterial>, x: f32, z: f32, lift: f32| {
        commands.spawn((
            ChildOf(root),
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(material.clone()),
            at(x, lift, z).with_rotation(flat),
            NotShadowCaster,
        ));
    };
    let stripe = |depth: f32, length: f32| Mesh::from(Rectangle::new(length, depth));
    let ring = |radius: f32| Annulus::new(radius - 0.05, radius + 0.05).mesh().resolution(96).build();
    mark(stripe(0.30, 2.0 * HALF.x), &red, 0.0, 0.0, -0.0015);
    for side in [-1.0, 1.0] {
        mark(stripe(0.30, 2.0 * HALF.x), &blue, 0.0, side * 8.5, -0.0015);
        mark(stripe(0.06, 2.0 * HALF.x - 4.4), &red, 0.0, side * 26.0, -0.0015);
        for x in [-7.0, 7.0] {
            mark(ring(4.5), &red, x, side * 20.0, -0.001);
            mark(Circle::new(0.3).into(), &red, x, side * 20.0, -0.001);
            mark(Circle::new(0.3).into(), &red, x, side * 6.5, -0.001);
        }
    }
    mark(ring(4.5), &blue, 0.0, 0.0, -0.001);
    mark(Circle::new(0.3).into(), &blue, 0.0, 0.0, -0.0008);

    // Boards, with the strip at the foot and the rail on top, and their mirror image below the ice.
    let bands = [
        (0.0, 0.20, 0.06, Color::srgb(0.95, 0.77, 0.25)),
        (0.20, BOARDS, 0.04, Color::srgb(0.93, 0.95, 0.97)),
        (BOARDS, BOARDS + 0.06, 0.08, Color::srgb(0.16, 0.33, 0.60)),
    ];
    for (low, high, thickness, color) in bands {
        let material = materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 0.6,
            reflectance: 0.25,
            cull_mode: None,
            double_sided: true,
            ..default()
        });
        let dim = Color::from(color.to_linear() * 0.65).with_alpha(1.0);
        let image = materials.add(StandardMaterial { base_color: dim, unlit: true, cull_mode: None, ..default() });
        commands.spawn((
            ChildOf(root),
            Mesh3d(meshes.add(wall(low, high, thickness))),
            MeshMaterial3d(material),
            at(0.0, 0.0, 0.0),
        ));
        commands.spawn((
            ChildOf(root),
            Mesh3d(meshes.add(wall(-high, -low - 0.01, thickness))),
            MeshMaterial3d(image),
            at(0.0, 0.0, 0.0),
            NotShadowCaster,
        ));
    }
}

/// The sun and the light of the sky.
pub(super) fn spawn_sun(commands: &mut Commands, root: Entity, low: bool) {
    let cascades = if low {
        CascadeShadowConfigBuilder { num_cascades: 1, maximum_distance: 14.0, ..default() }
    } else {
        CascadeShadowConfigBuilder {
            // WebGL2 has room for one.
            num_cascades: if cfg!(target_arch = "wasm32") { 1 } else { 2 },
            first_cascade_far_bound: 9.0,
            maximum_distance: 45.0,
            ..default()
        }
    };
    // Without tone mapping bright surfaces would lose their colour.
    let light = if low { 0.72 } else { 1.0 };
    commands.insert_resource(DirectionalLightShadowMap { size: if low { 1024 } else { 2048 } });
    commands.insert_resource(GlobalAmbientLight {
        color: Color::srgb(0.78, 0.87, 1.0),
        brightness: 1000.0 * light,
        ..default()
    });
    commands.spawn((
        ChildOf(root),
        DirectionalLight {
            color: Color::srgb(1.0, 0.93, 0.82),
            illuminance: 7800.0 * light,
            shadow_maps_enabled: true,
            ..default()
        },
        cascades.build(),
        Transform::from_xyz(-7.0, 8.5, -4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Points around a rounded rectangle, counter-clockwise from above, with their outward directions.
fn outline(half: Vec2, radius: f32) -> Vec<(Vec2, Vec2)> {
    const PER_CORNER: usize = 16;
    let centers = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let mut points = Vec::new();
    for (corner, (x, z)) in centers.into_iter().enumerate() {
        let center = Vec2::new(x * (half.x - radius), z * (half.y - radius));
        for k in 0..=PER_CORNER {
            let angle = (corner as f32 + k as f32 / PER_CORNER as f32) * TAU / 4.0;
            let out = Vec2::from_angle(angle);
            points.push((center + out * radius, out));
        }
    }
    points
}

/// A level floor with rounded corners.
fn rounded_floor(half: Vec2, radius: f32) -> Mesh {
    let points = outline(half, radius);
    let mut positions = vec![[0.0, 0.0, 0.0]];
    positions.extend(points.iter().map(|(p, _)| [p.x, 0.0, p.y]));
    let count = points.len() as u32;
    // Seen from above (+Y) the outline runs clockwise in (x, z) order of the world's axes.
    let indices = (0..count).flat_map(|k| [0, 1 + (k + 1) % count, 1 + k]).collect();
    let normals = vec![[0.0, 1.0, 0.0]; positions.len()];
    triangles(positions, normals, indices)
}

/// An upright band around the ice from `low` to `high` (m), `thickness` (m) towards the outside, with a top.
fn wall(low: f32, high: f32, thickness: f32) -> Mesh {
    let points = outline(HALF, CORNER);
    let count = points.len() as u32;
    let (mut positions, mut normals, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for (p, out) in &points {
        let outer = *p + *out * thickness;
        let inward = [-out.x, 0.0, -out.y];
        for (place, y, normal) in [
            (*p, low, inward),
            (*p, high, inward),
            (*p, high, [0.0, 1.0, 0.0]),
            (outer, high, [0.0, 1.0, 0.0]),
            (outer, high, [out.x, 0.0, out.y]),
            (outer, low, [out.x, 0.0, out.y]),
        ] {
            positions.push([place.x, y, place.y]);
            normals.push(normal);
        }
    }
    for k in 0..count {
        let (a, b) = (6 * k, 6 * ((k + 1) % count));
        for face in [0, 2, 4] {
            let (a, b) = (a + face, b + face);
            indices.extend([a, a + 1, b, b, a + 1, b + 1]);
        }
    }
    triangles(positions, normals, indices)
}

/// A mesh of triangles.
pub(super) fn triangles(positions: Vec<[f32; 3]>, normals: Vec<[f32; 3]>, indices: Vec<u32>) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(indices))
}
