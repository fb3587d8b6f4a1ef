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
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    let text = lines.collect::<Vec<_>>().join(" ").replace(':', " ");
    let numbers = numbers(&text)?;
    let white = if even { EVEN } else { Rgb::ONE };
    if let [grey] = numbers[..] {
        return Some(white * grey as f32);
    }
    let pairs: Vec<[f64; 2]> = numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
    let rising = pairs.windows(2).all(|w| w[0][0] < w[1][0]);
    let whole = numbers.len() % 2 == 0 && pairs.len() > 1 && rising;
    whole.then(|| white * from_pairs(&pairs))
}

/// What is seen of a spectrum, as linear sRGB in which an even one of 1 is (1, 1, 1). Nothing is outside of its ends.
fn from_pairs(pairs: &[[f64; 2]]) -> Rgb {
    let (mut xyz, mut all) = ([0.0; 3], [0.0; 3]);
    for wavelength in (360..=830).map(f64::from) {
        let (seen, value) = (matching(wavelength), at(pairs, wavelength));
        (0..3).for_each(|k| {
            xyz[k] += value * seen[k];
            all[k] += seen[k];
        });
    }
    let rgb = |[x, y, z]: [f64; 3]| {
        [
            3.240_479 * x - 1.537_150 * y - 0.498_535 * z,
            -0.969_256 * x + 1.875_991 * y + 0.041_556 * z,
            0.055_648 * x - 0.204_043 * y + 1.057_311 * z,
        ]
    };
    let (seen, even) = (rgb(xyz), rgb(all));
    Rgb::from([0, 1, 2].map(|k| (seen[k] / even[k]).max(0.0) as f32))
}

fn at(pairs: &[[f64; 2]], wavelength: f64) -> f64 {
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
