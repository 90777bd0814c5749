//! The shape of a collider as a signed distance.

use crate::engine::avian::mesh::{FIELD_REACH, SOLID_DEPTH, field_distance, field_top, hull_distance, mesh_distance};
use crate::engine::avian::profile::Profile;
use crate::engine::avian::triangles::NearestFace;
use avian3d::parry::shape::{SharedShape, TypedShape};
use bevy::math::{DVec3, Vec3};

/// Nothing is nearer than this to nothing, m.
pub(super) const FAR: f64 = 1e9;

/// A shape in its own frame. What is not kept here as numbers is looked up in the shared shape.
#[derive(Clone, Debug)]
pub(super) enum Form {
    HalfSpace {
        normal: DVec3,
    },
    Box {
        half: DVec3,
    },
    /// All points within `radius` of a segment; a ball where the ends are one.
    Capsule {
        a: DVec3,
        b: DVec3,
        radius: f64,
    },
    Revolved {
        profile: Profile,
        round: f64,
    },
    RoundBox {
        half: DVec3,
        round: f64,
    },
    Triangle {
        corners: [DVec3; 3],
        round: f64,
    },
    Hull {
        shape: SharedShape,
        round: f64,
    },
    Mesh(SharedShape),
    /// With the part of it that is near the athlete, in its own frame, and the highest point of that part, m.
    Field {
        shape: SharedShape,
        low: DVec3,
        high: DVec3,
        top: f64,
    },
    /// Anything else that parry projects points on.
    Other(SharedShape),
}

impl Form {
    /// Of a shape that is no compound. `low` and `high` bound the neighbourhood that will be asked about, in the shape's frame.
    pub fn of(shape: &SharedShape, low: DVec3, high: DVec3) -> Self {
        let d = |v: Vec3| v.as_dvec3();
        match shape.as_typed_shape() {
            TypedShape::HalfSpace(s) => Self::HalfSpace { normal: d(s.normal).normalize_or(DVec3::Y) },
            TypedShape::Ball(s) => Self::Capsule { a: DVec3::ZERO, b: DVec3::ZERO, radius: s.radius.into() },
            TypedShape::Cuboid(s) => Self::Box { half: d(s.half_extents) },
            TypedShape::Capsule(s) => Self::Capsule { a: d(s.segment.a), b: d(s.segment.b), radius: s.radius.into() },
            TypedShape::Segment(s) => Self::Capsule { a: d(s.a), b: d(s.b), radius: 0.0 },
            TypedShape::Cylinder(s) => {
                Self::Revolved { profile: Profile::cylinder(s.half_height.into(), s.radius.into()), round: 0.0 }
            }
            TypedShape::Cone(s) => {
                Self::Revolved { profile: Profile::cone(s.half_height.into(), s.radius.into()), round: 0.0 }
            }
            TypedShape::RoundCuboid(s) => {
                Self::RoundBox { half: d(s.inner_shape.half_extents), round: s.border_radius.into() }
            }
            TypedShape::RoundCylinder(s) => {
                let profile = Profile::cylinder(s.inner_shape.half_height.into(), s.inner_shape.radius.into());
                Self::Revolved { profile, round: s.border_radius.into() }
            }
            TypedShape::RoundCone(s) => {
                let profile = Profile::cone(s.inner_shape.half_height.into(), s.inner_shape.radius.into());
                Self::Revolved { profile, round: s.border_radius.into() }
            }
            TypedShape::Triangle(s) => Self::Triangle { corners: [d(s.a), d(s.b), d(s.c)], round: 0.0 },
            TypedShape::RoundTriangle(s) => {
                let t = &s.inner_shape;
                Self::Triangle { corners: [d(t.a), d(t.b), d(t.c)], round: s.border_radius.into() }
            }
            TypedShape::ConvexPolyhedron(_) => Self::Hull { shape: shape.clone(), round: 0.0 },
            TypedShape::RoundConvexPolyhedron(s) => Self::Hull { shape: shape.clone(), round: s.border_radius.into() },
            TypedShape::TriMesh(_) => Self::Mesh(shape.clone()),
            TypedShape::HeightField(field) => {
                let reach = DVec3::splat(2.0 * FIELD_REACH);
                let (low, high) = (low - reach, high + reach);
                Self::Field { shape: shape.clone(), low, high, top: field_top(field, low, high) }
            }
            _ => Self::Other(shape.clone()),
        }
    }

