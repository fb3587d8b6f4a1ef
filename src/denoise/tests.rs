//! With the library, where it is.

use super::*;
use crate::math::rng::mix;

/// The library; `None`, after saying so, where it is missing.
fn denoiser() -> Option<Denoiser> {
    match Denoiser::new(2) {
        Ok(denoiser) => Some(denoiser),
        Err(error) => {
            eprintln!("SKIPPED: {error}");
            None
        }
    }
}

const SIDE: usize = 96;

/// Left and right half of a picture, one a hundred times as bright as the other, with noise of their own size.
fn noisy(light: f32) -> (Image, Image, Vec<Rgb>, Vec<Rgb>) {
    let mut clean = Image::new(SIDE, SIDE);
    let mut noisy = clean.clone();
    let (mut albedo, mut normal) = (Vec::new(), Vec::new());
    for i in 0..SIDE * SIDE {
        let left = i % SIDE < SIDE / 2;
        let random = (mix(i as u64) >> 40) as f32 / (1 << 24) as f32;
        clean.data[i] = Rgb::new(1.0, 0.5, 0.25) * if left { 0.01 * light } else { light };
        noisy.data[i] = clean.data[i] * 2.0 * random;
        albedo.push(if left { Rgb::splat(0.2) } else { Rgb::splat(0.8) });
        normal.push(if left { Rgb::X } else { Rgb::Z });
    }
    (clean, noisy, albedo, normal)
}

/// Mean of the squared relative differences.
fn error(image: &Image, clean: &Image) -> f64 {
    let squares = image.data.iter().zip(&clean.data).map(|(a, b)| f64::from(((*a - *b) / *b).length_squared() / 3.0));
    squares.sum::<f64>() / clean.data.len() as f64
}

#[test]
fn noise_goes_and_the_picture_stays() {
    let Some(denoiser) = denoiser() else { return };
    assert!(denoiser.version().starts_with("Open Image Denoise 2."), "{}", denoiser.version());
    let mut errors = Vec::new();
    for stops in [0, -80, 80] {
        let light = (stops as f32).exp2();
        let (clean, noisy, albedo, normal) = noisy(light);
        let features = Features { albedo: &albedo, normal: &normal };
        let denoised = denoiser.denoise(&noisy, &features).unwrap();
        let (before, after) = (error(&noisy, &clean), error(&denoised, &clean));
        assert!(before > 0.3 && after < 0.25 * before, "light of {light:e}: error {before} before, {after} after");
        errors.push(after);
    }
    assert_eq!(errors, [errors[0]; 3], "the strength of light changes nothing");
}

#[test]
fn undefined_pixels_do_not_spread() {
    let Some(denoiser) = denoiser() else { return };
    let (_, mut noisy, albedo, normal) = noisy(1.0);
    (noisy.data[100], noisy.data[4000]) = (Rgb::splat(f32::NAN), Rgb::splat(f32::INFINITY));
    let denoised = denoiser.denoise(&noisy, &Features { albedo: &albedo, normal: &normal }).unwrap();
    assert!(denoised.data.iter().all(|pixel| pixel.is_finite() && pixel.cmpge(Rgb::ZERO).all()));
}

#[test]
fn what_the_library_refuses_is_an_error() {
    let Some(denoiser) = denoiser() else { return };
    let pixels = [Rgb::ONE; 4];
    let refused = denoiser.device.filter(&[("nonsense", &pixels)], (2, 2), &[]).unwrap_err().to_string();
    assert!(refused.starts_with("denoising: "), "{refused}");
    // The device is as good as before.
    assert_eq!(denoiser.device.filter(&[("albedo", &pixels)], (2, 2), &[]).unwrap().len(), 4);
}
