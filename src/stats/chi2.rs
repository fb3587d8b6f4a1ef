//! Pearson's χ² test of samplers against their densities: of directions (solid angle) and of indices.
//!
//! Cells are equal steps of (cosθ, φ); what the density leaves of probability 1 (samples that fail, delta lobes)
//! is one more cell, so a sampler may lose samples only as its density says.

use super::quadrature::{Rect, Refinement, integrate};
use glam::Vec3;
use statrs::function::gamma::gamma_ur;
use std::f64::consts::TAU;
use std::fmt;

/// Cells are pooled until they expect this many samples (Cochran 1954's rule of thumb).
const MIN_EXPECTED: f64 = 5.0;
/// A cell that expects fewer samples than this must get none.
const IMPOSSIBLE: f64 = 1e-6;
/// By how much quadrature and single precision may lift the mass of a density above 1.
const MASS_TOLERANCE: f64 = 1e-3;

/// Where a density may be positive, in the local frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Domain {
    Sphere,
    /// z ≥ 0 only: a sample below is a failure.
    Hemisphere,
}

/// A χ² test of a direction sampler.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectionTest {
    pub(crate) domain: Domain,
    /// Equal steps of cosθ; even on the sphere, so that the horizon is an edge.
    pub(crate) cos_bins: usize,
    /// Equal steps of φ.
    pub(crate) phi_bins: usize,
    pub(crate) samples: u64,
    /// Halvings of every cell along θ and φ before the quadrature looks whether more are needed: features
    /// narrower than a cell's side/2^(depth + 2) may be missed. The test then fails, it never passes for that.
    pub(crate) depth: u32,
}

/// What a test found. A `failure` says what no chance explains; the p-value is then 0.
#[derive(Clone, Debug)]
pub(crate) struct Chi2Report {
    pub(crate) statistic: f64,
    pub(crate) degrees_of_freedom: usize,
    /// Probability of a statistic as large or larger if the sampler follows the density.
    pub(crate) p_value: f64,
    /// Integral of the density.
    pub(crate) mass: f64,
    /// Cells that were merged because they expect fewer than five samples.
    pub(crate) pooled: usize,
    /// The cell that adds most to the statistic.
    pub(crate) worst: Option<Cell>,
    pub(crate) failure: Option<String>,
}

/// One cell of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) expected: f64,
    pub(crate) observed: f64,
    /// Index in the order of the test; a pooled cell has that of its first member.
    pub(crate) index: usize,
}

impl Cell {
    fn share(&self) -> f64 {
        (self.observed - self.expected).powi(2) / self.expected
    }
}

impl Chi2Report {
    /// Whether nothing speaks against the sampler at false-alarm probability `level`.
    pub(crate) fn passes(&self, level: f64) -> bool {
        self.failure.is_none() && self.p_value >= level
    }

    fn failed(mass: f64, why: String) -> Chi2Report {
        Chi2Report {
            statistic: f64::INFINITY,
            degrees_of_freedom: 0,
            p_value: 0.0,
            mass,
            pooled: 0,
            worst: None,
            failure: Some(why),
        }
    }
}

impl fmt::Display for Chi2Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(failure) = &self.failure {
            return write!(f, "{failure} (mass {:.6})", self.mass);
        }
        let Chi2Report { statistic, degrees_of_freedom, p_value, mass, pooled, .. } = self;
        write!(
            f,
            "chi2 = {statistic:.1}, {degrees_of_freedom} degrees of freedom, p = {p_value:.3e}, \
             mass {mass:.6}, {pooled} cells pooled"
        )?;
        if let Some(Cell { expected, observed, index }) = self.worst {
            write!(f, "; worst cell {index}: {observed} observed, {expected:.1} expected")?;
        }
        Ok(())
    }
}

impl DirectionTest {
    /// A test with cells of about 8°, resolved to half a degree, and 400 000 samples.
    pub(crate) fn new(domain: Domain) -> DirectionTest {
        let cos_bins = if domain == Domain::Sphere { 24 } else { 12 };
        DirectionTest { domain, cos_bins, phi_bins: 32, samples: 400_000, depth: 2 }
    }

    /// Draws from `sample` (unit directions; `None` is a lost sample) and compares with `pdf` per steradian,
    /// whose mass may be below 1.
    pub(crate) fn run(&self, mut sample: impl FnMut() -> Option<Vec3>, pdf: impl Fn(Vec3) -> f32) -> Chi2Report {
        let masses = self.masses(&pdf);
        let mass: f64 = masses.iter().sum();
        if mass.is_nan() || mass > 1.0 + MASS_TOLERANCE {
            return Chi2Report::failed(mass, "the density has a mass above 1".into());
        }
        let n = self.samples as f64;
        let mut cells: Vec<Cell> = masses
            .iter()
            .chain([&(1.0 - mass).max(0.0)])
            .enumerate()
            .map(|(index, m)| Cell { expected: m * n, observed: 0.0, index })
            .collect();
        for _ in 0..self.samples {
            let index = match sample() {
                None => masses.len(),
                Some(w) => match self.cell_of(w) {
                    Some(index) => index,
                    None => {
                        let why = format!("{w} is not a unit direction of the domain");
                        return Chi2Report::failed(mass, why);
                    }
                },
            };
            cells[index].observed += 1.0;
        }
        pearson(cells, mass)
    }

