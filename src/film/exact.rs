//! Sums of samples that do not depend on their order: parts of a render add up to the same bits, however many there are.
//!
//! A sum is an integer ([`crate::math::fixed`]) of radiance in the scene's own unit, where it is about one, of squares of it, of
//! directions, and of places in the scene's unit of length.

use super::RadianceLayer;
use super::accumulate::{Estimate, PictureIds};
use super::ids::{AllCounts, IdCounts, KINDS};
use super::tile::{Aovs, Tile, TileSamples};
use crate::math::Rgb;
use crate::math::fixed::{fixed, value};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Numbers of an [`Aovs`].
const FEATURES: usize = 14;

/// Sums of three numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Sum3([i128; 3]);

impl Sum3 {
    fn add(&mut self, v: Vec3) {
        self.add_sums(Sum3(v.to_array().map(fixed)));
    }

    fn add_sums(&mut self, other: Sum3) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, more)| *sum = sum.saturating_add(more));
    }

    fn value(self) -> DVec3 {
        self.0.map(value).into()
    }
}

/// Sums over the samples of a tile's pixels.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct TileSums {
    sum: Vec<Sum3>,
    squares: Vec<Sum3>,
    layers: Vec<Vec<Sum3>>,
    /// Empty where no sample was averaged.
    features: Vec<[i128; FEATURES]>,
    /// What the same samples met; empty where that is not asked for.
    ids: Vec<[AllCounts; KINDS]>,
}

impl TileSums {
    fn new(pixels: usize, layers: usize) -> TileSums {
        let sums = || vec![Sum3::default(); pixels];
        TileSums {
            sum: sums(),
            squares: sums(),
            layers: (0..layers).map(|_| sums()).collect(),
            features: Vec::new(),
            ids: Vec::new(),
        }
    }

    fn add(&mut self, samples: &TileSamples) {
        let add = |sums: &mut [Sum3], values: &[Rgb]| sums.iter_mut().zip(values).for_each(|(sum, v)| sum.add(*v));
        add(&mut self.sum, &samples.sum);
        add(&mut self.squares, &samples.sum_squares);
        self.layers.iter_mut().zip(&samples.layers).for_each(|(sums, values)| add(sums, values));
        if !samples.features.is_empty() {
            self.features.resize(self.sum.len(), [0; FEATURES]);
            let both = self.features.iter_mut().zip(&samples.features);
            both.for_each(|(sums, v)| add_all(sums, &numbers(v).map(fixed)));
        }
        if !samples.ids.is_empty() {
            let pixels = self.sum.len();
            self.ids.resize(pixels, Default::default());
            for (k, met) in samples.ids.iter().enumerate() {
                self.ids[k % pixels].iter_mut().zip(met).for_each(|(counts, &id)| counts.add(id, 1));
            }
        }
    }

    fn add_sums(&mut self, other: &TileSums) {
        let add = |sums: &mut [Sum3], more: &[Sum3]| sums.iter_mut().zip(more).for_each(|(sum, v)| sum.add_sums(*v));
        add(&mut self.sum, &other.sum);
        add(&mut self.squares, &other.squares);
        self.layers.iter_mut().zip(&other.layers).for_each(|(sums, more)| add(sums, more));
        if !other.features.is_empty() {
            self.features.resize(self.sum.len(), [0; FEATURES]);
            self.features.iter_mut().zip(&other.features).for_each(|(sums, more)| add_all(sums, more));
        }
        if !other.ids.is_empty() {
            self.ids.resize(self.sum.len(), Default::default());
            let kinds = self.ids.iter_mut().flatten().zip(other.ids.iter().flatten());
            kinds.for_each(|(counts, more)| counts.join(more));
        }
    }

    fn fits(&self, pixels: usize, layers: usize) -> bool {
        let all = [&self.sum, &self.squares].into_iter().chain(&self.layers);
        let features = self.features.is_empty() || self.features.len() == pixels;
        let ids = self.ids.is_empty() || self.ids.len() == pixels;
        features && ids && self.layers.len() == layers && all.into_iter().all(|sums| sums.len() == pixels)
    }
}

