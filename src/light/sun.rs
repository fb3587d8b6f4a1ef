//! A sun that has a size: a bright disc far away.

use super::source::{Extent, Findings, LightParameters, LightSource};
use super::tree::FarLight;
use super::{LightSample, check_light, scaled, wide_luminance};
use crate::Result;
use crate::document::{Bounds, NOT_NEGATIVE, key};
use crate::fields::{FieldVisitor, Fields};
use crate::math::Frame;
use crate::math::Rgb;
use crate::math::warp::square_to_disk;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Mean angular diameter of the sun, degrees.
pub(super) const SUN_DIAMETER: f32 = 0.533;

const DIAMETER: Bounds = Bounds::new(|x| (0.01..=90.0).contains(&x), "between 0.01 and 90");

/// A disc of even radiance around where light comes from, as written.
#[derive(Clone, Debug, PartialEq)]
pub struct SunLight {
    /// Where the light travels to, of any length but zero.
    pub direction: Vec3,
    /// W/m² on a surface that faces the middle of the disc.
    pub irradiance: Rgb,
    /// Degrees.
    pub angular_diameter: f32,
}

impl Default for SunLight {
    fn default() -> SunLight {
        SunLight { direction: Vec3::NEG_Y, irradiance: Rgb::ZERO, angular_diameter: SUN_DIAMETER }
    }
}

impl Fields for SunLight {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.direction(key("direction", "where the light travels to").required(), &mut self.direction)?;
        let irradiance = key("irradiance", "on a surface that faces the sun").unit("W/m²").required();
        visitor.color(irradiance, NOT_NEGATIVE, &mut self.irradiance)?;
        let diameter = key("angular_diameter", "of the disc; shadows are the softer the larger it is").unit("degrees");
        visitor.number(diameter, DIAMETER, &mut self.angular_diameter)
    }
}

impl LightParameters for SunLight {
    const NUMBER: u32 = 5;
    type Loaded = SunDisc;

    fn load(&self, _: &mut Findings) -> Result<SunDisc> {
        let unit = self.direction.as_dvec3().try_normalize();
        check_light(self.irradiance, unit.is_some(), "a sun")?;
        Ok(SunDisc::new(-unit.unwrap_or(DVec3::Y), self.irradiance, self.angular_diameter))
    }
}

/// The directions that are seen as a sun, all with one radiance.
#[derive(Clone, Debug)]
pub(crate) struct SunDisc {
    /// Its `n` points to the middle of the disc.
    frame: Frame,
    /// W/(sr·m²).
    radiance: Rgb,
    /// 1 − cos of the angle between middle and edge.
    versine: f64,
}

impl SunDisc {
    /// `irradiance` on a surface that faces `to_sun` (unit): L·π·sin²θ for a disc of angular radius θ.
    pub(super) fn new(to_sun: DVec3, irradiance: Rgb, angular_diameter: f32) -> SunDisc {
        let radius = 0.5 * f64::from(angular_diameter).to_radians();
        SunDisc {
            frame: Frame::from_normal(to_sun.as_vec3().normalize()),
            radiance: (irradiance.as_dvec3() / (PI * radius.sin().powi(2))).as_vec3(),
            // 1 − cos would lose its digits
            versine: 2.0 * (0.5 * radius).sin().powi(2),
        }
    }

    /// W/m² on a surface that faces the middle.
    #[cfg(test)]
    pub(super) fn irradiance(&self) -> Rgb {
        self.radiance * (PI * self.versine * (2.0 - self.versine)) as f32
    }

    fn solid_angle(&self) -> f64 {
        2.0 * PI * self.versine
    }

    /// Whether the unit direction `wi` is seen within the disc.
    fn holds(&self, wi: Vec3) -> bool {
        // the chord squared is twice the versine
        0.5 * f64::from((wi - self.frame.n).length_squared()) <= self.versine
    }
}

impl LightSource for SunDisc {
    fn checked(self) -> Result<SunDisc> {
        check_light(self.radiance, true, "a sun")?;
        Ok(self)
    }

    fn power(&self, section: f64) -> f64 {
        section * self.solid_angle() * wide_luminance(self.radiance)
    }

    fn extent(&self) -> Extent {
        let size = (1.0 - self.versine).acos();
        Extent::Far(FarLight { axis: self.frame.n, size, irradiance: self.power(1.0) })
    }

    fn brightness(&self, _scene_radius: f64) -> f64 {
        self.radiance.max_element() as f64
    }

    fn scaled(self, factor: f64) -> SunDisc {
        SunDisc { radiance: scaled(self.radiance, factor), ..self }
    }

    /// Evenly over the solid angle: a disk's even points, lifted to the sphere by Lambert's equal-area azimuthal map.
    fn sample(&self, _p: Vec3, _u_cell: f64, u: [f32; 2]) -> Option<LightSample> {
        let disk = square_to_disk(u);
        let versine = self.versine as f32 * disk.length_squared();
        // sinθ/r with r² = versine/versine of the edge, so that no division by r is needed
        let sine = (self.versine as f32 * (2.0 - versine)).sqrt();
        let wi = self.frame.to_world(Vec3::new(disk.x * sine, disk.y * sine, 1.0 - versine));
        let (wi, pdf) = (wi.normalize(), self.solid_angle().recip() as f32);
        // rounding may put a direction at the edge beyond it, where it has neither radiance nor density
        self.holds(wi).then(|| LightSample::far(wi, self.radiance, pdf, false))
    }

    fn surrounds(&self) -> bool {
        true
    }

    fn radiance(&self, wi: Vec3) -> Rgb {
        if self.holds(wi) { self.radiance } else { Rgb::ZERO }
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        if self.holds(wi) { self.solid_angle().recip() as f32 } else { 0.0 }
    }
}
