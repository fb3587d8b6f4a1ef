//! Disney's principled model (Burley 2012, "Physically Based Shading at Disney"), opaque and isotropic, with the
//! conventions of Mitsuba 3: exact dielectric Fresnel where not tinted, separable Smith shadowing. Like the
//! original it may reflect a little more than it receives (rough, bright bases at grazing angles), and a rough metal
//! less, unless light that facets send to each other comes back.

mod clearcoat;
mod parameters;
mod textured;

pub use parameters::{PrincipledMaps, PrincipledParameters};
pub(crate) use textured::TexturedPrincipledModel;

use super::microfacet::MicrofacetDistribution::Ggx;
use super::microfacet::{Microfacet, sin_cos_turn};
use super::model::Prepared;
use super::multiple_scattering::{Loss, LossTable};
use super::rough_conductor::{reflection_pdf, sample_reflection};
use super::{BLACK, BsdfSample, Gloss, Scatter, fresnel};
use crate::math::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use crate::math::{Rgb, luminance};
use crate::simd::pick;
use clearcoat::Clearcoat;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

/// The principled model of a whole material.
#[derive(Clone, Debug)]
pub(crate) struct PrincipledModel {
    lobes: PrincipledLobes,
    /// Of facets, where light that they send to each other comes back.
    loss: Option<Arc<LossTable>>,
}

impl PrincipledModel {
    /// What facets of a roughness lose.
    fn loss(&self, roughness: f32) -> Option<Loss<'_>> {
        self.loss.as_ref().map(|table| table.at(roughness))
    }
}

impl Prepared for PrincipledModel {
    type At<'s> = Principled<'s>;

    #[inline(always)]
    fn at(&self, [base_color, _]: [Rgb; 2]) -> Principled<'_> {
        Principled { base_color, lobes: &self.lobes, loss: self.loss(self.lobes.set.roughness) }
    }
}

/// The parameters and what follows from them, computed once per material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PrincipledLobes {
    set: Shares,
    /// From the reflectance at normal incidence, 0.08·specular.
    eta: f32,
    facets: Microfacet,
    coat: Clearcoat,
}

/// As of [`PrincipledParameters`].
#[derive(Clone, Copy, Debug)]
struct Shares {
    metallic: f32,
    roughness: f32,
    spec_tint: f32,
    clearcoat: f32,
    sheen: f32,
    sheen_tint: f32,
}

impl PrincipledLobes {
    fn new(set: &PrincipledParameters) -> PrincipledLobes {
        let &PrincipledParameters { metallic, roughness, spec_tint, clearcoat, sheen, sheen_tint, .. } = set;
        let (eta, alpha) = (eta_of(set.specular), alpha_of(roughness));
        let coat = Clearcoat { alpha: 0.1 + (0.001 - 0.1) * set.clearcoat_gloss };
        let set = Shares { metallic, roughness, spec_tint, clearcoat, sheen, sheen_tint };
        PrincipledLobes { set, eta, facets: Microfacet::new(Ggx, alpha), coat }
    }
}

/// The index of refraction that reflects 0.08·specular at normal incidence.
#[inline(always)]
fn eta_of(specular: f32) -> f32 {
    2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
}

#[inline(always)]
fn alpha_of(roughness: f32) -> f32 {
    (roughness * roughness).max(1e-3)
}

impl PrincipledLobes {
    /// The same numbers where it is known already that there is no clear coat, of which directions take calls.
    #[inline(always)]
    fn known_without_coat(self) -> PrincipledLobes {
        debug_assert_eq!(self.set.clearcoat, 0.0);
        PrincipledLobes { set: Shares { clearcoat: 0.0, ..self.set }, ..self }
    }

    /// The same with other shares: metallic, roughness and specular.
    #[inline(always)]
    fn with(mut self, shares: Rgb) -> PrincipledLobes {
        let [metallic, roughness, specular] = shares.clamp(Rgb::ZERO, Rgb::ONE).to_array();
        (self.set.metallic, self.set.roughness, self.eta) = (metallic, roughness, eta_of(specular));
        self.facets = Microfacet::new(Ggx, alpha_of(roughness));
        self
    }
}

