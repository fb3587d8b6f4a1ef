//! Lambert's law.

use super::model::{BsdfParameters, Prepared};
use super::{BLACK, Bsdf, BsdfSample, BsdfTables, DIFFUSE, Model, Scatter, mirrored};
use crate::Result;
use crate::document::key;
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use crate::math::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes};
use crate::texture::ColorTexture;
use glam::Vec3;

/// A Lambertian surface as written.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseParameters {
    pub reflectance: ColorTexture,
}

impl Default for DiffuseParameters {
    fn default() -> DiffuseParameters {
        DiffuseParameters { reflectance: ColorTexture::grey(0.5) }
    }
}

impl Fields for DiffuseParameters {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.texture(key("reflectance", "albedo"), &mut self.reflectance)
    }
}

impl BsdfParameters for DiffuseParameters {
    const NUMBER: u32 = 1;
    const OPAQUE: bool = true;

    fn model(&self, _tables: &mut BsdfTables) -> Result<Model> {
        Ok(DiffuseModel.into())
    }
}

/// A Lambertian material: all of it may vary from place to place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DiffuseModel;

impl Prepared for DiffuseModel {
    type At<'s> = Diffuse;

    #[inline(always)]
    fn at(&self, [reflectance, _]: [Rgb; 2]) -> Diffuse {
        Diffuse { reflectance }
    }
}

/// f = reflectance/π above the horizon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Diffuse {
    pub reflectance: Rgb,
}

impl Scatter for Diffuse {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    #[inline]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wo.z <= 0.0 {
            return BLACK;
        }
        let pdf = square_to_cosine_hemisphere_pdf(wi);
        (self.reflectance * pdf, pdf)
    }

    #[inline]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = square_to_cosine_hemisphere(u);
        let pdf = square_to_cosine_hemisphere_pdf(wi);
        (wo.z > 0.0 && pdf > 0.0).then_some(BsdfSample { wi, weight: self.reflectance, pdf, delta: false, eta: 1.0 })
    }

    #[inline]
    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z > 0.0 { self.reflectance } else { Rgb::ZERO }
    }

    fn roughness(&self) -> f32 {
        DIFFUSE
    }
}

/// Lambertian surfaces of a packet, side by side: what [`Bsdf`] gives one by one, to the last bit. Lanes with a surface of
/// another kind are black, those without one hold any numbers.
pub(crate) struct DiffuseLanes {
    reflectance: Vec3Lanes,
    turns: Mask,
    is: Mask,
}

impl DiffuseLanes {
    pub fn new() -> DiffuseLanes {
        DiffuseLanes { reflectance: Vec3Lanes::ZERO, turns: Mask::NONE, is: Mask::NONE }
    }

    /// Forgets all.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.is = Mask::NONE;
    }

    /// Takes surface `k`, where it is Lambertian.
    #[inline(always)]
    pub fn set(&mut self, k: usize, bsdf: &Bsdf) {
        let diffuse = bsdf.diffuse();
        self.is.set(k, diffuse.is_some());
        self.reflectance.set(k, diffuse.map_or(Rgb::ZERO, |diffuse| diffuse.reflectance));
        self.turns.set(k, bsdf.turns());
    }

    /// Those that are Lambertian.
    #[inline(always)]
    pub fn are(&self) -> Mask {
        self.is
    }

    #[inline(always)]
    pub fn reflectance(&self, k: usize) -> Rgb {
        self.reflectance.get(k)
    }

    /// Surface `k`, with the directions by which it is seen and lit, on the side from which it scatters: either, where it
    /// `turns`.
    #[inline(always)]
    fn turned(&self, turns: bool, k: usize, wo: Vec3, wi: Vec3) -> (Diffuse, Vec3, Vec3) {
        let turned = turns & (wo.z < 0.0);
        let (wo, wi) = if turned { (mirrored(wo), mirrored(wi)) } else { (wo, wi) };
        (Diffuse { reflectance: self.reflectance.get(k) }, wo, wi)
    }

    /// As [`Bsdf::albedo`].
    #[inline(always)]
    pub fn albedo(&self, wo: &Vec3Lanes, albedo: &mut Vec3Lanes) {
        let turns = self.turns.lanes();
        for k in 0..LANES {
            let (diffuse, wo, _) = self.turned(turns.has(k), k, wo.get(k), Vec3::Z);
            albedo.set(k, diffuse.albedo(wo).clamp(Rgb::ZERO, Rgb::ONE));
        }
    }

    /// As [`Bsdf::eval_pdf`]; directions in the shading frames.
    #[inline(always)]
    pub fn eval_pdf(&self, wo: &Vec3Lanes, wi: &Vec3Lanes, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        let turns = self.turns.lanes();
        for k in 0..LANES {
            let (diffuse, wo, wi) = self.turned(turns.has(k), k, wo.get(k), wi.get(k));
            let (value, density) = diffuse.eval_pdf(wo, wi);
            f.set(k, value);
            pdf[k] = density;
        }
    }

    /// As [`Bsdf::sample`] with the numbers `u`; the density is 0 where there is no sample. Its weight is the reflectance.
    #[inline(always)]
    pub fn sample(&self, wo: &Vec3Lanes, u: &[Lanes; 2], wi: &mut Vec3Lanes, pdf: &mut Lanes) {
        let turns = self.turns.lanes();
        for k in 0..LANES {
            let above = square_to_cosine_hemisphere([u[0][k], u[1][k]]);
            let (_, wo, turned) = self.turned(turns.has(k), k, wo.get(k), above);
            wi.set(k, turned);
            pdf[k] = if wo.z > 0.0 { square_to_cosine_hemisphere_pdf(above) } else { 0.0 };
        }
    }
}

impl Default for DiffuseLanes {
    fn default() -> DiffuseLanes {
        DiffuseLanes::new()
    }
}
