//! What this program was built for: figures mean nothing without it.

use serde::Serialize;

/// Instruction set, lanes and profile of this build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct BuildInfo {
    /// Version of the crate.
    pub version: &'static str,
    /// Processor family, such as `x86_64`.
    pub arch: &'static str,
    /// Vector instructions the compiler was allowed: `avx512f+fma`, `avx2+fma`, `avx2`, `sse2`, `neon`, `simd128` or
    /// `scalar`.
    pub instructions: &'static str,
    /// Whether the training configuration (lanes `f64`, `4 x f64`, `8 x f32`) fuses multiply and add in this build. The
    /// play configuration never does.
    pub fused: bool,
    /// `release` or `debug` (debug assertions on).
    pub profile: &'static str,
}

impl BuildInfo {
    /// That of this build.
    pub const fn current() -> Self {
        let fma = cfg!(target_feature = "fma");
        let instructions = if cfg!(target_feature = "avx512f") && fma {
            "avx512f+fma"
        } else if cfg!(target_feature = "avx2") && fma {
            "avx2+fma"
        } else if cfg!(target_feature = "avx2") {
            "avx2"
        } else if cfg!(target_feature = "sse2") {
            "sse2"
        } else if cfg!(target_feature = "neon") {
            "neon"
        } else if cfg!(target_feature = "simd128") {
            "simd128"
        } else {
            "scalar"
        };
        Self {
            version: env!("CARGO_PKG_VERSION"),
            arch: std::env::consts::ARCH,
            instructions,
            fused: fma,
            profile: if cfg!(debug_assertions) { "debug" } else { "release" },
        }
    }
}

impl std::fmt::Display for BuildInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { version, arch, instructions, fused, profile } = self;
        let training = if *fused { "fused" } else { "unfused" };
        write!(f, "bevy_athlete {version}, {arch}, built for {instructions}, {profile}, training lanes {training}")
    }
}
