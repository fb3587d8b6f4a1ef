//! Kinds of scattering as written.

use crate::math::Rgb;
use crate::texture::ColorTexture;

/// The kinds of scattering. `alpha` is the roughness of the microfacet distribution; 0 is smooth.
#[derive(Clone, Debug, PartialEq)]
pub enum BsdfDescription {
    Diffuse {
        reflectance: ColorTexture,
    },
    /// Two Lambertian lobes, one on each side.
    DiffuseTransmitter {
        reflectance: ColorTexture,
        transmittance: ColorTexture,
    },
    /// Metal: complex index of refraction `eta` + i`k`; `None` reflects all (a perfect mirror for `alpha` 0).
    Conductor {
        eta_k: Option<(Rgb, Rgb)>,
        specular_reflectance: ColorTexture,
        alpha: f32,
        distribution: MicrofacetDistribution,
    },
    /// Glass and water. `thin`: a pane whose two sides are one surface, so rays pass without bending.
    Dielectric {
        int_ior: f32,
        ext_ior: f32,
        specular_reflectance: Rgb,
        specular_transmittance: Rgb,
        alpha: f32,
        distribution: MicrofacetDistribution,
        thin: bool,
    },
    /// A diffuse base under a dielectric coat.
    Plastic {
        reflectance: ColorTexture,
        specular_reflectance: Rgb,
        int_ior: f32,
        ext_ior: f32,
        alpha: f32,
        distribution: MicrofacetDistribution,
        /// Colour shifts by internal scattering are taken into account.
        nonlinear: bool,
    },
    /// Disney's principled model (Burley 2012), opaque, isotropic: diffuse, metallic and clear-coat lobes.
    Principled {
        base_color: ColorTexture,
        metallic: f32,
        roughness: f32,
        specular: f32,
        spec_tint: f32,
        clearcoat: f32,
        clearcoat_gloss: f32,
        sheen: f32,
        sheen_tint: f32,
    },
    /// Lets everything through.
    Null,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MicrofacetDistribution {
    #[default]
    Ggx,
    Beckmann,
}
