//! The colour of what is learnt of light, in few bits.

use crate::math::{Rgb, luminance};

/// The colour of light without its amount: the shares of red and of blue in the sum of the channels, in 65535ths: fine enough that what
/// rounding turns is no more than rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hue {
    red: u16,
    blue: u16,
}

impl Hue {
    pub const GREY: Hue = Hue { red: 21845, blue: 21845 };

    /// That of `light`; grey where it has none.
    #[inline]
    pub fn of(light: Rgb) -> Hue {
        let sum = light.element_sum();
        if !(sum > 0.0 && sum.is_finite() && light.min_element() >= 0.0) {
            return Hue::GREY;
        }
        let share = |channel: f32| (65535.0 * channel / sum).round() as u16;
        Hue { red: share(light.x), blue: share(light.z) }
    }

    /// Light of this colour with luminance 1. Arithmetic alone, so that a loop over many runs in vectors.
    #[inline(always)]
    pub fn light(self) -> Rgb {
        let (red, blue) = (f32::from(self.red), f32::from(self.blue));
        let light = Rgb::new(red, (65535.0 - red - blue).max(0.0), blue);
        light / luminance(light)
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
            let hue = Hue::of(color).light();
            assert!((luminance(hue) - 1.0).abs() < 1e-5);
            let exact = color / luminance(color);
            assert!((hue - exact).abs().max_element() < 1e-3 * exact.max_element(), "{hue} {exact}");
        }
    }

    #[test]
    fn what_is_no_colour_is_grey() {
        for odd in [Rgb::ZERO, Rgb::splat(f32::NAN), Rgb::splat(f32::INFINITY), Rgb::new(1.0, -1.0, 2.0)] {
            assert_eq!(Hue::of(odd), Hue::GREY);
        }
        assert!((Hue::GREY.light() - Rgb::ONE).abs().max_element() < 1e-6);
    }
}
