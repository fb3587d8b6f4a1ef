//! The same radiance from everywhere.

use super::source::{Extent, Findings, LightParameters, LightSource};
use super::tree::FarLight;
use super::{LightSample, check_light, scaled, wide_luminance};
use crate::Result;
use crate::document::{NOT_NEGATIVE, key};
use crate::fields::{FieldVisitor, Fields};
use crate::math::{Rgb, warp};
use glam::Vec3;
use std::f64::consts::PI;

/// The same `radiance` (W/(sr·m²)) from everywhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConstantLight {
    pub radiance: Rgb,
}

impl Fields for ConstantLight {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.color(
            key("radiance", "from every direction").unit("W/(sr·m²)").required(),
            NOT_NEGATIVE,
            &mut self.radiance,
        )
    }
}

impl LightParameters for ConstantLight {
    const NUMBER: u32 = 2;
    type Loaded = ConstantLight;

    fn load(&self, _: &mut Findings) -> Result<ConstantLight> {
        Ok(self.clone())
    }
}

impl LightSource for ConstantLight {
    fn checked(self) -> Result<ConstantLight> {
        check_light(self.radiance, true, "a constant light")?;
        Ok(self)
    }

    fn power(&self, section: f64) -> f64 {
        section * 4.0 * PI * wide_luminance(self.radiance)
    }

    fn extent(&self) -> Extent {
        Extent::Far(FarLight::around(4.0 * PI * wide_luminance(self.radiance), 0.0))
    }

    fn brightness(&self, _scene_radius: f64) -> f64 {
        self.radiance.max_element() as f64
    }

    fn scaled(self, factor: f64) -> ConstantLight {
        ConstantLight { radiance: scaled(self.radiance, factor) }
    }

    fn sample(&self, _p: Vec3, _u_cell: f64, u: [f32; 2]) -> Option<LightSample> {
        let wi = warp::square_to_uniform_sphere(u);
        Some(LightSample::far(wi, self.radiance, warp::UNIFORM_SPHERE_PDF, false))
    }

    fn surrounds(&self) -> bool {
        true
    }

    fn radiance(&self, _wi: Vec3) -> Rgb {
        self.radiance
    }

    fn pdf(&self, _wi: Vec3) -> f32 {
        warp::UNIFORM_SPHERE_PDF
    }
}
