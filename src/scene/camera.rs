//! Cameras, and the filter through which a pixel sees.

use crate::film::{FilmSettings, Filter};
use crate::geometry::Ray;
use crate::math::warp::square_to_disk;
use crate::scene::description::{CameraDescription, Projection};
use crate::simd::{LANES, Lanes, Vec3Lanes};
use crate::{Error, Result};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// A camera with its film.
#[derive(Clone, Debug)]
pub struct Camera {
    origin: Vec3,
    view: View,
    /// `None`: a pinhole.
    lens: Option<Lens>,
    filter: Filter,
    /// Of the part of the film that is rendered.
    pub width: u32,
    pub height: u32,
    /// Where that part begins, from the upper left of the whole film, and columns of the whole.
    left: u32,
    top: u32,
    columns: u32,
}

/// Where the pixels of the film look.
#[derive(Clone, Debug)]
enum View {
    /// From one point: direction to the film's upper left corner, and a pixel's edges, at unit distance along the view.
    Perspective { corner: Vec3, right: Vec3, down: Vec3 },
    /// Along one direction: from the origin to the film's upper left corner, and a pixel's edges.
    Orthographic { forward: Vec3, corner: Vec3, right: Vec3, down: Vec3 },
    /// All around: the unit vectors of the view, and radians of a pixel.
    Panorama { forward: Vec3, right: Vec3, up: Vec3, pixel: [f32; 2], middle: [f32; 2] },
}

/// A thin lens: what lies in the plane of focus is sharp.
#[derive(Clone, Copy, Debug)]
struct Lens {
    /// Unit edges of the lens times its radius.
    right: Vec3,
    up: Vec3,
    /// Distance of the plane of focus along the unit vector of the view.
    focus: f32,
    forward: Vec3,
}

