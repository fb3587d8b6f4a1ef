//! Surroundings on a square: the equal-area octahedral mapping of pbrt-v4 (Clarberg 2008, "Fast Equal-Area Mapping of the
//! (Hemi)Sphere using SIMD").

use crate::math::Rgb;
use glam::{DVec3, DVec4};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// Points along a side of a texel on the equator; towards the poles there are more, as pixels are narrower there.
const POINTS: f64 = 4.0;

/// The unit direction of a place on [0, 1]², of which the middle is +z and the corners are −z. Areas are solid angles over 4π.
pub(crate) fn to_sphere([x, y]: [f64; 2]) -> DVec3 {
    let (u, v) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let signed = 1.0 - u.abs() - v.abs();
    let r = 1.0 - signed.abs();
    let phi = if r == 0.0 { FRAC_PI_4 } else { ((v.abs() - u.abs()) / r + 1.0) * FRAC_PI_4 };
    let radius = r * (2.0 - r * r).max(0.0).sqrt();
    DVec3::new((radius * phi.cos()).copysign(u), (radius * phi.sin()).copysign(v), (1.0 - r * r).copysign(signed))
}

/// The same surroundings in latitude and longitude, in the mapping of [`super::environment::Environment`]: width, height and pixels.
///
/// Each texel is cut into points of one solid angle, which give their light to the four pixels about them by their weights between these.
/// A pixel is the mean of what it got, so that even light stays even; the light of a single texel is kept within 1 %.
pub(crate) fn unfolded(side: usize, square: &[Rgb]) -> (usize, usize, Vec<Rgb>) {
    let (width, height) = (2 * side, side + 1);
    let mut sums = vec![DVec4::ZERO; width * height];
    let step = 1.0 / side as f64;
    for (k, texel) in square.iter().enumerate() {
        let (column, row) = ((k % side) as f64, (k / side) as f64);
        let middle = to_sphere([(column + 0.5) * step, (row + 0.5) * step]);
        let sine = (1.0 - middle.y * middle.y).max(0.0).sqrt();
        let points = (POINTS / (sine - 2.0 * step).max(step).sqrt()).ceil();
        let light = texel.as_dvec3().extend(1.0) / (points * points);
        for point in 0..(points * points) as usize {
            let (i, j) = ((point % points as usize) as f64, (point / points as usize) as f64);
            let place = [column + (i + 0.5) / points, row + (j + 0.5) / points];
            give(&mut sums, [width, height], to_sphere(place.map(|x| x * step)), light);
        }
    }
    let mean = |sum: &DVec4| (sum.truncate() / sum.w.max(f64::MIN_POSITIVE)).as_vec3();
    (width, height, sums.iter().map(mean).collect())
}

/// Spreads light from a direction over the pixels about it.
fn give(sums: &mut [DVec4], [width, height]: [usize; 2], direction: DVec3, light: DVec4) {
    let u = direction.x.atan2(-direction.z) / TAU * width as f64 - 0.5;
    let v = direction.y.clamp(-1.0, 1.0).acos() / PI * (height - 1) as f64;
    let (left, above) = (u.floor(), (v as usize).min(height - 2));
    let (a, b) = (u - left, v - above as f64);
    for (row, by_row) in [(above, 1.0 - b), (above + 1, b)] {
        for (column, by_column) in [(left, 1.0 - a), (left + 1.0, a)] {
            let column = column.rem_euclid(width as f64) as usize % width;
            sums[row * width + column] += light * (by_row * by_column);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_where_pbrt_has_them() {
        for (direction, place) in [
            (DVec3::Z, [0.5, 0.5]),
            (DVec3::X, [1.0, 0.5]),
            (DVec3::Y, [0.5, 1.0]),
            (DVec3::NEG_X, [0.0, 0.5]),
            (DVec3::NEG_Z, [1.0, 1.0]),
            // 1 − z = r²: half of the upper hemisphere is within r = √½
            (DVec3::new(0.75f64.sqrt(), 0.0, 0.5), [0.5 + 0.5 * 0.5f64.sqrt(), 0.5]),
        ] {
            let found = to_sphere(place);
            assert!((found - direction).length() < 1e-12, "{place:?}: {found}");
        }
    }

    #[test]
    fn even_light_stays_even() {
        let (width, height, pixels) = unfolded(8, &[Rgb::new(1.0, 2.0, 3.0); 64]);
        assert_eq!((width, height), (16, 9));
        assert!(pixels.iter().all(|p| (*p - Rgb::new(1.0, 2.0, 3.0)).abs().max_element() < 1e-6));
    }

    #[test]
    fn equal_areas_are_equal_solid_angles_and_no_light_is_lost() {
        const SIDE: usize = 16;
        // one bright texel among dark ones: its light is that of 4π over the number of texels
        for lit in [0, 37, 136, 255] {
            let mut square = vec![Rgb::ZERO; SIDE * SIDE];
            square[lit] = Rgb::ONE;
            let (width, height, pixels) = unfolded(SIDE, &square);
            // ∫ of the bilinear picture, by fine steps
            const STEPS: usize = 8;
            let mut sum = 0.0;
            for row in 0..(height - 1) * STEPS {
                let v = (row as f64 + 0.5) / STEPS as f64;
                let (j, t) = (v as usize, v.fract());
                let sine = (PI * v / (height - 1) as f64).sin();
                let line = |j: usize| pixels[j * width..][..width].iter().map(|p| f64::from(p.x)).sum::<f64>();
                sum += sine * (line(j) * (1.0 - t) + line(j + 1) * t);
            }
            let solid = sum * (TAU / width as f64) * (PI / ((height - 1) * STEPS) as f64);
            // the steps themselves are good to 0.3 %
            let wanted = 4.0 * PI / (SIDE * SIDE) as f64;
            assert!((solid / wanted - 1.0).abs() < 0.015, "texel {lit}: {solid}, not {wanted}");
        }
    }
}
