#![allow(missing_docs)]
pub mod asset;
pub mod contact;
pub mod dynamics;
pub mod math;
pub mod model;
pub mod sim;
#[cfg(feature = "storyboard")]
pub mod storyboard;
