//! A point that shines in all directions.

use super::source::{Extent, Findings, LightParameters, LightSource};
use super::tree::LightBounds;
use super::{LightPoint, LightSample, Rounding, check_light, scaled, wide_luminance};
use crate::Result;
use crate::document::{NOT_NEGATIVE, key};
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// `intensity` in W/sr, the same in all directions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointLightParameters {
    /// As written: it may be far from 0.
    pub position: DVec3,
    pub intensity: Rgb,
}

/// The same in the scene's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PointLight {
    pub position: Vec3,
    pub intensity: Rgb,
}

impl Fields for PointLightParameters {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.position(key("position", "where it is").unit("length").required(), &mut self.position)?;
        visitor.color(key("intensity", "in every direction").unit("W/sr").required(), NOT_NEGATIVE, &mut self.intensity)
    }
}

impl LightParameters for PointLightParameters {
    const NUMBER: u32 = 3;
    type Loaded = PointLight;

    fn load(&self, _: &mut Findings) -> Result<PointLight> {
        Ok(PointLight { position: self.position.as_vec3(), intensity: self.intensity })
    }

    fn translate(&mut self, by: DVec3) {
        self.position += by;
    }
}

impl LightSource for PointLight {
    fn checked(self) -> Result<PointLight> {
        check_light(self.intensity, self.position.is_finite(), "a point light")?;
        Ok(self)
    }

    fn power(&self, _section: f64) -> f64 {
        4.0 * PI * wide_luminance(self.intensity)
    }

    fn extent(&self) -> Extent {
        let at = self.position;
        let intensity = wide_luminance(self.intensity);
        Extent::Near(LightBounds {
            lo: at,
            hi: at,
            centre: at,
            radius: 0.0,
            thickness: 0.0,
            axis: Vec3::ZERO,
            two_sided: false,
            intensity,
        })
    }

    fn brightness(&self, scene_radius: f64) -> f64 {
        self.intensity.max_element() as f64 / scene_radius.powi(2)
    }

    fn scaled(self, factor: f64) -> PointLight {
        PointLight { intensity: scaled(self.intensity, factor), ..self }
    }

    fn sample(&self, p: Vec3, _u_cell: f64, _u: [f32; 2]) -> Option<LightSample> {
        let (wi, distance) = unit_and_length(self.position - p)?;
        let radiance = self.intensity / distance / distance;
        let target = LightPoint { point: self.position, normal: Vec3::ZERO, error: Rounding::default() };
        Some(LightSample { wi, radiance, pdf: 1.0, delta: true, target: Some(target) })
    }
}

/// Without loss where the square of the length is beyond an `f32`.
pub(super) fn unit_and_length(v: Vec3) -> Option<(Vec3, f32)> {
    let wide = v.as_dvec3();
    let length = wide.length();
    (length > 0.0 && length.is_finite()).then(|| ((wide / length).as_vec3(), length as f32))
}
