//! Bytes to validated data and back.

pub mod clip;
pub mod mjcf;
