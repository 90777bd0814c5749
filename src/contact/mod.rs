//! Contact between characters and the world: the signed-distance world, contact points, the blade, grips, the solver,
//! and self-collision.

mod blade;
mod candidate;
mod course;
mod detect;
mod geometry;
mod grips;
mod material;
mod mobility;
mod rows;
mod scratch;
mod self_collision;
mod solver;
mod terrain;
mod world;

pub use blade::{BladeContact, BladeEdge, carve_curvature};
pub use candidate::{ContactCandidate, ContactGroup};
pub use course::{CourseLaneError, CourseTerrain};
pub use detect::detect_contacts;
pub use geometry::{Column, Geometry, GeometryHit, HeightField, HeightFieldError};
pub use grips::GripInputs;
pub use material::{Material, Surface};
pub use mobility::{ContactMobility, OperationalInverseInertia};
pub use rows::{ContactSettings, RowInputs, build_rows};
pub use scratch::ContactScratch;
pub use self_collision::{CollisionCapsule, SelfCollision, SelfCollisionSettings, deepest_overlap};
pub use solver::solve_contacts;
pub use terrain::{AnchorMotion, STEP_UP, SupportHit, SurfaceHit, Terrain};
pub use world::{Solid, World};
