//! Unpolarised Fresnel reflectance, and the directions that go with it.

use crate::math::Rgb;
use glam::Vec3;

/// Reflectance of a dielectric interface (Born & Wolf 1999, §1.5.2) and the cosine of the refracted direction.
///
/// `cos` ≥ 0 is the cosine of incidence, `eta` the index behind the interface over that before it. Under total
/// internal reflection the result is (1, 0).
#[inline(always)]
pub fn dielectric(cos: f32, eta: f32) -> (f32, f32) {
    let sin2_t = (1.0 - cos * cos).max(0.0) / (eta * eta);
    if eta == 1.0 {
        return (0.0, cos);
    }
    if sin2_t >= 1.0 {
        return (1.0, 0.0);
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let s = (cos - eta * cos_t) / (cos + eta * cos_t);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t);
    (0.5 * (s * s + p * p), cos_t)
}

/// Reflectance of a conductor with complex index `eta` + i`k` relative to the medium before it, per channel, at
/// cosine `cos` ≥ 0 (Born & Wolf 1999, §14.2, squared amplitudes in real arithmetic).
#[inline(always)]
pub fn conductor(cos: f32, eta: Rgb, k: Rgb) -> Rgb {
    let cos2 = cos * cos;
    let sin2 = (1.0 - cos2).max(0.0);
    let t = eta * eta - k * k - Vec3::splat(sin2);
    let a2_b2 = sqrt(t * t + 4.0 * eta * eta * k * k);
    let twice_a_cos = 2.0 * cos * sqrt(0.5 * (a2_b2 + t));
    let sum = a2_b2 + Vec3::splat(cos2);
    let s = (sum - twice_a_cos) / (sum + twice_a_cos);
    let sum = cos2 * a2_b2 + Vec3::splat(sin2 * sin2);
    let p = s * (sum - twice_a_cos * sin2) / (sum + twice_a_cos * sin2);
    0.5 * (s + p)
}

#[inline(always)]
fn sqrt(v: Vec3) -> Vec3 {
    Vec3::new(v.x.max(0.0).sqrt(), v.y.max(0.0).sqrt(), v.z.max(0.0).sqrt())
}

/// Schlick's weight (1 − cosθ)⁵ (1994).
#[inline(always)]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// Mean over directions, 2∫F µ dµ, of Schlick's reflectance r0 + (1 − r0)(1 − µ)⁵.
#[inline]
pub fn schlick_mean(r0: Rgb) -> Rgb {
    r0 + (Rgb::ONE - r0) / 21.0
}

/// `w` mirrored about the unit normal `m`.
#[inline]
pub fn reflect(w: Vec3, m: Vec3) -> Vec3 {
    2.0 * w.dot(m) * m - w
}

/// `w` refracted at the unit normal `m` on its side; `cos_t` and `eta` as in [`dielectric`].
#[inline]
pub fn refract(w: Vec3, m: Vec3, cos_t: f32, eta: f32) -> Vec3 {
    (w.dot(m) / eta - cos_t) * m - w / eta
}

/// 2∫F(µ)µ dµ: what a smooth interface reflects of diffuse light that meets it.
pub fn diffuse_reflectance(eta: f32) -> f32 {
    const STEPS: usize = 1024;
    let sum: f64 = (0..STEPS)
        .map(|i| {
            let mu = (i as f64 + 0.5) / STEPS as f64;
            dielectric(mu as f32, eta).0 as f64 * mu
        })
        .sum();
    (2.0 * sum / STEPS as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dielectrics_at_known_angles() {
        let (f, cos_t) = dielectric(1.0, 1.5);
        assert!((f - 0.04).abs() < 1e-7 && cos_t == 1.0);
        assert!((dielectric(1.0, 1.0 / 1.5).0 - 0.04).abs() < 1e-7);
        // Brewster's angle: only the s wave, ((n² − 1)/(n² + 1))²/2
        let brewster = 1.5f32.atan().cos();
        assert!((dielectric(brewster, 1.5).0 - 0.5 * (1.25f32 / 3.25).powi(2)).abs() < 1e-6);
        // 60°: cos_t = √(1 − 1/3); s: (0.5 − 1.5·0.8165)/(…) = −0.42020, p: −0.04250
        assert!((dielectric(0.5, 1.5).0 - 0.089_19).abs() < 1e-5);
        assert_eq!(dielectric(0.0, 1.5).0, 1.0);
        assert_eq!(dielectric(0.5, 1.0 / 1.5), (1.0, 0.0));
        assert_eq!([dielectric(0.0, 1.0), dielectric(0.3, 1.0)], [(0.0, 0.0), (0.0, 0.3)]);
    }

    #[test]
    fn both_sides_of_an_interface_reflect_alike() {
        for cos in [0.05f32, 0.3, 0.7, 1.0] {
            let (f, cos_t) = dielectric(cos, 1.7);
            let (back, cos_i) = dielectric(cos_t, 1.0 / 1.7);
            assert!((f - back).abs() < 1e-5 && (cos - cos_i).abs() < 1e-5, "{cos}: {f} {back}");
        }
    }

    #[test]
    fn conductors_at_known_angles() {
        let (eta, k) = (Rgb::new(0.2, 1.5, 2.0), Rgb::new(3.9, 0.0, 3.0));
        let normal = conductor(1.0, eta, k);
        for c in 0..3 {
            let known = ((eta[c] - 1.0).powi(2) + k[c] * k[c]) / ((eta[c] + 1.0).powi(2) + k[c] * k[c]);
            assert!((normal[c] - known).abs() < 1e-5, "{normal}");
        }
        // without absorption a conductor is a dielectric
        for cos in [0.1f32, 0.5, 0.9] {
            assert!((conductor(cos, eta, k).y - dielectric(cos, 1.5).0).abs() < 1e-5);
        }
        assert!((conductor(0.0, eta, k) - Rgb::ONE).length() < 1e-5);
    }

    #[test]
    fn refraction_obeys_snell() {
        let m = Vec3::new(0.2, -0.1, 1.0).normalize();
        let w = Vec3::new(0.5, 0.3, 0.8).normalize();
        let (_, cos_t) = dielectric(w.dot(m), 1.5);
        let t = refract(w, m, cos_t, 1.5);
        assert!((t.length() - 1.0).abs() < 1e-6);
        assert!((t.cross(m) * 1.5 + w.cross(m)).length() < 1e-6);
    }

    #[test]
    fn diffuse_reflectance_of_glass() {
        // 9.2 % for an index of 1.5 (tabulated by Judd 1942, "Fresnel Reflection of Diffusely Incident Light")
        let outside = diffuse_reflectance(1.5);
        assert!((outside - 0.0918).abs() < 2e-4, "{outside}");
        // reciprocity of transmission: 1 − outside = n²(1 − inside)
        let inside = diffuse_reflectance(1.0 / 1.5);
        assert!((1.0 - outside - 2.25 * (1.0 - inside)).abs() < 1e-4, "{inside}");
    }
}
