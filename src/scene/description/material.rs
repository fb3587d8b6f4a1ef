//! Materials and textures as written.

use crate::math::Rgb;
use std::path::PathBuf;

/// A surface material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    pub bsdf: BsdfDescription,
    /// Scatters alike on both sides; else the back of an opaque material is black.
    pub two_sided: bool,
    /// Share of light that is stopped; the rest passes straight through.
    pub opacity: Option<ScalarTexture>,
    /// Radiance (W/(sr·m²)) leaving the side of the face's winding.
    pub emission: Rgb,
    /// Both sides emit.
    pub emission_two_sided: bool,
}

impl Default for MaterialDescription {
    fn default() -> MaterialDescription {
        MaterialDescription {
            bsdf: BsdfDescription::Diffuse { reflectance: ColorTexture::Constant(Rgb::splat(0.5)) },
            two_sided: true,
            opacity: None,
            emission: Rgb::ZERO,
            emission_two_sided: false,
        }
    }
}

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

/// A colour, constant or from a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum ColorTexture {
    Constant(Rgb),
    Image(ImageTexture),
}

/// A number, constant or from a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum ScalarTexture {
    Constant(f32),
    /// The alpha channel where the picture has one, else its luminance as stored (not decoded from sRGB).
    Image(ImageTexture),
    /// The luminance as stored, whatever the alpha channel says.
    Luminance(ImageTexture),
}

/// A picture on a surface. v points up: (0, 0) is the lower left corner. Outside of [0, 1) it repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageTexture {
    pub path: PathBuf,
    /// Multiplies (u, v) first.
    pub scale: [f32; 2],
    /// Then added.
    pub offset: [f32; 2],
    /// Nearest texel instead of bilinear.
    pub nearest: bool,
    /// Multiplies the picture.
    pub tint: Rgb,
}
