//! Scattering at a surface. A BSDF is one file, with its parameters as written, their keys, and how it scatters; and one line
//! in the list below (with its `mod`).
//!
//! All directions are unit vectors in the local shading frame (z = shading normal) and point away from the
//! surface; `wo` leads to where the path came from, `wi` to where it goes on. Values include the cosine:
//! `eval` is f(wo, wi)·|cosθi| per steradian. Radiance is carried from the lights (so refraction scales it by
//! (ηo/ηi)², Veach 1997, §5.2). Delta lobes (perfect mirrors and glass) have no value and no density: only
//! `sample` meets them.

mod fresnel;
mod microfacet;

#[macro_use]
mod list;

mod coat;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_transmitter;
mod interface;
mod lanes;
mod mirror;
mod model;
mod multiple_scattering;
mod null;
mod plastic;
mod point;
mod principled;
mod rough_conductor;
mod rough_dielectric;
mod rough_plastic;
mod shading_normal;
mod table;
mod tables;

pub(crate) use diffuse::DiffuseLanes;
pub(crate) use lanes::BsdfLanes;
pub use microfacet::MicrofacetDistribution;
pub use model::BsdfModel;
pub(crate) use model::{color_textures, share_textures};
pub(crate) use point::Bsdf;
pub use principled::PrincipledMaps;
pub use tables::BsdfTables;

use crate::Result;
use crate::fields::{FieldVisitor, Fields};
use crate::math::{Rgb, luminance};
use crate::simd::{Lanes, Vec3Lanes};
use glam::Vec3;
use lanes::{LobeNumbers, SameMaterial};
use model::{BsdfParameters, Prepared};

// What a type of material is called in scene files, its parameters, and the kinds of scattering that it may be.
bsdfs! {
    "diffuse" = Diffuse(diffuse::DiffuseParameters) => Diffuse(diffuse::DiffuseModel);
    "diffuse_transmitter" = DiffuseTransmitter(diffuse_transmitter::DiffuseTransmitterParameters)
        => DiffuseTransmitter(diffuse_transmitter::DiffuseTransmitterModel);
    "mirror" = Mirror(mirror::MirrorParameters) => Mirror(mirror::MirrorModel);
    "conductor" = Conductor(conductor::ConductorParameters) => RoughConductor(rough_conductor::RoughConductorModel);
    "dielectric" = Dielectric(dielectric::DielectricParameters)
        => Dielectric(dielectric::Dielectric), ThinDielectric(dielectric::ThinDielectric),
           RoughDielectric(rough_dielectric::RoughDielectric);
    "plastic" = Plastic(plastic::PlasticParameters)
        => Plastic(plastic::PlasticModel), RoughPlastic(rough_plastic::RoughPlasticModel);
    "principled" = Principled(principled::PrincipledParameters)
        => Principled(principled::PrincipledModel), TexturedPrincipled(principled::TexturedPrincipledModel);
    "null" = Null(null::NullParameters) => Null(null::Null);
}

/// A direction drawn by [`Bsdf::sample`].
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit, local frame, away from the surface.
    pub wi: Vec3,
    /// f·|cosθi|/p with p the density of *this way* of drawing `wi`: what the throughput is multiplied by.
    pub weight: Rgb,
    /// For a smooth lobe: the density of all smooth lobes together, per steradian, equal to `Bsdf::pdf(wo, wi)`.
    /// For a delta lobe: the probability of having chosen it.
    pub pdf: f32,
    /// Whether the lobe is a delta distribution.
    pub delta: bool,
    /// η of the side of `wi` over η of the side of `wo`; 1 for reflection. Energy is radiance times its square.
    pub eta: f32,
}

impl BsdfSample {
    /// A sample of the smooth lobes, given what they all evaluate to; `None` where their density vanishes.
    #[inline(always)]
    fn smooth(wi: Vec3, (value, pdf): (Rgb, f32), eta: f32) -> Option<BsdfSample> {
        (pdf > 0.0).then(|| BsdfSample { wi, weight: value / pdf, pdf, delta: false, eta })
    }

    /// A sample of a delta lobe chosen with probability `pdf`, which reflects or transmits the share `value`.
    #[inline]
    fn delta(wi: Vec3, value: Rgb, pdf: f32, eta: f32) -> Option<BsdfSample> {
        (pdf > 0.0).then(|| BsdfSample { wi, weight: value / pdf, pdf, delta: true, eta })
    }
}

/// What there is beside sharper lobes, seen from a direction: one reflection by microfacets over a diffuse base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gloss {
    /// Roughness α of the facets.
    pub alpha: f32,
    /// Albedos (luminance) of the reflection and of the base, as of [`Bsdf::albedo`].
    pub specular: f32,
    pub diffuse: f32,
}

impl Gloss {
    fn new(alpha: f32, specular: Rgb, diffuse: Rgb) -> Option<Gloss> {
        Some(Gloss { alpha, specular: luminance(specular), diffuse: luminance(diffuse) })
    }
}

/// What every kind of scattering answers; contracts as in [`Bsdf`]. Opaque kinds scatter only above the horizon.
pub(crate) trait Scatter {
    /// Whether any lobe is smooth.
    const SMOOTH: bool;
    /// Whether light never crosses: such a kind can be two-sided.
    const OPAQUE: bool;

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32);
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample>;
    fn albedo(&self, wo: Vec3) -> Rgb;
    /// Of the sharpest smooth lobe; [`DIFFUSE`] where no lobe is a microfacet's.
    fn roughness(&self) -> f32;

    fn sharp_probability(&self, _wo: Vec3, alpha: f32) -> f32 {
        if self.roughness() < alpha { 1.0 } else { 0.0 }
    }

    fn eval_pdf_rough(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        if self.roughness() < alpha { BLACK } else { self.eval_pdf(wo, wi) }
    }

    fn diffuse_albedo(&self, _wo: Vec3) -> Rgb {
        Rgb::ZERO
    }

    fn gloss(&self, _wo: Vec3) -> Option<Gloss> {
        None
    }
}

/// The roughness of diffuse lobes, rougher than any microfacet distribution.
pub(crate) const DIFFUSE: f32 = f32::INFINITY;

/// `w` on the other side of the surface.
#[inline(always)]
fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

/// What light without smooth lobes evaluates to.
const BLACK: (Rgb, f32) = (Rgb::ZERO, 0.0);

/// Probability of choosing the first of two lobes in proportion to their luminance; `None` if both are black.
#[inline(always)]
fn choice(a: Rgb, b: Rgb) -> Option<f32> {
    let (a, b) = (luminance(a), luminance(b));
    (a + b > 0.0).then(|| a / (a + b))
}

#[cfg(test)]
mod tests;