/// Base, specular and clear-coat lobes over a base colour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Principled<'s> {
    base_color: Rgb,
    lobes: &'s PrincipledLobes,
    loss: Option<Loss<'s>>,
}

/// Probabilities of choosing each lobe; they sum to 1.
struct Choice {
    specular: f32,
    coat: f32,
    base: f32,
}

impl Principled<'_> {
    /// The base colour without its brightness.
    #[inline(always)]
    fn tint(&self) -> Rgb {
        let l = luminance(self.base_color);
        if l > 0.0 { self.base_color / l } else { Rgb::ONE }
    }

    /// Fresnel reflectance of facets met at cosine `cos`: metallic by Schlick from the base colour, dielectric
    /// exact, its tinted share by Schlick.
    #[inline(always)]
    fn fresnel(&self, cos: f32) -> Rgb {
        let PrincipledLobes { set, eta, .. } = self.lobes;
        let schlick = |r0: Rgb| r0 + (Rgb::ONE - r0) * fresnel::schlick_weight(cos);
        let (dielectric, _) = fresnel::dielectric(cos, *eta);
        let mut f = Rgb::splat((1.0 - set.metallic) * (1.0 - set.spec_tint) * dielectric);
        // choices and no jumps: in a loop over lanes compilers would pull those out of the loop, and leave it in pieces
        f = pick(set.metallic > 0.0, f + set.metallic * schlick(self.base_color), f);
        let r0 = ((eta - 1.0) / (eta + 1.0)).powi(2);
        pick(set.spec_tint > 0.0, f + (1.0 - set.metallic) * set.spec_tint * schlick(r0 * self.tint()), f)
    }

    /// Diffuse, retro-reflective and sheen lobes; `cos_d` is that of both directions to their half-vector.
    #[inline(always)]
    fn base(&self, cos_o: f32, cos_i: f32, cos_d: f32) -> Rgb {
        let set = &self.lobes.set;
        let (fo, fi) = (fresnel::schlick_weight(cos_o), fresnel::schlick_weight(cos_i));
        let diffuse = (1.0 - 0.5 * fo) * (1.0 - 0.5 * fi);
        let rr = 2.0 * set.roughness * cos_d * cos_d;
        let retro = rr * (fo + fi + fo * fi * (rr - 1.0));
        let mut f = self.base_color * (FRAC_1_PI * (diffuse + retro));
        if set.sheen > 0.0 {
            f += self.sheen_color() * (set.sheen * fresnel::schlick_weight(cos_d));
        }
        f * ((1.0 - set.metallic) * cos_i)
    }

    /// The lobe of light that has met several facets of the metal, and its colour.
    #[inline(always)]
    fn multiple(&self) -> Option<(Loss<'_>, Rgb)> {
        let loss = self.loss.filter(|_| self.lobes.set.metallic > 0.0)?;
        Some((loss, self.lobes.set.metallic * loss.returned(fresnel::schlick_mean(self.base_color))))
    }

    /// What it adds to the albedo from wo.
    #[inline(always)]
    fn multiple_albedo(&self, wo: Vec3) -> Rgb {
        self.multiple().map_or(Rgb::ZERO, |(loss, color)| color * loss.at(wo.z))
    }

    #[inline(always)]
    fn sheen_color(&self) -> Rgb {
        Rgb::ONE.lerp(self.tint(), self.lobes.set.sheen_tint)
    }

    /// The direction of [`Scatter::sample`]; `turn` as of [`Microfacet::sample_visible_with`].
    #[inline(always)]
    fn draw(&self, wo: Vec3, u_lobe: f32, u: [f32; 2], turn: impl Fn() -> (f32, f32)) -> Option<Vec3> {
        if wo.z <= 0.0 {
            return None;
        }
        let choice = self.choice(wo);
        // the sharper lobe comes first
        let coat_first = self.lobes.coat.alpha < self.lobes.facets.alpha();
        let first = if coat_first { choice.coat } else { choice.specular };
        if u_lobe >= choice.specular + choice.coat {
            Some(square_to_cosine_hemisphere(u))
        } else if self.lobes.set.clearcoat > 0.0 && (u_lobe < first) == coat_first {
            Some(fresnel::reflect(wo, self.lobes.coat.sample(u)).normalize())
        } else {
            sample_reflection(&self.lobes.facets, wo, u, turn)
        }
    }

    /// In proportion to what the lobes reflect, roughly; multiple scattering counts as part of the base. The specular lobe, which covers all directions, always
    /// has a share, since it may be brighter off the macroscopic normal.
    #[inline(always)]
    fn choice(&self, wo: Vec3) -> Choice {
        let set = &self.lobes.set;
        let specular = luminance(self.fresnel(wo.z)).max(0.04);
        let sheen = 0.1 * set.sheen * luminance(self.sheen_color());
        let base = (1.0 - set.metallic) * (luminance(self.base_color) + sheen) + luminance(self.multiple_albedo(wo));
        let coat = self.coat_albedo(wo);
        let sum = specular + base + coat;
        Choice { specular: specular / sum, coat: coat / sum, base: base / sum }
    }

    /// A sharp lobe D·cosθi about the mirrored direction integrates to 4 cos²θ.
    #[inline(always)]
    fn coat_albedo(&self, wo: Vec3) -> f32 {
        self.lobes.set.clearcoat * Clearcoat::fresnel(wo.z) * wo.z * wo.z
    }
}

