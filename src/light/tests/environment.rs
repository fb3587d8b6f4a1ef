use super::{Estimate, sphere_integral};
use crate::light::environment::Environment;
use crate::light::{LightSample, LightSource, wide_luminance};
use crate::math::Rgb;
use crate::math::rng::Rng;
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes};
use glam::{Affine3A, Mat3, Quat, Vec3};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f32::consts::{FRAC_1_SQRT_2, PI, TAU};
use std::path::Path;

fn environment(width: u32, height: u32, f: impl Fn(u32, u32) -> f32) -> Environment {
    let pixel = |i: u32| Rgb::new(1.0, 0.8, 0.5) * f(i % width, i / width);
    let pixels = (0..width * height).map(pixel).collect();
    let turn = Affine3A::from_quat(Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7));
    Environment::new(width, height, pixels, Rgb::ONE, turn).unwrap()
}

/// What importance sampling finds hard: noise, one pixel in the middle, at the seam and at a pole, black rows, one
/// column, a sun in a dim sky.
fn pictures() -> Vec<Environment> {
    let noise = |x: u32, y: u32| Rng::for_place(1, x, y).f32().powi(4);
    let only = |a: u32, b: u32| move |x: u32, y: u32| if (x, y) == (a, b) { 3.0 } else { 0.0 };
    vec![
        environment(16, 9, noise),
        environment(16, 9, only(5, 4)),
        environment(16, 9, only(15, 6)),
        environment(16, 9, only(3, 0)),
        environment(16, 9, only(3, 8)),
        environment(16, 9, |x, y| if y % 4 < 2 { 0.0 } else { noise(x, y) }),
        environment(1, 7, noise),
        environment(5, 2, noise),
        environment(32, 17, |x, y| if (x, y) == (20, 5) { 1e5 } else { 1.0 }),
    ]
}

#[test]
fn directions_of_a_packet_are_those_of_single_draws() {
    let black = environment(16, 9, |_, _| 0.0);
    let mut rng = Rng::new(17);
    for (number, environment) in pictures().into_iter().chain([black]).map(Box::new).enumerate() {
        let mut drawn = 0;
        for lanes in [0xffff, 0x7f3a, 0x0001, 0].map(Mask::from_bits).into_iter().cycle().take(80) {
            let u_cell: [f64; LANES] = std::array::from_fn(|_| rng.f64());
            let u: [Lanes; 2] = std::array::from_fn(|_| std::array::from_fn(|_| rng.f32()));
            let before = LightSample::far(Vec3::X, Rgb::ONE, 7.0, true);
            let mut samples = [Some(before); LANES];
            environment.sample_lanes(lanes, &Vec3Lanes::ZERO, &u_cell, &u, &mut samples);
            for (k, sample) in samples.into_iter().enumerate() {
                let told = sample.map(|LightSample { wi, radiance, pdf, delta, .. }| (wi, radiance, pdf, delta));
                let single = match lanes.has(k) {
                    false => Some((Vec3::X, Rgb::ONE, 7.0, true)),
                    true => Environment::sample(&environment, u_cell[k], [u[0][k], u[1][k]])
                        .map(|(wi, radiance, pdf)| (wi, radiance, pdf, false)),
                };
                assert_eq!(told, single, "picture {number}, lane {k}");
                drawn += (lanes.has(k) && told.is_some()) as u32;
            }
        }
        assert_eq!(drawn > 0, number < 9, "picture {number}: {drawn} drawn");
    }
}

#[test]
fn pixels_are_where_mitsuba_puts_them() {
    let value = |x: u32, y: u32| (1 + x + 10 * y) as f32;
    let pixels = (0..12).map(|i| Rgb::splat(value(i % 4, i / 4))).collect();
    // light x → world −z, as in a scene of the reference set
    let axes = Mat3::from_cols(Vec3::NEG_Z, Vec3::Y, Vec3::X);
    let env = Environment::new(4, 3, pixels, Rgb::splat(2.0), Affine3A::from_mat3(axes)).unwrap();
    let at = |x: f32, y: f32, z: f32| 0.5 * env.radiance(axes * Vec3::new(x, y, z)).x;
    let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-4, "{a} is not {b}");
    let s = FRAC_1_SQRT_2;
    // centres of the equator's pixels: u = ⅛, ⅜, ⅝, ⅞
    close(at(s, 0.0, -s), value(0, 1));
    close(at(s, 0.0, s), value(1, 1));
    close(at(-s, 0.0, s), value(2, 1));
    close(at(-s, 0.0, -s), value(3, 1));
    // between columns, also over the seam at −z
    close(at(1.0, 0.0, 0.0), 0.5 * (value(0, 1) + value(1, 1)));
    close(at(0.0, 0.0, -1.0), 0.5 * (value(3, 1) + value(0, 1)));
    // the poles are the first and the last row; half way down lies between two rows
    close(at(1e-7, 1.0, -1e-7), value(0, 0));
    close(at(1e-7, -1.0, 1e-7), value(1, 2));
    close(at(0.5, s, -0.5), 0.5 * (value(0, 0) + value(0, 1)));
    close(at(0.5, -s, -0.5), 0.5 * (value(0, 1) + value(0, 2)));
}

