//! The unit in which light is reckoned while a scene is rendered.

use super::source::LightSource;
use super::{EmissiveTriangle, Light, scaled};
use crate::math::Rgb;
use glam::DVec3;

/// A power of two, near the radiance of the scene's brightest light. All emission is divided by it when the scene is loaded,
/// and the picture is multiplied by it when it is finished.
///
/// Squares of radiance are taken everywhere: for variances, for what the guide learns of them, for roulette. In single
/// precision they hold from 10⁻¹⁹ to 10¹⁹ only; in this unit, that range lies about the brightest light, however bright that
/// is. A power of two changes no digit of any number, and nothing in the renderer goes by an absolute radiance, so that the
/// picture is the same to the last bit as with any other unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightUnit {
    exponent: i32,
}

impl LightUnit {
    /// `scene_radius` is that of a sphere around all surfaces: a point light counts as bright as it is seen from that far.
    /// The unit is 1 where nothing emits.
    pub(crate) fn of(triangles: &[EmissiveTriangle], others: &[Light], scene_radius: f32) -> LightUnit {
        let near = triangles.iter().map(|t| t.radiance.max_element() as f64);
        let far = others.iter().map(|light| light.brightness(scene_radius as f64));
        let brightest = near.chain(far).filter(|b| b.is_finite()).fold(0.0, f64::max);
        LightUnit { exponent: if brightest > 0.0 { brightest.log2().floor() as i32 } else { 0 } }
    }

    /// Emission of a light in this unit.
    pub fn divide(self, emission: Rgb) -> Rgb {
        scaled(emission, self.factor(-1))
    }

    /// The light with its emission in this unit.
    pub(crate) fn divide_light(self, light: Light) -> Light {
        light.scaled(self.factor(-1))
    }

    /// Radiance in W/(sr·m²) of one in this unit; infinite where that is beyond an `f32`.
    pub fn radiance(self, reckoned: Rgb) -> Rgb {
        scaled(reckoned, self.factor(1))
    }

    /// The same of a square of radiance, which is at most the largest `f32`: a variance may be beyond it where the radiance
    /// itself is not.
    pub fn squared_radiance(self, reckoned: Rgb) -> Rgb {
        (reckoned.as_dvec3() * self.factor(2)).min(DVec3::splat(f32::MAX as f64)).as_vec3()
    }

    /// What one of this unit is in W/(sr·m²).
    pub fn value(self) -> f64 {
        self.factor(1)
    }

    fn factor(self, power: i32) -> f64 {
        2.0f64.powi(self.exponent * power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{ConstantLight, PointLight};
    use glam::Vec3;

    fn unit(light: Light) -> LightUnit {
        LightUnit::of(&[], &[light], 2.0)
    }

    #[test]
    fn the_brightest_light_is_about_one() {
        for radiance in [f32::from_bits(1), 1e-30, 0.5, 1.0, 3.0, 1e20, f32::MAX] {
            let light = Light::from(ConstantLight { radiance: Rgb::new(radiance, 0.25 * radiance, 0.0) });
            let unit = unit(light.clone());
            let Light::Constant(ConstantLight { radiance: reckoned }) = unit.divide_light(light) else {
                unreachable!()
            };
            assert!((1.0..2.0).contains(&reckoned.x), "{radiance:e} is reckoned as {reckoned}");
            assert_eq!(unit.radiance(reckoned).x, radiance);
            assert_eq!(unit.radiance(Rgb::ONE).x as f64, unit.value());
        }
        let point = PointLight { position: Vec3::ZERO, intensity: Rgb::splat(8.0) };
        assert_eq!(unit(point.into()).value(), 2.0, "8 W/sr seen from a distance of 2");
        assert_eq!(unit(ConstantLight { radiance: Rgb::ZERO }.into()).value(), 1.0);
        assert_eq!(LightUnit::of(&[], &[], 0.0).value(), 1.0);
    }

    #[test]
    fn a_variance_is_never_infinite_and_a_radiance_says_so() {
        let unit = unit(ConstantLight { radiance: Rgb::splat(1e30) }.into());
        assert_eq!(unit.squared_radiance(Rgb::splat(0.1)), Rgb::splat(f32::MAX));
        assert_eq!(unit.radiance(Rgb::splat(1e20)), Rgb::INFINITY);
        assert_eq!(unit.squared_radiance(Rgb::ZERO), Rgb::ZERO);
    }
}
