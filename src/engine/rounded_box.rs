//! A box with round edges.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;

/// Parts that each half of a face's rounding is cut into.
const SEGMENTS: usize = 4;

/// A box about the origin whose edges are rounded with `radius` (m; at most the smallest half extent).
pub(super) fn rounded_box(half_extents: Vec3, radius: f32) -> Mesh {
    let radius = radius.clamp(0.0, half_extents.min_element());
    let core = half_extents - Vec3::splat(radius);
    let mut positions = Vec::new();
    let mut normals = Vec::new();
    let mut indices: Vec<u32> = Vec::new();
    // Along one direction of a face: the rounding on both sides, the flat part between them.
    let stops: Vec<(f32, f32)> = (0..=SEGMENTS)
        .map(|k| (-1.0, -1.0 + k as f32 / SEGMENTS as f32))
        .chain((0..=SEGMENTS).map(|k| (1.0, k as f32 / SEGMENTS as f32)))
        .collect();
    let n = stops.len() as u32;
    for (axis, sign) in [(0, 1.0_f32), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
        let (u_axis, v_axis) = ((axis + 1) % 3, (axis + 2) % 3);
        let first = positions.len() as u32;
        for &(v_side, v) in &stops {
            for &(u_side, u) in &stops {
                // A point of a cube's face, seen from the corner of the core it belongs to.
                let mut direction = Vec3::ZERO;
                direction[axis] = sign;
                direction[u_axis] = (u * std::f32::consts::FRAC_PI_4).tan();
                direction[v_axis] = (v * std::f32::consts::FRAC_PI_4).tan();
                let normal = direction.normalize();
                let mut corner = Vec3::ZERO;
                corner[axis] = sign * core[axis];
                corner[u_axis] = u_side * core[u_axis];
                corner[v_axis] = v_side * core[v_axis];
                positions.push((corner + normal * radius).to_array());
                normals.push(normal.to_array());
            }
        }
        for row in 0..n - 1 {
            for column in 0..n - 1 {
                let a = first + row * n + column;
                let (b, c, d) = (a + 1, a + n, a + n + 1);
                let quad = if sign > 0.0 { [a, b, d, a, d, c] } else { [a, d, b, a, c, d] };
                indices.extend(quad);
            }
        }
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(indices))
}
