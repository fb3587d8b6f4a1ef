//! The light that the paths of a batch bring, all of it and layer by layer.

use crate::film::tile::TileSamples;
use crate::film::{LightPath, RadianceLayer};
use crate::math::Rgb;

/// Radiance by path, W/(sr·m²) in the scene's unit of light.
#[derive(Default)]
pub(super) struct Radiance {
    /// Of all light that was found.
    found: Vec<Rgb>,
    /// Light that was expected and not looked for, less light that was looked for more often than once: 0 on average.
    expected: Vec<Rgb>,
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
        blank(&mut self.found);
        blank(&mut self.expected);
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
        self.found[slot] += light;
        for (layer, radiance) in &mut self.layers {
            if layer.takes(path) {
                radiance[slot] += light;
            }
        }
    }

    /// Adds what was expected of paths that were not followed from the path in this place. It counts as light that was scattered twice or
    /// more often, of lights in no group: no layer may be other than on average.
    #[inline(always)]
    pub(super) fn expect(&mut self, slot: usize, light: Rgb) {
        self.expect_by(slot, LightPath { segments: u32::MAX, group: 0 }, light, false);
    }

    /// The same where the light would have come by `path`. Where it is `likely` that there is light, it counts as found.
    #[inline(always)]
    pub(super) fn expect_by(&mut self, slot: usize, path: LightPath, light: Rgb, likely: bool) {
        let all = if likely { &mut self.found } else { &mut self.expected };
        all[slot] += light;
        for (layer, radiance) in &mut self.layers {
            if layer.takes(path) {
                radiance[slot] += light;
            }
        }
    }

    /// What each path brings.
    pub(super) fn all(&self) -> impl Iterator<Item = Rgb> {
        self.found.iter().zip(&self.expected).map(|(found, expected)| *found + *expected)
    }

    /// Whether the path in this place has found light.
    pub(super) fn is_lit(&self, slot: usize) -> bool {
        self.found[slot] != Rgb::ZERO
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
            for (slot, (light, all)) in radiance.iter().zip(self.all()).enumerate() {
                sum[slot % pixels] += if all.is_finite() { *light } else { Rgb::ZERO };
            }
            samples.layers.push(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_expected_is_in_the_picture_and_among_indirect_light() {
        let layers =
            [RadianceLayer::Emission, RadianceLayer::Direct, RadianceLayer::Indirect, RadianceLayer::Shortest(2)];
        let mut radiance = Radiance::default();
        radiance.begin(layers.into_iter(), 2);
        radiance.add(0, LightPath { segments: 2, group: 0 }, Rgb::ONE);
        radiance.expect(0, Rgb::splat(-0.5));
        radiance.expect(1, Rgb::splat(0.25));
        assert_eq!(radiance.all().collect::<Vec<_>>(), [Rgb::splat(0.5), Rgb::splat(0.25)]);
        let of =
            |radiance: &Radiance, layer| radiance.layer(layer).unwrap().iter().map(|light| light.x).collect::<Vec<_>>();
        assert_eq!(
            layers.map(|layer| of(&radiance, layer)),
            [vec![0.0, 0.0], vec![1.0, 0.0], vec![-0.5, 0.25], vec![1.0, 0.0]]
        );
        assert!(radiance.is_lit(0) && !radiance.is_lit(1), "a path that ends has found nothing");
        // light of a known path is in that path's layers, and found where it is likely
        let (direct, light) = (LightPath { segments: 2, group: 0 }, Rgb::splat(0.125));
        radiance.expect_by(1, direct, light, false);
        assert!(!radiance.is_lit(1) && radiance.all().nth(1) == Some(Rgb::splat(0.375)));
        let parts = [RadianceLayer::Direct, RadianceLayer::Indirect].map(|layer| of(&radiance, layer));
        assert_eq!(parts, [vec![1.0, 0.125], vec![-0.5, 0.25]]);
        radiance.expect_by(1, direct, light, true);
        assert!(radiance.is_lit(1) && radiance.all().nth(1) == Some(Rgb::splat(0.5)));
    }
}
