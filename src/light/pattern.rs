//! Emitters that do not send the same from everywhere: screens, windows of a picture, letters, leaves of a lampshade that are seen
//! through in places.

use crate::math::alias::AliasTable;
use crate::math::{ONE_MINUS_EPSILON, Rgb, luminance, warp};
use std::sync::Arc;

/// By how much the radiance of emissive triangles varies over them.
///
/// Emission from a picture is multiplied by it. Where an emitter is seen through in part, a ray that arrives at a point is stopped
/// there, and sees the emission, with the probability of the opacity, and otherwise goes on as if there were no surface.
/// Next-event estimation weighs emission by the same number, so that both have one mean.
pub(crate) trait EmitterPattern: Send + Sync {
    /// What [`EmissiveTriangle::radiance`] is multiplied by, each component in [0, 1]. `weights` are barycentric, of the second and
    /// third corner of the triangle as [`EmissiveTriangle`] has them.
    ///
    /// [`EmissiveTriangle`]: super::EmissiveTriangle
    /// [`EmissiveTriangle::radiance`]: super::EmissiveTriangle::radiance
    fn factor(&self, triangle: u32, weights: [f32; 2]) -> Rgb;

    /// How many texels lie under the triangle: how fine the pattern is there. 1 where it is the same everywhere.
    fn texels(&self, triangle: u32) -> f64;
}

/// The pattern of one triangle, with a distribution of points that follows it.
///
/// The unit square, which [`warp::square_to_triangle`] makes the triangle of without changing shares of area, is cut into `side`²
/// cells. A cell is drawn by its mean luminance, and a point uniformly within, so that the density over that of uniform points is
/// constant in a cell. A share [`DEFENSIVE`] of the points is uniform, so that what the means have missed is still drawn.
#[derive(Clone)]
pub(super) struct TrianglePattern {
    pattern: Arc<dyn EmitterPattern>,
    triangle: u32,
    mean: Rgb,
    /// `None` where there is one cell.
    cells: Option<Cells>,
}

#[derive(Clone)]
struct Cells {
    rows: AliasTable,
    columns: Vec<AliasTable>,
}

/// Share of points that go by area alone: a tenth bounds what they weigh by ten (defensive mixtures, Hesterberg 1995).
const DEFENSIVE: f64 = 0.1;

/// The most cells along a side, and of all triangles together (16 bytes each).
const MOST_CELLS: f64 = 128.0;
const ALL_CELLS: f64 = (1 << 22) as f64;

/// Points along a side by which a mean is estimated: at least so many in a triangle, at most so many in a cell, and the square of those
/// of all triangles together.
const LEAST_POINTS: f64 = 4.0;
const MOST_POINTS: f64 = 16.0;
const ALL_POINTS: f64 = (1 << 24) as f64;

/// How finely the patterns of a scene are looked at, so that all of them together take bounded memory and time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fineness {
    cells: f64,
    points: f64,
}

impl Fineness {
    /// For triangles of which each has so many texels.
    pub(super) fn of(texels: impl Iterator<Item = f64> + Clone) -> Fineness {
        let sum = |f: fn(f64) -> f64| texels.clone().map(f).sum::<f64>();
        let cells = sum(|texels| whole_sides(texels).0.powi(2));
        let points = sum(|texels| {
            let (cells, points) = whole_sides(texels);
            (cells * points).powi(2)
        });
        let scaled = |sum: f64, most: f64| if sum > most { (most / sum).sqrt() } else { 1.0 };
        Fineness { cells: scaled(cells, ALL_CELLS), points: scaled(points, ALL_POINTS) }
    }

    /// Cells along a side, and points along a side of each.
    pub(super) fn sides(self, texels: f64) -> (u32, u32) {
        let (cells, points) = whole_sides(texels);
        let cells = (cells * self.cells).floor().max(1.0);
        let least = (LEAST_POINTS / cells).ceil();
        (cells as u32, (points * self.points).clamp(least, MOST_POINTS) as u32)
    }
}

/// The same without a bound on all together: a cell and 2 × 2 points for each texel, as far as may be.
fn whole_sides(texels: f64) -> (f64, f64) {
    let side = texels.sqrt().ceil();
    let cells = side.clamp(1.0, MOST_CELLS);
    (cells, (2.0 * side / cells).ceil().clamp(1.0, MOST_POINTS))
}

