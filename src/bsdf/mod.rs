//! Scattering at a surface: a closed set of BSDFs, one kind per file, one enum.
//!
//! All directions are unit vectors in the local shading frame (z = shading normal) and point away from the
//! surface; `wo` leads to where the path came from, `wi` to where it goes on. Values include the cosine:
//! `eval` is f(wo, wi)·|cosθi| per steradian. Radiance is carried from the lights (so refraction scales it by
//! (ηo/ηi)², Veach 1997, §5.2). Delta lobes (perfect mirrors and glass) have no value and no density: only
//! `sample` meets them.

pub mod fresnel;

pub mod microfacet;

mod coat;
mod description;
mod dielectric;
mod diffuse;
mod diffuse_transmitter;
mod lanes;
mod mirror;
mod model;
mod null;
mod plastic;
mod principled;
mod rough_conductor;
mod rough_dielectric;
mod rough_plastic;

pub use coat::{CoatTable, CoatTables};
pub use description::{BsdfDescription, MicrofacetDistribution};
pub use dielectric::{Dielectric, ThinDielectric};
pub use diffuse::{Diffuse, DiffuseLanes};
pub use diffuse_transmitter::DiffuseTransmitter;
pub use lanes::BsdfLanes;
pub use mirror::Mirror;
pub use model::{BsdfModel, color_textures};
pub use null::Null;
pub use plastic::{Plastic, SmoothCoat};
pub use principled::{Principled, PrincipledLobes, PrincipledParameters};
pub use rough_conductor::{Metal, RoughConductor};
pub use rough_dielectric::RoughDielectric;
pub use rough_plastic::RoughPlastic;

use crate::math::{Rgb, luminance};
use glam::Vec3;

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
    /// η of the side of `wi` over η of the side of `wo`; 1 for reflection. Roulette undoes the scaling of radiance with it.
    pub eta: f32,
}

impl BsdfSample {
    /// A sample of the smooth lobes, given what they all evaluate to; `None` where their density vanishes.
    #[inline]
    fn smooth(wi: Vec3, (value, pdf): (Rgb, f32), eta: f32) -> Option<BsdfSample> {
        (pdf > 0.0).then(|| BsdfSample { wi, weight: value / pdf, pdf, delta: false, eta })
    }

    /// A sample of a delta lobe chosen with probability `pdf`, which reflects or transmits the share `value`.
    #[inline]
    fn delta(wi: Vec3, value: Rgb, pdf: f32, eta: f32) -> Option<BsdfSample> {
        (pdf > 0.0).then(|| BsdfSample { wi, weight: value / pdf, pdf, delta: true, eta })
    }
}

/// What every kind of scattering answers; contracts as in [`Bsdf`]. Opaque kinds scatter only above the horizon.
trait Scatter {
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
}

/// The roughness of diffuse lobes, rougher than any microfacet distribution.
pub const DIFFUSE: f32 = f32::INFINITY;

/// The kinds of scattering at one point of a surface: textures are evaluated, tables are borrowed.
#[derive(Clone, Copy, Debug)]
pub enum BsdfKind<'s> {
    Diffuse(Diffuse),
    DiffuseTransmitter(DiffuseTransmitter),
    Mirror(Mirror),
    RoughConductor(RoughConductor),
    Dielectric(Dielectric),
    ThinDielectric(ThinDielectric),
    RoughDielectric(RoughDielectric),
    Plastic(Plastic),
    RoughPlastic(RoughPlastic<'s>),
    Principled(Principled<'s>),
    Null(Null),
}

/// Evaluates an expression with the payload of whichever kind it is.
macro_rules! each {
    ($kind:expr, $b:ident => $e:expr) => {
        match $kind {
            BsdfKind::Diffuse($b) => $e,
            BsdfKind::DiffuseTransmitter($b) => $e,
            BsdfKind::Mirror($b) => $e,
            BsdfKind::RoughConductor($b) => $e,
            BsdfKind::Dielectric($b) => $e,
            BsdfKind::ThinDielectric($b) => $e,
            BsdfKind::RoughDielectric($b) => $e,
            BsdfKind::Plastic($b) => $e,
            BsdfKind::RoughPlastic($b) => $e,
            BsdfKind::Principled($b) => $e,
            BsdfKind::Null($b) => $e,
        }
    };
}

/// The BSDF at one point: what its material says for everywhere, borrowed, and the colours there. One-sided opaque kinds
/// are black from behind (wo.z < 0); two-sided ones scatter there like their mirror image about the surface.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'s> {
    model: &'s BsdfModel,
    colors: [Rgb; 2],
}

