//! Measurements of parts: how rays are best traced on this machine.

mod rays;

pub use rays::{RayFigure, RaySet, measure};
