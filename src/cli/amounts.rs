//! Amounts as people write them: 1k, 1m30s, 1920x1080, 50%.

use crate::image::Rectangle;

/// A whole number of 1 or more: `64`, `1k` (1000), `1.5M`, `2G`.
pub(crate) fn count(text: &str) -> Result<u64, String> {
    let expected = || format!("'{text}' is no number of 1 or more, such as 64, 1k (1000) or 1.5M");
    let (number, factor) = match text.char_indices().last() {
        Some((at, 'k' | 'K')) => (&text[..at], 1e3),
        Some((at, 'M')) => (&text[..at], 1e6),
        Some((at, 'G')) => (&text[..at], 1e9),
        _ => return text.parse().ok().filter(|n| *n > 0).ok_or_else(expected),
    };
    let value = decimal(number).ok_or_else(expected)? * factor;
    // What is left of a fraction by a number in base 2 is no fraction.
    let whole = value.round();
    let is_whole = (value - whole).abs() < 1e-6 && (1.0..=(1u64 << 53) as f64).contains(&whole);
    if is_whole { Ok(whole as u64) } else { Err(expected()) }
}

/// As [`count`], at most what fits 32 bits.
pub(crate) fn count_u32(text: &str) -> Result<u32, String> {
    let n = count(text)?;
    u32::try_from(n).map_err(|_| format!("'{text}' is too large: {} at most", u32::MAX))
}

/// Seconds: `90`, `1m`, `1.5h`, `1h30m`, `500ms`.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let expected = || format!("'{text}' is no time: a positive number of seconds, or such as 90s, 1m, 1h30m");
    let total = match decimal(text) {
        Some(seconds) => seconds,
        None => with_units(text).ok_or_else(expected)?,
    };
    if total > 0.0 && total.is_finite() { Ok(total) } else { Err(expected()) }
}

/// A relative error, as a number or as a percentage.
pub(crate) fn error(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let error = decimal(number.trim()).map(|error| error * unit).filter(|error| *error > 0.0 && error.is_finite());
    error.ok_or_else(|| format!("'{text}' is no relative error: a positive number such as 0.02, or 2%"))
}

/// A part and of how many, counted from 1.
pub(crate) fn part(text: &str) -> Result<(u32, u32), String> {
    let expected = || format!("'{text}' is no part: two whole numbers such as 3/16, the first from 1 to the second");
    let (number, parts) = text.split_once('/').ok_or_else(expected)?;
    let both = number.trim().parse().ok().zip(parts.trim().parse().ok());
    both.filter(|(number, parts)| (1..=*parts).contains(number)).ok_or_else(expected)
}

fn with_units(text: &str) -> Option<f64> {
    let (mut rest, mut total) = (text, 0.0);
    while !rest.is_empty() {
        let unit = rest.find(|c: char| c.is_ascii_alphabetic())?;
        let after = rest[unit..].find(|c: char| !c.is_ascii_alphabetic()).map_or(rest.len(), |n| unit + n);
        let factor = match &rest[unit..after] {
            "ms" => 1e-3,
            "s" => 1.0,
            "m" | "min" => 60.0,
            "h" => 3600.0,
            "d" => 86_400.0,
            _ => return None,
        };
        total += decimal(&rest[..unit])? * factor;
        rest = &rest[after..];
    }
    Some(total)
}

/// A number without sign, exponent or name.
fn decimal(text: &str) -> Option<f64> {
    let plain = text.starts_with(|c: char| c.is_ascii_digit()) && text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    text.parse().ok().filter(|_| plain)
}

/// `1920x1080`.
pub(crate) fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|n| *n > 0);
    let sides = text.split_once(['x', 'X', '×']).and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or_else(|| format!("'{text}' is no size: WIDTHxHEIGHT in pixels, such as 1920x1080"))
}

/// `50%` or `0.5`.
pub(crate) fn scale(text: &str) -> Result<f64, String> {
    let value = text.strip_suffix('%').map_or_else(|| decimal(text), |text| decimal(text).map(|x| x / 100.0));
    let scale = value.filter(|x| *x > 0.0 && x.is_finite());
    scale.ok_or_else(|| format!("'{text}' is no scale: a positive percentage, such as 50%"))
}

/// A side in this scale, of at least one pixel.
pub(crate) fn scaled(side: u64, scale: f64) -> u64 {
    ((side as f64 * scale).round() as u64).max(1)
}

/// `x,y,width,height`.
pub(crate) fn rectangle(text: &str) -> Result<Rectangle, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Rectangle { x, y, width, height }),
        _ => Err(format!("'{text}' is no part of a picture: X,Y,WIDTH,HEIGHT in pixels from the upper left")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_may_have_a_letter() {
        let cases =
            [("64", 64), ("1k", 1000), ("1K", 1000), ("1.5M", 1_500_000), ("0.064k", 64), ("2G", 2_000_000_000)];
        for (text, n) in cases {
            assert_eq!(count(text), Ok(n), "{text}");
        }
        for text in ["", "k", "0", "-3", "1.5", "0.0001k", "1e3", "nan", "infk", "1kk", "1 k"] {
            assert!(count(text).is_err(), "{text}");
        }
        assert!(count_u32("5G").is_err() && count_u32("4G").is_ok());
    }

    #[test]
    fn times_may_have_units() {
        let cases = [("90", 90.0), ("0.5", 0.5), ("1m", 60.0), ("1.5h", 5400.0), ("1h30m", 5400.0), ("500ms", 0.5)];
        for (text, wanted) in cases {
            assert_eq!(seconds(text), Ok(wanted), "{text}");
        }
        for text in ["", "m", "0", "0s", "-1", "nan", "inf", "1x", "1m30", "1h m", "5 parsecs"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_scales_and_parts_are_read() {
        assert_eq!(size("1920x1080"), Ok((1920, 1080)));
        ["1920", "0x3", "3x", "ax3", "-1x2"].iter().for_each(|text| assert!(size(text).is_err(), "{text}"));
        assert_eq!((scale("50%"), scale("0.25")), (Ok(0.5), Ok(0.25)));
        ["", "%", "0%", "-5%", "nan", "1e2%"].iter().for_each(|text| assert!(scale(text).is_err(), "{text}"));
        assert_eq!((scaled(1, 0.1), scaled(333, 0.5)), (1, 167));
        assert_eq!((error("0.02"), error("5%")), (Ok(0.02), Ok(0.05)));
        ["", "0", "-1", "%", "nan", "2 dB"].iter().for_each(|text| assert!(error(text).is_err(), "{text}"));
        assert_eq!((part("3/16"), part("1/1")), (Ok((3, 16)), Ok((1, 1))));
        ["", "3", "0/4", "5/4", "1/0", "-1/3", "1/2/3"].iter().for_each(|text| assert!(part(text).is_err(), "{text}"));
        assert_eq!(rectangle("1, 2,3,4"), Ok(Rectangle { x: 1, y: 2, width: 3, height: 4 }));
        ["1,2,3", "1,2,0,4", "1,2,3,-4", "a"].iter().for_each(|text| assert!(rectangle(text).is_err(), "{text}"));
    }
}
