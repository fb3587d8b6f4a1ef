//! Options that several subcommands share, and what they override in a scene file.

use clap::{Args, ValueEnum};

/// Which guide, which numbers, how many threads.
#[derive(Args)]
pub struct Choices {
    /// The guide: what learns where light comes from. [default: the scene file's, else auto]
    #[arg(long, value_name = "METHOD")]
    guide: Option<Method>,
    /// Seed of the random numbers. [default: the scene file's, else 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Threads; 0 takes all of the machine's. The picture does not depend on it.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Overrides a key of the scene file, for example guiding.resolution=32; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Method {
    /// As adaptive, for as long as it pays: judged by the first iterations' variance and cost
    Auto,
    /// No guide: directions from the material, and next-event estimation
    None,
    /// Learns in cells that refine where it pays, by position and facing normal
    Adaptive,
    /// Learns in the cells of a uniform grid
    Grid,
    /// Learns in the cells about sites on the surfaces
    Voronoi,
    /// Learns in a spatial tree from whole paths (Practical Path Guiding)
    #[value(name = "sdtree")]
    SdTree,
}

impl Choices {
    /// `KEY=VALUE` for all that was chosen, after `first`; what `--set` says comes last and holds.
    pub fn overrides(&self, first: impl IntoIterator<Item = String>) -> Vec<String> {
        let method = self.guide.map(|m| m.to_possible_value().expect("none is hidden").get_name().to_owned());
        let given =
            [self.seed.map(|n| format!("render.seed={n}")), method.map(|name| format!("guiding.method={name}"))];
        first.into_iter().chain(given.into_iter().flatten()).chain(self.set.iter().cloned()).collect()
    }
}