impl Scatter for Principled<'_> {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        self.eval_pdf_rough(wo, wi, 0.0)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = self.draw(wo, u_lobe, u, || sin_cos_turn(u[0]))?;
        BsdfSample::smooth(wi, self.eval_pdf(wo, wi), 1.0)
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z <= 0.0 {
            return Rgb::ZERO;
        }
        let metal = self.loss.map_or(0.0, |loss| loss.at(wo.z) * self.lobes.set.metallic);
        self.fresnel(wo.z) * (1.0 - metal) + self.diffuse_albedo(wo) + Rgb::splat(self.coat_albedo(wo))
    }

    fn roughness(&self) -> f32 {
        let alpha = self.lobes.facets.alpha();
        if self.lobes.set.clearcoat > 0.0 { alpha.min(self.lobes.coat.alpha) } else { alpha }
    }

    fn sharp_probability(&self, wo: Vec3, alpha: f32) -> f32 {
        if wo.z <= 0.0 {
            return 1.0;
        }
        let choice = self.choice(wo);
        match (self.lobes.facets.alpha() < alpha, self.lobes.coat.alpha < alpha) {
            (true, true) => choice.specular + choice.coat,
            (true, false) => choice.specular,
            (false, true) => choice.coat,
            (false, false) => 0.0,
        }
    }

    #[inline(always)]
    fn eval_pdf_rough(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        let PrincipledLobes { set, facets, coat, .. } = self.lobes;
        let Some((m, specular_pdf)) = reflection_pdf(facets, wo, wi) else { return BLACK };
        let (choice, cos_d) = (self.choice(wo), wo.dot(m));
        let (mut value, mut pdf) = BLACK;
        if facets.alpha() >= alpha {
            value = self.fresnel(cos_d) * (specular_pdf * facets.g1(wi));
            pdf = choice.specular * specular_pdf;
        }
        pdf += choice.base * square_to_cosine_hemisphere_pdf(wi);
        value += self.base(wo.z, wi.z, cos_d);
        if let Some((loss, color)) = self.multiple() {
            value += color * loss.lobe(wo.z, wi.z);
        }
        if set.clearcoat > 0.0 && coat.alpha >= alpha {
            value += Rgb::splat(set.clearcoat * coat.eval(wo, wi, m));
            pdf += choice.coat * coat.pdf(wo, m);
        }
        (value, pdf)
    }

    fn gloss(&self, wo: Vec3) -> Option<Gloss> {
        Gloss::new(self.lobes.facets.alpha(), self.fresnel(wo.z), self.diffuse_albedo(wo))
    }

    #[inline(always)]
    fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        let diffuse = (1.0 - self.lobes.set.metallic) * self.base_color;
        if wo.z > 0.0 { diffuse + self.multiple_albedo(wo) } else { Rgb::ZERO }
    }
}
