use super::*;
use crate::guiding::Hue;
use crate::math::rng::Rng;

fn with(mean: f32, square: f32, rays: f32) -> Moments {
    let rays = rays.max(1.0);
    Moments { square: square / rays, variance: (square - mean * mean) / rays, expected: 0.0, hue: Hue::GREY }
}

/// Of a picture whose paths take as many rays as they have variance. Pixels have a luminance of 2 unless said.
fn efficiency() -> RouletteNormalisation {
    RouletteNormalisation { inverse_luminance: Vec::new(), scale: 1.0 }
}

#[test]
fn paths_are_those_of_the_formula() {
    // importance 1/2; a second moment of 4 at 4 rays: 1/2 · √(4/4)
    assert_eq!(efficiency().paths(with(1.0, 4.0, 4.0), 1.0, 0.5, 8.0), 0.5);
    // importance 2; below one by the second moment it would not be: 2 · √((68 − 4)/16) by the variance
    assert_eq!(efficiency().paths(with(2.0, 68.0, 16.0), 4.0, 0.5, 8.0), 4.0);
    // never worth splitting where every path brings the same, nor ending one for that
    assert_eq!(efficiency().paths(with(3.0, 9.0, 1.0), 100.0, 0.5, 8.0), 1.0);
}

#[test]
fn paths_stay_within_their_bounds() {
    let mut rng = Rng::new(1);
    let wide = |rng: &mut Rng| (60.0 * rng.f32() - 30.0).exp2();
    let (mut fewest, mut most) = (f32::MAX, 0.0f32);
    for _ in 0..20_000 {
        let mean = wide(&mut rng);
        let known = with(mean, mean * mean + wide(&mut rng), 1.0 + 10.0 * rng.f32());
        let efficiency = RouletteNormalisation { inverse_luminance: Vec::new(), scale: wide(&mut rng) };
        let (inverse_luminance, reflected) = (wide(&mut rng), wide(&mut rng));
        for max_split in [1.0, 4.0, 8.0, 0.5] {
            let paths = efficiency.paths(known, reflected, inverse_luminance, max_split);
            assert!((MIN_SURVIVAL..=max_split.max(1.0)).contains(&paths), "{paths} at most {max_split}");
            (fewest, most) = (fewest.min(paths), most.max(paths));
        }
    }
    assert_eq!((fewest, most), (MIN_SURVIVAL, 8.0), "both bounds were met");
    // black states and black throughput
    assert_eq!(efficiency().paths(with(0.0, 0.0, 1.0), 1.0, 0.5, 8.0), MIN_SURVIVAL);
    assert_eq!(efficiency().paths(with(1.0, 1.0, 1.0), 0.0, 0.5, 8.0), MIN_SURVIVAL);
}

/// Twice the squared weight of what is at stake, as a shadow ray costs half a ray; between a tenth and 1.
#[test]
fn shadow_rays_are_cast_where_they_may_change_the_picture() {
    // 1/4 · √(1/2 · 1/2 / ½)
    let quarter = efficiency().cast(0.5, 0.5, 0.5);
    assert!((quarter - 0.25 * 0.5f32.sqrt()).abs() < 1e-6, "{quarter}");
    assert_eq!(efficiency().cast(0.5, 1.0, 0.25), efficiency().cast(0.5, 1.0, 0.75));
    assert_eq!([1e-3, 0.5, 0.999].map(|open| efficiency().cast(1e-3, 1.0, open)), [MIN_CAST; 3]);
    assert_eq!(efficiency().cast(100.0, 1.0, 0.5), 1.0);
    // what is sure needs no ray, and what cannot be weighed gets one
    assert_eq!([0.0, 1.0].map(|open| efficiency().cast(100.0, 1.0, open)), [MIN_CAST; 2]);
    assert_eq!([f32::NAN, f32::INFINITY].map(|brought| efficiency().cast(brought, 1.0, 0.5)), [1.0; 2]);
    for k in [2.0f32.powi(-20), 2.0f32.powi(20)] {
        assert_eq!(efficiency().cast(0.5 * k, 0.5 / k, 0.5), quarter);
    }
}

#[test]
fn paths_do_not_go_by_exposure() {
    let mut rng = Rng::new(2);
    for _ in 0..1000 {
        let (mean, extra, rays, reflected) = (rng.f32(), 4.0 * rng.f32(), 1.0 + 9.0 * rng.f32(), rng.f32());
        let square = mean * mean + extra;
        let paths = |k: f32| efficiency().paths(with(mean * k, square * k * k, rays), reflected, 3.0 / k, 8.0);
        let one = paths(1.0);
        assert!(paths(2.0f32.powi(20)) == one && paths(2.0f32.powi(-20)) == one);
        assert!((paths(1e6) / one - 1.0).abs() < 1e-4 && (paths(1e-6) / one - 1.0).abs() < 1e-4);
        // a pixel of another brightness is another matter
        let twice = efficiency().paths(with(mean, square, rays), reflected, 6.0, 8.0);
        assert!(twice >= one && (twice > one || one == 1.0 || one == 8.0 || twice == MIN_SURVIVAL || twice == 1.0));
    }
}
