//! The light that the paths of a batch bring, all of it and layer by layer.

use crate::film::tile::TileSamples;
use crate::film::{LightPath, RadianceLayer};
use crate::math::Rgb;

/// Radiance by path, W/(sr·m²) in the scene's unit of light.
#[derive(Default)]
pub(super) struct Radiance {
    /// Of all light.
    pub(super) all: Vec<Rgb>,
    /// Of the light that a layer takes.
    layers: Vec<(RadianceLayer, Vec<Rgb>)>,
}

impl Radiance {
    /// Begins anew, with nothing brought by `paths` paths.
    pub(super) fn begin(&mut self, layers: impl Iterator<Item = RadianceLayer>, paths: usize) {
        let blank = |radiance: &mut Vec<Rgb>| {
            radiance.clear();
            radiance.resize(paths, Rgb::ZERO);
        };
        blank(&mut self.all);
        let mut before = std::mem::take(&mut self.layers).into_iter().map(|(_, buffer)| buffer);
        for layer in layers {
            let mut buffer = before.next().unwrap_or_default();
            blank(&mut buffer);
            self.layers.push((layer, buffer));
        }
    }

    /// Adds what the path in this place has brought.
    #[inline(always)]
    pub(super) fn add(&mut self, slot: usize, path: LightPath, light: Rgb) {
        self.all[slot] += light;
        for (layer, radiance) in &mut self.layers {
            if layer.takes(path) {
                radiance[slot] += light;
            }
        }
    }

    /// What a layer holds; `None` where it was not asked for.
    pub(super) fn layer(&self, layer: RadianceLayer) -> Option<&[Rgb]> {
        self.layers.iter().find(|(own, _)| *own == layer).map(|(_, radiance)| &radiance[..])
    }

    /// Sums over the samples of each pixel of the first `count` layers. A sample that is not finite as a whole is left out.
    pub(super) fn gather_layers(&self, count: usize, samples: &mut TileSamples) {
        let pixels = samples.sum.len();
        for (_, radiance) in &self.layers[..count] {
            let mut sum = vec![Rgb::ZERO; pixels];
            for (slot, light) in radiance.iter().enumerate().filter(|(slot, _)| self.all[*slot].is_finite()) {
                sum[slot % pixels] += light;
            }
            samples.layers.push(sum);
        }
    }
}
