//! Actions: strata of the hemisphere, and the crate's only conversion from their probabilities to densities.

use crate::math::warp;
use glam::Vec3;
use std::f32::consts::TAU;

/// The hemisphere cut into `side`² strata of equal solid angle: the cells of a square grid under the concentric
/// equal-area map, so that strata are compact everywhere, also around the pole.
#[derive(Clone, Debug)]
pub struct Strata {
    side: u32,
    /// Mean of cosθ over each stratum.
    cosines: Vec<f32>,
}

impl Strata {
    pub fn new(side: u32) -> Strata {
        let cosines = (0..side * side).map(|k| mean_cosine(side, k)).collect();
        Strata { side, cosines }
    }

    /// K, the number of strata.
    #[inline]
    pub fn count(&self) -> usize {
        self.cosines.len()
    }

    /// Strata along each side of the square.
    #[inline]
    pub fn side(&self) -> usize {
        self.side as usize
    }

    /// Solid angle of one stratum, 2π/K sr.
    #[inline]
    pub fn solid_angle(&self) -> f32 {
        TAU / self.count() as f32
    }

    /// Mean cosine to the normal over each stratum.
    pub fn cosines(&self) -> &[f32] {
        &self.cosines
    }

    /// The stratum of a unit direction in the table's frame; `None` below the horizon.
    #[inline]
    pub fn index(&self, local: Vec3) -> Option<usize> {
        if local.z < 0.0 {
            return None;
        }
        let u = warp::uniform_hemisphere_to_square(local);
        let cell = |v: f32| ((v * self.side as f32) as u32).min(self.side - 1);
        Some((cell(u[1]) * self.side + cell(u[0])) as usize)
    }

    /// Uniform direction in stratum `k`, in the table's frame.
    #[inline]
    pub fn direction(&self, k: usize, u: [f32; 2]) -> Vec3 {
        let (x, y) = (k as u32 % self.side, k as u32 / self.side);
        let inverse = 1.0 / self.side as f32;
        warp::square_to_uniform_hemisphere([(x as f32 + u[0]) * inverse, (y as f32 + u[1]) * inverse])
    }

    /// Density per steradian of drawing a stratum with probability `pmf` and then a direction in it uniformly:
    /// P(k)·K/2π (Dahm & Keller 2017).
    #[inline]
    pub fn density(&self, pmf: f32) -> f32 {
        pmf * (self.count() as f32 / TAU)
    }
}

/// In closed form: the concentric map sends the point (x, y) of [−1, 1]² to cosθ = 1 − max(|x|, |y|)².
fn mean_cosine(side: u32, k: u32) -> f32 {
    let (x, y) = (distances(side, k % side), distances(side, k / side));
    let square = |[a, b]: [f64; 2]| (a * a + a * b + b * b) / 3.0;
    let mean = if x == y { mean_square_of_the_larger(x) } else { square(if x[0] > y[0] { x } else { y }) };
    (1.0 - mean) as f32
}

/// The range of |x| over column `i` of `side` that cut [−1, 1].
fn distances(side: u32, i: u32) -> [f64; 2] {
    // mirrored to the right half; counted in half columns from the middle, so that equal ranges are equal numbers
    let right = i.max(side - 1 - i);
    let (from, to) = ((2 * right).saturating_sub(side), 2 * right + 2 - side);
    [from as f64 / side as f64, to as f64 / side as f64]
}

/// Mean of max(u, v)² for u and v uniform in [a, b]: the larger has the density 2(m − a)/(b − a)².
fn mean_square_of_the_larger([a, b]: [f64; 2]) -> f64 {
    let whole = (b.powi(4) - a.powi(4)) / 4.0 - a * (b.powi(3) - a.powi(3)) / 3.0;
    2.0 * whole / (b - a).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    #[test]
    fn a_direction_drawn_in_a_stratum_is_found_in_it() {
        let mut rng = Rng::new(1);
        for side in [1, 2, 3, 8, 13] {
            let strata = Strata::new(side);
            let misses = (0..100_000)
                .filter(|i| {
                    let k = i % strata.count();
                    strata.index(strata.direction(k, rng.f32x2())) != Some(k)
                })
                .count();
            // only directions within rounding of a border may fall to the neighbour
            assert!(misses <= 5, "side {side}: {misses} of 100000");
        }
    }

    #[test]
    fn cosines_integrate_to_pi() {
        for side in [1, 2, 3, 4, 12, 15] {
            let strata = Strata::new(side);
            let integral = strata.cosines().iter().sum::<f32>() * strata.solid_angle();
            assert!((integral - std::f32::consts::PI).abs() < 1e-5, "side {side}: {integral}");
        }
    }

    #[test]
    fn cosines_are_the_means_of_directions_drawn() {
        let mut rng = Rng::new(2);
        for side in [1, 3, 4] {
            let strata = Strata::new(side);
            for (k, cosine) in strata.cosines().iter().enumerate() {
                let n = 20_000;
                let mean = (0..n).map(|_| strata.direction(k, rng.f32x2()).z).sum::<f32>() / n as f32;
                // the deviation of one cosine is below 0.3: six standard errors are 0.0127
                assert!((mean - cosine).abs() < 0.0127, "side {side}, stratum {k}: {mean} for {cosine}");
            }
        }
    }
}
