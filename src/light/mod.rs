//! Where light comes from: emissive triangles, the surroundings, points and far suns, and one sampler over them all.
//!
//! Everything is in world space. Directions `wi` are unit vectors from the lit point towards the light; densities are
//! per steradian there. A light is chosen by what it may send to the lit point, or by its power alone ([`LightSampler`]).

#[macro_use]
mod list;

mod choice;
mod constant;
mod directional;
mod environment;
mod leaves;
mod lights;
pub(crate) mod octahedral;
mod pattern;
mod point;
mod samples;
mod sky;
mod source;
mod spot;
mod sun;
#[cfg(test)]
mod tests;
mod tree;
mod triangle;
mod unit;

pub(crate) use lights::Lights;
pub(crate) use pattern::EmitterPattern;
#[cfg(test)]
pub(crate) use point::PointLight;
pub(crate) use samples::LightSamples;
pub(crate) use source::Findings;
pub(crate) use triangle::EmissiveTriangle;
pub(crate) use unit::LightUnit;

use crate::fields::{FieldVisitor, Fields};
use crate::geometry::Ray;
use crate::math::{Rgb, luminance};
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes};
use crate::{Error, Result};
use glam::{DVec3, Vec3};
pub(crate) use source::LightSource;
use source::{Extent, LightParameters};

// What a type of light is called in scene files, its parameters, and what samples it.
lights! {
    "constant" = Constant(constant::ConstantLight) => constant::ConstantLight;
    "environment" = Environment(environment::EnvironmentLight) => Box<environment::Environment>;
    "point" = Point(point::PointLightParameters) => point::PointLight;
    "directional" = Directional(directional::DirectionalLight) => directional::DirectionalLight;
    "sun" = Sun(sun::SunLight) => sun::SunDisc;
    "sky" = Sky(sky::SkyLight) => sky::Sky;
    "spot" = Spot(spot::SpotLightParameters) => spot::SpotLight;
}

/// How next-event estimation chooses a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSampler {
    /// By a light hierarchy: power, distance, and orientation of light and surface.
    Tree,
    /// By power alone.
    Power,
}

impl LightSampler {
    /// What scene files call them.
    pub(crate) const NAMES: &'static [(&'static str, LightSampler)] =
        &[("tree", LightSampler::Tree), ("power", LightSampler::Power)];
}

/// A point that is to be lit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSampleContext {
    pub p: Vec3,
    /// Unit; only light from its side counts. Zero where light counts from everywhere: on surfaces that let light through.
    pub n: Vec3,
}

impl LightSampleContext {
    /// A point to which light counts from everywhere.
    pub fn unoriented(p: Vec3) -> LightSampleContext {
        LightSampleContext { p, n: Vec3::ZERO }
    }
}

/// What next-event estimation gets: the contribution of the light is f(wo, wi)·|cosθi|·`radiance`/`pdf` where nothing
/// stands between.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit, from the lit point to the light.
    pub wi: Vec3,
    /// Radiance from `wi`, W/(sr·m²). For a delta light the irradiance (W/m²) on a surface that faces it.
    pub radiance: Rgb,
    /// Density of `wi` per steradian, the choice of the light included. For a delta light the probability of its choice.
    /// Positive and finite.
    pub pdf: f32,
    /// Whether no direction drawn otherwise can meet the light (it takes no part in MIS).
    pub delta: bool,
    /// Where a shadow ray is to end; `None` for lights at infinity.
    pub target: Option<LightPoint>,
}

impl LightSample {
    /// One of a light at infinity.
    fn far(wi: Vec3, radiance: Rgb, pdf: f32, delta: bool) -> LightSample {
        LightSample { wi, radiance, pdf, delta, target: None }
    }

    /// The ray from `origin`, just off the lit surface, that must reach the light.
    #[inline]
    pub fn shadow_ray(&self, origin: Vec3) -> Ray {
        let Some(target) = self.target else { return Ray { org: origin, dir: self.wi, tfar: f32::INFINITY } };
        // aimed anew: the origin is not quite the point that the light was drawn from
        let way = target.point - origin;
        let distance = way.length();
        let dir = way / distance;
        Ray { org: origin, dir, tfar: target.open_way(dir, distance) }
    }
}

/// A point on an emissive triangle, or a point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPoint {
    pub point: Vec3,
    /// Unit geometric normal by the winding of the corners; an emitter with two sides may be seen from behind. Zero for a
    /// point light.
    pub normal: Vec3,
    /// How wrong rounding may put the triangle, across its plane.
    pub(crate) error: Rounding,
}

/// How far rounding may put an emissive triangle beside its points, as a ray sees it from a distance d: `near` + `far`·d.
/// Zeros for a point light, which no ray meets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Rounding {
    pub near: f32,
    pub far: f32,
}

impl LightPoint {
    /// How far a shadow ray along the unit vector `dir` goes of its way `distance` to the light: so near that nothing of
    /// what can be told from the light is left out, and not so far that the light shadows itself. 0 where that cannot be
    /// told apart, which is where the light is seen almost from the side.
    #[inline(always)]
    fn open_way(&self, dir: Vec3, distance: f32) -> f32 {
        let cosine = dir.dot(self.normal).abs().max(f32::MIN_POSITIVE);
        (distance - (self.error.near + self.error.far * distance) / cosine).max(0.0)
    }
}

/// An error that names `what` unless `colour` is finite and not negative and its other numbers, by `usable`, are fit.
fn check_light(colour: Rgb, usable: bool, what: &str) -> Result<()> {
    if usable && colour.is_finite() && colour.min_element() >= 0.0 {
        Ok(())
    } else {
        Err(Error::Scene(format!("{what} has a negative, infinite or undefined number, or no direction")))
    }
}

/// A colour times a factor that may be beyond an `f32`.
fn scaled(c: Rgb, factor: f64) -> Rgb {
    (c.as_dvec3() * factor).as_vec3()
}

/// Luminance in double precision: powers are summed over lights that may differ by twenty orders of magnitude.
fn wide_luminance(c: Rgb) -> f64 {
    let largest = c.max_element();
    // scaled, so that neither faint nor strong colours leave the range of an f32
    if largest > 0.0 { luminance(c / largest) as f64 * largest as f64 } else { 0.0 }
}
