//! Fixed strata of equal solid angle: the actions of the paper's tables.

use crate::math::{ONE_MINUS_EPSILON, warp};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};

/// Which directions strata cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// The hemisphere about +z of the table's frame, by the concentric equal-area map: strata are compact everywhere,
    /// also around the pole.
    Hemisphere,
    /// The sphere in world space, by height and azimuth.
    Sphere,
}

/// A domain cut into strata of equal solid angle, which are the cells of a grid over the unit square.
#[derive(Clone, Debug)]
pub struct Strata {
    domain: Domain,
    /// Strata along the two sides of the square.
    columns: u32,
    lines: u32,
    /// Mean of cosθ over each stratum of a hemisphere.
    cosines: Vec<f32>,
}

impl Strata {
    /// `side`² strata on a hemisphere, twice as many on the sphere.
    pub fn new(domain: Domain, side: u32) -> Strata {
        match domain {
            Domain::Hemisphere => {
                let cosines = (0..side * side).map(|k| mean_cosine(side, k)).collect();
                Strata { domain, columns: side, lines: side, cosines }
            }
            Domain::Sphere => Strata { domain, columns: side, lines: 2 * side, cosines: Vec::new() },
        }
    }

    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// K, the number of strata.
    #[inline]
    pub fn count(&self) -> usize {
        (self.columns * self.lines) as usize
    }

    /// Strata in a line of the square.
    #[inline]
    pub fn columns(&self) -> usize {
        self.columns as usize
    }

    #[inline]
    pub fn lines(&self) -> usize {
        self.lines as usize
    }

    /// Solid angle of one stratum, 2π/K or 4π/K sr.
    #[inline]
    pub fn solid_angle(&self) -> f32 {
        let whole = if self.domain == Domain::Hemisphere { TAU } else { 2.0 * TAU };
        whole / self.count() as f32
    }

    /// Mean cosine to the frame's normal over each stratum of a hemisphere.
    pub fn cosines(&self) -> &[f32] {
        &self.cosines
    }

    /// The stratum of a unit direction in the table's frame; `None` below the horizon of a hemisphere.
    #[inline]
    pub fn index(&self, local: Vec3) -> Option<usize> {
        let u = match self.domain {
            Domain::Hemisphere if local.z < 0.0 => return None,
            Domain::Hemisphere => warp::uniform_hemisphere_to_square(local),
            Domain::Sphere => sphere_to_square(local),
        };
        let cell = |v: f32, n: u32| ((v * n as f32) as u32).min(n - 1);
        Some((cell(u[1], self.lines) * self.columns + cell(u[0], self.columns)) as usize)
    }

    /// Uniform direction in stratum `k`, in the table's frame.
    #[inline]
    pub fn direction(&self, k: usize, u: [f32; 2]) -> Vec3 {
        let (x, y) = (k as u32 % self.columns, k as u32 / self.columns);
        let at = [(x as f32 + u[0]) / self.columns as f32, (y as f32 + u[1]) / self.lines as f32];
        match self.domain {
            Domain::Hemisphere => warp::square_to_uniform_hemisphere(at),
            Domain::Sphere => warp::square_to_uniform_sphere(at),
        }
    }

    /// Density per steradian of drawing a stratum with probability `pmf` and then a direction in it uniformly
    /// (Dahm & Keller 2017: P(k)·K/2π on the hemisphere).
    #[inline]
    pub fn density(&self, pmf: f32) -> f32 {
        pmf / self.solid_angle()
    }
}

/// Inverse of [`warp::square_to_uniform_sphere`].
#[inline]
fn sphere_to_square(w: Vec3) -> [f32; 2] {
    let turn = w.y.atan2(w.x) * (0.5 * FRAC_1_PI);
    let v = if turn < 0.0 { turn + 1.0 } else { turn };
    [(0.5 - 0.5 * w.z).clamp(0.0, ONE_MINUS_EPSILON), v.clamp(0.0, ONE_MINUS_EPSILON)]
}

/// Mean cosine over stratum `k` of `side`² on the hemisphere, in closed form: the concentric map sends the point (x, y) of [−1, 1]² to cosθ = 1 − max(|x|, |y|)².
pub fn mean_cosine(side: u32, k: u32) -> f32 {
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
        let domains = [Domain::Hemisphere, Domain::Sphere];
        for (side, domain) in [1, 2, 3, 8, 13].into_iter().flat_map(|side| domains.map(|d| (side, d))) {
            let strata = Strata::new(domain, side);
            let misses = (0..100_000)
                .filter(|i| {
                    let k = i % strata.count();
                    strata.index(strata.direction(k, rng.f32x2())) != Some(k)
                })
                .count();
            // only directions within rounding of a border may fall to the neighbour
            assert!(misses <= 5, "{domain:?}, side {side}: {misses} of 100000");
        }
    }

    #[test]
    fn cosines_integrate_to_pi() {
        for side in [1, 2, 3, 4, 12, 15] {
            let strata = Strata::new(Domain::Hemisphere, side);
            let integral = strata.cosines().iter().sum::<f32>() * strata.solid_angle();
            assert!((integral - std::f32::consts::PI).abs() < 1e-5, "side {side}: {integral}");
        }
    }

    #[test]
    fn cosines_are_the_means_of_directions_drawn() {
        let mut rng = Rng::new(2);
        for side in [1, 3, 4] {
            let strata = Strata::new(Domain::Hemisphere, side);
            for (k, cosine) in strata.cosines().iter().enumerate() {
                let n = 20_000;
                let mean = (0..n).map(|_| strata.direction(k, rng.f32x2()).z).sum::<f32>() / n as f32;
                // the deviation of one cosine is below 0.3: six standard errors are 0.0127
                assert!((mean - cosine).abs() < 0.0127, "side {side}, stratum {k}: {mean} for {cosine}");
            }
        }
    }
}
