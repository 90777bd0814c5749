#![allow(missing_docs)]
pub mod asset;
#[cfg(feature = "cli")]
pub mod cli;
pub mod contact;
pub mod control;
pub mod dynamics;
pub mod math;
pub mod model;
pub mod scenes;
pub mod sim;
#[cfg(feature = "storyboard")]
pub mod storyboard;
#[cfg(feature = "train")]
pub mod train;
