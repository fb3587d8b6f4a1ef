//! Options that several subcommands share, and what they override in a scene file.

use crate::embree::{ISA_VARIABLE, Isa};
use crate::format::reference;
use crate::format::reference::METHODS;
use crate::integrator::SamplerKind;
use anyhow::Result;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::Vec3;
use std::num::NonZero;

/// What of the machine is used.
#[derive(Args, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Machine {
    /// Threads, at most as many as there are processors; 0 takes all. What is rendered does not depend on it.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Holds Embree to an instruction set: sse4.2, avx, avx2 or avx512, where the processor has it. Another one gives
    /// another picture of the same quality. [default: the largest there is]
    #[arg(long, value_name = "SET", env = ISA_VARIABLE, value_parser = |text: &str| text.parse::<Isa>())]
    isa: Option<Isa>,
}

impl Machine {
    /// The options that ask for the same.
    pub(crate) fn words(&self) -> Vec<String> {
        let threads = ["--threads".to_string(), self.threads.to_string()];
        threads
            .into_iter()
            .chain(self.isa.iter().flat_map(|isa| ["--isa".to_string(), isa.name().to_string()]))
            .collect()
    }

    /// The same, with the instruction set of another where none was chosen.
    pub(crate) fn or_isa_of(&self, other: &Machine) -> Machine {
        Machine { threads: self.threads, isa: self.isa.or(other.isa) }
    }

    /// Starts the threads and settles what Embree uses. Returns the number of threads for Embree, 0 for all.
    pub(crate) fn start(&self, quiet: bool) -> Result<usize> {
        let processors = std::thread::available_parallelism().map_or(usize::MAX, NonZero::get);
        let threads = self.threads.min(processors);
        if threads < self.threads && !quiet {
            eprintln!("warning: --threads {} is limited to the number of processors, {processors}", self.threads);
        }
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
        self.isa.into_iter().for_each(Isa::choose);
        Ok(threads)
    }
}

/// Which guide, which numbers, what of the machine.
#[derive(Args, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Choices {
    /// The guide: what learns where light comes from. [default: the scene file's, else auto]
    #[arg(long, value_name = "METHOD", value_parser = methods())]
    guide: Option<String>,
    #[arg(long, value_name = "N", help = reference::help("render.seed"))]
    seed: Option<u64>,
    #[arg(long, value_name = "KIND", value_parser = samplers(), help = reference::help("render.sampler"))]
    sampler: Option<String>,
    /// The camera of this name, of a scene file with several. [default: that of [camera], else the first]
    #[arg(long, value_name = "NAME")]
    pub(crate) camera: Option<String>,
    /// The axis that is up, where the camera is found and in its picture: x, y, z, -x, -y or -z. [default: the scene
    /// file's camera.up, else what an OBJ file says of itself, else y]
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true, value_parser = up())]
    up: Option<Vec3>,
    #[command(flatten)]
    pub(crate) machine: Machine,
    /// Overrides a key of the scene file, for example guiding.resolution=32; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    definitions: Definitions,
}

/// What scenes of Mitsuba leave to whoever renders them.
#[derive(Args, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Definitions {
    /// What a scene of Mitsuba calls $NAME, over its <default>; may be repeated. The same as --set default.NAME=VALUE.
    #[arg(short = 'D', value_name = "NAME=VALUE")]
    define: Vec<String>,
}

impl Definitions {
    /// As overrides.
    pub(crate) fn overrides(&self) -> impl Iterator<Item = String> + '_ {
        self.define.iter().map(|definition| format!("default.{definition}"))
    }
}

/// The guide's methods, each with its help.
fn methods() -> PossibleValuesParser {
    PossibleValuesParser::new(METHODS.map(|(name, help)| PossibleValue::new(name).help(help.replace('`', ""))))
}

fn samplers() -> PossibleValuesParser {
    PossibleValuesParser::new(SamplerKind::NAMES.map(|(name, _)| name))
}

/// The axes, by name.
fn up() -> impl TypedValueParser<Value = Vec3> {
    const NAMES: [&str; 6] = ["x", "y", "z", "-x", "-y", "-z"];
    const AXES: [Vec3; 6] = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    PossibleValuesParser::new(NAMES).map(|name| AXES[NAMES.iter().position(|known| *known == name).unwrap_or(1)])
}

impl Choices {
    /// `KEY=VALUE` for all that was chosen, after `first`; what `--set` says comes last and holds.
    pub(crate) fn overrides(&self, first: impl IntoIterator<Item = String>) -> Vec<String> {
        let method = self.guide.as_ref().map(|name| format!("guiding.method={name}"));
        let up = self.up.map(|up| format!("camera.up={up}"));
        let sampler = self.sampler.as_ref().map(|name| format!("render.sampler={name}"));
        let given = [self.seed.map(|n| format!("render.seed={n}")), sampler, method, up];
        let given = first.into_iter().chain(given.into_iter().flatten());
        given.chain(self.set.iter().cloned()).chain(self.definitions.overrides()).collect()
    }
}
