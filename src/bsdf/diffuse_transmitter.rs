//! Leaves and paper: Lambertian on both sides.

use super::lanes::{LobeNumbers, SameMaterial};
use super::model::{BsdfParameters, Prepared};
use super::{BLACK, BsdfSample, BsdfTables, DIFFUSE, Model, Scatter, choice, mirrored};
use crate::Result;
use crate::document::key;
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use crate::math::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use crate::simd::{Lanes, Vec3Lanes, pick};
use crate::texture::ColorTexture;
use glam::Vec3;

/// A translucent Lambertian surface as written.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseTransmitterParameters {
    pub reflectance: ColorTexture,
    pub transmittance: ColorTexture,
}

impl Default for DiffuseTransmitterParameters {
    fn default() -> DiffuseTransmitterParameters {
        let quarter = ColorTexture::grey(0.25);
        DiffuseTransmitterParameters { reflectance: quarter.clone(), transmittance: quarter }
    }
}

impl Fields for DiffuseTransmitterParameters {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.texture(key("reflectance", "albedo of the side that is lit"), &mut self.reflectance)?;
        let meaning = "albedo of the other side; with `reflectance` at most 1";
        visitor.texture(key("transmittance", meaning), &mut self.transmittance)?;
        // pictures are not looked into
        let (ColorTexture::Constant(r), ColorTexture::Constant(t)) = (&self.reflectance, &self.transmittance) else {
            return Ok(());
        };
        // Leaves room for decimal fractions whose rounded sum is a little above 1.
        let conserves = (*r + *t).max_element() <= 1.0 + 1e-6;
        let message = "`reflectance` and `transmittance` must not add up to more than 1";
        visitor.check(conserves, &["transmittance", "reflectance"], message)
    }
}

impl BsdfParameters for DiffuseTransmitterParameters {
    const NUMBER: u32 = 2;
    const OPAQUE: bool = false;

    fn model(&self, _tables: &mut BsdfTables) -> Result<Model> {
        Ok(DiffuseTransmitterModel.into())
    }
}

/// A translucent material: all of it may vary from place to place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DiffuseTransmitterModel;

impl Prepared for DiffuseTransmitterModel {
    type At<'s> = DiffuseTransmitter;

    #[inline(always)]
    fn at(&self, [reflectance, transmittance]: [Rgb; 2]) -> DiffuseTransmitter {
        DiffuseTransmitter { reflectance, transmittance }
    }

    fn in_lanes(&self) -> bool {
        true
    }

    #[inline(never)]
    fn eval_pdf_lanes(&self, surfaces: &SameMaterial, wi: &Vec3Lanes, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        surfaces.eval_pdf(wi, |colors| self.at(colors), f, pdf);
    }

    #[inline(never)]
    fn draw_lanes(&self, surfaces: &SameMaterial, numbers: &LobeNumbers, wi: &mut Vec3Lanes) {
        surfaces.draw(numbers, |colors, wo, lobe, u, _| self.at(colors).draw(wo, lobe, u), wi);
    }

    fn draws_in_lanes(&self) -> bool {
        true
    }

    #[inline(never)]
    fn albedo_lanes(&self, surfaces: &SameMaterial, albedo: &mut Vec3Lanes) {
        surfaces.albedo(|colors| self.at(colors), albedo);
    }
}

/// f = reflectance/π on the side of wo, transmittance/π on the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DiffuseTransmitter {
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

impl DiffuseTransmitter {
    /// The direction of [`Scatter::sample`].
    #[inline(always)]
    fn draw(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<Vec3> {
        let reflect = choice(self.reflectance, self.transmittance)?;
        let wi = square_to_cosine_hemisphere(u);
        Some(pick((wo.z < 0.0) == (u_lobe < reflect), mirrored(wi), wi))
    }
}

impl Scatter for DiffuseTransmitter {
    const SMOOTH: bool = true;
    const OPAQUE: bool = false;

    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let Some(reflect) = choice(self.reflectance, self.transmittance) else { return BLACK };
        let cosine = square_to_cosine_hemisphere_pdf(wi.abs());
        if wo.z * wi.z > 0.0 {
            (self.reflectance * cosine, reflect * cosine)
        } else if wo.z * wi.z < 0.0 {
            (self.transmittance * cosine, (1.0 - reflect) * cosine)
        } else {
            BLACK
        }
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = self.draw(wo, u_lobe, u)?;
        BsdfSample::smooth(wi, self.eval_pdf(wo, wi), 1.0)
    }

    #[inline(always)]
    fn albedo(&self, _wo: Vec3) -> Rgb {
        self.reflectance + self.transmittance
    }

    fn roughness(&self) -> f32 {
        DIFFUSE
    }
}
