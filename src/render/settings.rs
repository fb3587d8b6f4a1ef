//! How a render is asked for.

use crate::document::{Fault, Reader, key};
use crate::embree::{BuildOptions, BuildQuality};
use crate::film::{Combine, ExtraLayer, RadianceLayer};
use crate::integrator::SamplerKind;

const ORDERS: &[(&str, Order)] = &[("progressive", Order::Progressive), ("blocks", Order::Blocks)];
const COMBINES: &[(&str, Combine)] =
    &[("inverse-variance", Combine::InverseVariance), ("all", Combine::All), ("last", Combine::Last)];

/// How long, from which numbers, and what becomes of the iterations.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Samples per pixel over all iterations.
    pub spp: u32,
    /// Seconds after loading; rendering stops at whichever of `spp` and `time` comes first, but not before every pixel has a
    /// sample.
    pub time: Option<f64>,
    /// Relative error of the picture at which rendering stops too.
    pub noise: Option<f64>,
    /// Noisy tiles get more samples than quiet ones.
    pub adaptive: bool,
    pub seed: u64,
    pub sampler: SamplerKind,
    pub combine: Combine,
    pub order: Order,
    /// What the EXR also holds.
    pub(crate) layers: Vec<ExtraLayer>,
    /// Of Embree's acceleration structure.
    pub build: BuildOptions,
    /// Pictures of material libraries that are missing or cannot be read are errors.
    pub strict: bool,
}

impl Default for RenderSettings {
    fn default() -> RenderSettings {
        RenderSettings {
            spp: 64,
            time: None,
            noise: None,
            adaptive: false,
            seed: 0,
            sampler: SamplerKind::Sobol,
            combine: Combine::InverseVariance,
            order: Order::Progressive,
            layers: Vec::new(),
            build: BuildOptions::default(),
            strict: false,
        }
    }
}

impl RenderSettings {
    /// Whether objects and materials are counted.
    pub(crate) fn wants_ids(&self) -> bool {
        self.layers.contains(&ExtraLayer::Cryptomatte)
    }

    /// Light that is kept apart, in a scene whose lights are in so many groups.
    pub(crate) fn radiance_layers(&self, groups: usize) -> Vec<RadianceLayer> {
        self.layers.iter().flat_map(|layer| layer.light(groups)).collect()
    }

    /// Reads `[render]` over what there is.
    pub(crate) fn read(&mut self, t: &mut Reader) -> Result<(), Fault> {
        let spp = key("spp", "over all iterations").unit("samples per pixel");
        t.integer(spp, 1..=u64::from(u32::MAX), &mut self.spp)?;
        t.positive(key("time", TIME).unit("seconds"), &mut self.time)?;
        t.positive(key("noise", NOISE), &mut self.noise)?;
        t.flag(key("adaptive", ADAPTIVE), &mut self.adaptive)?;
        t.integer(key("seed", SEED), 0..=u64::MAX, &mut self.seed)?;
        t.choice(key("sampler", SAMPLER), &SamplerKind::NAMES, &mut self.sampler)?;
        let robust = "no ray slips between two triangles that share an edge, for about a quarter of the speed";
        t.flag(key("robust", robust), &mut self.build.robust)?;
        t.choice(key("build_quality", BUILD_QUALITY), &BuildQuality::NAMES, &mut self.build.quality)?;
        t.choices(key("layers", LAYERS), ExtraLayer::NAMES, &mut self.layers)?;
        let strict = "a picture of a material library (MTL) that is missing or cannot be read is an error; else it is a warning, and half \
                      of the colour stands in its place";
        t.flag(key("strict", strict), &mut self.strict)?;
        t.choice(key("order", ORDER), ORDERS, &mut self.order)?;
        t.choice(key("combine", COMBINE), COMBINES, &mut self.combine)
    }
}

const TIME: &str = "after loading; rendering stops at whichever of `spp` and `time` comes first. All pixels get one sample at least, \
    however long that takes; later a pass that takes more than a fiftieth of the time is cut where the time ends, so that some \
    pixels have more samples than others (layer `samples.Y`)";
const NOISE: &str = "relative error of the picture, for example 0.02: rendering stops once it is estimated to be no larger, or at `spp` or \
    `time` if one of them comes first. See [long-renders.md](long-renders.md#until-it-is-good)";
const ADAPTIVE: &str = "tiles of the picture get more samples where it is noisy, and fewer where it is quiet; with `noise`, none once they \
    are as good as that. The picture stays unbiased. See [long-renders.md](long-renders.md#where-it-is-noisy)";
const SEED: &str = "of all random numbers: the same seed and `spp` give the same picture, bit for bit, with any number of threads, \
    by one build of the program at one instruction set of Embree's (see [processors.md](processors.md#the-same-picture-bit-for-bit))";
const SAMPLER: &str = "how the samples of a pixel are spread: evenly, by scrambled Sobol' points, or as independent random numbers; see \
    [sampling.md](sampling.md)";
const BUILD_QUALITY: &str = "of Embree's acceleration structure: how long it takes to build against how long every ray takes after that. `low` \
    is for previews and short budgets in large scenes: built in a quarter to a half of the time, and rendered about a fifth more slowly. `high` cuts \
    large triangles apart and takes twice as long or more. Rays meet the same triangles. See \
    [performance.md](performance.md#quality-of-the-build)";
const LAYERS: &str = "what the EXR also holds, each under its name: light apart, which emitters and surroundings send to the camera by \
    themselves, which one surface has scattered, and which several have (together they are the picture); the light of each group of lights (`light_group`); places and normals of the \
    triangles that the camera sees. See [pictures.md](pictures.md#layers)";
const ORDER: &str = "passes over the whole picture in iterations of doubling length, or block after block from the middle outwards, \
    each with all of its samples: one iteration, so a guide needs `updates = \"online\"` and a grid of strata; not together with `time`";
const COMBINE: &str = "weights of the iterations' pictures: by inverse estimated variance, relative to the picture that the \
    iteration after makes (where `method` is `\"none\"`, whose samples are all alike, by samples), by samples, or only the last";

/// Which samples come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Passes over the whole picture, in iterations of doubling length.
    Progressive,
    /// One block after the other, each with all of its samples, from the middle outwards: a single iteration.
    Blocks,
}
