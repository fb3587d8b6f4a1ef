//! The transfer curve of sRGB (IEC 61966-2-1) between linear light and stored values, both in [0, 1].

use std::sync::{Arc, LazyLock};

/// The stored value of a linear one. Values outside of [0, 1] are clamped, NaN counts as 0.
pub fn encode(linear: f32) -> f32 {
    let x = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The linear value of a stored one; the inverse of [`encode`] on [0, 1] up to rounding.
pub(crate) fn decode(stored: f32) -> f32 {
    if stored <= 0.040_45 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) }
}

/// [`decode`] of i/255 for every 8-bit value i.
pub(crate) static DECODE_8: LazyLock<Arc<[f32; 256]>> =
    LazyLock::new(|| Arc::new(std::array::from_fn(|i| decode(i as f32 / 255.0))));

/// [`decode`] of i/65535 for every 16-bit value i.
pub(crate) static DECODE_16: LazyLock<Arc<[f32]>> =
    LazyLock::new(|| (0..=u16::MAX).map(|i| decode(f32::from(i) / 65535.0)).collect());

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_goes_through_known_points() {
        // The standard's own example of mid grey: linear 0.2140 is stored as 0.5.
        assert!((decode(0.5) - 0.214_041).abs() < 1e-5);
        assert!((encode(0.18) - 0.461_356).abs() < 1e-5);
        assert!((encode(0.002) - 0.025_84).abs() < 1e-6);
        assert_eq!((encode(0.0), decode(0.0), decode(1.0)), (0.0, 0.0, 1.0));
        assert!((encode(1.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn out_of_range_is_clamped() {
        assert_eq!(encode(-1.0), 0.0);
        assert_eq!(encode(7.0), encode(1.0));
        assert_eq!(encode(f32::INFINITY), encode(1.0));
        assert_eq!(encode(f32::NEG_INFINITY), 0.0);
        assert_eq!(encode(f32::NAN), 0.0);
    }

    #[test]
    fn tables_invert_the_encoding() {
        for i in 0..=255 {
            assert_eq!((encode(DECODE_8[i]) * 255.0).round() as usize, i);
        }
        for i in 0..=65535 {
            assert_eq!((encode(DECODE_16[i]) * 65535.0).round() as usize, i);
        }
    }
}
