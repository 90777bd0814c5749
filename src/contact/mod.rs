//! Contact between characters and the world: the signed-distance world, contact points, the blade, grips, the solver,
//! and self-collision.

mod blade;
mod detect;
mod geometry;
mod height_field;
mod mobility;
mod rows;
mod self_collision;
mod solver;
mod world;

pub use blade::{BladeContact, BladeEdge, carve_curvature};
pub use detect::{ContactCandidate, ContactGroup, ContactScratch, detect_contacts};
pub use geometry::{Geometry, GeometryHit};
pub use height_field::{HeightField, HeightFieldError};
pub use mobility::{ContactMobility, OwnMobility};
pub use rows::{ContactSettings, RowInputs, build_rows};
pub use self_collision::{CollisionCapsule, SelfCollision, SelfCollisionSettings, deepest_overlap};
pub use solver::solve_contacts;
pub use world::{Solid, Surface, SurfaceHit, SurfaceKind, Terrain, World};