impl Camera {
    /// # Errors
    /// Where the view direction or the up vector is degenerate.
    pub(crate) fn new(c: &CameraDescription, film: &FilmSettings) -> Result<Camera> {
        let degenerate = || Error::Scene("the camera's origin, target and up do not span a view".into());
        let (origin, target) = (c.origin.as_vec3(), c.target.as_vec3());
        let forward = (target - origin).try_normalize().ok_or_else(degenerate)?;
        let right = forward.cross(c.up).try_normalize().ok_or_else(degenerate)?;
        let up = right.cross(forward);
        let side = if c.mirrored { -right } else { right };
        let [left, top, width, height] = film.crop.unwrap_or([0, 0, film.width, film.height]);
        let focus = c.focus_distance.unwrap_or_else(|| (target - origin).length());
        let radius = c.aperture_radius;
        Ok(Camera {
            origin,
            view: View::new(c, [forward, side, up], film),
            lens: (radius > 0.0).then(|| Lens { right: right * radius, up: up * radius, focus, forward }),
            filter: film.filter,
            width,
            height,
            left,
            top,
            columns: film.width,
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
        let (origin, target) = (origin.as_dvec3(), centre.as_dvec3());
        CameraDescription { origin, target, vfov, ..CameraDescription::default() }
    }

    /// Number of pixel `(x, y)` in the whole film, row by row: random numbers are a pixel's own, whatever part is rendered.
    #[inline]
    pub(crate) fn pixel(&self, x: u32, y: u32) -> u32 {
        (self.top + y) * self.columns + self.left + x
    }

    /// Where the part that is rendered begins in the whole film.
    pub(crate) fn corner(&self) -> [u32; 2] {
        [self.left, self.top]
    }

    /// The same view on about so many pixels; no more than it has.
    pub(crate) fn coarser(&self, pixels: u64) -> Camera {
        let step = (self.width as f64 * self.height as f64 / pixels as f64).sqrt().max(1.0);
        let along = |n: u32| ((n as f64 / step).round() as u32).max(1);
        let (width, height) = (along(self.width), along(self.height));
        let (x, y) = (self.width as f32 / width as f32, self.height as f32 / height as f32);
        let [left, top] = [self.left, self.top].map(|n| n as f32);
        let shifted = |corner: Vec3, right: Vec3, down: Vec3| corner + right * left + down * top;
        let view = match self.view {
            View::Perspective { corner, right, down } => {
                View::Perspective { corner: shifted(corner, right, down), right: right * x, down: down * y }
            }
            View::Orthographic { forward, corner, right, down } => {
                let corner = shifted(corner, right, down);
                View::Orthographic { forward, corner, right: right * x, down: down * y }
            }
            View::Panorama { forward, right, up, pixel, middle } => View::Panorama {
                forward,
                right,
                up,
                pixel: [pixel[0] * x, pixel[1] * y],
                middle: [(middle[0] - left) / x, (middle[1] - top) / y],
            },
        };
        Camera { view, width, height, left: 0, top: 0, columns: width, ..self.clone() }
    }

    /// Whether rays come from more than one point of a lens.
    pub(crate) fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// [`Self::ray`] for a packet: whence rays come and whither they go.
    #[inline(always)]
    pub(crate) fn rays(&self, [x, y]: [&[u32; LANES]; 2], u: &[Lanes; 2], [org, dir]: [&mut Vec3Lanes; 2]) {
        let mut on_film = [[0.0; LANES]; 2];
        for k in 0..LANES {
            on_film[0][k] = self.filter.place(self.left + x[k], u[0][k]);
            on_film[1][k] = self.filter.place(self.top + y[k], u[1][k]);
        }
        let [x, y] = &on_film;
        // one loop for each kind, without a choice in it
        match self.view {
            View::Perspective { corner, right, down } => {
                for k in 0..LANES {
                    org.set(k, self.origin);
                    dir.set(k, towards(corner, right * x[k], down * y[k]));
                }
            }
            View::Orthographic { .. } | View::Panorama { .. } => {
                for k in 0..LANES {
                    let (from, to) = self.view.ray(self.origin, x[k], y[k]);
                    org.set(k, from);
                    dir.set(k, to);
                }
            }
        }
    }

    /// Moves such rays, which go through the middle of the lens, to points of it that are drawn by `u`.
    pub(crate) fn bend(&self, u: &[Lanes; 2], [org, dir]: [&mut Vec3Lanes; 2]) {
        if let Some(lens) = &self.lens {
            for k in 0..LANES {
                let (from, to) = lens.bend(org.get(k), dir.get(k), [u[0][k], u[1][k]]);
                org.set(k, from);
                dir.set(k, to);
            }
        }
    }

    /// The ray of pixel `(x, y)` through the middle of the lens and a point of the filter drawn by `u`. Filters
    /// are importance sampled (Ernst et al. 2006), so every sample has weight 1 and stays in its pixel's sum.
    #[inline]
    pub(crate) fn ray(&self, x: u32, y: u32, u: [f32; 2]) -> Ray {
        let (x, y) = (self.filter.place(self.left + x, u[0]), self.filter.place(self.top + y, u[1]));
        let (org, dir) = self.view.ray(self.origin, x, y);
        Ray { org, dir, tfar: f32::INFINITY }
    }
}

/// The unit vector to a point of the film at unit distance.
#[inline(always)]
fn towards(corner: Vec3, right: Vec3, down: Vec3) -> Vec3 {
    (corner + right + down).normalize()
}

impl View {
    /// Whence and whither rays go through a place of the film, in pixels; `origin` is the camera's.
    #[inline]
    fn ray(&self, origin: Vec3, x: f32, y: f32) -> (Vec3, Vec3) {
        match *self {
            View::Perspective { corner, right, down } => (origin, towards(corner, right * x, down * y)),
            View::Orthographic { forward, corner, right, down } => (origin + (corner + right * x + down * y), forward),
            View::Panorama { forward, right, up, pixel, middle } => {
                let (azimuth, elevation) = ((x - middle[0]) * pixel[0], (middle[1] - y) * pixel[1]);
                let level = forward * azimuth.cos() + right * azimuth.sin();
                (origin, (level * elevation.cos() + up * elevation.sin()).normalize())
            }
        }
    }

    fn new(c: &CameraDescription, [forward, side, up]: [Vec3; 3], film: &FilmSettings) -> View {
        let (columns, rows) = (film.width as f32, film.height as f32);
        let aspect = columns / rows;
        let edges = |half_height: f32| {
            let half_width = half_height * aspect;
            let edges = (side * (2.0 * half_width / columns), up * (-2.0 * half_height / rows));
            (up * half_height - side * half_width, edges)
        };
        match c.projection {
            Projection::Perspective => {
                let (corner, (right, down)) = edges((0.5 * c.vfov.to_radians()).tan());
                View::Perspective { corner: forward + corner, right, down }
            }
            Projection::Orthographic => {
                let (corner, (right, down)) = edges(0.5 * c.view_height);
                View::Orthographic { forward, corner, right, down }
            }
            Projection::Panorama => {
                let (pixel, middle) = ([TAU / columns, PI / rows], [0.5 * columns, 0.5 * rows]);
                View::Panorama { forward, right: side, up, pixel, middle }
            }
        }
    }
}

impl Lens {
    /// The ray from a point of the lens, drawn by `u` evenly over its disk, to where the one along `dir` meets the plane of focus.
    fn bend(&self, org: Vec3, dir: Vec3, u: [f32; 2]) -> (Vec3, Vec3) {
        let on_lens = square_to_disk(u);
        let offset = self.right * on_lens.x + self.up * on_lens.y;
        let to_focus = dir * (self.focus / dir.dot(self.forward));
        (org + offset, (to_focus - offset).normalize())
    }
}

impl Filter {
    /// A place in the film, in pixels, of the pixel of this number along an edge.
    #[inline(always)]
    fn place(self, pixel: u32, u: f32) -> f32 {
        pixel as f32 + 0.5 + self.warp(u)
    }

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
#[path = "camera_tests.rs"]
mod tests;
