#![allow(missing_docs)]
pub mod asset;
pub mod contact;
pub mod control;
pub mod dynamics;
#[cfg(feature = "engine")]
pub mod engine;
pub mod math;
pub mod model;
pub mod sim;
#[cfg(feature = "storyboard")]
pub mod storyboard;
#[cfg(feature = "train")]
pub mod train;
