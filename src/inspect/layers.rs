//! What the guide knows, pixel by pixel.

use super::PixelVertex;
use crate::guiding::{Guide, RegionId};
use crate::image::{Image, Layer};
use crate::integrator::mixture::{GuidedBy, GuidedLobes, glossy_product};
use crate::math::Rgb;
use crate::math::rng::mix;
use crate::scene::Scene;
use rayon::prelude::*;

/// Of each pixel, what the guide knows at the first surface behind its centre that is neither mirror nor glass.
pub(crate) struct Layers {
    width: usize,
    height: usize,
    pixels: Vec<Pixel>,
}

#[derive(Clone, Copy, Default)]
struct Pixel {
    /// Share of directions that the guide draws: all of the guided lobes' that the BSDF leaves to it.
    fraction: f32,
    visits: f32,
    state: Option<RegionId>,
}

impl Layers {
    pub(crate) fn new(scene: &Scene, guide: &Guide) -> Layers {
        let (width, height) = (scene.camera.width, scene.camera.height);
        let line = |y| (0..width).into_par_iter().map(move |x| Pixel::new(scene, guide, x, y));
        let pixels = (0..height).into_par_iter().flat_map(line).collect();
        Layers { width: width as usize, height: height as usize, pixels }
    }

    /// Layers of an EXR: `guide.fraction`, the share of directions drawn from the guide; `guide.visits`, the weight of
    /// the visits behind it; `guide.state`, a number from 1 to 2²⁴ − 1 that tells states apart. All are 0 where the guide
    /// knows nothing.
    pub(crate) fn channels(&self) -> Vec<Layer> {
        let layer = |name: &str, of: fn(&Pixel) -> f32| Layer::scalar(name, "Y", self.pixels.iter().map(of).collect());
        vec![
            layer("guide.fraction", |p| p.fraction),
            layer("guide.visits", |p| p.visits),
            layer("guide.state", |p| p.state.map_or(0, number) as f32),
        ]
    }

    /// How many states there are.
    pub(crate) fn states(&self) -> usize {
        let all: std::collections::BTreeSet<u64> =
            self.pixels.iter().filter_map(|p| p.state).map(|key| key.0).collect();
        all.len()
    }

    /// The share of directions that the guide draws, as greys from 0 to 1.
    pub(crate) fn shares(&self) -> Image {
        Image {
            width: self.width,
            height: self.height,
            data: self.pixels.iter().map(|p| Rgb::splat(p.fraction)).collect(),
        }
    }

    /// A colour for each state, at random; black where no state was met.
    pub(crate) fn false_colours(&self) -> Image {
        let data = self.pixels.iter().map(|p| p.state.map_or(Rgb::ZERO, colour)).collect();
        Image { width: self.width, height: self.height, data }
    }
}

impl Pixel {
    fn new(scene: &Scene, guide: &Guide, x: u32, y: u32) -> Pixel {
        let Some(seen) = PixelVertex::through(scene, x, y) else { return Pixel::default() };
        let Some(key) = seen.state(guide) else { return Pixel::default() };
        let Some(visits) = guide.visits(key) else { return Pixel::default() };
        let (field, wo) = (guide.field(), seen.si.frame.to_local(seen.wo));
        let fraction = field.summary(key).map_or(0.0, |summary| {
            let glossy = glossy_product((field, summary), &seen.bsdf, wo, (&seen.si.frame, seen.normal()));
            let lobes = glossy.map_or_else(|| GuidedLobes::of(&seen.bsdf, wo, GuidedBy::Radiance), |(lobes, _)| lobes);
            lobes.share() * (1.0 - summary.bsdf_fraction)
        });
        Pixel { fraction, visits, state: Some(key) }
    }
}

/// 24 bits, which an `f32` holds exactly.
fn number(key: RegionId) -> u32 {
    ((mix(key.0) >> 40) as u32).max(1)
}

fn colour(key: RegionId) -> Rgb {
    let byte = |k: u32| ((number(key) >> (8 * k)) & 0xff) as f32 / 255.0;
    Rgb::new(byte(0), byte(1), byte(2)) * 0.9 + 0.05
}
