//! Colours as they are written: linear RGB, sRGB, and spectra, which become RGB.

use crate::image::srgb;
use crate::math::Rgb;

/// Numbers between commas and blanks; `None` where one of them is none.
pub(crate) fn numbers(text: &str) -> Option<Vec<f64>> {
    let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
    words.map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect()
}

/// Three numbers, or one for all, or `#rrggbb`, which is sRGB as what `encoded` says so of.
pub(crate) fn rgb(text: &str, encoded: bool) -> Option<Rgb> {
    let text = text.trim();
    if let Some(digits) = text.strip_prefix('#') {
        let value = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6)?;
        return Some(Rgb::from([16, 8, 0].map(|shift| srgb::DECODE_8[(value >> shift & 255) as usize])));
    }
    let stored = match numbers(text)?[..] {
        [grey] => [grey as f32; 3],
        [r, g, b] => [r, g, b].map(|x| x as f32),
        _ => return None,
    };
    Some(Rgb::from(if encoded { stored.map(srgb::decode) } else { stored }))
}

/// Even light of 1 at all wavelengths in linear sRGB, as Mitsuba 3.9 has it: it is not the white of screens.
const EVEN: Rgb = Rgb::new(1.204_88, 0.948_228, 0.909_267);

/// A number, or pairs of a wavelength in nm and a number with `:` or a blank between them, one after the other. `even`: an even
/// spectrum of 1 is even light; else it is the white of screens, as for what reflects.
pub(crate) fn spectrum(text: &str, even: bool) -> Option<Rgb> {
    let numbers = uncommented(text)?;
    let white = if even { EVEN } else { Rgb::ONE };
    if let [grey] = numbers[..] {
        return Some(white * grey as f32);
    }
    pairs(&numbers).map(|pairs| white * from_pairs(&pairs))
}

/// The numbers of a text in which `#` begins a comment.
pub(crate) fn uncommented(text: &str) -> Option<Vec<f64>> {
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    numbers(&lines.collect::<Vec<_>>().join(" ").replace(':', " "))
}

/// Two or more pairs of a wavelength in nm and a number, the wavelengths rising.
pub(crate) fn pairs(numbers: &[f64]) -> Option<Vec<[f64; 2]>> {
    let (pairs, rest) = numbers.as_chunks::<2>();
    let rising = pairs.windows(2).all(|w| w[0][0] < w[1][0]);
    (rest.is_empty() && pairs.len() > 1 && rising).then(|| pairs.to_vec())
}

/// What is seen of light, as linear sRGB; even light of 1 has the luminance 1, and is not the white of screens.
pub(crate) fn seen(light: impl Fn(f64) -> f64) -> [f64; 3] {
    let (mut xyz, mut all) = ([0.0; 3], 0.0);
    for wavelength in (360..=830).map(f64::from) {
        let (seen, value) = (matching(wavelength), light(wavelength));
        (0..3).for_each(|k| xyz[k] += value * seen[k]);
        all += seen[1];
    }
    linear_srgb(xyz.map(|x| x / all))
}

/// Of a black body at this temperature in K, whose largest value is 1 at the wavelength that Wien's law names.
pub(crate) fn black_body(kelvin: f64) -> impl Fn(f64) -> f64 {
    // hc/k in nm·K, and Wien's constant in the same unit
    const C2: f64 = 1.438_776_877e7;
    const WIEN: f64 = 2.897_771_955e6;
    let planck = move |w: f64| w.powi(-5) / (C2 / (w * kelvin)).exp_m1();
    let top = planck(WIEN / kelvin);
    move |w: f64| planck(w) / top
}

/// The largest radiance of a black body at this temperature in K, in W/(sr·m²·nm): 2hc²/λ⁵/(exp(hc/λkT) − 1) at Wien's wavelength.
pub(crate) fn peak(kelvin: f64) -> f64 {
    // 2hc² in W·nm⁴/(sr·m²), and hc/k and Wien's constant in nm·K
    let wavelength = 2.897_771_955e6 / kelvin;
    1.191_042_972e20 / wavelength.powi(5) / (1.438_776_877e7 / (wavelength * kelvin)).exp_m1()
}

/// From XYZ with its white at D65.
pub(crate) fn linear_srgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240_479 * x - 1.537_150 * y - 0.498_535 * z,
        -0.969_256 * x + 1.875_991 * y + 0.041_556 * z,
        0.055_648 * x - 0.204_043 * y + 1.057_311 * z,
    ]
}

