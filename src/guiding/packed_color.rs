//! Colours in few bits, for what is learnt of light.

use crate::math::{Rgb, luminance};

/// The colour of light without its amount: the shares of red and of blue in the sum of the channels, in 255ths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hue {
    red: u8,
    blue: u8,
}

impl Hue {
    pub const GREY: Hue = Hue { red: 85, blue: 85 };

    /// That of `light`; grey where it has none.
    #[inline]
    pub fn of(light: Rgb) -> Hue {
        let sum = light.element_sum();
        if !(sum > 0.0 && sum.is_finite() && light.min_element() >= 0.0) {
            return Hue::GREY;
        }
        let share = |channel: f32| (255.0 * channel / sum).round() as u8;
        Hue { red: share(light.x), blue: share(light.z) }
    }

    /// Light of this colour with luminance 1.
    #[inline]
    pub fn light(self) -> Rgb {
        let (red, blue) = (f32::from(self.red), f32::from(self.blue));
        let light = Rgb::new(red, (255.0 - red - blue).max(0.0), blue);
        light / luminance(light)
    }
}

/// A colour of channels ≥ 0 with 8 bits each and an exponent that they share (Ward 1991, "Real Pixels").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PackedColor(u32);

/// 2 to the power of the exponent's byte less 127 is the unit of the mantissas: 127 for `f32` itself, and 8 for the mantissas' bits.
const BIAS: i32 = 127 - 8;

impl PackedColor {
    /// Within 1/256 of the largest channel. Black where that is not a normal number.
    #[inline]
    pub fn new(color: Rgb) -> PackedColor {
        let largest = color.max_element();
        if !(largest.is_normal() && color.min_element() >= 0.0) {
            return PackedColor(0);
        }
        // the largest channel is between 2^(e − 1) and 2^e
        let exponent = ((largest.to_bits() >> 23) as i32 - 126 + BIAS).max(0);
        let unit = f32::from_bits((exponent as u32) << 23);
        let mantissa = |channel: f32| ((channel / unit).round() as u32).min(255);
        if exponent == 0 {
            return PackedColor(0);
        }
        let [red, green, blue] = color.to_array().map(mantissa);
        PackedColor(red | green << 8 | blue << 16 | (exponent as u32) << 24)
    }

    /// The colour. Arithmetic alone, so that a loop over many runs in vectors.
    #[inline(always)]
    pub fn color(self) -> Rgb {
        let unit = f32::from_bits(self.0 >> 24 << 23);
        Rgb::new((self.0 & 255) as f32, (self.0 >> 8 & 255) as f32, (self.0 >> 16 & 255) as f32) * unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    #[test]
    fn colours_come_back() {
        let mut rng = Rng::new(1);
        for _ in 0..10_000 {
            let scale = (200.0 * rng.f32() - 100.0).exp2();
            let color = Rgb::new(rng.f32().powi(3), rng.f32(), rng.f32()) * scale;
            let off = (PackedColor::new(color).color() - color).abs().max_element();
            assert!(off <= color.max_element() / 200.0, "{color}");
            let hue = Hue::of(color).light();
            assert!((luminance(hue) - 1.0).abs() < 1e-5);
            let exact = color / luminance(color);
            assert!((hue - exact).abs().max_element() < 0.03 * exact.max_element(), "{hue} {exact}");
        }
    }

    #[test]
    fn a_power_of_two_is_exact() {
        let color = Rgb::new(0.3, 0.7, 0.1);
        let (one, other) = (PackedColor::new(color).color(), PackedColor::new(color * 1024.0).color());
        assert_eq!(one * 1024.0, other);
    }

    #[test]
    fn what_is_no_colour_is_black_or_grey() {
        for odd in
            [Rgb::ZERO, Rgb::splat(f32::NAN), Rgb::splat(f32::INFINITY), Rgb::new(1.0, -1.0, 2.0), Rgb::splat(1e-40)]
        {
            assert_eq!(PackedColor::new(odd).color(), Rgb::ZERO);
        }
        for odd in [Rgb::ZERO, Rgb::splat(f32::NAN), Rgb::splat(f32::INFINITY), Rgb::new(1.0, -1.0, 2.0)] {
            assert_eq!(Hue::of(odd), Hue::GREY);
        }
        assert!((Hue::GREY.light() - Rgb::ONE).abs().max_element() < 1e-6);
        assert!(PackedColor::new(Rgb::splat(f32::MAX)).color().is_finite());
    }
}
