//! Distances to triangle meshes, height fields and convex hulls: parry finds the triangles, the distance to them is taken
//! in double precision.

use crate::engine::avian::triangles::NearestFace;
use avian3d::parry::bounding_volume::{Aabb, BoundingVolume};
use avian3d::parry::query::PointQueryWithLocation;
use avian3d::parry::shape::{ConvexPolyhedron, HeightField, TriMesh, Triangle};
use bevy::math::{DVec3, Vec3};

/// How far behind its front a mesh or height field is solid, m. What is deeper has passed through.
pub(super) const SOLID_DEPTH: f64 = 0.2;
/// Within this distance the nearest triangle of a height field is found exactly, m.
pub(super) const FIELD_REACH: f64 = 0.35;

/// The corners of a triangle of parry.
fn corners(t: &Triangle) -> [DVec3; 3] {
    [t.a, t.b, t.c].map(|p| p.as_dvec3())
}

/// A box about a point.
fn around(center: DVec3, half: f64) -> Aabb {
    Aabb::new((center - DVec3::splat(half)).as_vec3(), (center + DVec3::splat(half)).as_vec3())
}

/// Signed distance and outward normal of a mesh; `None` for an empty one.
pub(super) fn mesh_distance(mesh: &TriMesh, point: DVec3) -> Option<(f64, DVec3)> {
    let asked = point.as_vec3();
    let (_, (id, _)) = mesh.project_local_point_and_get_location_with_max_dist(asked, false, f32::MAX)?;
    let mut nearest = NearestFace::new(point);
    if nearest.add(corners(&mesh.triangle(id))) {
        // Others may share the edge or corner that it is nearest at.
        let half = 1e-5 + 1e-6 * nearest.closest().abs().max_element();
        let place = around(nearest.closest(), half);
        for other in mesh.bvh().leaves(|node| node.aabb().intersects(&place)) {
            if other != id {
                nearest.add(corners(&mesh.triangle(other)));
            }
        }
    }
    nearest.distance()
}

/// Signed distance and outward (upward) normal of a height field: exact within [`FIELD_REACH`], along the slope under the
/// point beyond; `None` off the field.
pub(super) fn field_distance(field: &HeightField, point: DVec3) -> Option<(f64, DVec3)> {
    let mut nearest = NearestFace::new(point);
    field.map_elements_in_local_aabb(&around(point, FIELD_REACH), &mut |_, triangle| {
        nearest.add(upward(triangle));
    });
    if let Some((distance, normal)) = nearest.distance()
        && distance.abs() <= FIELD_REACH
    {
        return Some((distance, normal));
    }
    let (i, j) = field.cell_at_point(point.as_vec3())?;
    let (left, right) = field.triangles_at(i, j);
    [left, right].iter().flatten().find_map(|triangle| {
        let [a, b, c] = upward(triangle);
        let normal = (b - a).cross(c - a).try_normalize()?;
        // Over the triangle: on the inner side of its three edges as seen from above.
        let inside = |from: DVec3, to: DVec3| (to - from).cross(point - from).y >= 0.0;
        let distance = (point - a).dot(normal);
        // The plane of a steep triangle is nearer than anything of the field.
        let distance = if distance < 0.0 { distance.min(-FIELD_REACH) } else { distance.max(FIELD_REACH) };
        (inside(a, b) && inside(b, c) && inside(c, a)).then_some((distance, normal))
    })
}

/// The corners of a triangle of a height field, counter-clockwise from above.
fn upward(triangle: &Triangle) -> [DVec3; 3] {
    let [a, b, c] = corners(triangle);
    if (b - a).cross(c - a).y < 0.0 { [a, c, b] } else { [a, b, c] }
}

/// Highest point of a height field within a box in its own frame, m.
pub(super) fn field_top(field: &HeightField, low: DVec3, high: DVec3) -> f64 {
    // All heights of the columns count.
    let column =
        Aabb::new(Vec3::new(low.x as f32, f32::MIN, low.z as f32), Vec3::new(high.x as f32, f32::MAX, high.z as f32));
    let mut top = f64::NEG_INFINITY;
    field.map_elements_in_local_aabb(&column, &mut |_, t| {
        top = top.max(f64::from(t.a.y.max(t.b.y).max(t.c.y)));
    });
    top
}

/// Signed distance and outward normal of a convex hull; `None` for an empty one.
pub(super) fn hull_distance(hull: &ConvexPolyhedron, point: DVec3) -> Option<(f64, DVec3)> {
    let points = hull.points();
    let mut deepest: Option<(f64, DVec3)> = None;
    for face in hull.faces() {
        let start = face.first_vertex_or_edge as usize;
        let first = points[hull.vertices_adj_to_face()[start] as usize].as_dvec3();
        let normal = face.normal.as_dvec3().normalize_or_zero();
        let height = normal.dot(point - first);
        if deepest.is_none_or(|(most, _)| height > most) {
            deepest = Some((height, normal));
        }
    }
    let (height, normal) = deepest?;
    if height <= 0.0 {
        return Some((height, normal));
    }
    let mut nearest = NearestFace::new(point);
    for face in hull.faces() {
        let start = face.first_vertex_or_edge as usize;
        let around = &hull.vertices_adj_to_face()[start..start + face.num_vertices_or_edges as usize];
        let corner = |k: usize| points[around[k] as usize].as_dvec3();
        for k in 2..around.len() {
            nearest.add([corner(0), corner(k - 1), corner(k)]);
        }
    }
    nearest.distance().map(|(distance, normal)| (distance.abs(), normal))
}
