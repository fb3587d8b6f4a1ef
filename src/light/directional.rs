//! A sun: light that comes from one direction.

use super::source::{Extent, Findings, LightParameters, LightSource};
use super::tree::FarLight;
use super::{LightSample, check_light, scaled, wide_luminance};
use crate::Result;
use crate::document::{NOT_NEGATIVE, key};
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use glam::Vec3;

/// Light travels along `direction` (of any length but zero); `irradiance` in W/m² on a surface that faces it.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionalLight {
    pub direction: Vec3,
    pub irradiance: Rgb,
}

impl Default for DirectionalLight {
    fn default() -> DirectionalLight {
        DirectionalLight { direction: Vec3::NEG_Y, irradiance: Rgb::ZERO }
    }
}

impl Fields for DirectionalLight {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.direction(key("direction", "where the light travels to").required(), &mut self.direction)?;
        let irradiance = key("irradiance", "on a surface that faces the light").unit("W/m²").required();
        visitor.color(irradiance, NOT_NEGATIVE, &mut self.irradiance)
    }
}

impl LightParameters for DirectionalLight {
    const NUMBER: u32 = 4;
    type Loaded = DirectionalLight;

    fn load(&self, _: &mut Findings) -> Result<DirectionalLight> {
        Ok(self.clone())
    }
}

impl LightSource for DirectionalLight {
    fn checked(self) -> Result<DirectionalLight> {
        let unit = self.direction.as_dvec3().try_normalize();
        check_light(self.irradiance, unit.is_some(), "a directional light")?;
        let direction = unit.map_or(self.direction, |d| d.as_vec3());
        Ok(DirectionalLight { direction, ..self })
    }

    fn power(&self, section: f64) -> f64 {
        section * wide_luminance(self.irradiance)
    }

    fn extent(&self) -> Extent {
        let irradiance = wide_luminance(self.irradiance);
        Extent::Far(FarLight { axis: -self.direction, size: 0.0, irradiance })
    }

    fn brightness(&self, _scene_radius: f64) -> f64 {
        self.irradiance.max_element() as f64
    }

    fn scaled(self, factor: f64) -> DirectionalLight {
        DirectionalLight { irradiance: scaled(self.irradiance, factor), ..self }
    }

    fn sample(&self, _p: Vec3, _u_cell: f64, _u: [f32; 2]) -> Option<LightSample> {
        Some(LightSample::far(-self.direction, self.irradiance, 1.0, true))
    }
}