impl TrianglePattern {
    pub(super) fn new(pattern: &Arc<dyn EmitterPattern>, triangle: u32, fineness: Fineness) -> TrianglePattern {
        let (side, points) = fineness.sides(pattern.texels(triangle));
        let mut new = TrianglePattern { pattern: pattern.clone(), triangle, mean: Rgb::ONE, cells: None };
        let means: Vec<Rgb> = (0..side * side).map(|i| new.mean_of(side, [i % side, i / side], points)).collect();
        let count = (side * points).pow(2) as f64;
        // one point more that counts as 1 (Laplace's rule of succession): what only seems to be black is still drawn
        let sum: glam::DVec3 = means.iter().map(|mean| mean.as_dvec3()).sum();
        new.mean = ((sum * f64::from(points).powi(2) + 1.0) / (count + 1.0)).as_vec3();
        new.cells = (side > 1).then(|| Cells::new(&means, side as usize)).flatten();
        new
    }

    /// Mean over `points`² points of a cell.
    fn mean_of(&self, side: u32, [column, row]: [u32; 2], points: u32) -> Rgb {
        let place = |cell: u32, point: u32| (cell as f32 + (point as f32 + 0.5) / points as f32) / side as f32;
        let all = (0..points).flat_map(|i| (0..points).map(move |j| [i, j]));
        let sum: Rgb = all.map(|[i, j]| self.at([place(column, i), place(row, j)])).sum();
        sum / (points * points) as f32
    }

    /// The factor at the point that a light draws with these numbers.
    pub(super) fn at(&self, u: [f32; 2]) -> Rgb {
        self.pattern.factor(self.triangle, warp::square_to_triangle(u))
    }

    /// Moves numbers to where the pattern is bright; also by how much the density is that of uniform points there.
    pub(super) fn warp(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        self.cells.as_ref().map_or((u, 1.0), |cells| cells.warp(u))
    }

    /// The same density at barycentric weights of the second and third corner.
    pub(super) fn density(&self, weights: [f32; 2]) -> f32 {
        self.cells.as_ref().map_or(1.0, |cells| cells.density(warp::triangle_to_square(weights)))
    }

    /// Its mean, positive; of a single texel and more as many points as there are texels tell.
    pub(super) fn mean(&self) -> Rgb {
        self.mean
    }
}

impl Cells {
    /// `None` where all means are black.
    fn new(means: &[Rgb], side: usize) -> Option<Cells> {
        let bright: Vec<f64> = means.iter().map(|&mean| luminance(mean) as f64).collect();
        let sum: f64 = bright.iter().sum();
        let even = 1.0 / means.len() as f64;
        let share = |bright: f64| DEFENSIVE * even + (1.0 - DEFENSIVE) * bright / sum;
        let weights: Vec<f64> = bright.into_iter().map(share).collect();
        if sum.is_nan() || sum <= 0.0 {
            return None;
        }
        let rows: Vec<f64> = weights.chunks(side).map(|row| row.iter().sum()).collect();
        Some(Cells {
            rows: AliasTable::new(&rows)?,
            columns: weights.chunks(side).map(AliasTable::new).collect::<Option<_>>()?,
        })
    }

    fn warp(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        let side = self.rows.len() as f32;
        let (row, y) = self.rows.sample(u[1]);
        let (column, x) = self.columns[row].sample(u[0]);
        let inside = |cell: usize, rest: f32| ((cell as f32 + rest) / side).min(ONE_MINUS_EPSILON);
        ([inside(column, x), inside(row, y)], self.density_of(row, column))
    }

    fn density(&self, u: [f32; 2]) -> f32 {
        let side = self.rows.len();
        let cell = |x: f32| ((x * side as f32) as usize).min(side - 1);
        self.density_of(cell(u[1]), cell(u[0]))
    }

    fn density_of(&self, row: usize, column: usize) -> f32 {
        let cells = (self.rows.len() * self.rows.len()) as f32;
        self.rows.pmf(row) * self.columns[row].pmf(column) * cells
    }
}

impl std::fmt::Debug for TrianglePattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "pattern of triangle {}", self.triangle)
    }
}
