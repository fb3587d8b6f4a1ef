//! Lights as written.

use crate::math::Rgb;
use glam::{Affine3A, Vec3};
use std::path::PathBuf;

/// Lights that are not surfaces.
#[derive(Clone, Debug, PartialEq)]
pub enum LightDescription {
    /// Lat-long picture (EXR, linear): u = atan2(x, −z)/2π, v = acos(y)/π, row 0 is +y, in the light's own frame.
    Environment { path: PathBuf, scale: Rgb, to_world: Affine3A },
    /// The same radiance from everywhere.
    Constant { radiance: Rgb },
    /// `intensity` in W/sr.
    Point { position: Vec3, intensity: Rgb },
    /// Light travels along `direction`; `irradiance` in W/m² on a surface that faces it.
    Directional { direction: Vec3, irradiance: Rgb },
}
