//! A glossy reflection, as far as directions are weighed by it.

use crate::math::Frame;
use crate::simd::{LANES, Lanes, Vec3Lanes, pick};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// One lobe of microfacets over a diffuse base, seen from a direction. What directions are weighed by need not be the
/// BSDF, only resemble it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlossyLobe {
    /// To the viewer, and the surface's normal on that side: unit, in one frame.
    pub wo: Vec3,
    pub n: Vec3,
    /// Roughness α.
    pub alpha: f32,
    /// Albedos (luminance) of the lobe and of the base.
    pub specular: f32,
    pub diffuse: f32,
}

impl GlossyLobe {
    pub(super) fn in_frame(self, frame: &Frame) -> GlossyLobe {
        GlossyLobe { wo: frame.to_local(self.wo), n: frame.to_local(self.n), ..self }
    }

    /// What is reflected from cells of directions, by their centres and their size: the BSDF, without the cosine, about as its mean
    /// over the cell. 0 from below the surface.
    ///
    /// The lobe is that of GGX, widened by the cell: the half-vectors of the directions in a cell of Ω sr fill Ω/(4 cosθd) sr, and the
    /// mean square of their angle to the middle one is 1/(2π) of that, as α² is that of the slope of facets. Both add up:
    /// α'² = α² + Ω/(8π cosθd).
    #[inline(always)]
    pub(super) fn reflected(&self, centres: &Vec3Lanes, solid_angle: f32, values: &mut Lanes) {
        let (wo, n, a2) = (self.wo, self.n, self.alpha * self.alpha);
        let cos_o = n.dot(wo).max(1e-3);
        // G1(wo)/(4 cosθo), of Smith's G1
        let masking = 0.5 / (cos_o + (cos_o * cos_o + a2 * (1.0 - cos_o * cos_o)).max(0.0).sqrt());
        let specular = self.specular * masking * FRAC_1_PI;
        let base = self.diffuse * FRAC_1_PI;
        let widening = solid_angle / (8.0 * PI);
        // a cell at the horizon has the mean cosine of a half disk, 4/3π of its radius √(Ω/π)
        let least_cos = 4.0 / (3.0 * PI) * (solid_angle * FRAC_1_PI).sqrt();
        for k in 0..LANES {
            let wi = centres.get(k);
            let (cos_i, cos_2d) = (n.dot(wi), wo.dot(wi));
            let cos2_d = (0.5 + 0.5 * cos_2d).max(1e-4);
            let a2 = a2 + widening / cos2_d.sqrt();
            let cos_h = 0.5 * (cos_o + cos_i);
            let t = 1.0 + (a2 - 1.0) * (cos_h * cos_h / cos2_d).min(1.0);
            let value = base + specular * a2 / (t * t * cos_i.max(least_cos));
            values[k] = pick(cos_i > 0.0, value, 0.0);
        }
    }
}
