#![allow(missing_docs)]
#[cfg(feature = "app")]
pub mod app;
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