    fn cos_min(&self) -> f64 {
        if self.domain == Domain::Sphere { -1.0 } else { 0.0 }
    }

    fn cell_of(&self, w: Vec3) -> Option<usize> {
        let unit = (w.length_squared() - 1.0).abs() < 1e-3;
        if !unit || (self.domain == Domain::Hemisphere && w.z < 0.0) {
            return None;
        }
        let cos = (w.z as f64 - self.cos_min()) / (1.0 - self.cos_min());
        let phi = (w.y as f64).atan2(w.x as f64).rem_euclid(TAU) / TAU;
        let step = |v: f64, bins: usize| ((v * bins as f64) as usize).min(bins - 1);
        Some(step(cos, self.cos_bins) * self.phi_bins + step(phi, self.phi_bins))
    }

    /// ∫ pdf dω of every cell.
    fn masses(&self, pdf: &impl Fn(Vec3) -> f32) -> Vec<f64> {
        // over θ, not cosθ, in which a lobe about the pole would be needle-sharp
        let density = |theta: f64, phi: f64| {
            let (sin, cos) = theta.sin_cos();
            let w = Vec3::new((sin * phi.cos()) as f32, (sin * phi.sin()) as f32, cos as f32);
            pdf(w) as f64 * sin
        };
        // far below what chance moves: the two rules differ by more than the finer one errs
        let absolute = 0.1 / self.samples as f64;
        let refinement = Refinement { min_depth: self.depth, max_depth: 9, absolute, relative: 1e-4 };
        let cos_step = (1.0 - self.cos_min()) / self.cos_bins as f64;
        let phi_step = TAU / self.phi_bins as f64;
        let mut masses = Vec::with_capacity(self.cos_bins * self.phi_bins);
        for i in 0..self.cos_bins {
            for j in 0..self.phi_bins {
                let cos = |k: usize| (self.cos_min() + k as f64 * cos_step).clamp(-1.0, 1.0);
                let x = [cos(i + 1).acos(), cos(i).acos()];
                let y = [j, j + 1].map(|k| k as f64 * phi_step);
                masses.push(integrate(&density, Rect { x, y }, refinement));
            }
        }
        masses
    }
}

/// χ² test of `counts` against the probabilities `pmf` of the same indices. Where the pmf sums to less than 1,
/// the rest counts as an outcome that was never observed.
pub(crate) fn chi2_discrete(counts: &[u64], pmf: &[f64]) -> Chi2Report {
    let mass: f64 = pmf.iter().sum();
    if counts.len() != pmf.len() {
        let why = format!("{} counts but {} probabilities", counts.len(), pmf.len());
        return Chi2Report::failed(mass, why);
    }
    if mass.is_nan() || mass > 1.0 + MASS_TOLERANCE || pmf.iter().any(|&p| p < 0.0) {
        return Chi2Report::failed(mass, "these are not probabilities".into());
    }
    let n = counts.iter().sum::<u64>() as f64;
    let rest = (1.0 - mass).max(0.0);
    let cells = pmf
        .iter()
        .chain([&rest])
        .zip(counts.iter().chain([&0]))
        .enumerate()
        .map(|(index, (p, &count))| Cell { expected: p * n, observed: count as f64, index })
        .collect();
    pearson(cells, mass)
}

fn pearson(cells: Vec<Cell>, mass: f64) -> Chi2Report {
    if let Some(c) = cells.iter().find(|c| c.expected < IMPOSSIBLE && c.observed > 0.0) {
        let why = format!("{} samples in cell {}, where the density is zero", c.observed, c.index);
        return Chi2Report::failed(mass, why);
    }
    let (cells, pooled) = pool(cells);
    if cells.len() < 2 {
        return Chi2Report::failed(mass, "fewer than two cells expect five samples".into());
    }
    let statistic: f64 = cells.iter().map(Cell::share).sum();
    let degrees_of_freedom = cells.len() - 1;
    Chi2Report {
        statistic,
        degrees_of_freedom,
        p_value: gamma_ur(0.5 * degrees_of_freedom as f64, 0.5 * statistic.max(1e-300)),
        mass,
        pooled,
        worst: cells.into_iter().max_by(|a, b| a.share().total_cmp(&b.share())),
        failure: None,
    }
}

/// Merges cells, smallest first, until each expects enough; also how many were merged.
fn pool(mut cells: Vec<Cell>) -> (Vec<Cell>, usize) {
    cells.sort_by(|a, b| a.expected.total_cmp(&b.expected));
    let mut kept: Vec<Cell> = Vec::with_capacity(cells.len());
    let mut pooled = 0;
    for cell in cells {
        match kept.last_mut() {
            Some(last) if last.expected < MIN_EXPECTED => {
                pooled += 1;
                last.expected += cell.expected;
                last.observed += cell.observed;
            }
            _ => kept.push(cell),
        }
    }
    (kept, pooled)
}

#[cfg(test)]
#[path = "chi2_tests.rs"]
mod tests;
