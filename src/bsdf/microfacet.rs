//! Isotropic microfacet distributions with Smith's shadowing, uncorrelated: G = G1(wo)·G1(wi)
//! (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces").

use crate::fields::Choice;
use crate::math::ONE_MINUS_EPSILON;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// 1/√π.
const FRAC_1_SQRT_PI: f32 = 0.564_189_6;

/// How the normals of facets are distributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MicrofacetDistribution {
    #[default]
    Ggx,
    Beckmann,
}

impl Choice for MicrofacetDistribution {
    const NAMES: &'static [(&'static str, MicrofacetDistribution)] =
        &[("ggx", MicrofacetDistribution::Ggx), ("beckmann", MicrofacetDistribution::Beckmann)];
}

/// The microscopic normals of a rough surface. All normals `m` are unit, local, with m.z > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Microfacet {
    alpha: f32,
    kind: MicrofacetDistribution,
}

impl Microfacet {
    /// Below this, single precision no longer resolves the lobe.
    pub const MIN_ALPHA: f32 = 1e-4;

    /// `alpha` is the roughness (Beckmann: √2 times the standard deviation of a slope); raised to [`Self::MIN_ALPHA`].
    #[inline(always)]
    pub fn new(kind: MicrofacetDistribution, alpha: f32) -> Microfacet {
        Microfacet { alpha: alpha.max(Microfacet::MIN_ALPHA), kind }
    }

    /// The same where it is known already that the distribution is GGX: a loop over lanes that is told so has no call and no jump.
    #[inline(always)]
    pub fn known_as_ggx(self) -> Microfacet {
        debug_assert_eq!(self.kind, MicrofacetDistribution::Ggx);
        Microfacet { kind: MicrofacetDistribution::Ggx, ..self }
    }

    pub fn is_ggx(&self) -> bool {
        self.kind == MicrofacetDistribution::Ggx
    }

    #[inline(always)]
    pub fn alpha(&self) -> f32 {
        self.alpha
    }

    pub fn kind(&self) -> MicrofacetDistribution {
        self.kind
    }

    /// D(m): area of facets per area of surface and steradian (Walter et al. 2007, eqs. 25 and 33).
    #[inline(always)]
    pub fn d(&self, m: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        let (sin2, cos2) = (m.x * m.x + m.y * m.y, m.z * m.z);
        match self.kind {
            MicrofacetDistribution::Ggx => {
                let t = sin2 / a2 + cos2;
                FRAC_1_PI / (a2 * t * t)
            }
            // the exponential vanishes long before 1/cos⁴ overflows
            MicrofacetDistribution::Beckmann if cos2 < 1e-10 => 0.0,
            MicrofacetDistribution::Beckmann => FRAC_1_PI * (-sin2 / (a2 * cos2)).exp() / (a2 * cos2 * cos2),
        }
    }

    /// Smith's G1: the visible share of the facets that face `v`.
    #[inline(always)]
    pub fn g1(&self, v: Vec3) -> f32 {
        (self.g1_over_cos(v) * v.z.abs()).min(1.0)
    }

    /// G1(v)/|cosθ|, finite at grazing angles. Beckmann's is exact to 10⁻⁶ (not the rational fit of
    /// Walter et al., eq. 27, off by up to 0.35 %), so that visible normals have exactly this density.
    #[inline(always)]
    pub fn g1_over_cos(&self, v: Vec3) -> f32 {
        let cos = v.z.abs();
        let slope = self.alpha * (v.x * v.x + v.y * v.y).sqrt();
        match self.kind {
            MicrofacetDistribution::Ggx => 2.0 / (cos + (cos * cos + slope * slope).sqrt()),
            MicrofacetDistribution::Beckmann => {
                let a = cos / slope.max(1e-12);
                let gauss = (-a * a).exp();
                2.0 / (cos * (2.0 - erfc_with(a, gauss)) + slope * gauss * FRAC_1_SQRT_PI)
            }
        }
    }

    /// Density of [`Self::sample_visible`] per steradian of m: G1(wo)·max(0, wo·m)·D(m)/cosθo
    /// (Heitz & d'Eon 2014).
    #[inline(always)]
    pub fn visible_pdf(&self, wo: Vec3, m: Vec3) -> f32 {
        self.g1_over_cos(wo) * wo.dot(m).max(0.0) * self.d(m)
    }

    /// A normal visible from `wo` (wo.z ≥ 0).
    ///
    /// GGX: reflections of spherical caps (Dupuy & Benyoub 2023). Beckmann: slopes by inversion (Heitz & d'Eon
    /// 2014, supplement). Both stretch the surface to alpha 1 first (Heitz 2014).
    #[inline]
    pub fn sample_visible(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        self.sample_visible_with(wo, u, || sin_cos_turn(u[0]))
    }