/// What is seen of a spectrum, as linear sRGB in which an even one of 1 is (1, 1, 1). Nothing is outside of its ends.
pub(crate) fn from_pairs(pairs: &[[f64; 2]]) -> Rgb {
    let (seen, even) = (self::seen(|wavelength| at(pairs, wavelength)), self::seen(|_| 1.0));
    Rgb::from([0, 1, 2].map(|k| (seen[k] / even[k]).max(0.0) as f32))
}

/// Between the pairs linear, and nothing outside of them.
pub(crate) fn at(pairs: &[[f64; 2]], wavelength: f64) -> f64 {
    let after = pairs.partition_point(|pair| pair[0] < wavelength);
    match (after.checked_sub(1).and_then(|before| pairs.get(before)), pairs.get(after)) {
        (_, Some(&[w, value])) if w == wavelength => value,
        (Some(&[a, from]), Some(&[b, to])) => from + (to - from) * (wavelength - a) / (b - a),
        _ => 0.0,
    }
}

/// The colour matching functions of 1931 (Wyman et al. 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching
/// Functions", the fits of several lobes).
fn matching(w: f64) -> [f64; 3] {
    let lobe = |height: f64, middle: f64, below: f64, above: f64| {
        let t = (w - middle) * if w < middle { below } else { above };
        height * (-0.5 * t * t).exp()
    };
    [
        lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(-0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_in_all_spellings() {
        assert_eq!(rgb("0.1, 0.2 0.3", false), Some(Rgb::new(0.1, 0.2, 0.3)));
        assert_eq!(rgb(" 0.5 ", false), Some(Rgb::splat(0.5)));
        assert_eq!(rgb("#ff8000", false), Some(Rgb::new(1.0, srgb::DECODE_8[128], 0.0)));
        assert_eq!(rgb("0.5", true), Some(Rgb::splat(srgb::decode(0.5))));
        for wrong in ["", "1 2", "1 2 3 4", "#12345", "red", "1 nan 2"] {
            assert_eq!(rgb(wrong, false), None, "{wrong}");
        }
    }

    #[test]
    fn black_bodies_have_the_colours_of_their_temperatures() {
        // chromaticities of the Planckian locus: 2856 K is illuminant A, (0.4476, 0.4074); 6500 K is at (0.3135, 0.3237)
        for (kelvin, x, y) in [(2856.0, 0.4476, 0.4074), (6500.0, 0.3135, 0.3237)] {
            let [r, g, b] = seen(black_body(kelvin));
            let xyz = [
                0.412_453 * r + 0.357_580 * g + 0.180_423 * b,
                0.212_671 * r + 0.715_160 * g + 0.072_169 * b,
                0.019_334 * r + 0.119_193 * g + 0.950_227 * b,
            ];
            let sum: f64 = xyz.iter().sum();
            assert!((xyz[0] / sum - x).abs() < 3e-3 && (xyz[1] / sum - y).abs() < 3e-3, "{kelvin}: {xyz:?}");
        }
        // the sun's surface, at 500 nm: 2.6·10⁴ W/(sr·m²·nm)
        assert!((peak(5778.0) / 2.638e4 - 1.0).abs() < 2e-3, "{}", peak(5778.0));
        let top = (360..830).map(|w| black_body(5000.0)(f64::from(w))).fold(0.0, f64::max);
        assert!((top - 1.0).abs() < 1e-5, "{top}");
    }

    #[test]
    fn spectra_become_what_is_seen_of_them() {
        assert_eq!(spectrum("0.7", false), Some(Rgb::splat(0.7)));
        assert_eq!(spectrum("2", true), Some(EVEN * 2.0));
        // Mitsuba 3.9.1 (scalar_rgb) makes these of even spectra
        for (even, wanted) in [(true, Rgb::new(1.204_88, 0.948_228, 0.909_267)), (false, Rgb::ONE)] {
            let found = spectrum("300:1, 900:1", even).unwrap();
            assert!((found - wanted).abs().max_element() < 1e-3, "{found}");
        }
        let red = spectrum("600:0\n610:1 # a comment\n700:1", false).unwrap();
        assert!(red.x > 5.0 * red.y && red.x > 5.0 * red.z, "{red}");
        for wrong in ["", "400:1", "500:1 400:1", "400:1 500", "400:x 500:1"] {
            assert_eq!(spectrum(wrong, false), None, "{wrong}");
        }
    }
}
