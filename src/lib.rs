#![allow(missing_docs)]
pub mod math; pub mod model; pub mod asset;
