//! The numeric ground floor: the lane type, rotations, spatial algebra and seeded random streams.

mod cholesky;
mod lanes;
mod mat3;
mod quat;
mod random;
mod real;
mod spatial;
mod symmetric_eigen;
mod vec3;

pub use cholesky::{Cholesky, factorize, substitute};
pub use lanes::{F32x8, F32x8Fused, F64Fused, F64x4, F64x4Fused};
pub use mat3::{Mat3, Sym3};
pub use quat::{Quat, half_angle_over_sine};
pub use random::RandomStream;
pub use real::Real;
pub use spatial::{Force, Inertia, Mobility, Motion};
pub use symmetric_eigen::{SymmetricEigen, symmetric_eigen};
pub use vec3::Vec3;
