//! The kinds of scattering: one line in [`KINDS`], its defaults in [`Kind::bsdf`], its keys in [`Kind::read`].

use super::textures::color;
use crate::bsdf::{BsdfDescription, MicrofacetDistribution};
use crate::document::{Fault, NOT_NEGATIVE, POSITIVE, Reader, UNIT};
use crate::math::Rgb;
use crate::texture::ColorTexture;
use std::path::Path;

/// A value of a material's `type`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::format) enum Kind {
    Diffuse,
    DiffuseTransmitter,
    Mirror,
    Conductor,
    Dielectric,
    Plastic,
    Principled,
    Null,
}

pub(in crate::format) const KINDS: &[(&str, Kind)] = &[
    ("diffuse", Kind::Diffuse),
    ("diffuse_transmitter", Kind::DiffuseTransmitter),
    ("mirror", Kind::Mirror),
    ("conductor", Kind::Conductor),
    ("dielectric", Kind::Dielectric),
    ("plastic", Kind::Plastic),
    ("principled", Kind::Principled),
    ("null", Kind::Null),
];

const DISTRIBUTIONS: &[(&str, MicrofacetDistribution)] =
    &[("ggx", MicrofacetDistribution::Ggx), ("beckmann", MicrofacetDistribution::Beckmann)];

/// The types that have a key of this name of their own.
pub(in crate::format) fn kinds_with(key: &str) -> Vec<&'static str> {
    let has = |kind: Kind| {
        let mut probe = Reader::probe();
        let read = kind.read(&mut probe, &mut kind.bsdf(), Path::new(""));
        read.is_ok()
            && (probe.asked().iter().any(|info| info.key.name == key) || key == "two_sided" && kind.is_opaque())
    };
    KINDS.iter().filter(|(_, kind)| has(*kind)).map(|(name, _)| *name).collect()
}

impl Kind {
    /// The type by which a description would be written; a mirror counts as a conductor.
    pub fn of(bsdf: &BsdfDescription) -> Kind {
        match bsdf {
            BsdfDescription::Diffuse { .. } => Kind::Diffuse,
            BsdfDescription::DiffuseTransmitter { .. } => Kind::DiffuseTransmitter,
            BsdfDescription::Conductor { .. } => Kind::Conductor,
            BsdfDescription::Dielectric { .. } => Kind::Dielectric,
            BsdfDescription::Plastic { .. } => Kind::Plastic,
            BsdfDescription::Principled { .. } => Kind::Principled,
            BsdfDescription::Null => Kind::Null,
        }
    }

    pub fn name(self) -> &'static str {
        KINDS.iter().find(|(_, kind)| *kind == self).map_or("", |(name, _)| name)
    }

    /// Whether it has a back that may be black.
    pub fn is_opaque(self) -> bool {
        !matches!(self, Kind::DiffuseTransmitter | Kind::Dielectric | Kind::Null)
    }

    /// What it is when only its `type` is given.
    pub fn bsdf(self) -> BsdfDescription {
        let grey = |value| ColorTexture::Constant(Rgb::splat(value));
        let distribution = MicrofacetDistribution::Ggx;
        match self {
            Kind::Diffuse => BsdfDescription::Diffuse { reflectance: grey(0.5) },
            Kind::DiffuseTransmitter => {
                BsdfDescription::DiffuseTransmitter { reflectance: grey(0.25), transmittance: grey(0.25) }
            }
            Kind::Mirror | Kind::Conductor => {
                BsdfDescription::Conductor { eta_k: None, specular_reflectance: grey(1.0), alpha: 0.0, distribution }
            }
            Kind::Dielectric => BsdfDescription::Dielectric {
                int_ior: 1.5,
                ext_ior: 1.0,
                specular_reflectance: Rgb::ONE,
                specular_transmittance: Rgb::ONE,
                alpha: 0.0,
                distribution,
                thin: false,
            },
            Kind::Plastic => BsdfDescription::Plastic {
                reflectance: grey(0.5),
                specular_reflectance: Rgb::ONE,
                int_ior: 1.5,
                ext_ior: 1.0,
                alpha: 0.0,
                distribution,
                nonlinear: false,
            },
            Kind::Principled => principled(),
            Kind::Null => BsdfDescription::Null,
        }
    }

    /// Reads the type's own keys over `bsdf`, which is of this kind.
    pub fn read(self, t: &mut Reader, bsdf: &mut BsdfDescription, base: &Path) -> Result<(), Fault> {
        use BsdfDescription as B;
        match bsdf {
            B::Diffuse { reflectance } => color(t, "reflectance", base, reflectance),
            B::DiffuseTransmitter { reflectance, transmittance } => {
                color(t, "reflectance", base, reflectance)?;
                color(t, "transmittance", base, transmittance)?;
                check_sum(t, reflectance, transmittance)
            }
            B::Conductor { eta_k, specular_reflectance, alpha, distribution } => {
                color(t, "specular_reflectance", base, specular_reflectance)?;
                if self == Kind::Mirror {
                    return Ok(());
                }
                index(t, eta_k)?;
                roughness(t, alpha, distribution)
            }
            B::Dielectric {
                int_ior,
                ext_ior,
                specular_reflectance,
                specular_transmittance,
                alpha,
                distribution,
                thin,
            } => {
                iors(t, int_ior, ext_ior)?;
                t.color("specular_reflectance", UNIT, specular_reflectance)?;
                t.color("specular_transmittance", UNIT, specular_transmittance)?;
                roughness(t, alpha, distribution)?;
                t.flag("thin", thin)
            }
            B::Plastic { reflectance, specular_reflectance, int_ior, ext_ior, alpha, distribution, nonlinear } => {
                color(t, "reflectance", base, reflectance)?;
                t.color("specular_reflectance", UNIT, specular_reflectance)?;
                iors(t, int_ior, ext_ior)?;
                roughness(t, alpha, distribution)?;
                t.flag("nonlinear", nonlinear)
            }
            B::Principled { .. } => read_principled(t, bsdf, base),
            B::Null => Ok(()),
        }
    }
}

