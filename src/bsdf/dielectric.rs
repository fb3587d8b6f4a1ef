//! Clear glass and water, as a body and as a pane.

use super::{BLACK, BsdfSample, Scatter, choice, fresnel};
use crate::math::Rgb;
use glam::Vec3;

/// A smooth interface; `eta` is the index below the surface over that above.
#[derive(Clone, Copy, Debug)]
pub struct Dielectric {
    pub eta: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

/// Index of the side that light from `wo` is refracted into over that of `wo`'s side.
#[inline]
pub(super) fn relative_index(eta: f32, wo: Vec3) -> f32 {
    if wo.z > 0.0 { eta } else { 1.0 / eta }
}

impl Scatter for Dielectric {
    const SMOOTH: bool = false;
    const OPAQUE: bool = false;

    fn eval_pdf(&self, _wo: Vec3, _wi: Vec3) -> (Rgb, f32) {
        BLACK
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let eta = relative_index(self.eta, wo);
        let (f, cos_t) = fresnel::dielectric(wo.z.abs(), eta);
        let (reflected, transmitted) = (f * self.reflectance, (1.0 - f) * self.transmittance);
        let p = choice(reflected, transmitted)?;
        if u_lobe < p {
            return BsdfSample::delta(Vec3::new(-wo.x, -wo.y, wo.z), reflected, p, 1.0);
        }
        let wi = Vec3::new(-wo.x / eta, -wo.y / eta, -cos_t.copysign(wo.z));
        BsdfSample::delta(wi, transmitted / (eta * eta), 1.0 - p, eta)
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        let (f, _) = fresnel::dielectric(wo.z.abs(), relative_index(self.eta, wo));
        f * self.reflectance + (1.0 - f) * self.transmittance
    }

    fn roughness(&self) -> f32 {
        0.0
    }
}

/// A pane whose two faces are one surface: light passes without bending. Reflections between the faces are
/// summed: R = F + (1 − F)²F/(1 − F²) = 2F/(1 + F).
#[derive(Clone, Copy, Debug)]
pub struct ThinDielectric {
    pub eta: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

impl ThinDielectric {
    /// What is reflected and what passes.
    fn split(&self, wo: Vec3) -> (Rgb, Rgb) {
        let (f, _) = fresnel::dielectric(wo.z.abs(), self.eta);
        let r = 2.0 * f / (1.0 + f);
        (r * self.reflectance, (1.0 - r) * self.transmittance)
    }
}

impl Scatter for ThinDielectric {
    const SMOOTH: bool = false;
    const OPAQUE: bool = false;

    fn eval_pdf(&self, _wo: Vec3, _wi: Vec3) -> (Rgb, f32) {
        BLACK
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let (reflected, transmitted) = self.split(wo);
        let p = choice(reflected, transmitted)?;
        if u_lobe < p {
            BsdfSample::delta(Vec3::new(-wo.x, -wo.y, wo.z), reflected, p, 1.0)
        } else {
            BsdfSample::delta(-wo, transmitted, 1.0 - p, 1.0)
        }
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        let (reflected, transmitted) = self.split(wo);
        reflected + transmitted
    }

    fn roughness(&self) -> f32 {
        0.0
    }
}
