//! What facets send to each other. A microfacet model of single scattering loses it, the more the rougher the surface is; here it
//! comes back as a lobe of its own (Kulla & Conty 2017, "Revisiting Physically Based Shading at Imageworks").

use super::fresnel;
use super::microfacet::Microfacet;
use super::microfacet::MicrofacetDistribution::Ggx;
use super::table::{NODES, cosine_mean, interpolate, node, visible_normals};
use crate::math::Rgb;
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// Roughnesses √α of a table for all of them, equidistant from 0 to 1.
const ROUGHNESSES: usize = 24;

/// Loss of facets that reflect everything, by the cosine of the view: for one roughness, or for all.
#[derive(Debug)]
pub(crate) struct LossTable(Vec<LossRow>);

#[derive(Debug)]
struct LossRow {
    /// 1 − E(µ) with E the albedo of single scattering.
    loss: [f32; NODES],
    /// Its cosine-weighted mean, 1 − Ē.
    mean: f32,
}

impl LossRow {
    fn new(microfacet: &Microfacet) -> LossRow {
        let loss = std::array::from_fn(|i| (1.0 - albedo(microfacet, node(i))).max(0.0));
        LossRow { loss, mean: cosine_mean(&loss) }
    }
}

impl LossTable {
    /// For surfaces with these facets.
    pub(super) fn new(microfacet: &Microfacet) -> LossTable {
        LossTable(vec![LossRow::new(microfacet)])
    }

    /// For GGX facets of α = roughness², whatever the roughness.
    pub(super) fn of_all_roughnesses() -> LossTable {
        let roughness = |i: usize| i as f32 / (ROUGHNESSES - 1) as f32;
        let row = |i: usize| LossRow::new(&Microfacet::new(Ggx, roughness(i) * roughness(i)));
        LossTable((0..ROUGHNESSES).into_par_iter().map(row).collect())
    }

    /// At a roughness √α in [0, 1]; a table of one roughness has it everywhere.
    #[inline]
    pub(super) fn at(&self, roughness: f32) -> Loss<'_> {
        let x = roughness * (self.0.len() - 1) as f32;
        let first = (x as usize).min(self.0.len() - 1);
        let second = (first + 1).min(self.0.len() - 1);
        Loss { rows: [&self.0[first], &self.0[second]], t: x - first as f32 }
    }
}

/// ∫G1(wi) over the visible normals: what facets that reflect everything let out of light at cosine `cos` after one reflection.
fn albedo(microfacet: &Microfacet, cos: f32) -> f32 {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let let_out = |(u, weight): ([f32; 2], f32)| {
        let wi = fresnel::reflect(wo, microfacet.sample_visible(wo, u));
        if wi.z > 0.0 { weight * microfacet.g1(wi) } else { 0.0 }
    };
    visible_normals().map(let_out).sum()
}

/// A [`LossTable`] at one roughness.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Loss<'s> {
    rows: [&'s LossRow; 2],
    t: f32,
}

impl Loss<'_> {
    /// 1 − E(µ), in [0, 1].
    #[inline]
    pub fn at(&self, cos: f32) -> f32 {
        let [a, b] = self.rows.map(|row| interpolate(&row.loss, cos));
        a + self.t * (b - a)
    }

    /// 2∫(1 − E(µ))µ dµ.
    #[inline]
    pub fn mean(&self) -> f32 {
        let [a, b] = self.rows.map(|row| row.mean);
        a + self.t * (b - a)
    }

    /// The lobe's value times |cosθi|, where facets reflect everything: (1 − E(µo))(1 − E(µi))µi/(π(1 − Ē)). Its integral over wi is
    /// 1 − E(µo), which makes the whole surface reflect everything.
    #[inline]
    pub fn lobe(&self, cos_o: f32, cos_i: f32) -> f32 {
        let mean = self.mean();
        if mean > 0.0 { FRAC_1_PI * self.at(cos_o) * self.at(cos_i) * cos_i / mean } else { 0.0 }
    }

    /// What the lobe is multiplied by where facets reflect the share F in the mean over directions: light that has met two facets
    /// and may go on, F²Ē/(1 − F(1 − Ē)).
    #[inline]
    pub fn returned(&self, mean_fresnel: Rgb) -> Rgb {
        let loss = self.mean();
        mean_fresnel * mean_fresnel * (1.0 - loss) / (Rgb::ONE - mean_fresnel * loss)
    }
}
