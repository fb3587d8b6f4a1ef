//! Whether a picture that was given as reference shows the scene: as bright, and not mirrored. A picture of another scene, exposure or
//! orientation would make every figure wrong and none of them suspicious.

use super::measure::{Reference, blocks};
use crate::image::Image;
use crate::math::Rgb;

/// How much brighter or darker a reference may be on average than a render here. Other renderers read materials a little differently;
/// other exposures and colour spaces differ by more.
const BRIGHTER: f64 = 1.25;

/// Least correlation of brightness, block by block, once noise is accounted for.
const ALIKE: f64 = 0.7;

/// A reference is turned where its squared differences are so many times what noise explains, and so many times those of the
/// turned one. One turn fits better than another where it leaves less than this share.
const FAR: f64 = 10.0;
const BETTER: f64 = 4.0;
const TOLD: f64 = 0.9;

/// Share of the blocks' variance that must not be noise, for their correlation to be judged: an even picture has no shape.
const RELIABLE: f64 = 0.5;

/// Standard errors that are forgiven: 5 are an accident in 1.7 million.
const ERRORS: f64 = 5.0;

/// What speaks against a reference, by a short render of the scene and the variances of its pixels' means.
pub(crate) fn unlike(reference: &Image, picture: &Image, variance: &[Rgb]) -> Option<String> {
    let pilot = Reference { image: picture.clone(), variance: Some(variance.to_vec()) }.blocks()?;
    let given = blocks(reference);
    let n = given.len() as f64;
    let [mean, wanted] = [&pilot.mean, &given].map(|values| values.iter().sum::<f64>() / n);
    let error = pilot.variance.iter().sum::<f64>().sqrt() / n;
    let bound = BRIGHTER.ln() + ERRORS * error / mean.max(f64::MIN_POSITIVE);
    if mean > 0.0 && (wanted / mean).ln().abs() > bound {
        let ratio = wanted / mean;
        return Some(format!("it is {ratio:.3} times as bright on average as a short render of the scene"));
    }
    let noise = pilot.variance.iter().sum::<f64>() / n;
    let spread = pilot.mean.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / n;
    let reliable = 1.0 - noise / spread;
    if reliable.is_nan() || reliable < RELIABLE {
        return None;
    }
    // squares of what is left once both are as bright on average
    let misfit = |image: &Image| -> f64 {
        blocks(image).iter().zip(&pilot.mean).map(|(given, own)| (own - given * mean / wanted).powi(2)).sum()
    };
    let own = misfit(reference);
    let turns =
        [("mirrored left to right", true, false), ("upside down", false, true), ("turned by 180 degrees", true, true)];
    let turned = turns.map(|(how, x, y)| (how, misfit(&flipped(reference, x, y))));
    // of those that fit equally well, the first: what is the same upside down needs no second turn
    let best = turned.into_iter().reduce(|best, next| if next.1 < TOLD * best.1 { next } else { best });
    if let Some((how, _)) = best.filter(|(_, left)| own > FAR * n * noise && own > BETTER * left) {
        return Some(format!("it seems to be {how}: so turned, it is much more like a short render of the scene"));
    }
    let alike = correlation(&pilot.mean, &given) / reliable.sqrt();
    (alike < ALIKE)
        .then(|| format!("it shows something else than a short render of the scene: their correlation is {alike:.2}"))
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let [ma, mb] = [a, b].map(|v| v.iter().sum::<f64>() / n);
    let product =
        |x: &[f64], mx: f64, y: &[f64], my: f64| x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum::<f64>();
    let size = (product(a, ma, a, ma) * product(b, mb, b, mb)).sqrt();
    if size > 0.0 { product(a, ma, b, mb) / size } else { 0.0 }
}