#[test]
fn densities_integrate_to_one() {
    for (i, env) in pictures().iter().enumerate() {
        let total = sphere_integral(700, |w| env.pdf(w) as f64);
        assert!((total - 1.0).abs() < 3e-3, "picture {i}: {total}");
        let energy = sphere_integral(700, |w| wide_luminance(env.radiance(w)));
        let relative = energy / env.luminance_integral;
        assert!((relative - 1.0).abs() < 3e-3, "picture {i}: {relative}");
    }
}

const BINS: [usize; 2] = [12, 24];

fn bin(w: Vec3) -> usize {
    let z = (0.5 * (w.z + 1.0) * BINS[0] as f32) as usize;
    let phi = (w.y.atan2(w.x) / TAU + 0.5) * BINS[1] as f32;
    z.min(BINS[0] - 1) * BINS[1] + (phi as usize).min(BINS[1] - 1)
}

/// P value of `n` draws against `pdf`; bins that expect fewer than ten are pooled.
fn chi_square(env: &Environment, n: u32, pdf: impl Fn(Vec3) -> f32) -> f64 {
    let mut rng = Rng::new(3);
    let mut counts = [0.0; BINS[0] * BINS[1]];
    for _ in 0..n {
        counts[bin(env.sample(rng.f64(), rng.f32x2()).unwrap().0)] += 1.0;
    }
    let mut expected = [0.0; BINS[0] * BINS[1]];
    let per_sphere = sphere_integral(800, |w| {
        expected[bin(w)] += pdf(w) as f64;
        1.0
    });
    let scale = n as f64 * per_sphere / (2.0 * 800.0 * 800.0);
    let (mut statistic, mut cells, mut pool) = (0.0, 0, (0.0, 0.0));
    for (count, e) in counts.iter().zip(expected.map(|e| e * scale)) {
        if e < 10.0 {
            pool = (pool.0 + count, pool.1 + e);
        } else {
            statistic += (count - e).powi(2) / e;
            cells += 1;
        }
    }
    if pool.0 > 0.0 || pool.1 > 0.0 {
        statistic += (pool.0 - pool.1).powi(2) / pool.1.max(1.0);
        cells += 1;
    }
    1.0 - ChiSquared::new((cells - 1).max(1) as f64).unwrap().cdf(statistic)
}

#[test]
fn directions_follow_the_density() {
    for (i, env) in pictures().iter().enumerate() {
        let p = chi_square(env, 100_000, |w| env.pdf(w));
        assert!(p > 1e-6, "picture {i}: {p}");
    }
}

/// The negative control: half a pixel off is seen.
#[test]
fn directions_do_not_follow_a_shifted_density() {
    let env = &pictures()[0];
    let axis = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7) * Vec3::Y;
    let shift = Quat::from_axis_angle(axis, PI / 16.0);
    assert!(chi_square(env, 100_000, |w| env.pdf(shift * w)) < 1e-6);
}

#[test]
fn density_is_positive_wherever_there_is_radiance() {
    let mut seen = 0;
    for env in pictures() {
        sphere_integral(100, |w| {
            let lit = env.radiance(w) != Rgb::ZERO;
            assert!(!lit || env.pdf(w) > 0.0);
            seen += lit as usize;
            0.0
        });
    }
    assert!(seen > 50_000);
}

#[test]
fn samples_report_the_radiance_and_density_of_their_direction() {
    for (i, env) in pictures().iter().enumerate() {
        let mut rng = Rng::new(5);
        let mut others = 0;
        for _ in 0..20_000 {
            let (wi, radiance, pdf) = env.sample(rng.f64(), rng.f32x2()).unwrap();
            assert!((wi.length() - 1.0).abs() < 1e-6 && pdf > 0.0);
            let looked_up = env.radiance(wi);
            // the mean of the cell is the scale: bilinear radiance may be steep where it is small
            let mean = pdf * env.luminance_integral as f32;
            let same_radiance = (looked_up - radiance).length() <= 1e-3 * mean;
            let same_density = (env.pdf(wi) / pdf - 1.0).abs() < 1e-4;
            others += !(same_radiance && same_density) as usize;
        }
        // rounding moves a few over the edge of their cell
        assert!(others <= 4, "picture {i}: {others}");
    }
}

