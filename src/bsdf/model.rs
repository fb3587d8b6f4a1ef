//! From what a scene file says of a material to the BSDF at a point: everything but the colours is prepared once.

use super::microfacet::Microfacet;
use super::plastic::base_under_coat;
use super::{
    Bsdf, BsdfKind, CoatTable, CoatTables, Dielectric, Diffuse, DiffuseTransmitter, Metal, Mirror, Null, Plastic,
    Principled, PrincipledLobes, PrincipledParameters, RoughConductor, RoughDielectric, RoughPlastic, SmoothCoat,
    ThinDielectric,
};
use crate::bsdf::{BsdfDescription, MicrofacetDistribution};
use crate::math::Rgb;
use crate::texture::ColorTexture;
use crate::{Error, Result};
use std::sync::Arc;

/// A material's scattering without its textures' colours.
#[derive(Clone, Debug)]
pub struct BsdfModel {
    model: Model,
    /// Whether any lobe is smooth.
    smooth: bool,
    /// Opaque and two-sided: seen from behind, it scatters like its mirror image about the surface.
    turns: bool,
    /// As [`Bsdf::roughness`].
    roughness: f32,
}

#[derive(Clone, Debug)]
enum Model {
    Diffuse,
    DiffuseTransmitter,
    Mirror(Metal),
    RoughConductor(Metal, Microfacet),
    /// Nothing of it varies over the surface.
    Clear(BsdfKind<'static>),
    Plastic {
        coat: SmoothCoat,
        specular: Rgb,
        nonlinear: bool,
    },
    RoughPlastic {
        coat: Arc<CoatTable>,
        specular: Rgb,
        nonlinear: bool,
    },
    Principled(PrincipledLobes),
}

/// The colours that [`BsdfModel::at`] wants, in its order.
pub fn color_textures(description: &BsdfDescription) -> [Option<&ColorTexture>; 2] {
    use BsdfDescription as D;
    match description {
        D::Diffuse { reflectance } | D::Plastic { reflectance, .. } => [Some(reflectance), None],
        D::DiffuseTransmitter { reflectance, transmittance } => [Some(reflectance), Some(transmittance)],
        D::Conductor { specular_reflectance, .. } => [Some(specular_reflectance), None],
        D::Principled { base_color, .. } => [Some(base_color), None],
        D::Dielectric { .. } | D::Null => [None, None],
    }
}

impl BsdfModel {
    /// Checks the numbers and prepares what does not depend on the place; `coats` keeps tables for other
    /// materials. [`Error::Scene`] names the parameter that is out of its domain.
    pub fn new(description: &BsdfDescription, two_sided: bool, coats: &mut CoatTables) -> Result<BsdfModel> {
        use BsdfDescription as D;
        let model = match *description {
            D::Diffuse { .. } => Model::Diffuse,
            D::DiffuseTransmitter { .. } => Model::DiffuseTransmitter,
            D::Conductor { eta_k, alpha, distribution, .. } => conductor(eta_k, alpha, distribution)?,
            D::Dielectric {
                int_ior,
                ext_ior,
                specular_reflectance: reflectance,
                specular_transmittance: transmittance,
                alpha,
                distribution,
                thin,
            } => {
                let interface = Interface::new(int_ior, ext_ior, alpha, distribution)?;
                dielectric(interface, reflectance, transmittance, thin)?
            }
            D::Plastic { specular_reflectance: specular, int_ior, ext_ior, alpha, distribution, nonlinear, .. } => {
                let interface = Interface::new(int_ior, ext_ior, alpha, distribution)?;
                plastic(interface, specular, nonlinear, coats)?
            }
            D::Principled {
                base_color: _,
                metallic,
                roughness,
                specular,
                spec_tint,
                clearcoat,
                clearcoat_gloss,
                sheen,
                sheen_tint,
            } => Model::Principled(PrincipledLobes::new(checked_shares(PrincipledParameters {
                metallic,
                roughness,
                specular,
                spec_tint,
                clearcoat,
                clearcoat_gloss,
                sheen,
                sheen_tint,
            })?)),
            D::Null => Model::Clear(BsdfKind::Null(Null)),
        };
        let (smooth, opaque, roughness) = model.kind([Rgb::ZERO; 2]).traits();
        // two-sided means nothing for kinds that let light through
        Ok(BsdfModel { model, smooth, turns: two_sided && opaque, roughness })
    }

    /// The BSDF where the textures of [`color_textures`] have these values.
    #[inline]
    pub fn at(&self, colors: [Rgb; 2]) -> Bsdf<'_> {
        Bsdf { model: self, colors: if self.is_diffuse() { colors } else { self.model.prepared(colors) } }
    }

    #[inline(always)]
    pub(super) fn kind(&self, colors: [Rgb; 2]) -> BsdfKind<'_> {
        self.model.kind(colors)
    }

    #[inline(always)]
    pub fn is_diffuse(&self) -> bool {
        matches!(self.model, Model::Diffuse)
    }

    #[inline(always)]
    pub(super) fn smooth(&self) -> bool {
        self.smooth
    }

    #[inline(always)]
    pub(super) fn turns(&self) -> bool {
        self.turns
    }

    #[inline(always)]
    pub(super) fn roughness(&self) -> f32 {
        self.roughness
    }
}

impl Model {
    /// What is worth to be computed once for a place.
    #[inline(never)]
    fn prepared(&self, [color, other]: [Rgb; 2]) -> [Rgb; 2] {
        let base = match self {
            Model::Plastic { coat, nonlinear, .. } => {
                base_under_coat(color, coat.internal_reflectance, coat.eta, *nonlinear)
            }
            Model::RoughPlastic { coat, nonlinear, .. } => {
                base_under_coat(color, coat.internal_reflectance(), coat.eta(), *nonlinear)
            }
            _ => color,
        };
        [base, other]
    }

