//! Surroundings from a picture in latitude-longitude form.

mod description;

pub use description::EnvironmentLight;

use super::source::{Extent, LightSource};
use super::tree::FarLight;
use super::{LightSample, check_light, scaled, wide_luminance};
use crate::math::Rgb;
use crate::math::alias::AliasTable;
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes, each};
use crate::{Error, Result};
use glam::{Affine3A, DVec3, Mat3, Vec3};
use std::f64::consts::{PI, TAU};

impl LightSource for Box<Environment> {
    fn checked(self) -> Result<Box<Environment>> {
        Ok(self)
    }

    fn power(&self, section: f64) -> f64 {
        section * self.luminance_integral
    }

    fn extent(&self) -> Extent {
        Extent::Far(FarLight::around(self.luminance_integral, self.excess()))
    }

    fn brightness(&self, _scene_radius: f64) -> f64 {
        self.pixels.iter().map(|p| p.max_element()).fold(0.0, f32::max) as f64
    }

    /// A power of two leaves the choice of directions as it is.
    fn scaled(mut self, factor: f64) -> Box<Environment> {
        self.pixels.iter_mut().for_each(|p| *p = scaled(*p, factor));
        self.luminance_integral *= factor;
        self
    }

    fn sample(&self, _p: Vec3, u_cell: f64, u: [f32; 2]) -> Option<LightSample> {
        let (wi, radiance, pdf) = Environment::sample(self, u_cell, u)?;
        Some(LightSample::far(wi, radiance, pdf, false))
    }

    fn sample_lanes(
        &self,
        lanes: Mask,
        _p: &Vec3Lanes,
        u_cell: &[f64; LANES],
        u: &[Lanes; 2],
        samples: &mut [Option<LightSample>; LANES],
    ) {
        Environment::sample_lanes(self, lanes, u_cell, u, samples);
    }

    fn surrounds(&self) -> bool {
        true
    }

    fn radiance(&self, wi: Vec3) -> Rgb {
        Environment::radiance(self, wi)
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        Environment::pdf(self, wi)
    }
}

/// Radiance from far away in every direction, from a picture.
///
/// In the light's own frame a direction (x, y, z) has u = atan2(x, −z)/2π, wrapped to [0, 1), and v = acos(y)/π.
/// Column i of w has its centre at u = (i + ½)/w, and the picture repeats; row j of h lies at v = j/(h − 1), so that the
/// first and the last row are the poles. In between radiance is bilinear in (u, v). This is the mapping of the plug-in
/// `envmap` of Mitsuba 3.
///
/// Directions are drawn cell by cell, a cell being what four neighbouring pixels enclose: first a row of cells, then one
/// in it, each with the probability of ∫ luminance dω over its bilinear radiance (dω = sinθ dθ dφ, in closed form), then
/// uniformly by solid angle within. The density is thus constant in a cell and positive wherever there is radiance, and
/// has no pole.
#[derive(Clone, Debug)]
pub(crate) struct Environment {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
    /// Orthonormal.
    to_world: Mat3,
    /// Chooses the row of cells; `None` for a black picture.
    rows: Option<AliasTable>,
    /// Chooses the cell in a row; `None` for black rows.
    cells: Vec<Option<AliasTable>>,
    /// 1/sr, per row: the inverse of one cell's solid angle.
    inverse_solid_angle: Vec<f64>,
    /// Cosines of the polar angles of the rows of pixels.
    cosines: Vec<f64>,
    /// ∫ luminance dω over the sphere, in W/m² by luminance.
    pub(super) luminance_integral: f64,
    /// How many pixels had a component below zero.
    pub(super) negative_pixels: usize,
}

/// Where a direction falls: the cell and the position in it, in [0, 1]².
struct Place {
    column: usize,
    row: usize,
    s: f64,
    t: f64,
}

impl Environment {
    /// What is needed beside the picture to draw its pixels.
    const TABLE_BYTES_PER_PIXEL: u64 = AliasTable::BYTES_PER_BIN;

    /// `pixels`: linear radiance, W/(sr·m²), row by row from +y, multiplied by `scale`. `to_world` must be a rotation,
    /// with or without a mirroring; its translation means nothing to a light at infinity. Components below zero, which
    /// filters leave in pictures, count as zero, and are counted.
    ///
    /// An error where the picture has another size than it says or fewer than two rows, where a number is infinite or
    /// undefined, and where `to_world` scales or shears.
    pub fn new(width: u32, height: u32, pixels: Vec<Rgb>, scale: Rgb, to_world: Affine3A) -> Result<Environment> {
        if width == 0 || height < 2 || pixels.len() as u64 != width as u64 * height as u64 {
            let n = pixels.len();
            return Err(fault(format!("{n} pixels for {width} × {height}; at least 1 × 2 needed")));
        }
        check_light(scale, true, "the scale of an environment")?;
        let mut environment = Environment {
            width: width as usize,
            height: height as usize,
            pixels,
            to_world: orthonormal(to_world)?,
            rows: None,
            cells: Vec::new(),
            inverse_solid_angle: Vec::new(),
            cosines: Vec::new(),
            luminance_integral: 0.0,
            negative_pixels: 0,
        };
        environment.scale_pixels(scale)?;
        environment.cosines = (0..height as usize).map(|row| environment.polar_angle(row).cos()).collect();
        environment.build_distribution();
        Ok(environment)
    }

