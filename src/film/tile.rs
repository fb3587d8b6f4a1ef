//! A rectangle of the film, and what was sampled there.

use crate::math::Rgb;

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
    /// Σ L and Σ L².
    pub(crate) sum: Vec<Rgb>,
    pub(crate) sum_squares: Vec<Rgb>,
    /// Σ L by radiance layer, in the order in which they were asked for.
    pub(crate) layers: Vec<Vec<Rgb>>,
    /// Empty where not asked for.
    pub(crate) features: Vec<Aovs>,
}

/// What the first hit of a camera ray looks like; zero where it leaves the scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Aovs {
    pub(crate) albedo: Rgb,
    /// Shading normal in world space, facing the camera.
    pub(crate) normal: Rgb,
    /// Distance along the ray.
    pub depth: f32,
}

impl std::ops::AddAssign for Aovs {
    fn add_assign(&mut self, other: Aovs) {
        self.albedo += other.albedo;
        self.normal += other.normal;
        self.depth += other.depth;
    }
}

impl std::ops::Mul<f32> for Aovs {
    type Output = Aovs;

    fn mul(self, k: f32) -> Aovs {
        Aovs { albedo: self.albedo * k, normal: self.normal * k, depth: self.depth * k }
    }
}
