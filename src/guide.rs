//! The guide: short chapters for a game. Every block of code in them compiles.

/// Chapter one.
#[doc = include_str!("../docs/book/guide/first_skater.md")]
pub mod first_skater {}

/// Chapter two.
#[doc = include_str!("../docs/book/guide/steer.md")]
pub mod steer {}

/// Chapter three.
#[doc = include_str!("../docs/book/guide/events.md")]
pub mod events {}