    /// Radiance from the unit direction `wi` (world space), W/(sr·m²).
    pub fn radiance(&self, wi: Vec3) -> Rgb {
        self.bilinear(&self.place(wi))
    }

    /// Density per steradian with which [`Self::sample`] draws the unit direction `wi` (world space).
    pub fn pdf(&self, wi: Vec3) -> f32 {
        let place = self.place(wi);
        self.cell_pdf(place.row, place.column)
    }

    /// A direction in world space, its radiance and its density per steradian; `u_cell` chooses the cell, `u` the
    /// direction in it. `None` for a black picture.
    ///
    /// Radiance and density are those of the chosen cell: a direction may fall into the neighbour by rounding, and the
    /// neighbour's density may be smaller by orders of magnitude.
    pub fn sample(&self, u_cell: f64, u: [f32; 2]) -> Option<(Vec3, Rgb, f32)> {
        let (row, rest) = self.rows.as_ref()?.sample_wide(u_cell);
        let (column, _) = self.cells[row].as_ref()?.sample_wide(rest);
        let (wi, place) = self.direction([column, row], u);
        Some((wi, place.blend(&self.corners([column, row])), self.cell_pdf(row, column)))
    }

    /// [`Self::sample`] for the lanes of a packet. Tables and pixels of a large picture are in no cache: what one step reads for
    /// all lanes is on its way at once.
    fn sample_lanes(
        &self,
        lanes: Mask,
        u_cell: &[f64; LANES],
        u: &[Lanes; 2],
        samples: &mut [Option<LightSample>; LANES],
    ) {
        let Some(rows) = &self.rows else { return each(lanes).for_each(|k| samples[k] = None) };
        let (row, rest) = rows.sample_lanes(u_cell);
        let (mut cells, mut drawn) = ([rows; LANES], Mask::NONE);
        for k in each(lanes) {
            samples[k] = None;
            if let Some(of_row) = &self.cells[row[k] as usize] {
                cells[k] = of_row;
                drawn.set(k, true);
            }
        }
        let (column, _) = AliasTable::sample_each(&cells, &rest);
        let cell = |k: usize| [column[k] as usize, row[k] as usize];
        let (mut corners, mut pdf) = ([[Rgb::ZERO; 4]; LANES], [0.0; LANES]);
        for k in each(drawn) {
            corners[k] = self.corners(cell(k));
            pdf[k] = self.cell_pdf(row[k] as usize, column[k] as usize);
        }
        for k in each(drawn) {
            let (wi, place) = self.direction(cell(k), [u[0][k], u[1][k]]);
            samples[k] = Some(LightSample::far(wi, place.blend(&corners[k]), pdf[k], false));
        }
    }

    /// The direction of the place `u` of a cell, in world space, and that place, which is uniform by solid angle.
    #[inline(always)]
    fn direction(&self, [column, row]: [usize; 2], u: [f32; 2]) -> (Vec3, Place) {
        let (s, c) = (u[0] as f64, u[1] as f64);
        let (upper, lower) = (self.cosines[row], self.cosines[row + 1]);
        let cos = upper + (lower - upper) * c;
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let t = (sin.atan2(cos) / self.polar_angle(1) - row as f64).clamp(0.0, 1.0);
        let (sin_phi, cos_phi) = (TAU * (column as f64 + 0.5 + s) / self.width as f64).sin_cos();
        let local = DVec3::new(sin_phi * sin, cos, -cos_phi * sin).as_vec3();
        (self.to_world * local, Place { column, row, s, t })
    }

    fn scale_pixels(&mut self, scale: Rgb) -> Result<()> {
        for (i, pixel) in self.pixels.iter_mut().enumerate() {
            let scaled = *pixel * scale;
            if !scaled.is_finite() {
                let (x, y) = (i % self.width, i / self.width);
                return Err(fault(format!("the pixel in column {x} of row {y} is {pixel}")));
            }
            self.negative_pixels += (scaled.min_element() < 0.0) as usize;
            *pixel = scaled.max(Rgb::ZERO);
        }
        Ok(())
    }

