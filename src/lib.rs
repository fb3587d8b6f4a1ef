//! Phototaxis: a path tracer on Embree that learns where the light is while it renders.

pub mod bsdf;
pub mod error;
pub mod film;
pub mod generate;
pub mod geometry;
pub mod light;
pub mod math;
pub mod scene;
pub mod stats;

pub use error::{Error, Result};
