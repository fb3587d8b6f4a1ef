//! The perspective camera, and the filter through which a pixel sees.

use crate::film::Filter;
use crate::geometry::Ray;
use crate::scene::description::{CameraDescription, Unsaid};
use crate::{Error, Result};
use glam::Vec3;

/// A pinhole camera with its film size and pixel filter.
#[derive(Clone, Debug)]
pub struct Camera {
    origin: Vec3,
    /// Direction to the film's upper left corner, and its edges, at unit distance along the view.
    corner: Vec3,
    right: Vec3,
    down: Vec3,
    filter: Filter,
    pub width: u32,
    pub height: u32,
}

impl Camera {
    /// # Errors
    /// Where the view direction or the up vector is degenerate.
    pub(crate) fn new(c: &CameraDescription, width: u32, height: u32, filter: Filter) -> Result<Camera> {
        let degenerate = || Error::Scene("the camera's origin, target and up do not span a view".into());
        let forward = (c.target - c.origin).try_normalize().ok_or_else(degenerate)?;
        let right = forward.cross(c.up).try_normalize().ok_or_else(degenerate)?;
        let up = right.cross(forward);
        let half_height = (0.5 * c.vfov.to_radians()).tan();
        let half_width = half_height * width as f32 / height as f32;
        let side = if c.mirrored { -right } else { right };
        Ok(Camera {
            origin: c.origin,
            corner: forward - side * half_width + up * half_height,
            right: side * (2.0 * half_width / width as f32),
            down: up * (-2.0 * half_height / height as f32),
            filter,
            width,
            height,
        })
    }

    /// The camera that was described where and whither, else one that sees the whole box from a little above: a stand-in
    /// until one is found, and for renderers that are only measured.
    pub(crate) fn in_place(said: Option<&CameraDescription>, (low, high): (Vec3, Vec3)) -> CameraDescription {
        if let Some(camera) = said.filter(|camera| !camera.unsaid.is_open()) {
            return camera.clone();
        }
        let (centre, radius) = ((low + high) * 0.5, (high - low).length() * 0.5);
        let vfov = 40.0f32;
        let distance = radius / (0.5 * vfov).to_radians().sin();
        let origin = centre + Vec3::new(0.5, 0.35, 1.0).normalize() * distance;
        CameraDescription { origin, target: centre, vfov, unsaid: Unsaid::default(), ..Default::default() }
    }

    /// The ray of pixel `(x, y)`, counted from the upper left, through a point of the filter drawn by `u`. Filters
    /// are importance sampled (Ernst et al. 2006), so every sample has weight 1 and stays in its pixel's sum.
    #[inline]
    pub(crate) fn ray(&self, x: u32, y: u32, u: [f32; 2]) -> Ray {
        let (fx, fy) = (x as f32 + 0.5 + self.filter.warp(u[0]), y as f32 + 0.5 + self.filter.warp(u[1]));
        let dir = (self.corner + self.right * fx + self.down * fy).normalize();
        Ray { org: self.origin, dir, tfar: f32::INFINITY }
    }
}

impl Filter {
    /// A position in pixels from the centre, distributed like the filter.
    #[inline]
    pub(crate) fn warp(self, u: f32) -> f32 {
        match self {
            Filter::Box => u - 0.5,
            Filter::Tent => {
                if u < 0.5 {
                    (2.0 * u).sqrt() - 1.0
                } else {
                    1.0 - (2.0 - 2.0 * u).max(0.0).sqrt()
                }
            }
            Filter::Gaussian => truncated_gaussian(u),
        }
    }
}

/// Inverse of the distribution function of a normal law with σ = 0.5, cut at ±1.5 (three σ), by the rational
/// approximation of Abramowitz & Stegun (26.2.23, error below 4.5·10⁻⁴ σ).
fn truncated_gaussian(u: f32) -> f32 {
    const TAIL: f32 = 0.001_349_9;
    let p = TAIL + u * (1.0 - 2.0 * TAIL);
    let q = p.min(1.0 - p);
    let t = (-2.0 * q.ln()).sqrt();
    let numerator = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let denominator = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    let z = t - numerator / denominator;
    (0.5 * if p < 0.5 { -z } else { z }).clamp(-1.5, 1.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(mirrored: bool) -> Camera {
        let c = CameraDescription {
            origin: Vec3::new(0.0, 0.0, 5.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            vfov: 90.0,
            mirrored,
            unsaid: Unsaid::default(),
        };
        Camera::new(&c, 200, 100, Filter::Box).unwrap()
    }

    #[test]
    fn the_upper_left_pixel_looks_up_and_left() {
        let d = camera(false).ray(0, 0, [0.0, 0.0]).dir;
        // vertical field 90°: the upper edge is at 45°; the film is twice as wide as high
        assert!((d - Vec3::new(-2.0, 1.0, -1.0).normalize()).length() < 1e-6, "{d}");
        assert!(camera(true).ray(0, 0, [0.0, 0.0]).dir.x > 0.0);
    }

    #[test]
    fn filters_have_their_variance() {
        // box: 1/12; tent: 1/6; Gaussian cut at 3σ: σ²·(1 − 6φ(3)/(2Φ(3) − 1)) = 0.2433
        for (filter, expected) in [(Filter::Box, 1.0 / 12.0), (Filter::Tent, 1.0 / 6.0), (Filter::Gaussian, 0.243_3)] {
            let n = 100_000;
            let moment = |power: i32| {
                (0..n).map(|i| (filter.warp((i as f32 + 0.5) / n as f32) as f64).powi(power)).sum::<f64>() / n as f64
            };
            assert!(moment(1).abs() < 1e-3 && (moment(2) - expected).abs() < 1e-3, "{filter:?}: {}", moment(2));
        }
    }
}
