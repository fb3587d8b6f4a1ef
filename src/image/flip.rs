//! ꟻLIP: how different two pictures look when they are shown in turn at the same place (Andersson et al. 2020, "FLIP: A
//! Difference Evaluator for Alternating Images"), for pictures with low dynamic range.

use super::Image;
use super::metrics::check_sizes;
use crate::Result;
use glam::{Mat3, Vec3};
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_SQRT_2, PI};

/// Pixels per degree of vision: a 4K screen of 0.7 m at 0.7 m (the paper's §4.1).
pub(crate) const PIXELS_PER_DEGREE: f32 = 67.0;

/// Exponents of the colour and of the feature difference, and the two points of the map that compresses the largest
/// colour differences (the paper's qc, qf, pc, pt).
const COLOUR_POWER: f32 = 0.7;
const FEATURE_POWER: f32 = 0.5;
const KNEE: f32 = 0.4;
const KNEE_VALUE: f32 = 0.95;

/// Width in degrees of the features that are looked for (w in the paper).
const FEATURE_WIDTH: f32 = 0.082;

/// Contrast sensitivity as sums of Gaussians a·√(π/b)·exp(−π²x²/b), x in degrees: pairs (a, b) for the achromatic, the
/// red-green and the blue-yellow channel (the paper's table 1).
const SENSITIVITY: [&[(f32, f32)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
/// The largest of their b, by which all are cut off.
const WIDEST: f32 = 0.04;

/// Mean ꟻLIP over the pixels, in [0, 1]; 0 for equal pictures. Both pictures hold linear radiance and are shown as the
/// project's PNG shows them: brightened by `exposure` stops, clamped to [0, 1], as sRGB, seen at [`PIXELS_PER_DEGREE`].
/// NaN counts as black.
///
/// # Errors
/// [`crate::Error::Scene`] where the sizes differ or the pictures are empty.
pub(crate) fn flip(image: &Image, reference: &Image, exposure: f32) -> Result<f32> {
    check_sizes(image, reference)?;
    let (a, b) = (Shown::new(image, exposure), Shown::new(reference, exposure));
    let largest = largest_difference();
    let difference = |i: usize| {
        let colour = compress(hunt_hyab(a.colour[i], b.colour[i]).powf(COLOUR_POWER), largest);
        let edges = (a.edges[i] - b.edges[i]).abs();
        let points = (a.points[i] - b.points[i]).abs();
        let feature = (FRAC_1_SQRT_2 * edges.max(points)).powf(FEATURE_POWER);
        colour.powf(1.0 - feature) as f64
    };
    let sum: f64 = (0..a.colour.len()).map(difference).sum();
    Ok((sum / a.colour.len() as f64) as f32)
}

/// What is compared of a picture, pixel by pixel.
struct Shown {
    /// Filtered by contrast sensitivity, in L*a*b* with Hunt's adjustment.
    colour: Vec<Vec3>,
    /// Strength of edges and of points.
    edges: Vec<f32>,
    points: Vec<f32>,
}

impl Shown {
    fn new(image: &Image, exposure: f32) -> Shown {
        let gain = exposure.exp2();
        let seen = |x: f32| if x > 0.0 { (x * gain).min(1.0) } else { 0.0 };
        let shown = |pixel: &Vec3| to_opponent(pixel.map(seen));
        let opponent: Vec<Vec3> = image.data.par_iter().map(shown).collect();
        let achromatic: Vec<f32> = opponent.iter().map(|c| (c.x + 16.0) / 116.0).collect();
        let size = Size { width: image.width, height: image.height };
        let channels: Vec<Vec<f32>> = (0..3).map(|k| see(&opponent, k, size)).collect();
        let colour = |i: usize| perceived(Vec3::new(channels[0][i], channels[1][i], channels[2][i]));
        let colour = (0..opponent.len()).into_par_iter().map(colour).collect();
        let [smooth, first, second] = feature_kernels();
        Shown {
            colour,
            edges: gradient(&achromatic, size, &first, &smooth),
            points: gradient(&achromatic, size, &second, &smooth),
        }
    }
}

#[derive(Clone, Copy)]
struct Size {
    width: usize,
    height: usize,
}

/// Channel `k` through the eye's contrast sensitivity.
fn see(opponent: &[Vec3], k: usize, size: Size) -> Vec<f32> {
    let channel: Vec<f32> = opponent.iter().map(|c| c[k]).collect();
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let gaussian = |b: f32| kernel(radius, |x| (-(PI * x / PIXELS_PER_DEGREE).powi(2) / b).exp());
    let total = |kernel: &[f32]| kernel.iter().sum::<f32>();
    let parts: Vec<(f32, Vec<f32>)> = SENSITIVITY[k].iter().map(|&(a, b)| (a * (PI / b).sqrt(), gaussian(b))).collect();
    let norm: f32 = parts.iter().map(|(weight, g)| weight * total(g).powi(2)).sum();
    let mut seen = vec![0.0; channel.len()];
    for (weight, g) in &parts {
        let filtered = convolve(&channel, size, g, g);
        seen.iter_mut().zip(filtered).for_each(|(sum, x)| *sum += x * weight / norm);
    }
    seen
}

/// A Gaussian, and its first and second derivative, each scaled so that its positive weights sum to 1 and its negative
/// ones to −1.
fn feature_kernels() -> [Vec<f32>; 3] {
    let sigma = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * sigma).ceil() as i32;
    let g = |x: f32| (-x * x / (2.0 * sigma * sigma)).exp();
    let smooth = kernel(radius, g);
    let total: f32 = smooth.iter().sum();
    let balanced = |kernel: Vec<f32>| -> Vec<f32> {
        let positive: f32 = kernel.iter().filter(|w| **w > 0.0).sum();
        let negative: f32 = -kernel.iter().filter(|w| **w < 0.0).sum::<f32>();
        kernel.into_iter().map(|w| w / if w > 0.0 { positive } else { negative }).collect()
    };
    let first = balanced(kernel(radius, |x| -x * g(x)));
    let second = balanced(kernel(radius, |x| (x * x / (sigma * sigma) - 1.0) * g(x)));
    [smooth.into_iter().map(|w| w / total).collect(), first, second]
}

fn kernel(radius: i32, weight: impl Fn(f32) -> f32) -> Vec<f32> {
    (-radius..=radius).map(|x| weight(x as f32)).collect()
}

/// Length of the vector of responses to `across` along rows and along columns, each smoothed the other way.
fn gradient(values: &[f32], size: Size, across: &[f32], smooth: &[f32]) -> Vec<f32> {
    let x = convolve(values, size, across, smooth);
    let y = convolve(values, size, smooth, across);
    x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect()
}

/// Separable correlation, with the picture's border repeated outwards.
fn convolve(values: &[f32], size: Size, along_rows: &[f32], along_columns: &[f32]) -> Vec<f32> {
    let Size { width, height } = size;
    let (rx, ry) = (along_rows.len() / 2, along_columns.len() / 2);
    let mut rows = vec![0.0; values.len()];
    rows.par_chunks_mut(width).zip(values.par_chunks(width)).for_each(|(to, from)| {
        for (x, out) in to.iter_mut().enumerate() {
            let at = |k: usize| from[(x + k).saturating_sub(rx).min(width - 1)];
            *out = along_rows.iter().enumerate().map(|(k, w)| w * at(k)).sum();
        }
    });
    let mut result = vec![0.0; values.len()];
    result.par_chunks_mut(width).enumerate().for_each(|(y, to)| {
        for (k, w) in along_columns.iter().enumerate() {
            let from = (y + k).saturating_sub(ry).min(height - 1) * width;
            to.iter_mut().zip(&rows[from..from + width]).for_each(|(sum, x)| *sum += w * x);
        }
    });
    result
}

/// CIE XYZ of linear sRGB under D65 (IEC 61966-2-1); columns.
const XYZ: Mat3 = Mat3::from_cols(
    Vec3::new(0.412_390_8, 0.212_639, 0.019_330_82),
    Vec3::new(0.357_584_33, 0.715_168_65, 0.119_194_78),
    Vec3::new(0.180_480_8, 0.072_192_32, 0.950_532_14),
);

/// XYZ relative to that of white.
fn relative_xyz(linear: Vec3) -> Vec3 {
    XYZ * linear / (XYZ * Vec3::ONE)
}

/// YCxCz (Kolpatzik & Bouman 1995), linear in the light: brightness, red-green, blue-yellow.
fn to_opponent(linear: Vec3) -> Vec3 {
    let c = relative_xyz(linear);
    Vec3::new(116.0 * c.y - 16.0, 500.0 * (c.x - c.y), 200.0 * (c.y - c.z))
}

/// L*a*b* with Hunt's adjustment of a YCxCz colour, brought back into the cube of linear colours first.
fn perceived(opponent: Vec3) -> Vec3 {
    let y = (opponent.x + 16.0) / 116.0;
    let relative = Vec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
    let linear = XYZ.inverse() * (relative * (XYZ * Vec3::ONE));
    hunt(to_lab(linear.clamp(Vec3::ZERO, Vec3::ONE)))
}

fn to_lab(linear: Vec3) -> Vec3 {
    const DELTA: f32 = 6.0 / 29.0;
    let f =
        relative_xyz(linear).map(|t| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    Vec3::new(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z))
}

/// Colours look less vivid where it is dark (Hunt 1952).
fn hunt(lab: Vec3) -> Vec3 {
    Vec3::new(lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z)
}

/// HyAB distance (Abasi et al. 2020): lightness and chroma differ separately.
fn hunt_hyab(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// The largest colour difference there is, between the display's green and blue, to the power of the others.
fn largest_difference() -> f32 {
    hunt_hyab(hunt(to_lab(Vec3::Y)), hunt(to_lab(Vec3::Z))).powf(COLOUR_POWER)
}

/// Maps [0, largest] to [0, 1], the lower part to almost all of it.
fn compress(difference: f32, largest: f32) -> f32 {
    let knee = KNEE * largest;
    if difference < knee {
        KNEE_VALUE / knee * difference
    } else {
        KNEE_VALUE + (difference - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How the second of two pictures differs, and their mean ꟻLIP by the authors' own program.
    const VALUES: [(usize, f32); 3] = [(1, 0.691_249), (2, 0.170_647), (3, 0.519_574)];

    /// Two pictures of 48 × 32 pixels with gradients, edges and points, made of integers so that any program can make
    /// them again: a rounding-free pattern over 255, as *stored* sRGB values.
    fn pattern(variant: usize) -> Image {
        let stored = |x: usize, y: usize, k: usize| {
            let base = match k {
                0 => (5 * x + 3 * y) % 256,
                1 => (7 * y + 2 * x) % 256,
                _ => {
                    if (x / 8 + y / 8).is_multiple_of(2) {
                        200
                    } else {
                        40
                    }
                }
            };
            let moved = match variant {
                1 => base / 2 + 30,
                2 if (x * 31 + y * 17).is_multiple_of(23) => 255 - base,
                3 => {
                    if k == 2 {
                        255 - base
                    } else {
                        base
                    }
                }
                _ => base,
            };
            super::super::srgb::decode(moved as f32 / 255.0)
        };
        let pixel = |i: usize| Vec3::from_array(std::array::from_fn(|k| stored(i % 48, i / 48, k)));
        Image { width: 48, height: 32, data: (0..48 * 32).map(pixel).collect() }
    }

    #[test]
    fn values_of_the_authors_program() {
        // flip-evaluator 1.7 from PyPI on these pictures:
        // flip_evaluator.evaluate(reference, test, "LDR", parameters={"ppd": 67}), mean of the map
        for (variant, wanted) in VALUES {
            let got = flip(&pattern(variant), &pattern(0), 0.0).unwrap();
            assert!((got - wanted).abs() < 2e-4, "{variant}: {got} is not {wanted}");
        }
    }

    #[test]
    fn equal_pictures_do_not_differ_and_opposite_ones_do() {
        let solid = |value: f32| Image { width: 9, height: 7, data: vec![Vec3::splat(value); 63] };
        assert_eq!(flip(&pattern(2), &pattern(2), 0.0).unwrap(), 0.0);
        let far = flip(&solid(1.0), &solid(0.0), 0.0).unwrap();
        assert!(far > 0.9 && far <= 1.0, "{far}");
        // brighter than white is white, and what is not a number is black
        assert_eq!(flip(&solid(5.0), &solid(1.0), 0.0).unwrap(), 0.0);
        assert_eq!(flip(&solid(f32::NAN), &solid(0.0), 0.0).unwrap(), 0.0);
        assert_eq!(flip(&solid(0.5), &solid(1.0), 1.0).unwrap(), 0.0);
        assert!(flip(&solid(0.5), &pattern(0), 0.0).is_err());
    }
}
