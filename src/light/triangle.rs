//! Triangles that emit.

use super::{LightPoint, check_light, wide_luminance};
use crate::Result;
use crate::math::{Rgb, warp};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// A triangle that emits the same radiance everywhere and in all directions of one side, or of both.
#[derive(Clone, Copy, Debug)]
pub struct EmissiveTriangle {
    /// Which triangle of which mesh of the scene this is: what a ray reports when it hits.
    pub mesh: u32,
    pub triangle: u32,
    /// World space, counter-clockwise seen from the side that emits.
    pub corners: [Vec3; 3],
    /// W/(sr·m²).
    pub radiance: Rgb,
    pub two_sided: bool,
}

/// An emissive triangle, ready to be sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct AreaLight {
    pub(super) origin: Vec3,
    pub(super) edges: [Vec3; 2],
    /// Unit, by the winding.
    pub(super) normal: Vec3,
    /// m²; double precision, so that no triangle is too small.
    pub(super) area: f64,
    pub(super) radiance: Rgb,
    pub(super) two_sided: bool,
}

/// A point on an emissive triangle as it is seen from the lit point.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub surface: LightPoint,
    /// Unit, to the light; undefined where `pdf` is 0.
    pub wi: Vec3,
    pub distance: f32,
    /// Per steradian there, the choice of the light left out; 0 where nothing arrives.
    pub pdf: f64,
}

impl AreaLight {
    /// `None` for a triangle that emits nothing: without area or without radiance.
    pub fn new(t: &EmissiveTriangle) -> Result<Option<AreaLight>> {
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
        Ok(Some(AreaLight {
            origin: t.corners[0],
            edges,
            normal: normal.as_vec3(),
            area: 0.5 * cross.length(),
            radiance: t.radiance,
            two_sided: t.two_sided,
        }))
    }

    /// W: luminance · π · area · sides.
    pub fn power(&self) -> f64 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        wide_luminance(self.radiance) * PI * self.area * sides
    }

    /// A point, uniform by area.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> LightPoint {
        let [b1, b2] = warp::square_to_triangle(u);
        let point = self.origin + self.edges[0] * b1 + self.edges[1] * b2;
        LightPoint { point, normal: self.normal }
    }

    /// A point, and how it is seen from `p`. Without a jump, so that a loop over many runs in vectors.
    #[inline(always)]
    pub fn sample_from(&self, p: Vec3, u: [f32; 2]) -> View {
        let surface = self.sample(u);
        let to_light = (surface.point - p).as_dvec3();
        let distance = to_light.length();
        // where `p` is behind the light, or on it, the density is 0
        let pdf = self.pdf_along(to_light, distance);
        View { surface, wi: (to_light / distance).as_vec3(), distance: distance as f32, pdf }
    }

    /// Density per steradian, seen from `p`, of the point `y` drawn uniformly by area: d²/(A·cosθ), with θ at the light.
    /// 0 where `p` is behind or in the plane, or where the density is too large for an `f32`: nothing is drawn there.
    pub fn pdf(&self, p: Vec3, y: Vec3) -> f64 {
        let to_light = (y - p).as_dvec3();
        self.pdf_along(to_light, to_light.length())
    }

    /// [`Self::pdf`] where the way to the point and its length are known: d²/(A·cosθ) is d³/(A·d·cosθ).
    #[inline(always)]
    fn pdf_along(&self, to_light: DVec3, distance: f64) -> f64 {
        let facing = self.emitting_cosine(-to_light.dot(self.normal.as_dvec3()));
        let pdf = distance * distance * distance / (self.area * facing);
        if facing > 0.0 && pdf <= f32::MAX as f64 { pdf } else { 0.0 }
    }

    /// Radiance on the side that emits.
    pub fn emitted(&self) -> Rgb {
        self.radiance
    }

    /// Radiance leaving along `wo` (unit, away from the light).
    pub fn radiance(&self, wo: Vec3) -> Rgb {
        if self.emitting_cosine(self.normal.dot(wo) as f64) > 0.0 { self.radiance } else { Rgb::ZERO }
    }

    #[inline(always)]
    fn emitting_cosine(&self, cos: f64) -> f64 {
        if self.two_sided { cos.abs() } else { cos }
    }
}