    /// With the colours of [`Self::prepared`].
    #[inline(always)]
    fn kind(&self, [color, other]: [Rgb; 2]) -> BsdfKind<'_> {
        match self {
            Model::Diffuse => BsdfKind::Diffuse(Diffuse { reflectance: color }),
            Model::DiffuseTransmitter => {
                BsdfKind::DiffuseTransmitter(DiffuseTransmitter { reflectance: color, transmittance: other })
            }
            &Model::Mirror(metal) => BsdfKind::Mirror(Mirror { metal, reflectance: color }),
            &Model::RoughConductor(metal, microfacet) => {
                BsdfKind::RoughConductor(RoughConductor { metal, reflectance: color, microfacet })
            }
            Model::Clear(kind) => *kind,
            &Model::Plastic { coat, specular, .. } => BsdfKind::Plastic(Plastic { base: color, specular, coat }),
            &Model::RoughPlastic { ref coat, specular, .. } => {
                BsdfKind::RoughPlastic(RoughPlastic { base: color, specular, coat })
            }
            Model::Principled(lobes) => BsdfKind::Principled(Principled { base_color: color, lobes }),
        }
    }
}

/// A dielectric interface as written.
struct Interface {
    /// Index inside over index outside.
    eta: f32,
    alpha: f32,
    distribution: MicrofacetDistribution,
}

impl Interface {
    fn new(int_ior: f32, ext_ior: f32, alpha: f32, distribution: MicrofacetDistribution) -> Result<Interface> {
        let eta = int_ior / ext_ior;
        if !(int_ior > 0.0 && ext_ior > 0.0 && (1e-2..=1e2).contains(&eta)) {
            return Err(out_of_domain("int_ior and ext_ior", "positive, with a ratio of 0.01 to 100"));
        }
        Ok(Interface { eta, alpha: checked_alpha(alpha)?, distribution })
    }
}

fn conductor(eta_k: Option<(Rgb, Rgb)>, alpha: f32, distribution: MicrofacetDistribution) -> Result<Model> {
    let metal = checked_metal(eta_k)?;
    Ok(match checked_alpha(alpha)? {
        0.0 => Model::Mirror(metal),
        alpha => Model::RoughConductor(metal, Microfacet::new(distribution, alpha)),
    })
}

fn dielectric(interface: Interface, reflectance: Rgb, transmittance: Rgb, thin: bool) -> Result<Model> {
    checked_color(reflectance, "specular_reflectance")?;
    checked_color(transmittance, "specular_transmittance")?;
    let Interface { eta, alpha, distribution } = interface;
    if thin && alpha > 0.0 {
        return Err(Error::Scene("a thin dielectric must be smooth (alpha = 0)".into()));
    }
    Ok(Model::Clear(if thin {
        BsdfKind::ThinDielectric(ThinDielectric { eta, reflectance, transmittance })
    } else if alpha > 0.0 && eta != 1.0 {
        let microfacet = Microfacet::new(distribution, alpha);
        BsdfKind::RoughDielectric(RoughDielectric { eta, reflectance, transmittance, microfacet })
    } else {
        // equal indices bend nothing, however rough the interface
        BsdfKind::Dielectric(Dielectric { eta, reflectance, transmittance })
    }))
}

fn plastic(interface: Interface, specular: Rgb, nonlinear: bool, coats: &mut CoatTables) -> Result<Model> {
    checked_color(specular, "specular_reflectance")?;
    let Interface { eta, alpha, distribution } = interface;
    Ok(if alpha == 0.0 {
        Model::Plastic { coat: SmoothCoat::new(eta), specular, nonlinear }
    } else {
        Model::RoughPlastic { coat: coats.get(eta, alpha, distribution), specular, nonlinear }
    })
}

fn checked_metal(eta_k: Option<(Rgb, Rgb)>) -> Result<Metal> {
    let Some((eta, k)) = eta_k else { return Ok(Metal::Perfect) };
    // an index of 0 + 0i reflects 0/0
    let fine = eta.is_finite() && k.is_finite() && eta.min(k).min_element() >= 0.0;
    if fine && (eta + k).min_element() > 0.0 {
        Ok(Metal::Index { eta, k })
    } else {
        Err(out_of_domain("eta and k of a conductor", "finite, not negative and not both 0"))
    }
}

fn checked_alpha(alpha: f32) -> Result<f32> {
    if (0.0..=10.0).contains(&alpha) { Ok(alpha) } else { Err(out_of_domain("alpha", "between 0 and 10")) }
}

fn checked_shares(set: PrincipledParameters) -> Result<PrincipledParameters> {
    for (name, share) in [
        ("metallic", set.metallic),
        ("roughness", set.roughness),
        ("specular", set.specular),
        ("spec_tint", set.spec_tint),
        ("clearcoat", set.clearcoat),
        ("clearcoat_gloss", set.clearcoat_gloss),
        ("sheen", set.sheen),
        ("sheen_tint", set.sheen_tint),
    ] {
        if !(0.0..=1.0).contains(&share) {
            return Err(out_of_domain(name, "between 0 and 1"));
        }
    }
    Ok(set)
}

fn checked_color(color: Rgb, name: &str) -> Result<()> {
    if color.is_finite() && color.min_element() >= 0.0 {
        Ok(())
    } else {
        Err(out_of_domain(name, "finite and not negative"))
    }
}

fn out_of_domain(name: &str, domain: &str) -> Error {
    Error::Scene(format!("{name} must be {domain}"))
}