fn add_all(sums: &mut [i128; FEATURES], more: &[i128; FEATURES]) {
    sums.iter_mut().zip(more).for_each(|(sum, more)| *sum = sum.saturating_add(*more));
}

/// In the order in which they are stored.
fn numbers(f: &Aovs) -> [f32; FEATURES] {
    let Aovs { albedo: a, normal: n, geometric_normal: g, position: p, depth, met } = *f;
    [a.x, a.y, a.z, n.x, n.y, n.z, g.x, g.y, g.z, p.x, p.y, p.z, depth, met]
}

fn features(sums: &[i128; FEATURES], samples: f64) -> Aovs {
    let v = sums.map(|sum| (value(sum) / samples) as f32);
    let three = |first: usize| Vec3::new(v[first], v[first + 1], v[first + 2]);
    Aovs {
        albedo: three(0),
        normal: three(3),
        geometric_normal: three(6),
        position: three(9),
        depth: v[12],
        met: v[13],
    }
}

/// Tiles to which any threads add samples, in any order.
pub(crate) struct ExactFilm {
    width: u32,
    height: u32,
    layers: Vec<RadianceLayer>,
    tiles: Vec<(Tile, Mutex<TileSums>)>,
}

impl ExactFilm {
    /// Of pixels in these tiles, which cover it.
    pub(crate) fn new(width: u32, height: u32, tiles: Vec<Tile>, layers: &[RadianceLayer]) -> ExactFilm {
        let sums = |tile: Tile| (tile, Mutex::new(TileSums::new(tile.pixels(), layers.len())));
        ExactFilm { width, height, layers: layers.to_vec(), tiles: tiles.into_iter().map(sums).collect() }
    }

    /// Adds what was sampled in tile `number`, all pixels of it equally often.
    pub(crate) fn add(&self, number: usize, samples: &TileSamples) {
        self.tiles[number].1.lock().unwrap_or_else(PoisonError::into_inner).add(samples);
    }

    /// The sums, tile by tile.
    pub(crate) fn into_tiles(self) -> Vec<TileSums> {
        let sums = |(_, sums): (Tile, Mutex<TileSums>)| sums.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.tiles.into_iter().map(sums).collect()
    }

    /// How many tiles there are.
    pub(crate) fn tiles(&self) -> usize {
        self.tiles.len()
    }

    /// Adds the sums of a tile of another film; `false` where that is not one like this.
    pub(crate) fn add_sums(&mut self, number: usize, sums: &TileSums) -> bool {
        let layers = self.layers.len();
        let Some((tile, own)) = self.tiles.get_mut(number) else { return false };
        let fits = sums.fits(tile.pixels(), layers);
        if fits {
            own.get_mut().unwrap_or_else(PoisonError::into_inner).add_sums(sums);
        }
        fits
    }

    /// The picture of `samples` samples of each pixel, of which `averaged` tell what the camera sees first.
    pub(crate) fn finish(self, samples: u32, averaged: u32) -> Estimate {
        let pixels = self.width as usize * self.height as usize;
        let mut estimate = Estimate {
            width: self.width,
            height: self.height,
            mean: vec![Rgb::ZERO; pixels],
            variance: vec![Rgb::ZERO; pixels],
            samples,
            counts: Vec::new(),
            layers: self.layers.iter().map(|layer| (*layer, vec![Rgb::ZERO; pixels])).collect(),
            features: vec![Aovs::default(); pixels],
            ids: PictureIds::default(),
        };
        let has_ids = self.tiles.iter().any(|(_, sums)| has_ids(sums));
        if has_ids {
            estimate.ids =
                PictureIds { counts: vec![[IdCounts::NONE; KINDS]; pixels], samples: vec![averaged.max(1); pixels] };
        }
        let n = f64::from(samples.max(1));
        for (tile, sums) in self.tiles {
            let sums = sums.into_inner().unwrap_or_else(PoisonError::into_inner);
            for k in 0..tile.pixels() {
                let (x, y) = (tile.x as usize + k % tile.width as usize, tile.y as usize + k / tile.width as usize);
                let i = y * self.width as usize + x;
                let mean = sums.sum[k].value() / n;
                estimate.mean[i] = mean.as_vec3();
                estimate.variance[i] = variance(mean, sums.squares[k].value(), n);
                let layers = estimate.layers.iter_mut().zip(&sums.layers);
                layers.for_each(|((_, means), layer)| means[i] = (layer[k].value() / n).as_vec3());
                if let Some(sum) = sums.features.get(k) {
                    estimate.features[i] = features(sum, f64::from(averaged.max(1)));
                }
                if let Some(met) = sums.ids.get(k) {
                    estimate.ids.counts[i] = met.clone().map(AllCounts::most);
                }
            }
        }
        estimate
    }
}

