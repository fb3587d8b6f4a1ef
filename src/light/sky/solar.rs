//! Sunlight at the ground, in the unit of the sky: watts weighed by the colour matching functions.

use crate::math::Rgb;
use glam::{DMat3, DVec3};

/// Solid angle of the sun, sr, and the temperature of a black body of its colour, K.
const SOLID_ANGLE: f64 = 6.807e-5;
const TEMPERATURE: f64 = 5778.0;

/// From CIE XYZ to linear sRGB (IEC 61966-2-1), by columns.
const TO_SRGB: DMat3 = DMat3::from_cols(
    DVec3::new(3.240_6, -0.968_9, 0.055_7),
    DVec3::new(-1.537_2, 1.875_8, -0.204_0),
    DVec3::new(-0.498_6, 0.041_5, 1.057_0),
);

/// Irradiance on a surface that faces the sun, by A. J. Preetham, P. Shirley, B. Smits, "A Practical Analytic Model for
/// Daylight", SIGGRAPH 1999, appendix: what air (Rayleigh) and aerosols (Ångström) let through. Ozone, water and
/// gases are left out: together some per cent. `elevation` in radians, 0 to π/2.
pub(super) fn irradiance(elevation: f64, turbidity: f64) -> Rgb {
    let mass = air_mass(elevation);
    let beta = 0.046_08 * turbidity - 0.045_86;
    let step = 5.0;
    let xyz: DVec3 = (0..=80)
        .map(|k| {
            let nanometres = 380.0 + step * f64::from(k);
            let micrometres = nanometres * 1e-3;
            let rayleigh = (-0.008_735 * micrometres.powf(-4.08) * mass).exp();
            let aerosol = (-beta.max(0.0) * micrometres.powf(-1.3) * mass).exp();
            matching(nanometres) * (planck(micrometres) * SOLID_ANGLE * rayleigh * aerosol * step)
        })
        .sum();
    (TO_SRGB * xyz).max(DVec3::ZERO).as_vec3()
}

/// Air on the way of the light, in atmospheres (F. Kasten 1966, as in the paper).
fn air_mass(elevation: f64) -> f64 {
    let zenith = 90.0 - elevation.to_degrees();
    1.0 / (elevation.sin() + 0.15 * (93.885 - zenith).powf(-1.253))
}

/// Radiance of a black body, W/(m²·sr·nm).
fn planck(micrometres: f64) -> f64 {
    const C1: f64 = 1.191_043e8; // 2hc², W·µm⁴/(m²·sr)
    const C2: f64 = 14_387.77; // hc/k, µm·K
    1e-3 * C1 / (micrometres.powi(5) * ((C2 / (micrometres * TEMPERATURE)).exp() - 1.0))
}

/// The CIE 1931 colour matching functions by C. Wyman, P.-P. Sloan, P. Shirley, "Simple Analytic Approximations to the CIE
/// XYZ Color Matching Functions", JCGT 2013, multi-lobe.
fn matching(nanometres: f64) -> DVec3 {
    let lobe = |height: f64, middle: f64, below: f64, above: f64| {
        let t = (nanometres - middle) / if nanometres < middle { below } else { above };
        height * (-0.5 * t * t).exp()
    };
    DVec3::new(
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::luminance;

    /// Lumens of a watt at the eye's most sensitive.
    const EFFICACY: f32 = 683.0;

    #[test]
    fn sunlight_is_as_bright_as_outdoors_and_red_in_the_evening() {
        // the sun alone, high in a clear sky, gives about 100 klx on what faces it (IESNA handbook: 100 to 130)
        let noon = irradiance(1.2, 2.5);
        let lux = EFFICACY * luminance(noon);
        assert!((80e3..130e3).contains(&lux), "{lux} lx");
        let evening = irradiance(0.05, 2.5);
        assert!(luminance(evening) < 0.3 * luminance(noon));
        assert!(noon.x / noon.z < 2.0 && evening.x / evening.z > 5.0, "{noon} {evening}");
        assert!(irradiance(0.0, 10.0).is_finite());
    }

    #[test]
    fn the_fits_have_the_areas_of_the_curves() {
        // ∫ȳ dλ = 106.857 nm, and those of x̄ and z̄ are nearly the same
        let area: DVec3 = (0..4000).map(|k| matching(360.0 + 0.1 * f64::from(k)) * 0.1).sum();
        assert!((area / 106.857 - DVec3::ONE).abs().max_element() < 0.01, "{area}");
        // a black body of 5778 K, outside the air: 1.8 W/(m²·nm) at 550 nm
        assert!((planck(0.55) * SOLID_ANGLE - 1.8).abs() < 0.1);
    }
}
