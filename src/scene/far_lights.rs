//! Lights that a scene file names: points, suns and surroundings.

use super::description::SceneDescription;
use crate::image::exr::read_rgb;
use crate::io::{canon, memory};
use crate::light::{Environment, Light, LightDescription};
use crate::{Error, Result};

/// Lights that are not surfaces.
#[derive(Default)]
pub(super) struct FarLights {
    pub lights: Vec<Light>,
    /// Hashes of the pictures of the surroundings.
    pub pictures: Vec<u64>,
}

impl FarLights {
    /// Those of a description, and warnings about them.
    ///
    /// # Errors
    /// Pictures that cannot be read or used.
    pub fn of(description: &SceneDescription, warnings: &mut Vec<String>) -> Result<FarLights> {
        let mut far = FarLights::default();
        for light in &description.lights {
            let light = far.load(light, warnings)?;
            far.lights.push(light);
        }
        Ok(far)
    }

    fn load(&mut self, light: &LightDescription, warnings: &mut Vec<String>) -> Result<Light> {
        Ok(match light {
            LightDescription::Constant { radiance } => Light::Constant { radiance: *radiance },
            LightDescription::Point { position, intensity } => {
                Light::Point { position: *position, intensity: *intensity }
            }
            LightDescription::Directional { direction, irradiance } => {
                Light::Directional { direction: *direction, irradiance: *irradiance }
            }
            LightDescription::Environment { path, scale, to_world } => {
                let image = read_rgb(path)?;
                memory::check((image.width * image.height) as u64 * Environment::TABLE_BYTES_PER_PIXEL)
                    .map_err(|shortage| Error::file(path, format!("tables of its pixels {shortage}")))?;
                self.pictures.push(canon::texels([image.width, image.height], |canon| canon.array(&image.data)));
                let (width, height) = (image.width as u32, image.height as u32);
                let environment = Environment::new(width, height, image.data, *scale, *to_world)
                    .map_err(|error| Error::file(path, error.to_string()))?;
                if environment.negative_pixels() > 0 {
                    let n = environment.negative_pixels();
                    warnings.push(format!("{}: {n} pixels have negative radiance, which counts as 0", path.display()));
                }
                Light::Environment(Box::new(environment))
            }
        })
    }
}
