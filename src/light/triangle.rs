//! Triangles that emit.

use super::tree::LightBounds;
use super::{EmitterPattern, LightPoint, Rounding, check_light, wide_luminance};
use crate::Result;
use crate::geometry::rounding::{ROUNDING, across, thinness, unit};
use crate::math::{Rgb, warp};
use glam::Vec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// A triangle that emits the same radiance in all directions of one side, or of both; from point to point it may vary.
#[derive(Clone)]
pub(crate) struct EmissiveTriangle {
    /// Which triangle of which mesh of the scene this is: what a ray reports when it hits.
    pub mesh: u32,
    pub triangle: u32,
    /// World space, counter-clockwise seen from the side that emits.
    pub corners: [Vec3; 3],
    /// W/(sr·m²). Where the triangle lets the same share of light pass everywhere, this is the mean over the rays that
    /// arrive: what those see that it stops, times the share that it stops. Of a picture it is the brightest texel.
    pub radiance: Rgb,
    pub two_sided: bool,
    /// Number of its light group.
    pub group: u32,
    /// By which `radiance` is multiplied from point to point; `None`: 1 everywhere.
    pub pattern: Option<Arc<dyn EmitterPattern>>,
    /// How far across its plane the triangle may be from where rays meet it, for other reasons than the rounding of these
    /// corners: that of an instance's transform.
    pub slack: f32,
}

/// An emissive triangle, ready to be sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct AreaLight {
    pub(super) origin: Vec3,
    pub(super) edges: [Vec3; 2],
    /// Unit, by the winding.
    pub(super) normal: Vec3,
    /// Of its points by area, 1/m²: of uniform ones, where nothing else is said.
    pub(super) density: f32,
    pub(super) radiance: Rgb,
    pub(super) two_sided: bool,
    pub(super) error: Rounding,
}

/// Rounding in Embree's distance to a triangle from afar, in units of half an ulp: 8 for the numerator
/// ([`crate::geometry::rounding`]), 6 for the denominator, 2 for the quotient and the direction.
const OF_DISTANCE: f32 = 16.0;

/// A point on an emissive triangle as it is seen from the lit point.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub surface: LightPoint,
    /// Unit, to the light; undefined where `pdf` is 0.
    pub wi: Vec3,
    /// Per steradian there, the choice of the light included; 0 where nothing arrives.
    pub pdf: f32,
}

