//! Contact between characters and the world: the signed-distance world, contact points, the blade, grips, the solver,
//! and self-collision.

mod blade;
mod candidate;
mod detect;
mod geometry;
mod mobility;
mod rows;
mod scratch;
mod self_collision;
mod solver;
mod world;

pub use blade::{BladeContact, BladeEdge, carve_curvature};
pub use candidate::{ContactCandidate, ContactGroup};
pub use detect::detect_contacts;
pub use geometry::{Geometry, GeometryHit, HeightField, HeightFieldError};
pub use mobility::{ContactMobility, OwnMobility};
pub use rows::{ContactSettings, RowInputs, build_rows};
pub use scratch::ContactScratch;
pub use self_collision::{CollisionCapsule, SelfCollision, SelfCollisionSettings, deepest_overlap};
pub use solver::solve_contacts;
pub use world::{Solid, Surface, SurfaceHit, SurfaceKind, Terrain, World};
