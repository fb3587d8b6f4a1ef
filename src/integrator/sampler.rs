//! The random numbers of paths, by name: where on the film and the lens a path begins and, vertex by vertex, which light it asks
//! and where it goes on.
//!
//! A number is found by counting: it is a function of the seed, the pixel, the sample and its name. No generator is carried
//! along, and it makes no difference which thread asks, in which order, or for how many paths at once.

use crate::math::hash::{hash1, hash4};
use crate::math::rng::{mix, unit_f32, unit_f64};
use crate::math::sobol::{self, Seeds};
use crate::simd::{LANES, Packing};

/// Vertices from the camera whose numbers [`SamplerKind::Sobol`] spreads evenly. The light of later ones depends on so many
/// numbers before theirs that nothing is gained: in a Cornell box, of whose noise two vertices are worth a factor of 1.91 and
/// four 1.93, eight are worth 1.98.
const STRATIFIED_VERTICES: u32 = 8;

/// What tells apart the uses of the same hash.
const INDEPENDENT: u32 = 0x243f_6a88;
const SEEDS: u32 = 0x85a3_08d3;
const BRANCH: u32 = 0x1319_8a2e;

/// Begins the numbers of sets that are not numbered vertex by vertex.
const PARTS: u32 = 1 << 31;

/// How the samples of a pixel are spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplerKind {
    /// The numbers of a pixel's samples fill their space evenly, and each sample by itself is uniform: Sobol' points, scrambled
    /// after Owen, in sets of up to four numbers that are shuffled against each other. Beyond the first vertices as
    /// [`Self::Independent`].
    Sobol,
    /// All numbers are independent.
    Independent,
}

impl SamplerKind {
    /// By their names in scene files.
    pub const NAMES: [(&'static str, SamplerKind); 2] =
        [("sobol", SamplerKind::Sobol), ("independent", SamplerKind::Independent)];
}

/// Gives the paths of a batch their numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampler {
    kind: SamplerKind,
    /// Bits of the number of the last sample.
    bits: u32,
}

/// Whose numbers: those of `N` paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PathKeys<const N: usize> {
    /// Of the seed, the pixel, the sequence of samples and the branches that were taken.
    key: [u32; N],
    /// Number of the sample in its sequence.
    sample: [u32; N],
}

/// The same of one path.
pub(crate) type PathKey = PathKeys<1>;

/// Where camera rays begin, in the unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CameraNumbers<const N: usize> {
    pub(crate) film: [[f32; N]; 2],
    pub(crate) lens: [[f32; N]; 2],
}

/// Which light next-event estimation asks, and where on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightNumbers<const N: usize> {
    pub(crate) choice: [f64; N],
    pub(crate) point: [[f32; N]; 2],
}

/// Where paths go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DirectionNumbers<const N: usize> {
    /// Who draws: the guide or the BSDF.
    pub(crate) chooser: [f32; N],
    /// Which cell of the guide; where the BSDF draws, which of its lobes.
    pub(crate) cell: [f64; N],
    /// A point of the cell or of the lobe.
    pub(crate) point: [[f32; N]; 2],
}

/// A set of up to four numbers of a path.
#[derive(Clone, Copy, Debug)]
enum Set {
    Camera,
    // of a vertex, counted from 1
    Shadow(u32),
    Light(u32),
    Roulette(u32),
    Direction(u32),
    Part(u32),
}

impl Set {
    /// The vertex that the set belongs to, 0 being the camera; and which of all sets it is.
    fn place(self) -> (u32, u32) {
        let (vertex, number) = match self {
            // behind all others, whose numbers stay what they were
            Set::Part(vertex) => return (vertex, PARTS | vertex),
            Set::Camera => (0, 0),
            Set::Shadow(vertex) => (vertex, 0),
            Set::Light(vertex) => (vertex, 1),
            Set::Roulette(vertex) => (vertex, 2),
            Set::Direction(vertex) => (vertex, 3),
        };
        (vertex, vertex.wrapping_mul(4).wrapping_add(number))
    }
}

impl<const N: usize> PathKeys<N> {
    pub(crate) const NONE: PathKeys<N> = PathKeys { key: [0; N], sample: [0; N] };

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> PathKey {
        PathKeys { key: [self.key[lane]], sample: [self.sample[lane]] }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, PathKeys { key: [key], sample: [sample] }: PathKey) {
        (self.key[lane], self.sample[lane]) = (key, sample);
    }

    /// A further branch of each path where it splits at `vertex`, counted from 1. Its numbers are independent of those of the
    /// other branches.
    #[inline(always)]
    pub(crate) fn branch(&self, vertex: u32, branch: u32) -> PathKeys<N> {
        let [key, ..] = hash4([&self.key, &[branch; N], &[vertex; N], &[BRANCH; N]]);
        PathKeys { key, sample: self.sample }
    }
}

impl DirectionNumbers<LANES> {
    /// Those of one lane.
    #[inline(always)]
    pub(crate) fn get(&self, k: usize) -> DirectionNumbers<1> {
        let DirectionNumbers { chooser, cell, point: [u, v] } = self;
        DirectionNumbers { chooser: [chooser[k]], cell: [cell[k]], point: [[u[k]], [v[k]]] }
    }
}