/// The defaults of Burley 2012.
fn principled() -> BsdfDescription {
    BsdfDescription::Principled {
        base_color: ColorTexture::Constant(Rgb::splat(0.5)),
        metallic: 0.0,
        roughness: 0.5,
        specular: 0.5,
        spec_tint: 0.0,
        clearcoat: 0.0,
        clearcoat_gloss: 1.0,
        sheen: 0.0,
        sheen_tint: 0.5,
    }
}

fn read_principled(t: &mut Reader, bsdf: &mut BsdfDescription, base: &Path) -> Result<(), Fault> {
    let BsdfDescription::Principled {
        base_color,
        metallic,
        roughness,
        specular,
        spec_tint,
        clearcoat,
        clearcoat_gloss,
        sheen,
        sheen_tint,
    } = bsdf
    else {
        return Ok(());
    };
    color(t, "base_color", base, base_color)?;
    t.number("metallic", UNIT, metallic)?;
    t.number("roughness", UNIT, roughness)?;
    t.number("specular", UNIT, specular)?;
    t.number("spec_tint", UNIT, spec_tint)?;
    t.number("clearcoat", UNIT, clearcoat)?;
    t.number("clearcoat_gloss", UNIT, clearcoat_gloss)?;
    t.number("sheen", UNIT, sheen)?;
    t.number("sheen_tint", UNIT, sheen_tint)
}

/// `eta` and `k`, both or neither.
fn index(t: &mut Reader, eta_k: &mut Option<(Rgb, Rgb)>) -> Result<(), Fault> {
    let (mut eta, mut k) = eta_k.unwrap_or_default();
    t.color("eta", POSITIVE, &mut eta)?;
    t.color("k", NOT_NEGATIVE, &mut k)?;
    if eta_k.is_none() && t.has("eta") != t.has("k") {
        let at = t.place(&["eta", "k"]);
        return Err(Fault::new(at, "`eta` and `k` go together, but only one is given"));
    }
    if t.has("eta") || t.has("k") {
        *eta_k = Some((eta, k));
    }
    Ok(())
}

fn iors(t: &mut Reader, int_ior: &mut f32, ext_ior: &mut f32) -> Result<(), Fault> {
    t.number("int_ior", POSITIVE, int_ior)?;
    t.number("ext_ior", POSITIVE, ext_ior)
}

fn roughness(t: &mut Reader, alpha: &mut f32, distribution: &mut MicrofacetDistribution) -> Result<(), Fault> {
    t.number("alpha", UNIT, alpha)?;
    t.choice("distribution", DISTRIBUTIONS, distribution)
}

/// What a surface sends on is at most what it gets; pictures are checked when they are read.
fn check_sum(t: &Reader, r: &ColorTexture, tr: &ColorTexture) -> Result<(), Fault> {
    let (ColorTexture::Constant(r), ColorTexture::Constant(tr)) = (r, tr) else { return Ok(()) };
    // Leaves room for decimal fractions whose rounded sum is a little above 1.
    if (*r + *tr).max_element() <= 1.0 + 1e-6 {
        return Ok(());
    }
    let at = t.place(&["transmittance", "reflectance"]);
    Err(Fault::new(at, "`reflectance` and `transmittance` must not add up to more than 1"))
}