    /// Signed distance from a point in the shape's frame, negative inside, and outward unit normal.
    pub fn distance(&self, p: DVec3) -> (f64, DVec3) {
        let nothing = (FAR, DVec3::Y);
        let rounded = |(distance, normal): (f64, DVec3), round: f64| (distance - round, normal);
        match self {
            Self::HalfSpace { normal } => (normal.dot(p), *normal),
            Self::Box { half } => box_distance(p, *half),
            Self::RoundBox { half, round } => rounded(box_distance(p, *half), *round),
            Self::Capsule { a, b, radius } => {
                let along = *b - *a;
                let length = along.length_squared();
                let s = if length > 0.0 { ((p - *a).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
                let way = p - (*a + along * s);
                let distance = way.length();
                let up = if length > 0.0 { along.normalize().any_orthonormal_vector() } else { DVec3::Y };
                (distance - radius, if distance > 1e-9 { way / distance } else { up })
            }
            Self::Revolved { profile, round } => rounded(profile.distance(p), *round),
            Self::Triangle { corners, round } => {
                let mut nearest = NearestFace::new(p);
                nearest.add(*corners);
                nearest.distance().map_or(nothing, |found| one_sided(rounded(found, *round)))
            }
            Self::Hull { shape, round } => {
                let hull = match shape.as_typed_shape() {
                    TypedShape::ConvexPolyhedron(hull) => hull,
                    TypedShape::RoundConvexPolyhedron(hull) => &hull.inner_shape,
                    _ => return nothing,
                };
                hull_distance(hull, p).map_or(nothing, |found| rounded(found, *round))
            }
            Self::Mesh(shape) => {
                let found = shape.as_trimesh().and_then(|mesh| mesh_distance(mesh, p));
                found.map_or(nothing, one_sided)
            }
            Self::Field { shape, .. } => {
                let found = shape.as_heightfield().and_then(|field| field_distance(field, p));
                found.map_or(nothing, one_sided)
            }
            Self::Other(shape) => projected(shape, p),
        }
    }

    /// A lower bound of the distance, m: nothing within it of the point is inside.
    pub fn clearance(&self, p: DVec3) -> f64 {
        match self {
            Self::Field { shape, low, high, top } => {
                // Over the part that is known, all of it lies below its top.
                let to_border = (p.x - low.x).min(high.x - p.x).min(p.z - low.z).min(high.z - p.z);
                let quick = (p.y - top).min(to_border);
                if quick >= FIELD_REACH {
                    return quick;
                }
                let found = shape.as_heightfield().and_then(|field| field_distance(field, p));
                found.map_or(FIELD_REACH, |(distance, _)| behind(distance).min(FIELD_REACH))
            }
            Self::Mesh(shape) => {
                let found = shape.as_trimesh().and_then(|mesh| mesh_distance(mesh, p));
                found.map_or(FAR, |(distance, _)| behind(distance))
            }
            _ => self.distance(p).0,
        }
    }
}

/// What has passed through a surface is outside again.
fn one_sided(found: (f64, DVec3)) -> (f64, DVec3) {
    if found.0 < -SOLID_DEPTH { (FAR, found.1) } else { found }
}

/// Distance to the solid part of a surface.
fn behind(distance: f64) -> f64 {
    if distance < -SOLID_DEPTH { -distance - SOLID_DEPTH } else { distance }
}

/// Outside: the distance to the nearest point of the box. Inside: the face that is least deep.
fn box_distance(p: DVec3, half: DVec3) -> (f64, DVec3) {
    let sign = p.signum();
    let q = p.abs() - half;
    let outside = q.max(DVec3::ZERO);
    let length = outside.length();
    if length > 0.0 {
        return (length, outside / length * sign);
    }
    let face = if q.x >= q.y && q.x >= q.z {
        DVec3::X
    } else if q.y >= q.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    (q.max_element(), face * sign)
}

/// By parry's projection, in single precision. Near the surface the way to the projection has no good direction: there the
/// normal is the slope of the distance.
fn projected(shape: &SharedShape, p: DVec3) -> (f64, DVec3) {
    let signed = |p: DVec3| {
        let asked = p.as_vec3();
        let found = shape.project_local_point(asked, false);
        let way = p - found.point.as_dvec3();
        let distance = way.length();
        if found.is_inside { (-distance, -way) } else { (distance, way) }
    };
    let (distance, way) = signed(p);
    if distance.abs() > 1e-3 {
        return (distance, way / distance.abs());
    }
    let slope = |axis: DVec3| signed(p + axis * 1e-3).0 - signed(p - axis * 1e-3).0;
    (distance, DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize_or(DVec3::Y))
}
