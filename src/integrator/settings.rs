//! How paths are asked for.

/// How paths are built.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorSettings {
    /// Path segments from the camera, at most: 1 sees emitters only, 2 direct light.
    pub max_depth: u32,
    /// Next-event estimation: every vertex looks at a light ("path reuse" in the paper).
    pub next_event: bool,
    /// Emitters that are hit count by the power heuristic; without it only what next-event estimation cannot reach counts.
    pub mis: bool,
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
            roulette: Roulette::Guided,
            rr_depth: 5,
            max_split: 8.0,
        }
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