fn flipped(image: &Image, x: bool, y: bool) -> Image {
    let (w, h) = (image.width, image.height);
    let at = |i: usize| {
        let (column, row) = (i % w, i / w);
        let column = if x { w - 1 - column } else { column };
        let row = if y { h - 1 - row } else { row };
        image.data[row * w + column]
    };
    Image { width: w, height: h, data: (0..w * h).map(at).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::luminance;
    use crate::math::rng::Rng;

    /// Brighter to the right, and below, with noise of a tenth.
    fn scene(noise: f32, seed: u64) -> Image {
        let mut rng = Rng::new(seed);
        let pixel = |i: usize| (i % 40) as f32 / 40.0 + 2.0 * (i / 40) as f32 / 30.0 + 0.1;
        let data = (0..1200).map(|i| Rgb::splat(pixel(i) * (1.0 + noise * (rng.f32() - 0.5)))).collect();
        Image { width: 40, height: 30, data }
    }

    fn says(reference: &Image) -> String {
        let variance = vec![Rgb::splat(1e-3); 1200];
        unlike(reference, &scene(0.1, 1), &variance).unwrap_or_default()
    }

    fn scaled(by: f32) -> Image {
        let mut image = scene(0.0, 2);
        image.data.iter_mut().for_each(|c| *c *= by);
        image
    }

    #[test]
    fn what_is_no_picture_of_the_scene_is_told_by_its_fault() {
        let good = scene(0.0, 2);
        assert_eq!((says(&good), says(&scaled(1.1))), (String::new(), String::new()));
        assert!(
            says(&scaled(2.0)).contains("2.0") && says(&scaled(0.5)).contains("times as bright"),
            "{}",
            says(&scaled(2.0))
        );
        assert!(says(&flipped(&good, false, true)).contains("upside down"));
        assert!(says(&flipped(&good, true, true)).contains("180"));
        let mean = good.data.iter().map(|c| luminance(*c)).sum::<f32>() / 1200.0;
        let about = Rgb::splat(2.0 * mean);
        let other = Image { data: good.data.iter().rev().map(|c| about - *c).collect(), ..good.clone() };
        assert_eq!(says(&other), "", "turned about and inverted it is the same");
        let mut rng = Rng::new(3);
        let noise = Image { data: (0..1200).map(|_| Rgb::splat(2.0 * mean * rng.f32())).collect(), ..good };
        assert!(says(&noise).contains("something else"), "{}", says(&noise));
    }

    #[test]
    fn left_and_right_are_told_apart_where_they_differ() {
        let slope = |i: usize| Rgb::splat(0.1 + (i % 40) as f32 / 40.0);
        let image = Image { width: 40, height: 30, data: (0..1200).map(slope).collect() };
        let found = unlike(&flipped(&image, true, false), &image, &vec![Rgb::splat(1e-6); 1200]);
        assert!(found.unwrap().contains("left to right"));
    }

    #[test]
    fn a_nearly_symmetric_picture_is_told_from_its_mirror_image() {
        // a bright lamp in the middle, and one wall a little darker than the other: mirrored, they correlate by 0.98
        let room = |i: usize| {
            let (x, y) = ((i % 40) as f32 / 40.0, (i / 40) as f32 / 30.0);
            let lamp = if (0.4..0.6).contains(&x) && y < 0.2 { 5.0 } else { 0.0 };
            Rgb::splat(0.5 + lamp + if x < 0.1 { 0.2 } else { 0.0 })
        };
        let image = Image { width: 40, height: 30, data: (0..1200).map(room).collect() };
        let mirrored = flipped(&image, true, false);
        assert!(correlation(&blocks(&image), &blocks(&mirrored)) > 0.95);
        let variance = vec![Rgb::splat(1e-4); 1200];
        assert_eq!(unlike(&image, &image, &variance), None);
        assert!(unlike(&mirrored, &image, &variance).unwrap().contains("left to right"));
    }

    #[test]
    fn a_noisy_or_even_picture_accuses_nobody() {
        let even = Image { width: 40, height: 30, data: vec![Rgb::ONE; 1200] };
        assert_eq!(unlike(&even, &even, &vec![Rgb::splat(0.1); 1200]), None);
        assert_eq!(unlike(&scene(0.0, 2), &scaled(2.0), &vec![Rgb::splat(1e5); 1200]), None);
    }
}
