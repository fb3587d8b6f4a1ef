use super::{Estimate, sphere_integral};
use crate::light::sky::{Sky, SkyLight};
use crate::light::source::{Findings, LightParameters, LightSource};
use crate::light::sun::{SunDisc, SunLight};
use crate::light::{LightSample, luminance};
use crate::math::Rgb;
use crate::math::rng::Rng;
use crate::stats::{Chi2Report, DirectionTest, Domain};
use glam::Vec3;
use std::f64::consts::PI;

/// False alarms of each χ² test.
const LEVEL: f64 = 1e-6;
/// Lumens of a watt at the eye's most sensitive.
const EFFICACY: f64 = 683.0;

fn sun(angular_diameter: f32) -> SunDisc {
    let direction = Vec3::new(1.0, -2.0, 0.5);
    SunLight { direction, irradiance: Rgb::new(3.0, 2.0, 1.0), angular_diameter }
        .load(&mut Findings::default())
        .unwrap()
}

fn sky(elevation: f32, sun: bool) -> Sky {
    let sun_direction = Vec3::new(0.6 * elevation.cos(), elevation.sin(), -0.8 * elevation.cos());
    SkyLight { sun_direction, sun, ..SkyLight::default() }.load(&mut Findings::default()).unwrap()
}

fn drawn(light: &impl LightSource, rng: &mut Rng) -> Option<LightSample> {
    light.sample(Vec3::ZERO, rng.f64(), rng.f32x2())
}

fn chi2(sampled: &SunDisc, pdf: &SunDisc) -> Chi2Report {
    let mut rng = Rng::new(5);
    let test = DirectionTest { domain: Domain::Sphere, cos_bins: 32, phi_bins: 64, samples: 400_000, depth: 4 };
    test.run(|| drawn(sampled, &mut rng).map(|s| s.wi), |w| pdf.pdf(w))
}

#[test]
fn a_large_sun_is_drawn_as_its_density_says() {
    let report = chi2(&sun(60.0), &sun(60.0));
    assert!(report.passes(LEVEL), "{report:?}");
    assert!(!chi2(&sun(60.0), &sun(61.0)).passes(LEVEL), "a sun of another size is told apart");
}

#[test]
fn a_small_sun_is_even_over_its_disc() {
    for diameter in [0.01, 0.533, 5.0] {
        let (sun, mut rng) = (sun(diameter), Rng::new(2));
        let to_sun = Vec3::new(-1.0, 2.0, -0.5).normalize();
        let edge = 1.0 - (0.5 * f64::from(diameter)).to_radians().cos();
        let mut lost = 0;
        // within the disc, half the squared chord over that of the edge is even in [0, 1]: mean 1/2
        let share = Estimate::of(100_000, || match drawn(&sun, &mut rng) {
            None => {
                lost += 1;
                0.5
            }
            Some(s) => {
                assert!((f64::from(s.pdf) * 2.0 * PI * edge - 1.0).abs() < 1e-3 && s.radiance == sun.radiance(s.wi));
                0.5 * f64::from((s.wi - to_sun).length_squared()) / edge
            }
        });
        assert!(share.z(0.5).abs() < 5.0 || (share.mean - 0.5).abs() < 2e-3, "{diameter}: {}", share.mean);
        assert!(lost < 200, "{lost} of 100000 are lost at the rim of a disc of {diameter}°");
        let facing = Estimate::of(20_000, || {
            drawn(&sun, &mut rng).map_or(0.0, |s| f64::from(s.radiance.x * s.wi.dot(to_sun) / s.pdf))
        });
        assert!((facing.mean / 3.0 - 1.0).abs() < 2e-3, "{diameter}: irradiance {}", facing.mean);
    }
}

#[test]
fn sky_and_sun_together_give_the_light_of_both() {
    for with_sun in [false, true] {
        let (sky, mut rng) = (sky(0.7, with_sun), Rng::new(8));
        let up = |w: Vec3| f64::from(w.y.max(0.0));
        let dome = sphere_integral(1500, |w| f64::from(luminance(sky.dome_radiance(w))) * up(w));
        let sun = sky.sun_irradiance().map_or(0.0, |e| f64::from(luminance(e)) * 0.7f64.sin());
        let found = Estimate::of(400_000, || {
            drawn(&sky, &mut rng).map_or(0.0, |s| f64::from(luminance(s.radiance)) * up(s.wi) / f64::from(s.pdf))
        });
        found.assert_is(dome + sun, 0.02);
        assert!(sun == 0.0 || sun > 2.0 * dome, "the sun outshines a clear sky: {sun} and {dome}");
        // diffuse light of clear skies on level ground: 10 to 20 klx (CIE and IESNA tables)
        assert!((7e3..25e3).contains(&(EFFICACY * dome)), "{} lx", EFFICACY * dome);
    }
}

#[test]
fn a_sky_glows_about_its_sun_is_dark_below_and_stands_upright() {
    let sky = sky(0.5, false);
    let at = |w: Vec3| sky.radiance(w.normalize());
    let to_sun = Vec3::new(0.6 * 0.5f32.cos(), 0.5f32.sin(), -0.8 * 0.5f32.cos());
    let (glow, opposite) = (at(to_sun), at(Vec3::new(-to_sun.x, to_sun.y, -to_sun.z)));
    assert!(luminance(glow) > 3.0 * luminance(opposite) && opposite.z > opposite.x, "{glow} {opposite}");
    assert_eq!(at(Vec3::new(0.3, -0.2, 0.5)), Rgb::ZERO);
    let upright = SkyLight { sun_direction: Vec3::new(0.3, 0.1, 0.9), up: Vec3::Z, sun: false, ..SkyLight::default() };
    let upright = upright.load(&mut Findings::default()).unwrap();
    assert!(
        luminance(upright.radiance(Vec3::new(0.3, 0.1, 0.9).normalize()))
            > luminance(upright.radiance(Vec3::new(-0.9, 0.0, 0.3).normalize()))
    );
    assert_eq!(upright.radiance(Vec3::new(0.0, 0.9, -0.3).normalize()), Rgb::ZERO);
    let set = SkyLight { sun_direction: Vec3::new(1.0, -0.1, 0.0), ..SkyLight::default() };
    assert!(set.load(&mut Findings::default()).unwrap_err().to_string().contains("below the horizon"));
}
