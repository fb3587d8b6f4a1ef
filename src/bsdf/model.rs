//! From what a scene file says of a material to the BSDF at a point: everything but the colours is prepared once.

use super::lanes::{LobeNumbers, SameMaterial};
use super::{Bsdf, BsdfDescription, BsdfKind, BsdfTables, Model, Scatter};
use crate::fields::{Fields, each_share, each_texture};
use crate::math::Rgb;
use crate::simd::{Lanes, Vec3Lanes};
use crate::texture::{ColorTexture, ScalarTexture};
use crate::{Error, Result};

/// A type of scattering as written. Defaults are what it is when only its `type` is given.
pub(crate) trait BsdfParameters: Default + Fields {
    /// Stands for the type in a scene's hash: it never changes, and none is used twice.
    const NUMBER: u32;
    /// Whether light never crosses the surface, so that it has a back that may be black: `two_sided` is a key of it.
    const OPAQUE: bool;
    /// Whether there is a surface at all, which `opacity` can make holes in.
    const IS_SURFACE: bool = true;

    /// Checks the numbers and prepares what does not depend on the place. [`Error::Scene`] names the parameter that is out
    /// of its domain. (A scene file is checked when it is read; this is for descriptions from elsewhere.)
    fn model(&self, tables: &mut BsdfTables) -> Result<Model>;
}

/// A kind of scattering for a whole material.
pub(crate) trait Prepared {
    /// The same at one point.
    type At<'s>: Scatter
    where
        Self: 's;

    /// Makes of the textures' colours, in the order of the fields, what [`Self::at`] wants: what is worth to be computed
    /// once for a place.
    #[inline(always)]
    fn colors(&self, textures: [Rgb; 2]) -> [Rgb; 2] {
        textures
    }

    fn at(&self, colors: [Rgb; 2]) -> Self::At<'_>;

    /// Whether a packet's surfaces of this material are worth to be evaluated side by side: where nothing of it takes a call or a
    /// jump for each lane, so that the two loops below become vector instructions.
    fn in_lanes(&self) -> bool {
        false
    }

    /// [`Scatter::eval_pdf`] of surfaces of this material.
    fn eval_pdf_lanes(&self, surfaces: &SameMaterial, wi: &Vec3Lanes, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        surfaces.eval_pdf(wi, |colors| self.at(colors), f, pdf);
    }

    /// Whether the same holds for drawing from them, of which no lobe is then a delta distribution.
    fn draws_in_lanes(&self) -> bool {
        false
    }

    /// The directions that [`Scatter::sample`] draws from surfaces of this material.
    fn draw_lanes(&self, surfaces: &SameMaterial, numbers: &LobeNumbers, wi: &mut Vec3Lanes) {
        let sample = |colors, wo, lobe, u, _| self.at(colors).sample(wo, lobe, u).map(|sample| sample.wi);
        surfaces.draw(numbers, sample, wi);
    }

    /// [`Scatter::albedo`] of surfaces of this material.
    fn albedo_lanes(&self, surfaces: &SameMaterial, albedo: &mut Vec3Lanes) {
        surfaces.albedo(|colors| self.at(colors), albedo);
    }
}

/// A material's scattering without its textures' colours.
#[derive(Clone, Debug)]
pub struct BsdfModel {
    model: Model,
    /// Whether any lobe is smooth.
    smooth: bool,
    /// Whether light never crosses the surface.
    opaque: bool,
    /// Opaque and two-sided: seen from behind, it scatters like its mirror image about the surface.
    turns: bool,
    /// As [`Bsdf::roughness`].
    roughness: f32,
    in_lanes: bool,
    draws_in_lanes: bool,
}

/// The colours that [`BsdfModel::at`] wants, in its order.
pub(crate) fn color_textures(description: &BsdfDescription) -> [Option<ColorTexture>; 2] {
    let (mut found, mut count) = ([None, None], 0);
    each_texture(&mut description.clone(), |texture| {
        found[count] = Some(texture.clone());
        count += 1;
    });
    found
}

/// Numbers of which some are pictures, in the order in which [`BsdfModel::at`] wants them in its second colour; `None` where all of them
/// are constant.
pub(crate) fn share_textures(description: &BsdfDescription) -> Option<Vec<(f32, Option<ScalarTexture>)>> {
    let mut found = Vec::new();
    each_share(&mut description.clone(), |number, map| found.push((*number, map.clone())));
    found.iter().any(|(_, map)| map.is_some()).then_some(found)
}

impl BsdfModel {
    /// Checks the numbers and prepares what does not depend on the place; `tables` keeps tables for other
    /// materials. [`Error::Scene`] names the parameter that is out of its domain.
    pub fn new(description: &BsdfDescription, two_sided: bool, tables: &mut BsdfTables) -> Result<BsdfModel> {
        let model = description.model(tables)?;
        let (smooth, opaque, roughness) = model.at([Rgb::ZERO; 2]).traits();
        // two-sided means nothing for kinds that let light through
        let (in_lanes, draws_in_lanes) = (model.in_lanes(), model.draws_in_lanes());
        Ok(BsdfModel { model, smooth, opaque, turns: two_sided && opaque, roughness, in_lanes, draws_in_lanes })
    }

    /// The BSDF where the textures of the description, in their order, have these values.
    #[inline]
    pub fn at(&self, colors: [Rgb; 2]) -> Bsdf<'_> {
        Bsdf { model: self, colors: if self.is_diffuse() { colors } else { self.model.colors(colors) }, normal: None }
    }

    #[inline(always)]
    pub(super) fn kind(&self, colors: [Rgb; 2]) -> BsdfKind<'_> {
        self.model.at(colors)
    }

    #[inline(always)]
    pub(crate) fn is_diffuse(&self) -> bool {
        matches!(self.model, Model::Diffuse(_))
    }

    /// As of [`Prepared::in_lanes`].
    pub(super) fn in_lanes(&self) -> bool {
        self.in_lanes
    }

    /// [`Bsdf::eval_pdf`] of the surfaces of a packet that are of this material, about the normals of their shading frames.
    pub(super) fn eval_pdf_lanes(&self, surfaces: &SameMaterial, wi: &Vec3Lanes, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        self.model.eval_pdf_lanes(surfaces, wi, f, pdf);
    }

    /// As of [`Prepared::draws_in_lanes`].
    pub(super) fn draws_in_lanes(&self) -> bool {
        self.draws_in_lanes
    }

    /// Directions as of [`Bsdf::sample`] of the same.
    pub(super) fn draw_lanes(&self, surfaces: &SameMaterial, numbers: &LobeNumbers, wi: &mut Vec3Lanes) {
        self.model.draw_lanes(surfaces, numbers, wi);
    }

    /// [`Bsdf::albedo`] of the same.
    pub(super) fn albedo_lanes(&self, surfaces: &SameMaterial, albedo: &mut Vec3Lanes) {
        self.model.albedo_lanes(surfaces, albedo);
    }

    #[inline(always)]
    pub(super) fn smooth(&self) -> bool {
        self.smooth
    }

    #[inline(always)]
    pub(super) fn opaque(&self) -> bool {
        self.opaque
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

pub(super) fn checked_color(color: Rgb, name: &str) -> Result<()> {
    if color.is_finite() && color.min_element() >= 0.0 {
        Ok(())
    } else {
        Err(out_of_domain(name, "finite and not negative"))
    }
}

pub(super) fn out_of_domain(name: &str, domain: &str) -> Error {
    Error::Scene(format!("{name} must be {domain}"))
}
