//! How light finds its way: paths, in batches, bounce by bounce.

mod backward_pass;
pub(crate) mod batch;
pub(crate) mod mixture;
pub(crate) mod path;
pub mod probe;
mod radiance;
mod roulette;
pub(crate) mod sampler;
mod settings;
pub(crate) mod stop;
mod vertex_record;

pub use crate::light::LightSampler;
pub use batch::{Batch, BatchResult, Counters, Task};
pub(crate) use path::PathIntegrator;
pub(crate) use roulette::RouletteNormalisation;
pub use sampler::SamplerKind;
pub use settings::{IntegratorSettings, Roulette};
pub use stop::Stop;