impl<'s> Bsdf<'s> {
    /// The kind, with its parameters.
    #[inline(always)]
    pub fn kind(&self) -> BsdfKind<'s> {
        self.model.kind(self.colors)
    }

    /// f(wo, wi)·|cosθi| per steradian, summed over the smooth lobes.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.eval_pdf(wo, wi).0
    }

    /// Density of [`Self::sample`] per steradian of `wi` over all smooth lobes, the probability of choosing them
    /// included: its integral is that of drawing a smooth sample at all.
    #[inline]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_pdf(wo, wi).1
    }

    /// [`Self::eval`] and [`Self::pdf`] at once.
    #[inline]
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let (wo, wi) = if self.turned(wo) { (mirrored(wo), mirrored(wi)) } else { (wo, wi) };
        match self.diffuse() {
            Some(b) => b.eval_pdf(wo, wi),
            None => self.eval_pdf_other(wo, wi),
        }
    }

    /// Draws `wi`: `u_lobe` chooses the lobe, `u` the direction in it, all uniform in [0, 1). `None` where light
    /// is absorbed or the draw left the domain (probability 1 − ∫pdf − that of the delta lobes).
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let turned = self.turned(wo);
        let wo = if turned { mirrored(wo) } else { wo };
        let mut sample = match self.diffuse() {
            Some(b) => b.sample(wo, u_lobe, u),
            None => self.sample_other(wo, u_lobe, u),
        }?;
        if turned {
            sample.wi = mirrored(sample.wi);
        }
        Some(sample)
    }

    /// Whether any lobe is smooth: else neither next-event estimation nor a guide can help.
    #[inline]
    pub fn has_smooth(&self) -> bool {
        self.model.smooth()
    }

    /// Estimate of the directional-hemispherical albedo from `wo`: the share of energy that all lobes together,
    /// delta lobes included, scatter; the scaling of radiance by refraction left out; in [0, 1].
    ///
    /// Exact for diffuse kinds, mirrors, smooth glass and plastic; within 0.003 for rough plastic. Rough metal and
    /// glass count as if no facet shadowed another: too high by up to 0.09 near the normal and 0.17 towards grazing
    /// at alpha 0.25, by up to 0.7 at alpha 1. Principled likewise, over a Lambertian base.
    #[inline]
    pub fn albedo(&self, wo: Vec3) -> Rgb {
        let wo = if self.turned(wo) { mirrored(wo) } else { wo };
        let albedo = match self.diffuse() {
            Some(b) => b.albedo(wo),
            None => self.albedo_other(wo),
        };
        albedo.clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// The reflectance R of a Lambertian surface, f = R/π on the side of `wo` (for a one-sided surface: on its
    /// front); `None` for any other.
    #[inline]
    pub fn lambertian(&self) -> Option<Rgb> {
        self.diffuse().map(|diffuse| diffuse.reflectance)
    }

    /// Probability with which [`Self::sample`] draws from a lobe of less roughness than `alpha` > 0, delta lobes included:
    /// it does where `u_lobe` is below this number. 1 where `wo` is on the side that scatters nothing.
    #[inline]
    pub fn sharp_probability(&self, wo: Vec3, alpha: f32) -> f32 {
        if self.model.is_diffuse() { 0.0 } else { self.sharp_probability_other(wo, alpha) }
    }

    /// As much of [`Self::eval_pdf`] as is of lobes with at least the roughness `alpha`; with [`DIFFUSE`], of diffuse ones.
    /// The density integrates to at most 1 − [`Self::sharp_probability`].
    #[inline]
    pub fn eval_pdf_rough(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        let (wo, wi) = if self.turned(wo) { (mirrored(wo), mirrored(wi)) } else { (wo, wi) };
        match self.diffuse() {
            Some(b) => b.eval_pdf(wo, wi),
            None => self.eval_pdf_rough_other(wo, wi, alpha),
        }
    }

    /// As much of [`Self::albedo`] as is of lobes that follow Lambert's law on the side of `wo`, but for the Fresnel
    /// transmittance of a coat or the grazing angles of the principled model's base. Black for translucent kinds.
    #[inline]
    pub fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        let wo = if self.turned(wo) { mirrored(wo) } else { wo };
        let albedo = match self.diffuse() {
            Some(b) => b.albedo(wo),
            None => self.diffuse_albedo_other(wo),
        };
        albedo.clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// Lowest roughness alpha of the smooth lobes, at most 1; 1 for diffuse kinds, 0 without smooth lobes.
    #[inline]
    pub fn roughness(&self) -> f32 {
        self.model.roughness()
    }

    #[inline]
    fn turned(&self, wo: Vec3) -> bool {
        self.turns() && wo.z < 0.0
    }

    /// Whether it scatters to both sides alike.
    #[inline(always)]
    fn turns(&self) -> bool {
        self.model.turns()
    }

    /// Most of most scenes: it is worth a short way of its own.
    #[inline]
    fn diffuse(&self) -> Option<Diffuse> {
        self.model.is_diffuse().then_some(Diffuse { reflectance: self.colors[0] })
    }

    #[inline(never)]
    fn eval_pdf_other(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        each!(self.kind(), b => b.eval_pdf(wo, wi))
    }

    #[inline(never)]
    fn sample_other(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        each!(self.kind(), b => b.sample(wo, u_lobe, u))
    }

    #[inline(never)]
    fn albedo_other(&self, wo: Vec3) -> Rgb {
        each!(self.kind(), b => b.albedo(wo))
    }

    #[inline(never)]
    fn sharp_probability_other(&self, wo: Vec3, alpha: f32) -> f32 {
        let wo = if self.turned(wo) { mirrored(wo) } else { wo };
        each!(self.kind(), b => b.sharp_probability(wo, alpha))
    }

    #[inline(never)]
    fn eval_pdf_rough_other(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        each!(self.kind(), b => b.eval_pdf_rough(wo, wi, alpha))
    }

    #[inline(never)]
    fn diffuse_albedo_other(&self, wo: Vec3) -> Rgb {
        each!(self.kind(), b => b.diffuse_albedo(wo))
    }
}

impl BsdfKind<'_> {
    /// Whether any lobe is smooth, whether light never crosses, and [`Bsdf::roughness`]: the same for all colours.
    fn traits(&self) -> (bool, bool, f32) {
        fn of<S: Scatter>(b: &S) -> (bool, bool, f32) {
            (S::SMOOTH, S::OPAQUE, b.roughness().min(1.0))
        }
        each!(self, b => of(b))
    }
}

/// `w` on the other side of the surface.
#[inline]
fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

/// What light without smooth lobes evaluates to.
const BLACK: (Rgb, f32) = (Rgb::ZERO, 0.0);

/// Probability of choosing the first of two lobes in proportion to their luminance; `None` if both are black.
#[inline]
fn choice(a: Rgb, b: Rgb) -> Option<f32> {
    let (a, b) = (luminance(a), luminance(b));
    (a + b > 0.0).then(|| a / (a + b))
}

#[cfg(test)]
mod tests;