fn has_ids(sums: &Mutex<TileSums>) -> bool {
    !sums.lock().unwrap_or_else(PoisonError::into_inner).ids.is_empty()
}

/// Of the mean of `n` samples, by these; 0 of one.
fn variance(mean: DVec3, squares: DVec3, n: f64) -> Rgb {
    if n < 2.0 {
        return Rgb::ZERO;
    }
    ((squares / n - mean * mean).max(DVec3::ZERO) / (n - 1.0)).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    /// Samples of two pixels, of very different size.
    fn samples(rng: &mut Rng) -> TileSamples {
        let mut draw = || Vec3::from_array([0; 3].map(|_| rng.f32() * (60.0 * rng.f32() - 30.0).exp2()));
        let [sum, sum_squares, layer] = [0; 3].map(|_| vec![draw(), draw()]);
        let features = vec![Aovs { depth: draw().x, position: draw(), ..Aovs::default() }; 2];
        TileSamples { sum, sum_squares, layers: vec![layer], features, ..TileSamples::default() }
    }

    fn film() -> ExactFilm {
        let tiles = vec![Tile { x: 0, y: 0, width: 2, height: 1 }];
        ExactFilm::new(2, 1, tiles, &[RadianceLayer::Direct])
    }

    fn bits(e: &Estimate) -> Vec<u32> {
        let colours = e.mean.iter().chain(&e.variance).chain(&e.layers[0].1).flat_map(|c| c.to_array());
        let features = e.features.iter().flat_map(numbers);
        colours.chain(features).map(f32::to_bits).collect()
    }

    #[test]
    fn sums_do_not_depend_on_order_or_parts() {
        let mut rng = Rng::new(1);
        let all: Vec<TileSamples> = (0..200).map(|_| samples(&mut rng)).collect();
        let whole = film();
        all.iter().for_each(|samples| whole.add(0, samples));
        let whole = whole.finish(200, 200);
        let in_doubles = all.iter().map(|s| s.sum[1].as_dvec3()).sum::<DVec3>() / 200.0;
        assert!((whole.mean[1].as_dvec3() / in_doubles - 1.0).abs().max_element() < 1e-6);
        for parts in [1, 3, 7] {
            let mut joint = film();
            for part in all.rchunks(200 / parts) {
                let film = film();
                part.iter().rev().for_each(|samples| film.add(0, samples));
                assert!(film.into_tiles().iter().enumerate().all(|(k, sums)| joint.add_sums(k, sums)));
            }
            assert_eq!(bits(&joint.finish(200, 200)), bits(&whole), "{parts} parts");
        }
    }

    #[test]
    fn values_beyond_all_sums_stay_there() {
        let film = film();
        let sum = vec![Vec3::splat(f32::MAX); 2];
        let samples =
            TileSamples { sum_squares: sum.clone(), layers: vec![sum.clone()], sum, ..TileSamples::default() };
        (0..3).for_each(|_| film.add(0, &samples));
        let Estimate { mean, variance, .. } = film.finish(3, 0);
        assert!(mean[0].is_finite() && mean[0].x > 1e18 && variance[0].is_finite());
    }

    #[test]
    fn what_is_of_another_film_is_refused() {
        let other = ExactFilm::new(2, 1, vec![Tile { x: 0, y: 0, width: 2, height: 1 }], &[]);
        let (own, others) = (film().into_tiles(), other.into_tiles());
        assert!(film().add_sums(0, &own[0]) && !film().add_sums(1, &own[0]) && !film().add_sums(0, &others[0]));
    }
}
