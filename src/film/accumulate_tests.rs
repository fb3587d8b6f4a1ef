use super::*;
use crate::math::rng::Rng;

fn tile(side: u32) -> Tile {
    Tile { x: 0, y: 0, width: side, height: side }
}

/// `spp` samples of uniform noise of the given width about 1 in every pixel.
fn add_noise(film: &mut Film, spp: u32, width: f32, rng: &mut Rng) {
    add_samples(film, spp, width, rng);
    film.end_iteration();
}

fn add_samples(film: &mut Film, spp: u32, width: f32, rng: &mut Rng) {
    let tile = tile(film.width);
    for _ in 0..spp {
        let sum: Vec<Rgb> = (0..tile.pixels()).map(|_| Rgb::splat(1.0 + width * (rng.f32() - 0.5))).collect();
        let sum_squares = sum.iter().map(|&v| v * v).collect();
        film.add(&tile, &TileSamples { sum, sum_squares, ..TileSamples::default() });
    }
    film.add_samples(spp, false);
}

fn mean_square_error(estimate: &Estimate) -> f32 {
    estimate.mean.iter().map(|v| (v.x - 1.0).powi(2)).sum::<f32>() / estimate.mean.len() as f32
}

#[test]
fn variance_layer_is_the_variance_of_the_mean() {
    for combine in [Combine::All, Combine::InverseVariance] {
        let mut film = Film::new(64, 64, combine, &[]);
        let mut rng = Rng::new(3);
        for spp in [8, 16, 32] {
            add_noise(&mut film, spp, 1.0, &mut rng);
        }
        let estimate = film.resolve();
        let (claimed, real) =
            (estimate.variance.iter().map(|v| v.x).sum::<f32>() / 4096.0, mean_square_error(&estimate));
        // 4096 pixels: the error of a variance estimated from them is √(2/4096) = 2.2 %
        assert!((claimed / real - 1.0).abs() < 0.1, "{combine:?}: {claimed} claimed, {real} seen");
    }
}

#[test]
fn inverse_variance_beats_equal_weights_where_iterations_differ() {
    let error = |combine| {
        let mut film = Film::new(64, 64, combine, &[]);
        let mut rng = Rng::new(5);
        add_noise(&mut film, 32, 4.0, &mut rng);
        add_noise(&mut film, 32, 0.5, &mut rng);
        mean_square_error(&film.resolve())
    };
    let (all, weighted, last) = (error(Combine::All), error(Combine::InverseVariance), error(Combine::Last));
    assert!(weighted < 0.1 * all && weighted < last, "all {all}, weighted {weighted}, last {last}");
}

/// Of 1000 samples one holds all the light.
fn add_fireflies(film: &mut Film, spp: u32, rng: &mut Rng) {
    let tile = tile(film.width);
    for _ in 0..spp {
        let sample = |rng: &mut Rng| if rng.f32() < 1e-3 { 1e3 } else { 0.0 };
        let sum: Vec<Rgb> = (0..tile.pixels()).map(|_| Rgb::splat(sample(rng))).collect();
        let sum_squares = sum.iter().map(|&v| v * v).collect();
        film.add(&tile, &TileSamples { sum, sum_squares, ..TileSamples::default() });
    }
    film.add_samples(spp, false);
    film.end_iteration();
}

#[test]
fn a_noisy_beginning_is_known_as_such() {
    let mut rng = Rng::new(7);
    let (mut film, mut late) = (Film::new(64, 64, Combine::InverseVariance, &[]), Film::new(64, 64, Combine::All, &[]));
    // variance of a sample: 999 first, then 0.6
    add_fireflies(&mut film, 4, &mut rng);
    for spp in [8, 16] {
        let mut again = rng;
        add_noise(&mut film, spp, 2.7, &mut rng);
        add_noise(&mut late, spp, 2.7, &mut again);
    }
    let (all, late) = (mean_square_error(&film.resolve()), mean_square_error(&late.resolve()));
    assert!(all < 1.05 * late, "{all} with the beginning, {late} without");
}

#[test]
fn a_black_film_stays_black_and_finite() {
    let mut film = Film::new(8, 8, Combine::InverseVariance, &[]);
    let t = tile(8);
    let black = || TileSamples { sum: vec![Rgb::ZERO; 64], sum_squares: vec![Rgb::ZERO; 64], ..TileSamples::default() };
    for _ in 0..16 {
        film.add(&t, &black());
    }
    film.add_samples(16, false);
    film.end_iteration();
    assert!(film.resolve().mean.iter().all(|&v| v == Rgb::ZERO));
}

#[test]
fn scaling_the_light_scales_the_picture_and_nothing_else() {
    let picture = |scale: f32| {
        let mut film = Film::new(16, 16, Combine::InverseVariance, &[]);
        let mut rng = Rng::new(9);
        for spp in [8u32, 16] {
            for _ in 0..spp {
                let sum: Vec<Rgb> = (0..256).map(|_| Rgb::splat(scale * rng.f32())).collect();
                let sum_squares = sum.iter().map(|&v| v * v).collect();
                film.add(&tile(16), &TileSamples { sum, sum_squares, ..TileSamples::default() });
            }
            film.add_samples(spp, false);
            film.end_iteration();
        }
        film.resolve().mean
    };
    let (one, tiny) = (picture(1.0), picture(2.0f32.powi(-20)));
    for (a, b) in one.iter().zip(&tiny) {
        assert!((b.x * 2.0f32.powi(20) / a.x - 1.0).abs() < 1e-5);
    }
}

#[test]
fn variances_of_the_newest_iteration_are_of_its_own_samples() {
    let (mut film, mut rng) = (Film::new(64, 64, Combine::InverseVariance, &[]), Rng::new(11));
    let mean = |variances: Option<Vec<f64>>| variances.map(|v| v.iter().sum::<f64>() / v.len() as f64).unwrap();
    // of 3, 2 and 4 samples: the first two are weighed together, the third by itself
    for (spp, width) in [(3, 4.0), (2, 1.0), (4, 2.0)] {
        add_samples(&mut film, spp, width, &mut rng);
        // of uniform noise; 4096 pixels of two samples tell it to 3 %
        let (found, expected) = (mean(film.newest_variances()), (width as f64).powi(2) / 12.0);
        assert!((found / expected - 1.0).abs() < 0.15, "{spp} spp: {found} and not {expected}");
        film.end_iteration();
    }
    add_samples(&mut film, 3, 4.0, &mut rng);
    film.end_iteration();
    add_samples(&mut film, 2, 1.0, &mut rng);
    assert!(mean(film.sample_variances()) > 2.0 * mean(film.newest_variances()), "the film has both in one group");
}
