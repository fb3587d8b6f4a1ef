//! A rectangle of the film, and what was sampled there.

use crate::film::ids::Ids;
use crate::math::Rgb;
use glam::Vec3;
use std::ops::Range;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    pub(crate) x: u32,
    pub(crate) y: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Tile {
    pub(crate) fn pixels(&self) -> usize {
        (self.width * self.height) as usize
    }
}

/// Sums over the samples of a tile's pixels, row by row.
#[derive(Clone, Debug, Default)]
pub(crate) struct TileSamples {
    /// Which samples of each pixel, counted over the whole render; nothing tells the halves of a pixel's samples apart where
    /// it is empty.
    pub(crate) numbers: Range<u32>,
    /// Σ L and Σ L².
    pub(crate) sum: Vec<Rgb>,
    pub(crate) sum_squares: Vec<Rgb>,
    /// Σ L by radiance layer, in the order in which they were asked for.
    pub(crate) layers: Vec<Vec<Rgb>>,
    /// Empty where not asked for.
    pub(crate) features: Vec<Aovs>,
    /// By sample and pixel, what it met; empty where not asked for.
    pub(crate) ids: Vec<Ids>,
}

/// What the first hit of a camera ray looks like; zero where it leaves the scene.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Aovs {
    pub(crate) albedo: Rgb,
    /// Shading normal in world space, facing the camera.
    pub(crate) normal: Vec3,
    /// Normal of the triangle in world space, facing the camera.
    pub(crate) geometric_normal: Vec3,
    /// In world space.
    pub(crate) position: Vec3,
    /// Distance along the ray.
    pub depth: f32,
    /// 1: of a mean, the share of rays that met something.
    pub(crate) met: f32,
}

impl Aovs {
    /// Depth where no ray met anything, as Blender has it.
    pub(crate) const NOTHING: f32 = 1e10;

    /// Mean distance of what was met; [`Self::NOTHING`] where nothing was.
    pub(crate) fn mean_depth(&self) -> f32 {
        if self.met > 0.0 { self.depth / self.met } else { Aovs::NOTHING }
    }

    /// Mean place of what was met; zero where nothing was.
    pub(crate) fn mean_position(&self) -> Vec3 {
        if self.met > 0.0 { self.position / self.met } else { Vec3::ZERO }
    }

    fn combined(self, other: Aovs, with: impl Fn(Vec3, Vec3) -> Vec3) -> Aovs {
        let scalars = with(Vec3::new(self.depth, self.met, 0.0), Vec3::new(other.depth, other.met, 0.0));
        Aovs {
            albedo: with(self.albedo, other.albedo),
            normal: with(self.normal, other.normal),
            geometric_normal: with(self.geometric_normal, other.geometric_normal),
            position: with(self.position, other.position),
            depth: scalars.x,
            met: scalars.y,
        }
    }
}

impl std::ops::AddAssign for Aovs {
    fn add_assign(&mut self, other: Aovs) {
        *self = self.combined(other, |a, b| a + b);
    }
}

impl std::ops::Mul<f32> for Aovs {
    type Output = Aovs;

    fn mul(self, k: f32) -> Aovs {
        self.combined(Aovs::default(), |a, _| a * k)
    }
}