#[test]
fn irradiance_is_estimated_without_bias() {
    let normal = Vec3::new(0.48, 0.64, 0.6);
    let cosine = |w: Vec3| w.dot(normal).max(0.0) as f64;
    for env in pictures() {
        let truth = sphere_integral(1000, |w| wide_luminance(env.radiance(w)) * cosine(w));
        let mut rng = Rng::new(11);
        let estimate = Estimate::of(400_000, || {
            let (wi, radiance, pdf) = env.sample(rng.f64(), rng.f32x2()).unwrap();
            wide_luminance(radiance) * cosine(wi) / pdf as f64
        });
        // where the light is behind the surface there is nothing to compare
        if truth > 0.0 {
            estimate.assert_is(truth, 0.05);
        }
    }
}

#[test]
fn a_black_picture_gives_no_light() {
    let env = environment(4, 3, |_, _| 0.0);
    assert!(env.sample(0.5, [0.5, 0.5]).is_none());
    assert_eq!((env.pdf(Vec3::X), env.luminance_integral), (0.0, 0.0));
}

#[test]
fn unusable_pictures_are_errors() {
    let new = |w, h, pixels: Vec<f32>, to_world| {
        let pixels = pixels.into_iter().map(Rgb::splat).collect();
        Environment::new(w, h, pixels, Rgb::ONE, to_world)
    };
    let id = Affine3A::IDENTITY;
    assert!(new(2, 2, vec![1.0; 4], id).is_ok());
    assert!(new(2, 2, vec![1.0; 3], id).is_err());
    assert!(new(4, 1, vec![1.0; 4], id).is_err());
    assert!(new(0, 2, vec![], id).is_err());
    assert!(new(u32::MAX, u32::MAX, vec![], id).is_err());
    assert!(new(2, 2, vec![1.0, f32::NAN, 1.0, 1.0], id).is_err());
    assert!(new(2, 2, vec![1.0, 1.0, f32::INFINITY, 1.0], id).is_err());
    assert!(new(2, 2, vec![1.0; 4], Affine3A::from_scale(Vec3::splat(2.0))).is_err());
    assert!(new(2, 2, vec![1.0; 4], Affine3A::from_scale(Vec3::NAN)).is_err());
    assert!(new(2, 2, vec![1.0; 4], Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0))).is_ok());
    assert_eq!(new(2, 2, vec![1.0, -1.0, 1.0, 1.0], id).unwrap().negative_pixels, 1);
}

#[test]
fn a_mirrored_picture_is_mirrored() {
    let pixels: Vec<Rgb> = (0..12).map(|i| Rgb::splat(i as f32)).collect();
    let with = |t| Environment::new(4, 3, pixels.clone(), Rgb::ONE, t).unwrap();
    let (plain, mirrored) = (with(Affine3A::IDENTITY), with(Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0))));
    let w = Vec3::new(0.48, 0.64, 0.6);
    assert_eq!(mirrored.radiance(Vec3::new(-w.x, w.y, w.z)), plain.radiance(w));
    assert_ne!(mirrored.radiance(w), plain.radiance(w));
}

#[test]
fn a_real_sky_is_sampled_by_its_density() {
    let scenes = std::env::var("PHOTOTAXIS_SCENES")
        .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/scenes").into());
    let path = Path::new(&scenes).join("living-room/textures/Sky_19.exr");
    if !path.exists() {
        eprintln!("SKIPPED: {} is missing", path.display());
        return;
    }
    let image = exr::prelude::read_first_rgba_layer_from_file(
        &path,
        |size, _| (size.width(), Vec::new()),
        |(_, pixels), _, (r, g, b, _): (f32, f32, f32, f32)| pixels.push(Rgb::new(r, g, b)),
    )
    .unwrap();
    let (width, pixels) = image.layer_data.channel_data.pixels;
    let height = pixels.len() / width;
    let env = Environment::new(width as u32, height as u32, pixels, Rgb::ONE, Affine3A::IDENTITY).unwrap();
    let total = sphere_integral(1500, |w| env.pdf(w) as f64);
    assert!((total - 1.0).abs() < 1e-2, "{total}");
    let p = chi_square(&env, 100_000, |w| env.pdf(w));
    assert!(p > 1e-6, "{p}");
}