    fn build_distribution(&mut self) {
        let mut upper = self.row_luminance(0);
        let mut sums = Vec::with_capacity(self.height - 1);
        for row in 0..self.height - 1 {
            let lower = self.row_luminance(row + 1);
            let [a, b] = self.corner_weights(row);
            let right = |column: usize| (column + 1) % self.width;
            // the mean of two corners: radiance is linear in u, and dω does not depend on it
            let mean = |values: &[f64], i: usize| 0.5 * (values[i] + values[right(i)]);
            let weights: Vec<f64> = (0..self.width).map(|i| a * mean(&upper, i) + b * mean(&lower, i)).collect();
            sums.push(weights.iter().sum::<f64>());
            self.cells.push(AliasTable::new(&weights));
            self.inverse_solid_angle.push(1.0 / (a + b));
            upper = lower;
        }
        self.luminance_integral = sums.iter().sum();
        self.rows = AliasTable::new(&sums);
    }

    /// As much of the integral of luminance as is brighter than its mean.
    pub(super) fn excess(&self) -> f64 {
        let Some(rows) = &self.rows else { return 0.0 };
        let mean = self.luminance_integral / (4.0 * PI);
        let in_row = |row: usize| {
            let (sum, even) =
                (self.luminance_integral * f64::from(rows.pmf(row)), mean / self.inverse_solid_angle[row]);
            let cells = self.cells[row].iter().flat_map(|cells| (0..self.width).map(|k| f64::from(cells.pmf(k))));
            cells.map(|share| (sum * share - even).max(0.0)).sum::<f64>()
        };
        (0..self.height - 1).map(in_row).sum()
    }

    fn row_luminance(&self, row: usize) -> Vec<f64> {
        let start = row * self.width;
        self.pixels[start..start + self.width].iter().map(|&p| wide_luminance(p)).collect()
    }

    /// ∫ (1 − t) dω and ∫ t dω over a cell of a row, t running from 0 at its upper edge to 1 at its lower: what upper
    /// and lower corners weigh. They add up to the cell's solid angle.
    fn corner_weights(&self, row: usize) -> [f64; 2] {
        let (theta0, theta1) = (self.polar_angle(row), self.polar_angle(row + 1));
        let slope = (theta1.sin() - theta0.sin()) / self.polar_angle(1);
        let width = TAU / self.width as f64;
        [width * (theta0.cos() - slope), width * (slope - theta1.cos())]
    }

    /// θ of a row of pixels, in [0, π].
    fn polar_angle(&self, row: usize) -> f64 {
        PI * row as f64 / (self.height - 1) as f64
    }

    fn cell_pdf(&self, row: usize, column: usize) -> f32 {
        let (Some(rows), Some(cells)) = (&self.rows, &self.cells[row]) else { return 0.0 };
        let pmf = rows.pmf(row) as f64 * cells.pmf(column) as f64;
        (pmf * self.inverse_solid_angle[row]) as f32
    }

    fn place(&self, wi: Vec3) -> Place {
        let d = (self.to_world.transpose() * wi).as_dvec3();
        let u = d.x.atan2(-d.z) / TAU - 0.5 / self.width as f64;
        let x = (u - u.floor()) * self.width as f64;
        // the arctangent resolves directions near the poles, which the arccosine does not
        let y = d.x.hypot(d.z).atan2(d.y) / self.polar_angle(1);
        let column = (x as usize).min(self.width - 1);
        let row = (y as usize).min(self.height - 2);
        let (s, t) = (x - column as f64, (y - row as f64).min(1.0));
        Place { column, row, s, t }
    }

    fn bilinear(&self, place: &Place) -> Rgb {
        place.blend(&self.corners([place.column, place.row]))
    }

    /// The pixels around a cell: left and right of the upper row, left and right of the lower.
    #[inline(always)]
    fn corners(&self, [column, row]: [usize; 2]) -> [Rgb; 4] {
        let right = if column + 1 < self.width { column + 1 } else { 0 };
        let rows = &self.pixels[row * self.width..][..2 * self.width];
        [column, right, self.width + column, self.width + right].map(|pixel| rows[pixel])
    }
}

impl Place {
    /// The radiance there, between that of the corners of the cell, as of [`Environment::corners`].
    #[inline(always)]
    fn blend(&self, corners: &[Rgb; 4]) -> Rgb {
        let (s, t) = (self.s as f32, self.t as f32);
        corners[0].lerp(corners[1], s).lerp(corners[2].lerp(corners[3], s), t)
    }
}

/// The linear part of `transform` without what rounding did to it.
fn orthonormal(transform: Affine3A) -> Result<Mat3> {
    let m = Mat3::from(transform.matrix3);
    let gram = m.transpose() * m;
    if !gram.abs_diff_eq(Mat3::IDENTITY, 1e-3) {
        return Err(fault("its transform is not a rotation".into()));
    }
    let x = m.x_axis.normalize();
    let y = (m.y_axis - x * x.dot(m.y_axis)).normalize();
    let z = x.cross(y) * m.determinant().signum();
    Ok(Mat3::from_cols(x, y, z))
}

fn fault(message: String) -> Error {
    Error::Scene(format!("environment: {message}"))
}
