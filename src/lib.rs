#![allow(missing_docs)]
pub mod asset;
pub mod math;
pub mod model;
#[cfg(feature = "storyboard")]
pub mod storyboard;
