//! Scattering at a surface: a closed set of BSDFs, one kind per file, one enum.
//!
//! All directions are unit vectors in the local shading frame (z = shading normal) and point away from the
//! surface; `wo` leads to where the path came from, `wi` to where it goes on. Values include the cosine:
//! `eval` is f(wo, wi)·|cosθi| per steradian. Radiance is carried from the lights (so refraction scales it by
//! (ηo/ηi)², Veach 1997, §5.2). Delta lobes (perfect mirrors and glass) have no value and no density: only
//! `sample` meets them.

pub mod fresnel;
pub mod microfacet;

use crate::math::Rgb;
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
