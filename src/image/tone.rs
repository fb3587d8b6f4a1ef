//! Tone curves: from exposed linear light to the light that a screen shows, both with sRGB primaries.

use crate::math::Rgb;
use glam::{Mat3, Vec3, mat3, vec3};
use std::str::FromStr;

/// How light that is brighter than a screen becomes a colour of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Tone {
    /// Clamps each channel to [0, 1].
    #[default]
    Srgb,
    /// AgX (Troy Sobotka), base look, with the constants for Rec. 2020 that Blender 4 has (Eary Chow) and the polynomial by
    /// Benjamin Wrensch ("Minimal AgX Implementation", 2023) in place of the lookup table.
    Agx,
    /// Stephen Hill's fit of the ACES reference and sRGB output transforms (BakingLab, 2016). As in three.js, light is divided
    /// by 0.6 before, so that mid grey stays about as bright as it was.
    Aces,
}

impl Tone {
    /// All of them, by the names that scene files and options use.
    pub(crate) const NAMES: [(&str, Tone); 3] = [("srgb", Tone::Srgb), ("agx", Tone::Agx), ("aces", Tone::Aces)];

    pub(crate) fn name(self) -> &'static str {
        Tone::NAMES.iter().find(|(_, tone)| *tone == self).map_or("", |(name, _)| name)
    }

    /// The numbers of the curves by name, for programs that apply them: matrices by columns, polynomials from the highest power.
    pub(crate) fn constants() -> [(&'static str, Vec<f32>); 9] {
        let matrix = |m: Mat3| m.to_cols_array().to_vec();
        [
            ("agxIn", matrix(AGX_INSET * SRGB_TO_REC2020)),
            ("agxOut", matrix(AGX_OUTSET)),
            ("agxScreen", matrix(REC2020_TO_SRGB)),
            ("agxStops", AGX_STOPS.to_vec()),
            ("agxGamma", vec![AGX_GAMMA]),
            ("agxContrast", AGX_CONTRAST.to_vec()),
            ("acesIn", matrix(ACES_IN * (1.0 / ACES_SCALE))),
            ("acesOut", matrix(ACES_OUT)),
            ("acesCurve", ACES_CURVE.to_vec()),
        ]
    }

    /// What a screen shows, in [0, 1] and linear. What is not a number, or negative, counts as 0.
    #[inline]
    pub(crate) fn apply(self, light: Rgb) -> Rgb {
        // Far beyond the whites of all curves, and its square is still a number.
        const BRIGHTEST: f32 = 1e9;
        let light = Rgb::from(light.to_array().map(|x| if x > 0.0 { x.min(BRIGHTEST) } else { 0.0 }));
        match self {
            Tone::Srgb => light.min(Rgb::ONE),
            Tone::Agx => agx(light),
            Tone::Aces => aces(light),
        }
    }

    /// The grey that is shown as the brightest white there is; brighter ones look alike.
    pub(crate) fn white(self) -> f32 {
        match self {
            Tone::Srgb => 1.0,
            Tone::Agx => AGX_STOPS[1].exp2(),
            // Where the fit reaches 1: the positive root of 0.016271 x² − 0.4083724 x − 0.238171535.
            Tone::Aces => ACES_SCALE * 25.668_44,
        }
    }
}

impl FromStr for Tone {
    type Err = String;

    fn from_str(text: &str) -> Result<Tone, String> {
        let found = Tone::NAMES.iter().find(|(name, _)| *name == text).map(|(_, tone)| *tone);
        found.ok_or_else(|| format!("`{text}` is no tone curve: there are srgb, agx and aces"))
    }
}

const SRGB_TO_REC2020: Mat3 =
    mat3(vec3(0.6274, 0.0691, 0.0164), vec3(0.3293, 0.9195, 0.0880), vec3(0.0433, 0.0113, 0.8956));
const REC2020_TO_SRGB: Mat3 =
    mat3(vec3(1.6605, -0.1246, -0.0182), vec3(-0.5876, 1.1329, -0.1006), vec3(-0.0728, -0.0083, 1.1187));
const AGX_INSET: Mat3 = mat3(
    vec3(0.856_627_15, 0.137_318_97, 0.111_898_21),
    vec3(0.095_121_24, 0.761_242, 0.076_799_42),
    vec3(0.048_251_607, 0.101_439_04, 0.811_302_4),
);
const AGX_OUTSET: Mat3 = mat3(
    vec3(1.127_100_6, -0.141_329_76, -0.141_329_76),
    vec3(-0.110_606_64, 1.157_823_7, -0.110_606_64),
    vec3(-0.016_493_939, -0.016_493_939, 1.251_936_4),
);
/// Binary logarithms of the darkest and the brightest light: 10 stops below and 6.5 above mid grey, 0.18.
const AGX_STOPS: [f32; 2] = [-12.473_93, 4.026_069];
const AGX_GAMMA: f32 = 2.2;
/// Coefficients of its polynomial, that of the highest power first.
const AGX_CONTRAST: [f32; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];

