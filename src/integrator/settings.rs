//! How paths are asked for.

use crate::document::{Bounds, Fault, Reader, key};
use crate::light::LightSampler;

const AT_LEAST_ONE: Bounds = Bounds::new(|x| x >= 1.0, "at least 1");
const ROULETTES: &[(&str, Roulette)] =
    &[("guided", Roulette::Guided), ("throughput", Roulette::Throughput), ("none", Roulette::None)];

/// How paths are built.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorSettings {
    /// Path segments from the camera, at most: 1 sees emitters only, 2 direct light.
    pub max_depth: u32,
    /// Next-event estimation: every vertex looks at a light ("path reuse" in the paper).
    pub next_event: bool,
    /// Emitters that are hit count by the power heuristic; without it only what next-event estimation cannot reach counts.
    pub mis: bool,
    /// How it chooses a light.
    pub light_sampler: LightSampler,
    pub roulette: Roulette,
    /// Segments before roulette may end a path.
    pub rr_depth: u32,
    /// Guided roulette splits a path into at most this many.
    pub max_split: f32,
}

impl Default for IntegratorSettings {
    fn default() -> IntegratorSettings {
        IntegratorSettings {
            max_depth: 16,
            next_event: true,
            mis: true,
            light_sampler: LightSampler::Tree,
            roulette: Roulette::Guided,
            rr_depth: 5,
            max_split: 8.0,
        }
    }
}

impl IntegratorSettings {
    /// Reads `[integrator]` over what there is.
    pub(crate) fn read(&mut self, t: &mut Reader) -> Result<(), Fault> {
        let any = u64::from(u32::MAX);
        let depth = key("max_depth", "longest path from the camera: 1 sees emitters only, 2 adds direct light");
        t.integer(depth.unit("segments"), 1..=any, &mut self.max_depth)?;
        t.flag(key("next_event", "every vertex looks at a light"), &mut self.next_event)?;
        let mis =
            "emitters that are hit count by the power heuristic; without it only what `next_event` cannot reach counts";
        t.flag(key("mis", mis), &mut self.mis)?;
        let sampler = "chooses a light for `next_event`: by a hierarchy of lights, which knows what may arrive at the surface, \
                       or by their power alone";
        t.choice(key("light_sampler", sampler), LightSampler::NAMES, &mut self.light_sampler)?;
        t.choice(key("roulette", "ends paths at random, as described above"), ROULETTES, &mut self.roulette)?;
        let before = "before roulette may end a path; `\"guided\"` goes by it only where the guide knows nothing, and for sharp lobes";
        let before = key("rr_depth", before).unit("segments");
        t.integer(before, 0..=any, &mut self.rr_depth)?;
        let split =
            key("max_split", "into which `\"guided\"` roulette splits one at most; 1 never splits").unit("paths");
        t.number(split, AT_LEAST_ONE, &mut self.max_split)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Roulette {
    None,
    /// By what scattering alone would leave of the path's throughput, so that a guide's choices do not end its paths.
    Throughput,
    /// By what the guide expects of going on, against what it costs and what the pixel holds (Rath et al. 2022); where
    /// that is much, the path is split.
    Guided,
}