impl PathKey {
    /// Sample `sample` of the pixel, in a sequence of its samples that is spread evenly by itself and independent of those
    /// with another `sequence`.
    #[inline]
    pub(crate) fn new(seed: u64, pixel: u32, sequence: u32, sample: u32) -> PathKey {
        let key = mix(mix(seed) ^ mix(u64::from(pixel) << 32 | u64::from(sequence)));
        PathKeys { key: [(key >> 32) as u32], sample: [sample] }
    }
}

impl PathKeys<LANES> {
    /// Puts those that were chosen behind those which are there; see [`Packing::put`].
    #[inline(always)]
    pub(crate) fn pack(&self, packing: &Packing, [first, second]: [&mut PathKeys<LANES>; 2]) {
        packing.put(&self.key, [&mut first.key, &mut second.key]);
        packing.put(&self.sample, [&mut first.sample, &mut second.sample]);
    }
}

impl Sampler {
    /// For samples whose numbers in their sequence are below `end`.
    pub(crate) fn new(kind: SamplerKind, end: u32) -> Sampler {
        Sampler { kind, bits: u32::BITS - end.saturating_sub(1).leading_zeros() }
    }

    #[inline]
    pub(crate) fn camera<const N: usize>(self, keys: &PathKeys<N>) -> CameraNumbers<N> {
        let [x, y, u, v] = self.words(Set::Camera, keys);
        CameraNumbers { film: [units(&x), units(&y)], lens: [units(&u), units(&v)] }
    }

    /// [`CameraNumbers::film`] alone, where there is no lens.
    #[inline]
    pub(crate) fn film<const N: usize>(self, keys: &PathKeys<N>) -> [[f32; N]; 2] {
        let [x, y] = self.words(Set::Camera, keys);
        [units(&x), units(&y)]
    }

    #[inline]
    pub(crate) fn light<const N: usize>(self, keys: &PathKeys<N>, vertex: u32) -> LightNumbers<N> {
        let [u, v, choice] = self.words(Set::Light(vertex), keys);
        LightNumbers { choice: long_units(&choice, keys), point: [units(&u), units(&v)] }
    }

    /// Whether the ray towards the light is cast.
    #[inline]
    pub(crate) fn shadow<const N: usize>(self, keys: &PathKeys<N>, vertex: u32) -> [f32; N] {
        let [u] = self.words(Set::Shadow(vertex), keys);
        units(&u)
    }

    /// Whether a path goes on.
    #[inline]
    pub(crate) fn roulette<const N: usize>(self, keys: &PathKeys<N>, vertex: u32) -> [f32; N] {
        let [u] = self.words(Set::Roulette(vertex), keys);
        units(&u)
    }

    /// Which of two materials that are mixed a surface is.
    #[inline]
    pub(crate) fn part<const N: usize>(self, keys: &PathKeys<N>, vertex: u32) -> [f32; N] {
        let [u] = self.words(Set::Part(vertex), keys);
        units(&u)
    }

    #[inline]
    pub(crate) fn direction<const N: usize>(self, keys: &PathKeys<N>, vertex: u32) -> DirectionNumbers<N> {
        let [u, v, cell, chooser] = self.words(Set::Direction(vertex), keys);
        DirectionNumbers { chooser: units(&chooser), cell: long_units(&cell, keys), point: [units(&u), units(&v)] }
    }

    /// [`DirectionNumbers::point`] alone, where there is no choice.
    #[inline]
    pub(crate) fn direction_point<const N: usize>(self, keys: &PathKeys<N>, vertex: u32) -> [[f32; N]; 2] {
        let [u, v] = self.words(Set::Direction(vertex), keys);
        [units(&u), units(&v)]
    }

    /// The first `D` numbers of a set.
    #[inline(always)]
    fn words<const D: usize, const N: usize>(self, set: Set, keys: &PathKeys<N>) -> [[u32; N]; D] {
        let (vertex, set) = set.place();
        if self.kind == SamplerKind::Sobol && vertex <= STRATIFIED_VERTICES {
            let [x, y, z, shuffle] = hash4([&keys.key, &[0; N], &[set; N], &[SEEDS; N]]);
            let mut w = [0; N];
            for k in 0..N {
                w[k] = hash1(shuffle[k]);
            }
            sobol::points(&keys.sample, self.bits, &Seeds { shuffle, scramble: [x, y, z, w] })
        } else {
            let words = hash4([&keys.key, &keys.sample, &[set; N], &[INDEPENDENT; N]]);
            std::array::from_fn(|d| words[d])
        }
    }
}

#[inline(always)]
fn units<const N: usize>(words: &[u32; N]) -> [f32; N] {
    let mut u = [0.0; N];
    for k in 0..N {
        u[k] = unit_f32(words[k]);
    }
    u
}

/// The same with further digits, which a scramble would draw at random for each value of those that are there.
#[inline(always)]
fn long_units<const N: usize>(words: &[u32; N], keys: &PathKeys<N>) -> [f64; N] {
    let mut u = [0.0; N];
    for k in 0..N {
        u[k] = unit_f64(words[k], hash1(words[k] ^ keys.key[k]));
    }
    u
}

#[cfg(test)]
#[path = "sampler_tests.rs"]
mod tests;