fn agx(light: Vec3) -> Vec3 {
    let [darkest, brightest] = AGX_STOPS;
    let encoded = AGX_INSET * (SRGB_TO_REC2020 * light);
    // The logarithm of 0 is as dark as the darkest.
    let encoded = encoded.to_array().map(|x| contrast(((x.log2() - darkest) / (brightest - darkest)).clamp(0.0, 1.0)));
    let shown = (AGX_OUTSET * Vec3::from(encoded)).max(Vec3::ZERO).powf(AGX_GAMMA);
    (REC2020_TO_SRGB * shown).clamp(Vec3::ZERO, Vec3::ONE)
}

/// The S-shaped curve of AgX on [0, 1], by a polynomial.
fn contrast(x: f32) -> f32 {
    AGX_CONTRAST.into_iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// From linear sRGB to where the curve works: XYZ, D65 to D60, AP1, RRT saturation.
const ACES_IN: Mat3 =
    mat3(vec3(0.59719, 0.07600, 0.02840), vec3(0.35458, 0.90834, 0.13383), vec3(0.04823, 0.01566, 0.83777));
const ACES_OUT: Mat3 =
    mat3(vec3(1.60475, -0.10208, -0.00327), vec3(-0.53108, 1.10813, -0.07276), vec3(-0.07367, -0.00605, 1.07602));
const ACES_SCALE: f32 = 0.6;
/// Coefficients of the curve, (x (x + a) − b) / (x (c x + d) + e).
const ACES_CURVE: [f32; 5] = [0.024_578_6, 0.000_090_537, 0.983_729, 0.432_951, 0.238_081];

fn aces(light: Vec3) -> Vec3 {
    let x = ACES_IN * (light / ACES_SCALE);
    let [a, b, c, d, e] = ACES_CURVE;
    let curve = (x * (x + a) - b) / (x * (c * x + d) + e);
    (ACES_OUT * curve).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Tone; 3] = [Tone::Srgb, Tone::Agx, Tone::Aces];

    /// Worked out in double precision by another program from the published matrices.
    #[test]
    fn curves_are_the_published_ones() {
        let cases = [
            (Tone::Agx, [0.18; 3], [0.214_549, 0.214_502, 0.214_499]),
            (Tone::Agx, [1.0; 3], [0.590_229, 0.590_136, 0.590_102]),
            (Tone::Agx, [2.0, 0.2, 0.05], [0.868_613, 0.332_282, 0.204_506]),
            (Tone::Agx, [0.0, 0.0, 1.0], [0.034_013, 0.135_471, 0.730_010]),
            (Tone::Aces, [0.18; 3], [0.213_105, 0.213_105, 0.213_103]),
            (Tone::Aces, [1.0; 3], [0.763_397, 0.763_397, 0.763_390]),
            (Tone::Aces, [2.0, 0.2, 0.05], [1.0, 0.373_843, 0.108_486]),
            (Tone::Aces, [0.0, 0.0, 5.0], [0.376_761, 0.035_303, 1.0]),
            (Tone::Srgb, [0.18, 1.5, -1.0], [0.18, 1.0, 0.0]),
        ];
        for (tone, light, wanted) in cases {
            let shown = tone.apply(light.into());
            assert!((shown - Vec3::from(wanted)).abs().max_element() < 3e-5, "{tone:?} {light:?}: {shown}");
        }
    }

    #[test]
    fn brighter_greys_are_shown_brighter_up_to_white() {
        for tone in ALL {
            let shown = |light: f32| tone.apply(Vec3::splat(light));
            let white = tone.white();
            assert!(shown(white).min_element() > 0.996, "{tone:?}: {}", shown(white));
            assert!(shown(0.98 * white).max_element() < shown(white).max_element(), "{tone:?} ends before its white");
            let mut last = shown(0.0);
            assert_eq!(last, Vec3::ZERO);
            for k in 1..200 {
                let next = shown(white * (k as f32 / 200.0).powi(3));
                assert!(next.cmpge(last).all(), "{tone:?} {k}: {last} and then {next}");
                assert!(next.max_element() - next.min_element() < 1e-3, "{tone:?}: grey stays grey");
                last = next;
            }
        }
    }

    #[test]
    fn any_number_has_a_colour() {
        let numbers = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, -0.0, 0.0, f32::MIN_POSITIVE, 1.0, f32::MAX];
        for tone in ALL {
            for (r, g, b) in numbers.iter().flat_map(|r| numbers.iter().map(move |g| (*r, *g, 0.5))) {
                let shown = tone.apply(Rgb::new(r, g, b));
                assert!(shown.cmpge(Vec3::ZERO).all() && shown.cmple(Vec3::ONE).all(), "{tone:?} {r} {g}: {shown}");
            }
        }
    }

    #[test]
    fn names_are_read_and_written() {
        for (name, tone) in Tone::NAMES {
            assert_eq!((name.parse(), tone.name()), (Ok(tone), name));
        }
        assert!("filmic".parse::<Tone>().unwrap_err().contains("agx"));
    }
}