impl AreaLight {
    /// The light and its area, m². `None` for a triangle that emits nothing: without area or without radiance.
    pub fn new(t: &EmissiveTriangle) -> Result<Option<(AreaLight, f64)>> {
        let edges = [t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]];
        let finite = t.corners.iter().chain(&edges).all(|c| c.is_finite());
        let name = format!("emissive triangle {} of mesh {}", t.triangle, t.mesh);
        check_light(t.radiance, finite, &name)?;
        let [a, b, c] = t.corners.map(|c| c.as_dvec3());
        let cross = (b - a).cross(c - a);
        let Some(normal) = cross.try_normalize() else { return Ok(None) };
        if t.radiance == Rgb::ZERO {
            return Ok(None);
        }
        let area = 0.5 * cross.length();
        let light = AreaLight {
            origin: t.corners[0],
            edges,
            normal: normal.as_vec3(),
            density: (1.0 / area) as f32,
            radiance: t.radiance,
            two_sided: t.two_sided,
            error: rounding(t, edges, normal.as_vec3()),
        };
        Ok(Some((light, area)))
    }

    /// W: luminance · π · area · sides, where `mean` is that of its pattern.
    pub fn power(&self, area: f64, mean: Rgb) -> f64 {
        self.intensity(area, mean) * PI * if self.two_sided { 2.0 } else { 1.0 }
    }

    /// What a light tree chooses by.
    pub fn bounds(&self, area: f64, mean: Rgb) -> LightBounds {
        let corners = [self.origin, self.origin + self.edges[0], self.origin + self.edges[1]];
        let centre = (corners[0] / 3.0 + corners[1] / 3.0) + corners[2] / 3.0;
        LightBounds {
            lo: corners[0].min(corners[1]).min(corners[2]),
            hi: corners[0].max(corners[1]).max(corners[2]),
            centre,
            radius: corners.iter().map(|corner| corner.distance(centre)).fold(0.0, f32::max),
            thickness: corners.iter().map(|&corner| (corner - centre).dot(self.normal).abs()).fold(0.0, f32::max),
            axis: self.normal,
            two_sided: self.two_sided,
            intensity: self.intensity(area, mean),
        }
    }

    /// Whether it makes one flat patch with the triangle `other`: they share an edge and a plane but for rounding, and shine
    /// alike.
    pub fn continues(&self, other: &AreaLight) -> bool {
        let corners = |light: &AreaLight| [light.origin, light.origin + light.edges[0], light.origin + light.edges[1]];
        let one = |a: Vec3, b: Vec3| (a - b).abs().max_element() <= 4.0 * f32::EPSILON * a.abs().max_element();
        let shared = corners(self).iter().filter(|&&a| corners(other).iter().any(|&b| one(a, b))).count();
        let alike = (self.radiance, self.two_sided) == (other.radiance, other.two_sided);
        // smaller angles than the tree can tell
        alike && shared == 2 && self.normal.distance(other.normal) < 1.0 / 4096.0
    }

    /// Luminance of the intensity along the normal, W/sr.
    fn intensity(&self, area: f64, mean: Rgb) -> f64 {
        // the pattern is at most 1, and may be small: the product with the radiance must not leave the range of an f32
        let largest = self.radiance.max_element();
        let bright = if largest > 0.0 { wide_luminance(self.radiance / largest * mean) * largest as f64 } else { 0.0 };
        bright * area
    }

    /// The same light where points are drawn with another density, `factor` times as large: that of the light's choice for
    /// example.
    #[inline]
    pub fn denser(self, factor: f32) -> AreaLight {
        AreaLight { density: self.density * factor, ..self }
    }

    /// A point, uniform by area.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> LightPoint {
        let [b1, b2] = warp::square_to_triangle(u);
        let point = self.origin + (self.edges[0] * b1 + self.edges[1] * b2);
        LightPoint { point, normal: self.normal, error: self.error }
    }

    /// A point, and how it is seen from `p`. Without a jump, so that a loop over many runs in vectors.
    #[inline(always)]
    pub fn sample_from(&self, p: Vec3, u: [f32; 2]) -> View {
        let surface = self.sample(u);
        let to_light = surface.point - p;
        let distance = to_light.length();
        // where `p` is behind the light, or on it, the density is 0
        let pdf = self.pdf_along(to_light, distance);
        View { surface, wi: to_light / distance, pdf }
    }

    /// Density per steradian, seen from `p`, of the point `y` drawn uniformly by area: pmf·d²/(A·cosθ), with θ at the light,
    /// the choice of the light included. 0 where `p` is behind or in the plane, or where the density is too large for an
    /// `f32`: nothing is drawn there.
    pub fn pdf(&self, p: Vec3, y: Vec3) -> f32 {
        let to_light = y - p;
        self.pdf_along(to_light, to_light.length())
    }

    /// [`Self::pdf`] where the way to the point and its length are known. Coordinates have squares within an `f32`
    /// ([`crate::embree::LARGEST_COORDINATE`]), but not cubes: d/(d·cosθ) comes first.
    #[inline(always)]
    fn pdf_along(&self, to_light: Vec3, distance: f32) -> f32 {
        let facing = self.emitting_cosine(-to_light.dot(self.normal));
        let pdf = self.density * (distance * distance) * (distance / facing);
        if (facing > 0.0) & (pdf <= f32::MAX) { pdf } else { 0.0 }
    }

    #[inline(always)]
    fn emitting_cosine(&self, cos: f32) -> f32 {
        if self.two_sided { cos.abs() } else { cos }
    }
}

/// What rounding does to a triangle, whichever of its points is looked at.
fn rounding(t: &EmissiveTriangle, edges: [Vec3; 2], normal: Vec3) -> Rounding {
    let (_, per_length) = unit(edges[0].cross(edges[1]));
    let size = edges[0].abs().max(edges[1].abs());
    let largest = t.corners.iter().fold(Vec3::ZERO, |largest, c| largest.max(c.abs()));
    let near = across(edges, largest, size, normal, per_length) + t.slack;
    Rounding { near, far: OF_DISTANCE * ROUNDING * thinness(edges, per_length).length() }
}