    /// The same, `turn` being what finds [`sin_cos_turn`] of `u[0]`.
    #[inline(always)]
    pub fn sample_visible_with(&self, wo: Vec3, u: [f32; 2], turn: impl Fn() -> (f32, f32)) -> Vec3 {
        let w = Vec3::new(self.alpha * wo.x, self.alpha * wo.y, wo.z).normalize();
        match self.kind {
            MicrofacetDistribution::Ggx => {
                let z = (1.0 - u[1]) * (1.0 + w.z) - w.z;
                let r = (1.0 - z * z).max(0.0).sqrt();
                let (sin, cos) = turn();
                let h = Vec3::new(r * cos, r * sin, z) + w;
                Vec3::new(self.alpha * h.x, self.alpha * h.y, h.z.max(1e-7)).normalize()
            }
            MicrofacetDistribution::Beckmann => {
                let along = visible_gaussian_slope(w.z, u[1]);
                let across = erf_inv((2.0 * u[0] - 1.0).clamp(-ONE_MINUS_EPSILON, ONE_MINUS_EPSILON));
                let axis = w.truncate().try_normalize().unwrap_or(Vec2::X);
                let slope = self.alpha * axis.rotate(Vec2::new(along, across));
                (-slope).extend(1.0).normalize()
            }
        }
    }
}

/// Sine and cosine of so many turns.
#[inline(always)]
pub(super) fn sin_cos_turn(turns: f32) -> (f32, f32) {
    (TAU * turns).sin_cos()
}

/// Inverts the distribution of the slope x (along the view) of visible facets of a Gaussian surface of alpha 1,
/// density ∝ max(0, cosθ − x sinθ)·exp(−x²), by Newton steps within a bracket, in the variable erf x, where the
/// distribution function is nearly straight (Jakob 2014, "An Improved Visible Normal Sampling Routine…").
fn visible_gaussian_slope(cos: f32, u: f32) -> f32 {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let cot = (cos / sin.max(1e-12)).min(10.0);
    let integral = |e: f32, x: f32| cos * (1.0 + e) + sin * FRAC_1_SQRT_PI * (-x * x).exp();
    let last = erf(cot).min(ONE_MINUS_EPSILON);
    let target = u * integral(last, cot);
    let (mut low, mut high) = (-ONE_MINUS_EPSILON, last);
    let mut e = low + u * (high - low);
    let mut x = erf_inv(e);
    for _ in 0..12 {
        let excess = integral(e, x) - target;
        if excess.abs() < 1e-6 {
            break;
        }
        if excess > 0.0 {
            high = e
        } else {
            low = e
        }
        let next = e - excess / (cos - x * sin);
        e = if next > low && next < high { next } else { 0.5 * (low + high) };
        x = erf_inv(e);
    }
    x
}

/// erf for x ≥ 0 to 5·10⁻⁷ in single precision (Abramowitz & Stegun 1964, eq. 7.1.26).
fn erf(x: f32) -> f32 {
    1.0 - erfc_with(x, (-x * x).exp())
}

/// 1 − erf(x) for x ≥ 0, given exp(−x²).
#[inline]
fn erfc_with(x: f32, gauss: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let p = 1.061_405_4;
    let p = p * t - 1.453_152;
    let p = p * t + 1.421_413_7;
    let p = p * t - 0.284_496_74;
    let p = p * t + 0.254_829_6;
    p * t * gauss
}

/// Inverse error function on (−1, 1), relative error below 10⁻⁵ (Giles 2010, "Approximating the erfinv
/// function", single precision).
fn erf_inv(x: f32) -> f32 {
    const CENTRE: [f32; 9] = [
        2.810_226_4e-8,
        3.432_739_4e-7,
        -3.523_387_7e-6,
        -4.391_506_5e-6,
        0.000_218_580_87,
        -0.001_253_725,
        -0.004_177_681_6,
        0.246_640_73,
        1.501_409_4,
    ];
    const TAIL: [f32; 9] = [
        -0.000_200_214_26,
        0.000_100_950_56,
        0.001_349_343_2,
        -0.003_673_428_4,
        0.005_739_507_7,
        -0.007_622_461,
        0.009_438_870_5,
        1.001_674,
        2.832_976_8,
    ];
    let w = -((1.0 - x) * (1.0 + x)).ln();
    let horner = |c: [f32; 9], w: f32| c.into_iter().fold(0.0, |p, c| p * w + c);
    x * if w < 5.0 { horner(CENTRE, w - 2.5) } else { horner(TAIL, w.sqrt() - 3.0) }
}

#[cfg(test)]
#[path = "microfacet_tests.rs"]
mod tests;
